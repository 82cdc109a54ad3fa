"""Welding: the points of a grid per patch, numbered so that patches share what their control points say they share.

Two borders are the same curve if they have the same control points, in either direction, and weights of the same
ratios: then their points are the same at every resolution. No distances between points decide.
"""

from functools import lru_cache
from itertools import zip_longest
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array, IndexArray
from .control_points import number_columns, number_points, number_weights

MAX_KEPT_BYTES = 4 << 20  # of the faces of the last grid

_Place: TypeAlias = tuple[int | None, int | None]
_Array: TypeAlias = npt.NDArray[Any]

# Where the borders of a grid lie, by its two axes; None is any place.
_PLACES: list[_Place] = [(0, None), (-1, None), (None, 0), (None, -1)]


class WeldedGrids(NamedTuple):
    """The faces of a grid per patch, whose points are shared; every array is read-only."""

    places: IndexArray
    """Of each point, where it lies among all points of the grids, which are k (n + 1) (n + 1): (p,)."""
    offsets: IndexArray
    indices: IndexArray
    kept: BoolArray
    """Which corners of the quads are kept: (k n n, 4)."""
    quad: IndexArray
    """Of each face, counted through all patches: (f,)."""


def weld_grids(patches: Float64Array, n: int) -> WeldedGrids:
    """Return the faces of a grid of n steps for each patch (k, a, b, 3 or 4)."""
    control_numbers = number_points(patches)
    weights = [number_weights(points) for points, _ in _list_borders(patches)] if patches.shape[-1] == 4 else []
    keys = tuple((each.shape, each.tobytes()) for each in (control_numbers, *weights))
    weld = _weld_numbers if 100 * len(patches) * n * n <= MAX_KEPT_BYTES else _weld_numbers.__wrapped__
    return weld(keys, n)


@lru_cache(maxsize=1)
def _weld_numbers(keys: tuple[tuple[tuple[int, ...], bytes], ...], n: int) -> WeldedGrids:
    """Return the faces of grids by the numbers of control points and of weights, as bytes.

    Those of the last grids are kept: the frames of an animation share them.
    """
    control_numbers, *weights = (np.frombuffer(key, np.int64).reshape(shape) for shape, key in keys)
    numbers, places = number_grid_points(control_numbers, weights, n)
    corners = list_quads(numbers)
    offsets, kept = drop_repeated_corners(corners)
    quad = np.flatnonzero(kept[:, 0] | kept[:, 1])  # a triangle lacks one corner
    welded = WeldedGrids(places, offsets, corners[kept], kept, quad)
    for array in welded:
        array.flags.writeable = False
    return welded


def number_grid_points(control_numbers: IndexArray, weights: list[IndexArray], n: int) -> tuple[IndexArray, IndexArray]:
    """Return the number of each point of a grid per patch, from 0, counted where it is seen first: (k, n + 1, n + 1).

    control_numbers : of the control points (k, a, b)
    weights : the numbers of the weights of borders, for each group that `_list_borders` returns; none without weights

    Returns the place of each first one among all points of the grids as well, in order.
    """
    k = len(control_numbers)
    n_controls = int(control_numbers.max()) + 1
    n_inner = n - 1
    keys = np.empty((k, n + 1, n + 1), np.int64)
    keys[:, ::n, ::n] = control_numbers[:, :: control_numbers.shape[1] - 1, :: control_numbers.shape[2] - 1]
    base = n_controls
    for (borders, places), ratios in zip_longest(_list_borders(control_numbers), weights):
        curves, n_curves, is_backward, is_point = number_curves(borders, ratios)
        along = np.arange(n_inner)
        along = np.where(is_backward[:, np.newaxis], along[::-1], along)
        inner = base + curves[:, np.newaxis] * n_inner + along
        inner = np.where(is_point[:, np.newaxis], borders[:, :1], inner)
        for place, rows in zip(places, np.split(inner, len(places)), strict=True):
            keys[(slice(None), *(slice(1, -1) if at is None else at for at in place))] = rows
        base += n_curves * n_inner
    keys[:, 1:-1, 1:-1] = base + np.arange(k * n_inner**2).reshape(k, n_inner, n_inner)
    return compact(keys, base + k * n_inner**2)


def _list_borders(patches: _Array) -> list[tuple[_Array, list[_Place]]]:
    """Return the borders of (k, a, b, ...), those of equally many rows together, and where each lies in a grid."""
    at_ends_of_u, at_ends_of_v = (
        np.concatenate([rows[:, 0], rows[:, -1]]) for rows in (patches, patches.swapaxes(1, 2))
    )
    if patches.shape[1] == patches.shape[2]:
        return [(np.concatenate([at_ends_of_u, at_ends_of_v]), _PLACES)]
    return [(at_ends_of_u, _PLACES[:2]), (at_ends_of_v, _PLACES[2:])]


def number_curves(
    control_numbers: IndexArray, weights: IndexArray | None
) -> tuple[IndexArray, int, BoolArray, BoolArray]:
    """Return, for curves given by numbers of control points and weights (m, d), which are the same, either way.

    Returns the number of each (m,), how many differ, which run backwards (m,), and which are one point (m,).
    """
    rows = control_numbers if weights is None else np.concatenate([control_numbers, weights], axis=1)
    backward = control_numbers[:, ::-1]
    if weights is not None:
        backward = np.concatenate([backward, weights[:, ::-1]], axis=1)
    first = (rows != backward).argmax(axis=1)
    each = np.arange(len(rows))
    is_backward = backward[each, first] < rows[each, first]
    forward = np.where(is_backward[:, np.newaxis], backward, rows)
    numbers = number_columns(forward.T)
    is_point: BoolArray = (control_numbers == control_numbers[:, :1]).all(axis=1)
    return numbers, int(numbers.max()) + 1, is_backward, is_point


def compact(keys: IndexArray, n_keys: int) -> tuple[IndexArray, IndexArray]:
    """Return `keys`, which are below `n_keys`, renumbered from 0 in the order in which they occur first, and where."""
    flat = keys.reshape(-1)
    first = np.empty(n_keys, np.int64)  # where a key occurs first; those that do not occur are not looked at
    first[flat[::-1]] = np.arange(len(flat) - 1, -1, -1)  # the last assignment stays
    firsts = first[flat]
    places = np.flatnonzero(firsts == np.arange(len(flat)))
    first[flat[places]] = np.arange(len(places))
    return first[flat].reshape(keys.shape), places


def list_quads(grids: IndexArray) -> IndexArray:
    """Return the quads of grids of numbers (k, m, n), counter-clockwise as seen from the side of dS/du x dS/dv.

    Returns (k (m - 1) (n - 1), 4).
    """
    k, m, n = grids.shape
    quads = np.empty((k, m - 1, n - 1, 4), np.int64)
    corners = (grids[:, :-1, :-1], grids[:, 1:, :-1], grids[:, 1:, 1:], grids[:, :-1, 1:])
    for i, corner in enumerate(corners):
        quads[..., i] = corner
    return quads.reshape(-1, 4)


def drop_repeated_corners(quads: IndexArray) -> tuple[IndexArray, BoolArray]:
    """Return the offsets of the faces, and which corners they keep: of corners that follow each other, the last one.

    Quads become triangles where two corners are one point, and vanish where fewer than three are left. Returns
    offsets (f + 1,) and a mask (q, 4).
    """
    kept = np.empty(quads.shape, bool)
    for corner in range(4):  # column by column: along rows of four NumPy takes three times as long
        np.not_equal(quads[:, corner - 1], quads[:, corner], out=kept[:, corner - 1])
    a, b, c, d = kept.view(np.int8).T
    sizes = a + b + c + d
    if sizes.min(initial=4) < 3:
        kept[sizes < 3] = False
        sizes = sizes[sizes >= 3]
    offsets = np.zeros(len(sizes) + 1, np.int64)
    np.cumsum(sizes, out=offsets[1:])
    return offsets, kept
