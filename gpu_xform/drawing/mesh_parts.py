"""Meshes of more points than a drawable holds, cut into parts: some edges or triangles, and the points they name."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray


class MeshPart(NamedTuple):
    """Some edges or triangles.

    rows : which of all
    points : (p,), the points that they name
    indices : (k, 2) or (k, 3) uint32, which of those `points` each names
    """

    rows: slice
    points: IndexArray
    indices: npt.NDArray[np.uint32]


def split_by_points(indices: IndexArray, n_points: int, most: int) -> Iterator[MeshPart]:
    """Cut edges (m, 2) or triangles (m, 3) of `n_points` points into parts that name at most `most` points each.

    most : at least 3
    """
    n_rows = most // indices.shape[1]
    number = np.empty(n_points, np.uint32)
    for start in range(0, len(indices), n_rows):
        rows = slice(start, min(start + n_rows, len(indices)))
        own = indices[rows]
        is_used = np.zeros(n_points, np.bool_)
        is_used[own] = True
        points = np.flatnonzero(is_used)
        number[points] = np.arange(len(points), dtype=np.uint32)
        yield MeshPart(rows, points, number[own])
