"""Axes: a box around what is shown, with ticks on its outer edges and a grid on the sides behind."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .._core.types import Float64Array
from .boxes import TakenBoxes
from .items import Annotation, Box, Line, Text
from .text_style import TextStyle
from .ticks import Tick, fit_ticks, write_beside

PADDING = 0.04  # of the extent, between the models and the box
TICK_LENGTH, TICK_GAP, TITLE_GAP = 0.4, 0.25, 0.4  # in sizes of the font
_FLAT = 1e-9  # an extent that is less of the largest has no axis
_MAX_MOVES = 40


@dataclass(frozen=True, eq=False)
class AxesFigure:
    """What axes consist of.

    grid, spines : (s, 2, 3) segments in the world: the grid and the sides behind, and the axes themselves
    ticks : per axis
    """

    grid: Float64Array = field(default_factory=lambda: np.empty((0, 2, 3)))
    spines: Float64Array = field(default_factory=lambda: np.empty((0, 2, 3)))
    ticks: Sequence[Sequence[Tick]] = ((), (), ())
    annotation: Annotation = field(default_factory=Annotation)


def pad_bounds(bounds: Float64Array) -> Float64Array:
    """Return the bounds (2, 3) of the box of axes around bounds (2, 3) of models."""
    extent = bounds[1] - bounds[0]
    padded: Float64Array = bounds + np.array([[-1.0], [1.0]]) * PADDING * extent
    return padded


def lay_out_axes(
    bounds: Float64Array,
    clip_from_world: Float64Array,
    eye: Float64Array,
    size: tuple[int, int],
    viewport: Box,
    titles: Sequence[str | None],
    style: TextStyle,
) -> AxesFigure:
    """Return the axes of a box with `bounds` (2, 3), as they are seen from an eye (4,), homogeneous.

    Each axis has its ticks on one of the edges of the box that are outermost in the picture: the lowest, or for an axis
    that stands upright the leftmost. An axis along which the box is flat, or that points at the eye, has none. If the
    eye is in the box or close to it, there are no axes.

    viewport : where ticks may lie; texts lie outside of it too
    """
    corners = np.array(list(itertools.product(*bounds.T)))
    clip = corners @ clip_from_world[[0, 1, 3], :3].T + clip_from_world[[0, 1, 3], 3]
    extent = bounds[1] - bounds[0]
    if not (clip[:, 2] > 1e-6 * np.abs(clip[:, 2]).max()).all() or not extent.any():
        return AxesFigure()
    view = _BoxView(bounds, clip_from_world, size, _find_front(bounds, eye))
    is_flat = extent <= _FLAT * extent.max()
    taken = TakenBoxes()
    spines: list[Float64Array] = []
    all_ticks: list[list[Tick]] = []
    titled: list[tuple[int, Float64Array, Float64Array, list[Tick]]] = []
    for axis in range(3):
        found = None if is_flat[axis] else view.outer_edge(axis, 2.0 * style.size)
        if found is None:
            all_ticks.append([])
            continue
        edge, outward = found
        offset = (TICK_LENGTH + TICK_GAP) * style.size
        limits = float(bounds[0, axis]), float(bounds[1, axis])
        ticks = fit_ticks(limits, lambda v, e=edge, a=axis: view.along(e, a, v), outward, offset, viewport, style)  # type: ignore[misc]
        ticks = [tick for tick in ticks if taken.is_free(tick.text.box)]
        for tick in ticks:
            taken.add(tick.text.box)
        spines.append(edge)
        all_ticks.append(ticks)
        titled.append((axis, edge, outward, ticks))
    lines = [_tick_line(tick, outward, style) for _, _, outward, ticks in titled for tick in ticks]
    texts = [tick.text for ticks in all_ticks for tick in ticks]
    for axis, edge, outward, ticks in titled:
        title = titles[axis]
        if title and title.strip():
            texts.append(_place_title(style.text(title, "axes"), view.middle(edge), outward, ticks, taken, style))
    return AxesFigure(
        view.grid([[tick.value for tick in ticks] for ticks in all_ticks], is_flat),
        np.array(spines).reshape(-1, 2, 3),
        all_ticks,
        Annotation(lines, texts),
    )


class _BoxView:
    """A box as it is seen: which of its edges are outermost, and which sides are behind.

    is_front : (3, 2), whether the eye sees the outside of the low and of the high side of each axis
    """

    def __init__(
        self, bounds: Float64Array, clip_from_world: Float64Array, size: tuple[int, int], is_front: list[list[bool]]
    ) -> None:
        self._bounds = bounds
        self._rows = clip_from_world[[0, 1, 3]]
        self._size = size
        self._is_front = is_front
        self._center = self._project(bounds.mean(axis=0))

    def _project(self, point: Float64Array) -> Float64Array:
        x, y, w = self._rows[:, :3] @ point + self._rows[:, 3]
        return (np.array((x / w, -y / w)) * 0.5 + 0.5) * self._size

    def along(self, edge: Float64Array, axis: int, value: float) -> tuple[float, float]:
        """Return the pixel of a value on an edge (2, 3) along an axis."""
        point = edge[0].copy()
        point[axis] = value
        x, y = self._project(point).tolist()
        return x, y

    def middle(self, edge: Float64Array) -> Float64Array:
        """Return the middle of an edge in the picture."""
        return 0.5 * (self._project(edge[0]) + self._project(edge[1]))

    def outer_edge(self, axis: int, min_length: float) -> tuple[Float64Array, Float64Array] | None:
        """Return the edge (2, 3) along an axis that has its ticks, and the direction (2,) out of the box there."""
        b, c = (other for other in range(3) if other != axis)
        found: list[tuple[Float64Array, Float64Array, Float64Array, bool]] = []
        for side_b, side_c in itertools.product((0, 1), repeat=2):
            if self._is_front[b][side_b] == self._is_front[c][side_c]:
                continue
            edge = self._edge(axis, b, side_b, c, side_c)
            start, end = self._project(edge[0]), self._project(edge[1])
            along = end - start
            length = float(np.hypot(*along))
            if length < min_length:
                continue
            outward = np.array((-along[1], along[0])) / length
            middle = 0.5 * (start + end)
            is_upright = bool(abs(along[1]) > abs(along[0]) * (1.0 + 1e-9))
            away = float(outward @ (middle - self._center))
            preferred = -outward[0] if is_upright else outward[1]  # of a flat box seen along its plane
            if away < -1e-6 * length or (abs(away) <= 1e-6 * length and preferred < 0.0):
                outward = -outward
            found.append((edge, outward, middle, is_upright))
        if not found:
            return None
        all_upright = all(is_upright for *_, is_upright in found)
        places = [round(float(-middle[0] if all_upright else middle[1]), 3) for _, _, middle, _ in found]
        edge, outward, _, _ = found[places.index(max(places))]
        return edge, outward

    def _edge(self, axis: int, b: int, side_b: int, c: int, side_c: int) -> Float64Array:
        edge = np.empty((2, 3))
        edge[:, axis] = self._bounds[:, axis]
        edge[:, b], edge[:, c] = self._bounds[side_b, b], self._bounds[side_c, c]
        return edge

    def grid(self, values: Sequence[Sequence[float]], is_flat: Float64Array) -> Float64Array:
        """Return the segments (s, 2, 3) at the values of each axis on the sides behind, and the edges of these."""
        segments: list[Float64Array] = []
        for side_axis, side in itertools.product(range(3), (0, 1)):
            is_front = self._is_front[side_axis]
            if is_front[side] or (is_flat[side_axis] and side == 1 and not is_front[0]):  # one of two in one place
                continue
            for axis in range(3):
                if axis == side_axis or is_flat[axis]:
                    continue
                other = 3 - axis - side_axis
                if is_flat[other]:
                    continue
                for value in {*values[axis], *self._bounds[:, axis].tolist()}:
                    segment = np.empty((2, 3))
                    segment[:, side_axis] = self._bounds[side, side_axis]
                    segment[:, axis] = value
                    segment[:, other] = self._bounds[:, other]
                    segments.append(segment)
        unique = sorted({tuple(segment.ravel().tolist()) for segment in segments})
        return np.array(unique).reshape(-1, 2, 3)


def _find_front(bounds: Float64Array, eye: Float64Array) -> list[list[bool]]:
    """Say of the low and the high side of each axis whether the eye (4,) sees it from outside."""
    extent = bounds[1] - bounds[0]
    if abs(eye[3]) > 1e-12 * np.abs(eye).max():
        point = eye[:3] / eye[3]
        tolerance = 1e-9 * (extent.max() + np.abs(point).max())
        beyond = np.stack([bounds[0] - point, point - bounds[1]], axis=1) > tolerance
        return [[bool(low), bool(high)] for low, high in beyond]
    direction = eye[:3] / np.abs(eye[:3]).max()
    return [[bool(-direction[a] > 1e-9), bool(direction[a] > 1e-9)] for a in range(3)]


def _tick_line(tick: Tick, outward: Float64Array, style: TextStyle) -> Line:
    x, y = (outward * TICK_LENGTH * style.size).tolist()
    return Line(tick.x, tick.y, tick.x + x, tick.y + y, max(1.0, 0.06 * style.size), style.color)


def _place_title(
    title: Text, middle: Float64Array, outward: Float64Array, ticks: Sequence[Tick], taken: TakenBoxes, style: TextStyle
) -> Text:
    """Return the title of an axis beyond its ticks, as far out as it takes not to cover other texts."""
    depth = (TICK_LENGTH + TICK_GAP) * style.size
    if ticks:
        left, top, right, bottom = np.array([tick.text.box for tick in ticks]).T
        reach = (right - left) * abs(outward[0]) + (bottom - top) * abs(outward[1])
        depth += float(reach.max()) + TITLE_GAP * style.size
    x, y = middle.tolist()
    placed = write_beside(title, x, y, outward, depth)
    for _ in range(_MAX_MOVES):
        if taken.is_free(placed.box):
            break
        depth += 0.25 * style.size
        placed = write_beside(title, x, y, outward, depth)
    taken.add(placed.box)
    return placed


def overflow(texts: Sequence[Text], size: tuple[float, float], margin: float) -> Float64Array:
    """Return by how much texts reach over the margin at the left, the top, the right and the bottom: (4,)."""
    if not texts:
        return np.zeros(4)
    left, top, right, bottom = np.array([text.box for text in texts]).T
    reach = (margin - left.min(), margin - top.min(), right.max() + margin - size[0], bottom.max() + margin - size[1])
    beyond: Float64Array = np.maximum(0.0, np.array(reach))
    return beyond


def inset_matrix(inset: Float64Array, size: tuple[int, int]) -> Float64Array:
    """Return the matrix (4, 4) that moves a whole picture into itself, `inset` (4,) pixels from its sides.

    Of clip space, for column vectors; inset is from the left, the top, the right and the bottom.
    """
    (left, top, right, bottom), (width, height) = inset.tolist(), size
    matrix = np.eye(4)
    matrix[0, 0], matrix[0, 3] = (width - left - right) / width, (left - right) / width
    matrix[1, 1], matrix[1, 3] = (height - top - bottom) / height, (bottom - top) / height
    return matrix
