"""Welding: the points of a grid per patch, numbered so that patches share what their control points say they share.

Two borders are the same curve if they have the same control points, in either direction, and weights of the same
ratios: then their points are the same at every resolution. No distances between points decide.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from .bernstein import join_curves
from .control_points import number_columns, number_points, number_weights

MAX_KEPT_BYTES = 4 << 20  # of the faces of the last grid

_Place: TypeAlias = tuple[int | None, int | None]

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


def weld_grids(blocks: Sequence[Float64Array], n: int) -> WeldedGrids:
    """Return the faces of a grid of n steps for each patch of arrays (k, a, b, 3 or 4)."""
    borders = _list_borders(blocks)
    keys = [number_points(borders)]
    if borders.shape[-1] == 4:
        keys.append(number_weights(borders))
    n_patches = len(borders) // len(_PLACES)
    weld = _weld_numbers if 100 * n_patches * n * n <= MAX_KEPT_BYTES else _weld_numbers.__wrapped__
    return weld(tuple((each.shape, each.tobytes()) for each in keys), n)


def _list_borders(blocks: Sequence[Float64Array]) -> Float64Array:
    """Return the borders of all patches as curves of one degree: (4 k, a, 3 or 4), in the order of _PLACES."""
    curves = [
        block[(slice(None), *(slice(None) if i is None else i for i in place))] for place in _PLACES for block in blocks
    ]
    return join_curves(curves)


@lru_cache(maxsize=1)
def _weld_numbers(keys: tuple[tuple[tuple[int, ...], bytes], ...], n: int) -> WeldedGrids:
    """Return the faces of grids by the numbers of the control points of borders, and of their weights, as bytes.

    Those of the last grids are kept: the frames of an animation share them.
    """
    control_numbers, *weights = (np.frombuffer(key, np.int64).reshape(shape) for shape, key in keys)
    numbers, places = _number_grid_points(control_numbers, weights[0] if weights else None, n)
    corners = list_quads(numbers)
    offsets, kept = drop_repeated_corners(corners)
    quad = np.flatnonzero(kept[:, 0] | kept[:, 1])  # a triangle lacks one corner
    welded = WeldedGrids(places, offsets, corners[kept], kept, quad)
    for array in welded:
        array.flags.writeable = False
    return welded


def _number_grid_points(
    control_numbers: IndexArray, weights: IndexArray | None, n: int
) -> tuple[IndexArray, IndexArray]:
    """Return the number of each point of a grid per patch, from 0, counted where it is seen first: (k, n + 1, n + 1).

    control_numbers, weights : the numbers of the control points of borders, and of their weights: (4 k, a)

    Returns the place of each first one among all points of the grids as well, in order.
    """
    k, n_inner = len(control_numbers) // len(_PLACES), n - 1
    keys = np.empty((k, n + 1, n + 1), np.int64)
    keys[:, ::n, ::n] = control_numbers[: 2 * k, [0, -1]].reshape(2, k, 2).swapaxes(0, 1)
    base = int(control_numbers.max()) + 1
    curves, n_curves, is_backward, is_point = number_curves(control_numbers, weights)
    along = np.arange(n_inner)
    along = np.where(is_backward[:, np.newaxis], along[::-1], along)
    inner = base + curves[:, np.newaxis] * n_inner + along
    inner = np.where(is_point[:, np.newaxis], control_numbers[:, :1], inner)
    for place, rows in zip(_PLACES, np.split(inner, len(_PLACES)), strict=True):
        keys[(slice(None), *(slice(1, -1) if at is None else at for at in place))] = rows
    base += n_curves * n_inner
    keys[:, 1:-1, 1:-1] = base + np.arange(k * n_inner**2).reshape(k, n_inner, n_inner)
    return compact(keys, base + k * n_inner**2)


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
