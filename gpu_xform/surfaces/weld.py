"""Welding: the points of a grid per patch, numbered so that patches share what their control points say they share.

Two borders are the same curve if they have the same control points, in either direction, and weights of the same
ratios: then their points are the same at every resolution. No distances between points decide.
"""

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array, IndexArray
from .control_points import number_points, number_rows, snap_weights

_Place: TypeAlias = tuple[int | None, int | None]
_Array: TypeAlias = npt.NDArray[Any]

# Where the borders of a grid lie, by its two axes; None is any place.
_PLACES: list[_Place] = [(0, None), (-1, None), (None, 0), (None, -1)]


def number_grid_points(patches: Float64Array, n: int) -> IndexArray:
    """Return the number of each point of a grid per patch, from 0, counted where it is seen first: (k, n + 1, n + 1).

    patches : control points (k, a, b, 3 or 4)
    """
    k = len(patches)
    control_numbers = number_points(patches)
    n_controls = int(control_numbers.max()) + 1
    n_inner = n - 1
    keys = np.empty((k, n + 1, n + 1), np.int64)
    keys[:, ::n, ::n] = control_numbers[:, :: control_numbers.shape[1] - 1, :: control_numbers.shape[2] - 1]
    base = n_controls
    for (borders, places), (points, _) in zip(_list_borders(control_numbers), _list_borders(patches), strict=True):
        curves, n_curves, is_backward, is_point = number_curves(borders, snap_weights(points))
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
    numbers = number_rows(forward)
    is_point: BoolArray = (control_numbers == control_numbers[:, :1]).all(axis=1)
    return numbers, int(numbers.max()) + 1, is_backward, is_point


def compact(keys: IndexArray, n_keys: int) -> IndexArray:
    """Return `keys`, which are below `n_keys`, renumbered from 0 in the order in which they occur first."""
    flat = keys.reshape(-1)
    first = find_first(flat, n_keys)
    is_first = first[flat] == np.arange(len(flat))
    numbers: IndexArray = (np.cumsum(is_first) - 1)[first[flat]]
    return numbers.reshape(keys.shape)


def find_first(keys: IndexArray, n_keys: int) -> IndexArray:
    """Return where each of the keys below `n_keys` occurs first in `keys` (m,), -1 where it does not: (n_keys,)."""
    first = np.full(n_keys, -1, np.int64)
    first[keys[::-1]] = np.arange(len(keys) - 1, -1, -1)  # the last assignment stays
    return first


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
    np.not_equal(quads[:, :-1], quads[:, 1:], out=kept[:, :-1])
    np.not_equal(quads[:, -1], quads[:, 0], out=kept[:, -1])
    sizes = kept.view(np.int8) @ np.ones(4, np.int8)
    if sizes.min(initial=4) < 3:
        kept[sizes < 3] = False
        sizes = sizes[sizes >= 3]
    offsets = np.zeros(len(sizes) + 1, np.int64)
    np.cumsum(sizes, out=offsets[1:])
    return offsets, kept


def place_points(numbers: IndexArray, points: Float64Array) -> Float64Array:
    """Return the positions (n, 3) by number: each is the first point (..., 3) of its number."""
    first = find_first(numbers.reshape(-1), int(numbers.max()) + 1)
    return points.reshape(-1, 3)[first]
