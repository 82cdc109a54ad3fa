"""Ragged polygon arrays: polygons of any number of corners, their corners one after another."""

from typing import NamedTuple

import numpy as np

from ..._core.types import BoolArray, Float64Array, IndexArray
from .ragged import rows_of, to_offsets


class RaggedPolygons(NamedTuple):
    """Polygons, each with the index of the polygon that it is, or is a piece of.

    offsets : (k + 1,); polygon i has the corners from offsets[i] to offsets[i + 1], at least three
    corners : (c, d), in clip space or in pixels
    owners : (k,)
    """

    offsets: IndexArray
    corners: Float64Array
    owners: IndexArray


def select(polygons: RaggedPolygons, mask: BoolArray) -> RaggedPolygons:
    """Return the polygons for which `mask` (k,) is true."""
    sizes = np.diff(polygons.offsets)
    return RaggedPolygons(to_offsets(sizes[mask]), polygons.corners[np.repeat(mask, sizes)], polygons.owners[mask])


def take(polygons: RaggedPolygons, indices: IndexArray) -> RaggedPolygons:
    """Return polygons by their indices, in this order."""
    rows, offsets = rows_of(polygons.offsets, indices)
    return RaggedPolygons(offsets, polygons.corners[rows], polygons.owners[indices])


def concatenate(parts: list[RaggedPolygons]) -> RaggedPolygons:
    """Return the polygons of all `parts`, one after another."""
    sizes = np.concatenate([np.diff(part.offsets) for part in parts])
    return RaggedPolygons(
        to_offsets(sizes),
        np.concatenate([part.corners for part in parts]),
        np.concatenate([part.owners for part in parts]),
    )


def min_max(polygons: RaggedPolygons, values: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the least and the greatest of the values (c,) at the corners of each polygon."""
    first = polygons.offsets[:-1]
    if len(first) == 0:
        return np.empty(0), np.empty(0)
    return np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)


def next_corner(polygons: RaggedPolygons) -> IndexArray:
    """Return the index of the corner after each corner of its polygon: (c,)."""
    after = np.arange(1, len(polygons.corners) + 1)
    after[polygons.offsets[1:] - 1] = polygons.offsets[:-1]
    return after


def mean(polygons: RaggedPolygons, values: Float64Array) -> Float64Array:
    """Return the mean of the values (c,) at the corners of each polygon."""
    if len(values) == 0:
        return np.zeros(0)
    result: Float64Array = np.add.reduceat(values, polygons.offsets[:-1]) / np.diff(polygons.offsets)
    return result


def triangulate_fans(polygons: RaggedPolygons) -> tuple[IndexArray, IndexArray]:
    """Split convex polygons into triangles around their first corners.

    Returns the corners of each triangle (t, 3), and the index of its polygon (t,).
    """
    n_triangles = np.diff(polygons.offsets) - 2
    polygon = np.repeat(np.arange(len(n_triangles)), n_triangles)
    first = polygons.offsets[polygon]
    second = first + 1 + np.arange(len(polygon)) - to_offsets(n_triangles)[polygon]
    return np.column_stack([first, second, second + 1]), polygon
