"""Polygons of any number of corners, as rows of corners one after another."""

from typing import NamedTuple

import numpy as np

from ..._core.types import BoolArray, Float64Array, IndexArray
from .ragged import members, starts


class Pieces(NamedTuple):
    """Polygons, and what each is a piece of.

    offsets : (k + 1,); polygon i has the corners from offsets[i] to offsets[i + 1], at least three
    corners : (c, d), in clip space or in the picture
    owners : (k,)
    """

    offsets: IndexArray
    corners: Float64Array
    owners: IndexArray


def chosen(pieces: Pieces, which: BoolArray) -> Pieces:
    """Return some of the polygons: which (k,)."""
    sizes = np.diff(pieces.offsets)
    return Pieces(starts(sizes[which]), pieces.corners[np.repeat(which, sizes)], pieces.owners[which])


def taken(pieces: Pieces, numbers: IndexArray) -> Pieces:
    """Return polygons by their numbers, in this order."""
    rows, offsets = members(pieces.offsets, numbers)
    return Pieces(offsets, pieces.corners[rows], pieces.owners[numbers])


def together(parts: list[Pieces]) -> Pieces:
    """Return all polygons of several, one after another."""
    sizes = np.concatenate([np.diff(part.offsets) for part in parts])
    return Pieces(
        starts(sizes),
        np.concatenate([part.corners for part in parts]),
        np.concatenate([part.owners for part in parts]),
    )


def extremes(pieces: Pieces, values: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the least and the largest of the values (c,) at the corners of each polygon."""
    first = pieces.offsets[:-1]
    if len(first) == 0:
        return np.empty(0), np.empty(0)
    return np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)


def following(pieces: Pieces) -> IndexArray:
    """Return which corner comes after each: (c,)."""
    after = np.arange(1, len(pieces.corners) + 1)
    after[pieces.offsets[1:] - 1] = pieces.offsets[:-1]
    return after


def means(pieces: Pieces, values: Float64Array) -> Float64Array:
    """Return the mean of the values (c,) at the corners of each polygon."""
    if len(values) == 0:
        return np.zeros(0)
    result: Float64Array = np.add.reduceat(values, pieces.offsets[:-1]) / np.diff(pieces.offsets)
    return result


def fans(pieces: Pieces) -> tuple[IndexArray, IndexArray]:
    """Return convex polygons as triangles around their first corners (t, 3), and the polygon of each (t,)."""
    n_triangles = np.diff(pieces.offsets) - 2
    polygon = np.repeat(np.arange(len(n_triangles)), n_triangles)
    first = pieces.offsets[polygon]
    second = first + 1 + np.arange(len(polygon)) - starts(n_triangles)[polygon]
    return np.column_stack([first, second, second + 1]), polygon
