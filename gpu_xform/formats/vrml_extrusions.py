"""Extrusions of VRML 97: a section swept along a spine, as ISO 14772-1, 6.18, describes it.

Files may have many thousands of small ones: faces, which follow from few numbers, are kept, and points are computed at
the end, for all extrusions of a form at once.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from .vrml_shapes import join_columns

_TINY = 1e-12
_YZX, _ZXY = np.array([1, 2, 0]), np.array([2, 0, 1])
_LEAST = float(np.finfo(np.float64).tiny)
_MAX_KEPT_POINTS = 1 << 10
_POINTS_AT_ONCE = 1 << 16


class Form(NamedTuple):
    """What extrusions that are computed together have in common.

    n_corners, n_sections : the shape of the points; what ends where it began counts no point twice
    n_scales, n_turns : how many the sections have, the last of which stands for all that are missing; 0 turns for none
    """

    n_corners: int
    n_sections: int
    is_ring: bool
    is_loop: bool
    has_begin_cap: bool
    has_end_cap: bool
    n_scales: int
    n_turns: int

    @property
    def n_points(self) -> int:
        """How many points it has."""
        return self.n_corners * self.n_sections


class Extrusion(NamedTuple):
    """A section (c, 2) of x and z, a spine (s, 3), scales (1 or s, 2), and orientations (1 or s, 4), axis and angle.

    An angle of 0 may have any axis.
    """

    form: Form
    section: Float64Array
    spine: Float64Array
    scales: Float64Array
    orientations: Float64Array


def make_extrusion(
    section: Float64Array,
    spine: Float64Array,
    scales: Float64Array,
    orientations: Float64Array,
    *,
    has_begin_cap: bool = True,
    has_end_cap: bool = True,
) -> Extrusion:
    """Return an extrusion of at least two points of the section and two of the spine."""
    is_ring = len(section) > 2 and section[0].tolist() == section[-1].tolist()
    is_loop = len(spine) > 2 and spine[0].tolist() == spine[-1].tolist()
    n_sections = len(spine) - is_loop
    n_turns = min(len(orientations), n_sections) if orientations[:, 3].any() else 0
    form = Form(
        *(len(section) - is_ring, n_sections, is_ring, is_loop, has_begin_cap, has_end_cap),
        *(min(len(scales), n_sections), n_turns),
    )
    return Extrusion(form, section, spine, scales, orientations)


def list_faces(form: Form) -> tuple[IndexArray, IndexArray]:
    """Return the corners of all faces, and how many each has; nobody may write to them."""
    return _list_few_faces(form) if form.n_points <= _MAX_KEPT_POINTS else _list_faces(form)


def _list_faces(form: Form) -> tuple[IndexArray, IndexArray]:
    index = np.arange(form.n_points).reshape(form.n_sections, form.n_corners)
    rows = np.concatenate([index, index[:1]]) if form.is_loop else index
    grid = np.concatenate([rows, rows[:, :1]], axis=1) if form.is_ring else rows
    corners = [join_columns([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]])]
    n_caps = 0
    if form.n_corners > 2 and not form.is_loop:
        caps = [index[0, ::-1]] * form.has_begin_cap + [index[-1]] * form.has_end_cap
        corners, n_caps = corners + caps, len(caps)
    sizes = np.full(len(corners[0]) // 4 + n_caps, 4)
    sizes[len(sizes) - n_caps :] = form.n_corners
    return np.concatenate(corners), sizes


_list_few_faces = lru_cache(maxsize=64)(_list_faces)


class ExtrusionQueue:
    """Extrusions whose points are not computed yet, and where they go."""

    def __init__(self) -> None:
        self._waiting: dict[Form, list[tuple[int, Extrusion, Float64Array | None]]] = {}

    def add(self, start: int, extrusion: Extrusion, matrix: Float64Array | None) -> None:
        """Add an extrusion whose points are the rows from `start` on, moved by an affine matrix, None if by none."""
        self._waiting.setdefault(extrusion.form, []).append((start, extrusion, matrix))

    def fill(self, points: Float64Array) -> None:
        """Write all points into their rows."""
        for form, waiting in self._waiting.items():
            step = max(_POINTS_AT_ONCE // form.n_points, 1)
            for begin in range(0, len(waiting), step):
                starts, extrusions, matrices = zip(*waiting[begin : begin + step], strict=True)
                swept = _sweep(form, extrusions)
                if any(matrix is not None for matrix in matrices):
                    moves = np.stack([np.eye(4) if matrix is None else matrix for matrix in matrices])
                    swept = swept @ moves[:, :3, :3].transpose(0, 2, 1) + moves[:, np.newaxis, :3, 3]
                points[np.array(starts)[:, np.newaxis] + np.arange(form.n_points)] = swept
        self._waiting.clear()


def _sweep(form: Form, extrusions: tuple[Extrusion, ...]) -> Float64Array:
    """Return the points of k extrusions of one form: (k, n, 3)."""
    section = np.stack([each.section[: form.n_corners] for each in extrusions])
    spine = np.stack([each.spine for each in extrusions])
    scales = np.stack([each.scales[: form.n_scales] for each in extrusions])
    local = np.zeros((len(extrusions), form.n_sections, form.n_corners, 3))
    local[..., ::2] = section[:, np.newaxis] * _last_for_rest(scales, form.n_sections)[:, :, np.newaxis]
    if form.n_turns:
        turns = _rotate_about(np.stack([each.orientations[: form.n_turns] for each in extrusions]))
        local = local @ _last_for_rest(turns, form.n_sections).swapaxes(-1, -2)
    frames = _frames_along(spine, form.is_loop)[:, : form.n_sections]
    points: Float64Array = local @ frames + spine[:, : form.n_sections, np.newaxis]
    return points.reshape(len(extrusions), form.n_points, 3)


def _last_for_rest(rows: Float64Array, n: int) -> Float64Array:
    """Return `n` rows per extrusion, of which the last given one stands for all that are missing."""
    return rows[:, np.minimum(np.arange(n), rows.shape[1] - 1)]


def _frames_along(spine: Float64Array, is_loop: bool) -> Float64Array:
    """Return the axes x, y and z of the section at each point of k spines, as rows: (k, s, 3, 3)."""
    before, after = np.roll(spine, 1, axis=1), np.roll(spine, -1, axis=1)
    if is_loop:
        before[:, 0], after[:, -1] = spine[:, -2], spine[:, 1]
    along = after - before
    bend = _cross(after - spine, before - spine)
    if not is_loop:
        along[:, 0], along[:, -1] = spine[:, 1] - spine[:, 0], spine[:, -1] - spine[:, -2]
        if spine.shape[1] > 2:
            bend[:, 0], bend[:, -1] = bend[:, 1], bend[:, -2]
        else:
            bend[:] = 0.0
    y, z = _carry_over(_unit(along)), _carry_over(_unit(bend))
    z[_find_flipped(z)] *= -1.0
    frames = np.stack([_cross(y, z), y, z], axis=2)
    is_straight = ~z.any(axis=(1, 2))
    if is_straight.any():  # the shortest turn from y to it
        frames[is_straight] = _turn_from_y(y[is_straight, 0]).swapaxes(-1, -2)[:, np.newaxis]
        frames[~y.any(axis=(1, 2))] = np.eye(3)
    return frames


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    product: Float64Array = a[..., _YZX] * b[..., _ZXY] - a[..., _ZXY] * b[..., _YZX]
    return product


def _unit(rows: Float64Array) -> Float64Array:
    """Return rows of length 1; those without a direction, beside the longest of their spine, become 0."""
    lengths = np.sqrt((rows * rows).sum(axis=2, keepdims=True))
    is_short = lengths <= _TINY * np.maximum(lengths.max(axis=1, keepdims=True), _LEAST)
    unit: Float64Array = np.where(is_short, 0.0, rows) / np.where(is_short, 1.0, lengths)
    return unit


def _carry_over(rows: Float64Array) -> Float64Array:
    """Return rows with each 0 replaced by the row before it, the first ones of a spine by the next."""
    known = rows.any(axis=2)
    if known.all():
        return rows
    source = np.maximum.accumulate(np.where(known, np.arange(rows.shape[1]), 0), axis=1)
    source = np.maximum(source, known.argmax(axis=1)[:, np.newaxis])
    carried: Float64Array = np.take_along_axis(rows, source[..., np.newaxis], axis=1)
    return carried


def _find_flipped(z: Float64Array) -> BoolArray:
    """Return which of the axes to turn round, so that each is at most a right angle from the one before it: (k, s)."""
    is_behind = np.zeros(z.shape[:2], bool)
    is_across = np.zeros(z.shape[:2], bool)  # at a right angle, and so as it is
    cosines = (z[:, 1:] * z[:, :-1]).sum(axis=2)
    is_behind[:, 1:], is_across[:, 1:] = cosines < -_TINY, np.abs(cosines) <= _TINY
    n_behind = np.cumsum(is_behind, axis=1)
    flipped: BoolArray = (n_behind - np.maximum.accumulate(np.where(is_across, n_behind, 0), axis=1)) % 2 == 1
    return flipped


def _turn_from_y(directions: Float64Array) -> Float64Array:
    """Return the shortest rotations from +y to directions of length 1: (n, 3, 3). Half a turn is one around x."""
    x, cosine, z = directions.T
    squared = x * x + z * z  # of the sine
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(cosine > 0.0, 1.0 / (1.0 + cosine), (1.0 - cosine) / squared)
        turns = np.array(
            [
                [cosine + factor * z * z, x, -factor * x * z],
                [-x, cosine, -z],
                [-factor * x * z, z, cosine + factor * x * x],
            ]
        ).transpose(2, 0, 1)
    turns[(np.sqrt(squared) <= _TINY) & (cosine <= 0.0)] = np.diag([1.0, -1.0, -1.0])
    return turns


def _rotate_about(turns: Float64Array) -> Float64Array:
    """Return rotations (k, m, 3, 3) about axes by angles in radians: (k, m, 4)."""
    axes, angles = turns[..., :3], np.where(turns[..., 3] == 0.0, 0.0, turns[..., 3])
    axes = np.where(angles[..., np.newaxis] == 0.0, [0.0, 0.0, 1.0], axes)
    axes = axes / np.abs(axes).max(axis=-1, keepdims=True)
    x, y, z = np.moveaxis(axes / np.sqrt((axes * axes).sum(axis=-1, keepdims=True)), -1, 0)
    c, s = np.cos(angles), np.sin(angles)
    d = 1.0 - c
    rows = [
        [c + d * x * x, d * x * y - s * z, d * x * z + s * y],
        [d * x * y + s * z, c + d * y * y, d * y * z - s * x],
        [d * x * z - s * y, d * y * z + s * x, c + d * z * z],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
