"""Workloads: how many edges a picture has, and how long they are on average, for the choice of a rasteriser."""

from collections.abc import Sequence
from typing import NamedTuple

from ..drawing.draw_list import Drawable
from ..drawing.edge_sample import mean_length, project_sample

FALLBACK_LENGTH_PX = 10.0  # of edges whose points the host does not know


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
    """Return the mean length of a drawable's sampled edges in its first instance."""
    ends_px = project_sample(drawable.sample_edges, drawable.clip_from_points[0], size)
    return mean_length(ends_px, size) if len(ends_px) else FALLBACK_LENGTH_PX
