"""Workloads: how many edges a picture has, and how long they are on average, for the choice of a rasteriser."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array
from ..drawing.draw_list import Drawable
from ..drawing.view import ndc_to_pixels

FALLBACK_LENGTH_PX = 10.0  # of edges whose points the host does not know
MIN_RELATIVE_W = 1e-6  # of the largest coordinate; a sampled edge that reaches nearer to the eye is left out


class Workload(NamedTuple):
    """What a rasteriser has to draw; lengths are means in pixels."""

    n_edges: int
    length_px: float


def estimate_workload(drawables: Sequence[Drawable], size: tuple[int, int]) -> Workload:
    """Return the workload of a picture of `size` = (width, height), with lengths from a sample of the edges."""
    n_edges, total_px = 0, 0.0
    for drawable in drawables:
        for lines in drawable.lines:
            n = lines.n_edges * len(drawable.clip_from_points)
            n_edges += n
            total_px += n * (0.0 if lines.are_points else _mean_length(drawable, size))
    return Workload(n_edges, total_px / max(n_edges, 1))


def _mean_length(drawable: Drawable, size: tuple[int, int]) -> float:
    """Return the mean length of a drawable's sampled edges in its first instance, none longer than the diagonal."""
    ends = drawable.sample_edges() if drawable.sample_edges else np.empty((0, 2, 3))
    clip: Float64Array = ends @ drawable.clip_from_points[0, :, :3].T + drawable.clip_from_points[0, :, 3]
    is_before_eye = (clip[..., 3] > MIN_RELATIVE_W * np.abs(clip).max(initial=0.0)).all(axis=1)
    clip = clip[is_before_eye]
    if not len(clip):
        return FALLBACK_LENGTH_PX
    pixels = ndc_to_pixels(clip / clip[..., 3:], size)
    lengths = np.hypot(*(pixels[:, 1] - pixels[:, 0]).T)
    return float(np.minimum(lengths, math.hypot(*size)).mean())
