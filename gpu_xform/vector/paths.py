"""Paths of a vector layer: which lines and polygons share one.

A path paints what it covers once, however often its lines cross; the lines of a picture are each drawn over those
before them. So a transparent line has a path of its own: where two cross, the picture is darker. Consecutive opaque
lines of one colour share a path, which looks the same as many.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, IndexArray
from ..imaging.colors import pack_rgba8
from .decimal_text import Bytes, FixedPoint, to_fixed_point
from .join_segments import MAX_POINTS_PER_LINE, join_dashes, join_segments
from .layer import FloatArray, Gradients, Polygons, VectorLayer

SEAM_WIDTH_PX = 0.5  # overlap of polygons of several paths, or what lies behind would glimmer between them

SMOOTH_SEAM_WIDTH_PX = 1.0  # the same where one colour goes on across seams, and a twentieth of what is behind shows


@dataclass(frozen=True)
class Paths:
    """Paths in the order in which they are drawn.

    points : (n, 2)
    begins : (n,) whether a line of a path begins at the point
    offsets : (p + 1,) path i has the points from offsets[i] to offsets[i + 1]
    colors : (p, 4) red, green, blue, alpha from 0 to 255
    phases : (p,) offset into the dash pattern at which each line of a path starts; None if lines are not dashed
    closed : whether lines end where they begin, as polygons do
    axes, end_colors : (p, 4) and (p, 2, 4) from 0 to 255, of the gradients that paths are filled with in place of
        colours; one colour twice for none
    """

    points: FixedPoint
    begins: BoolArray
    offsets: IndexArray
    colors: Bytes
    phases: FixedPoint | None = None
    closed: bool = False
    axes: FloatArray | None = None
    end_colors: Bytes | None = None

    @property
    def is_gradient(self) -> BoolArray:
        """Which paths are filled with a gradient: (p,)."""
        if self.end_colors is None:
            return np.zeros(len(self.colors), np.bool_)
        differs: BoolArray = (self.end_colors[:, 0] != self.end_colors[:, 1]).any(axis=1)
        return differs

    @property
    def ends(self) -> BoolArray:
        """Whether a line ends at the point: (n,)."""
        return np.append(self.begins[1:], True)


def quantize_colors(colors: FloatArray, n: int) -> Bytes:
    """Return `n` colours with 8 bits per component, rounded as in pictures of pixels: (n, 4).

    colors : (1, 4) or (n, 4)
    """
    return np.broadcast_to(pack_rgba8(np.asarray(colors, np.float64))[:, None].view(np.uint8), (n, 4))


def unique_colors(colors: Bytes) -> tuple[Bytes, IndexArray]:
    """Return the distinct colours, and the index of each of `colors` among them."""
    as_numbers = np.ascontiguousarray(colors).view(np.uint32)[:, 0]
    _, first, index = np.unique(as_numbers, return_index=True, return_inverse=True)
    return colors[first], index


def make_line_paths(layer: VectorLayer, *, hidden: bool) -> Paths:
    """Return the paths of the hidden or of the visible segments, without those whose alpha is 0."""
    colors = quantize_colors(layer.colors, len(layer.segments))
    which = np.flatnonzero((layer.hidden == hidden) & (colors[:, 3] > 0))
    which = which[_is_needed(to_fixed_point(layer.segments[which]))]
    ends, colors = to_fixed_point(layer.segments[which]).reshape(-1, 2, 2), colors[which]
    if dash := layer.stroke(hidden=hidden).dash:
        period = 100.0 * sum(dash)
        lengths = np.hypot(*(layer.segments[which, 2:] - layer.segments[which, :2]).T)
        starts = layer.dash_start[which]
        return _make_dashed_paths(ends, colors, to_fixed_point(np.stack([starts, starts + lengths], axis=1)), period)
    return _make_solid_paths(ends, colors)


def _is_needed(ends: FixedPoint) -> BoolArray:
    """Return which segments (s, 4) are longer than a point, or a point at which none of those ends: (s,)."""
    is_long: BoolArray = (ends[:, :2] != ends[:, 2:]).any(axis=1)
    if is_long.all() or not is_long.any():
        return np.ones(len(ends), np.bool_)
    places = (ends[:, ::2].astype(np.int64) << 32) + ends[:, 1::2]
    return is_long | ~np.isin(places[:, 0], places[is_long])


def _make_solid_paths(ends: FixedPoint, colors: Bytes) -> Paths:
    runs = _number_runs(colors)
    points, begins = join_segments(ends, runs)
    offsets = _path_offsets(begins, runs[points >> 1])
    return Paths(ends.reshape(-1, 2)[points], begins, offsets, colors[points[offsets[:-1]] >> 1])


def _make_dashed_paths(ends: FixedPoint, colors: Bytes, distances: FixedPoint, period: float) -> Paths:
    """Return paths whose lines share a phase, because each line restarts the dash pattern.

    distances : (s, 2) of both ends of each segment along the pattern, as `period` in hundredths of a pixel
    """
    runs = _number_runs(colors)
    points, begins = join_dashes(ends, distances, runs)
    line_starts = np.flatnonzero(begins)
    first = points[line_starts] >> 1  # segment of each line
    phases = _round_phases(distances[first, 0], period)
    order = np.lexsort((phases, runs[first]))
    sizes = np.diff(line_starts, append=len(points))[order]
    moved = np.repeat(line_starts[order] - np.cumsum(sizes) + sizes, sizes) + np.arange(len(points))
    line_runs = np.cumsum(_differs_from_previous(np.column_stack([runs[first], phases])[order]))
    points, begins = points[moved], begins[moved]
    offsets = _path_offsets(begins, np.repeat(line_runs, sizes))
    segments = points[offsets[:-1]] >> 1
    return Paths(
        ends.reshape(-1, 2)[points], begins, offsets, colors[segments], _round_phases(distances[segments, 0], period)
    )


def _round_phases(distances: FixedPoint, period: float) -> FixedPoint:
    """Return how far into a pattern distances along it lie: the pattern's period need not be whole."""
    return np.rint(np.mod(distances, period)).astype(np.int32)


def make_polygon_paths(polygons: Polygons) -> Iterator[tuple[int, Paths]]:
    """Yield runs of polygons of one alpha: the alpha, from 0 to 255, and opaque paths to composite with it as a group.

    All polygons have the same winding, or there would be holes where two of a path overlap.
    """
    n = len(polygons.offsets) - 1
    colors = quantize_colors(polygons.colors, n)
    points = to_fixed_point(polygons.points)
    for start, end in pairwise([*np.flatnonzero(_differs_from_previous(colors[:, 3:])), n]):
        alpha = int(colors[start, 3])
        if alpha > 0:
            gradients = polygons.gradients
            if gradients is not None:
                gradients = Gradients(gradients.axes[start:end], gradients.ends[start:end])
            yield alpha, _make_opaque_paths(points, polygons.offsets[start : end + 1], colors[start:end], gradients)


def _make_opaque_paths(
    points: FixedPoint, offsets: npt.NDArray[np.integer[Any]], colors: Bytes, gradients: Gradients | None
) -> Paths:
    points, offsets = points[offsets[0] : offsets[-1]], offsets - offsets[0]
    sizes = np.diff(offsets)
    polygon = np.repeat(np.arange(len(sizes)), sizes)
    index = np.arange(len(points))
    begins = index == offsets[polygon]
    after = np.where(index + 1 == offsets[polygon + 1], offsets[polygon], index + 1)
    p, q = points.astype(np.float64), points[after].astype(np.float64)
    areas = np.bincount(polygon, p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0], len(sizes))
    points = points[np.where(areas[polygon] < 0.0, offsets[polygon] + offsets[polygon + 1] - 1 - index, index)]
    opaque = colors.copy()
    opaque[:, 3] = 255
    if gradients is None:
        paths = _path_offsets(begins, _number_runs(opaque)[polygon])
        return Paths(points, begins, paths, opaque[polygon[paths[:-1]]], closed=True)
    ends = np.stack([quantize_colors(gradients.ends[:, i], len(opaque)) for i in range(2)], axis=1)
    ends[..., 3] = 255
    is_gradient = (ends[:, 0] != ends[:, 1]).any(axis=1)
    is_alone = is_gradient | np.append(False, is_gradient[:-1])
    paths = _path_offsets(begins, np.cumsum(_differs_from_previous(opaque) | is_alone)[polygon])
    first = polygon[paths[:-1]]
    return Paths(points, begins, paths, opaque[first], closed=True, axes=gradients.axes[first], end_colors=ends[first])


def _differs_from_previous(rows: npt.NDArray[np.integer[Any]]) -> BoolArray:
    """Tell whether each row (n, k) differs from the one before; the first does."""
    differs = np.ones(len(rows), np.bool_)
    differs[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    return differs


def _number_runs(colors: Bytes) -> IndexArray:
    """Return the number of each colour's run: equal opaque neighbours, or one colour that is not opaque."""
    return np.cumsum(_differs_from_previous(colors) | (colors[:, 3] < 255))


def _path_offsets(begins: BoolArray, runs: IndexArray) -> IndexArray:
    """Return where each path begins, and the end: at a line that begins a run, or would make the path too long."""
    first = np.maximum.accumulate(np.where(_differs_from_previous(runs[:, None]), np.arange(len(runs)), 0))
    part = (np.arange(len(runs)) - first) // MAX_POINTS_PER_LINE
    lines = np.flatnonzero(begins)
    is_first = _differs_from_previous(np.stack([runs[lines], part[lines]], axis=1))
    return np.append(lines[is_first], len(runs))
