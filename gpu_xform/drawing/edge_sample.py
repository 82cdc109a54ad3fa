"""Samples of edges in the picture: how long edges are, and how wide lines may be, without looking at all of them."""

import math
from collections.abc import Callable

import numpy as np

from .._core.types import Float64Array
from .view import ndc_to_pixels

DEFAULT_LINE_WIDTH_PX = 1.5
MIN_LINE_WIDTH_PX = 0.01
MAX_COVERED_PART = 0.5  # of the pixels of a model
MIN_RELATIVE_W = 1e-6  # of the largest coordinate; a sampled edge that reaches nearer to the eye is left out

SampleEdges = Callable[[], Float64Array]  # returns the ends of some edges (k, 2, 3)


def project_sample(
    sample_edges: SampleEdges | None, clip_from_points: Float64Array, size: tuple[int, int]
) -> Float64Array:
    """Return the ends of sampled edges in pixels (k, 2, 2); k may be 0."""
    ends = sample_edges() if sample_edges else np.empty((0, 2, 3))
    clip: Float64Array = ends @ clip_from_points[:, :3].T + clip_from_points[:, 3]
    is_before_eye = (clip[..., 3] > MIN_RELATIVE_W * np.abs(clip).max(initial=0.0)).all(axis=1)
    clip = clip[is_before_eye]
    return ndc_to_pixels(clip / clip[..., 3:], size)


def mean_length(ends_px: Float64Array, size: tuple[int, int]) -> float:
    """Return the mean length of edges (k, 2, 2), k > 0, none longer than the diagonal of the picture."""
    lengths = np.hypot(*(ends_px[:, 1] - ends_px[:, 0]).T)
    return float(np.minimum(lengths, math.hypot(*size)).mean())


def fit_line_width(ends_px: Float64Array, n_edges: int, size: tuple[int, int], *, hides_half: bool) -> float:
    """Return the width of lines, in pixels, at which they cover at most half of the part of the picture they lie in.

    ends_px : (k, 2, 2) of a sample
    hides_half : faces hide the edges on the far side

    The part is the box around the sample; wider than `DEFAULT_LINE_WIDTH_PX` they are never.
    """
    if len(ends_px) == 0:
        return DEFAULT_LINE_WIDTH_PX
    corners = ends_px.reshape(-1, 2)
    width, height = np.clip(corners.max(axis=0), 0, size) - np.clip(corners.min(axis=0), 0, size)
    length = n_edges * mean_length(ends_px, size) * (0.5 if hides_half else 1.0)
    if length <= 0.0:
        return DEFAULT_LINE_WIDTH_PX
    fitting = MAX_COVERED_PART * max(width, 1.0) * max(height, 1.0) / length
    return float(np.clip(fitting, MIN_LINE_WIDTH_PX, DEFAULT_LINE_WIDTH_PX))
