"""Intersections: the lines along which the faces of bodies that penetrate one another meet."""

from typing import NamedTuple

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from .box_tree import find_overlapping_boxes
from .components import number_components
from .edges import find_edge_faces, merge_coincident_points
from .mesh import Mesh

MAX_PAIRS = 1 << 25  # of triangles whose boxes overlap
PAIRS_PER_BLOCK = 1 << 18
ON_PLANE_TOLERANCE = 1e-12  # of the extent: a corner that is nearer to a plane lies in it
MIN_SINE = 1e-10  # of the angle between two planes: those of less are parallel


class Segments(NamedTuple):
    """Segments in space: points (p, 3), edges (m, 2) of their indices, and the triangles (m, 2) that meet in each."""

    points: Float64Array
    edges: IndexArray
    triangles: IndexArray


def number_bodies(mesh: Mesh) -> IndexArray:
    """Return the number of each face's body, from 0: faces that `find_edge_faces` finds at one edge are of one body."""
    pairs = find_edge_faces(mesh).faces
    pairs = pairs[(pairs >= 0).all(axis=1)]
    return number_components(mesh.n_faces, pairs)


def intersect_bodies(points: Float64Array, triangles: IndexArray, bodies: IndexArray) -> Segments:
    """Return where triangles (t, 3) of different bodies (t,) meet, but in parallel planes: touching faces give nothing.

    A corner in the plane of a triangle counts as before it, so that lines of closed bodies are closed; Möller, "A fast
    triangle-triangle intersection test", 1997, has the intervals. Neighbours share the ends of their segments exactly.
    Raises `OverflowError` if the boxes of more than `MAX_PAIRS` pairs overlap.
    """
    nothing = Segments(np.empty((0, 3)), np.empty((0, 2), np.int64), np.empty((0, 2), np.int64))
    if len(triangles) == 0 or bodies.min() == bodies.max():
        return nothing
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    extent = float(np.abs(points - center).max()) or 1.0
    unit = (points - center) / extent
    corners = unit[triangles]
    with np.errstate(invalid="ignore"):
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.sqrt(np.einsum("ij,ij->i", normals, normals))[:, np.newaxis]
    low, high = corners.min(axis=1) - ON_PLANE_TOLERANCE, corners.max(axis=1) + ON_PLANE_TOLERANCE
    has_area = np.isfinite(normals).all(axis=1)
    rows = np.flatnonzero(has_area & _reach_others(low, high, bodies))
    if len(rows) == 0:
        return nothing
    i, j = find_overlapping_boxes(low[rows], high[rows], bodies[rows], MAX_PAIRS)
    i, j = rows[i], rows[j]
    ends, pairs = [np.empty((0, 2, 3))], [np.empty((0, 2), np.int64)]
    for first in range(0, len(i), PAIRS_PER_BLOCK):
        block = slice(first, first + PAIRS_PER_BLOCK)
        found, meets = _intersect_pairs(unit, triangles, normals, i[block], j[block])
        ends.append(found)
        pairs.append(np.column_stack([i[block][meets], j[block][meets]]))
    all_ends = np.concatenate(ends)
    if len(all_ends) == 0:
        return nothing
    flat = all_ends.reshape(-1, 3)
    # Where an edge meets an edge, either plane has an end there, and they differ by rounding.
    numbers = merge_coincident_points(flat, np.arange(len(flat)).reshape(-1, 2))
    _, rows_of_points, edges = np.unique(numbers, return_index=True, return_inverse=True)
    edges = edges.reshape(-1, 2).astype(np.int64)
    is_long = edges[:, 0] != edges[:, 1]
    return Segments(center + extent * flat[rows_of_points], edges[is_long], np.concatenate(pairs)[is_long])


def _reach_others(low: Float64Array, high: Float64Array, bodies: IndexArray) -> BoolArray:
    """Return which triangles' boxes meet the box of another body: few of many bodies that are apart."""
    n = int(bodies.max()) + 1
    lowest, highest = np.full((n, 3), np.inf), np.full((n, 3), -np.inf)
    np.minimum.at(lowest, bodies, low)
    np.maximum.at(highest, bodies, high)
    one, other = find_overlapping_boxes(lowest, highest, np.arange(n), MAX_PAIRS)
    reaches = np.zeros(n, np.bool_)
    reaches[one] = reaches[other] = True
    return reaches[bodies]


def _intersect_pairs(
    points: Float64Array, triangles: IndexArray, normals: Float64Array, i: IndexArray, j: IndexArray
) -> tuple[Float64Array, IndexArray]:
    """Return the ends (k, 2, 3) of the segments in which pairs of triangles meet, and which of the pairs do (k,)."""
    distances_i, distances_j = (
        _distances(points, triangles, normals, i, j),
        _distances(points, triangles, normals, j, i),
    )
    rows = np.flatnonzero(_is_mixed(distances_i) & _is_mixed(distances_j))
    i, j, distances_i, distances_j = i[rows], j[rows], distances_i[rows], distances_j[rows]
    along = np.cross(normals[i], normals[j])
    is_crossing = np.sqrt(np.einsum("ij,ij->i", along, along)) > MIN_SINE
    rows, i, j, along = rows[is_crossing], i[is_crossing], j[is_crossing], along[is_crossing]
    along /= np.sqrt(np.einsum("ij,ij->i", along, along))[:, np.newaxis]
    places, positions = [], []
    for triangle, distances in ((i, distances_i[is_crossing]), (j, distances_j[is_crossing])):
        crossings = _plane_crossings(points, triangles[triangle], distances)
        at = np.einsum("kci,ki->kc", crossings, along)
        order = np.argsort(at, axis=1)
        positions.append(np.take_along_axis(at, order, axis=1))
        places.append(np.take_along_axis(crossings, order[..., np.newaxis], axis=1))
    begins = np.where((positions[0][:, :1] >= positions[1][:, :1]), places[0][:, 0], places[1][:, 0])
    stops = np.where((positions[0][:, 1:] <= positions[1][:, 1:]), places[0][:, 1], places[1][:, 1])
    start = np.maximum(positions[0][:, 0], positions[1][:, 0])
    stop = np.minimum(positions[0][:, 1], positions[1][:, 1])
    meets = stop - start > ON_PLANE_TOLERANCE
    return np.stack([begins, stops], axis=1)[meets], rows[meets]


def _distances(
    points: Float64Array, triangles: IndexArray, normals: Float64Array, i: IndexArray, j: IndexArray
) -> Float64Array:
    """Return the distances of the corners of triangles i from the planes of triangles j: (k, 3)."""
    from_corner = points[triangles[i]] - points[triangles[j, :1]]
    distances: Float64Array = np.einsum("kci,ki->kc", from_corner, normals[j])
    distances[np.abs(distances) <= ON_PLANE_TOLERANCE] = 0.0
    return distances


def _is_mixed(distances: Float64Array) -> BoolArray:
    """Say whether some corners are before a plane, or in it, and others behind it."""
    is_before = distances >= 0.0
    return np.logical_and(is_before.any(axis=1), ~is_before.all(axis=1))


def _plane_crossings(points: Float64Array, triangles: IndexArray, distances: Float64Array) -> Float64Array:
    """Return where two sides of each triangle cross the plane that its corners lie at `distances` (k, 3) from.

    A side is passed from its lower end to its higher one, so that both triangles at it find the same numbers.
    """
    is_before = distances >= 0.0
    alone = np.where(is_before.sum(axis=1) == 1, is_before.argmax(axis=1), is_before.argmin(axis=1))
    row = np.arange(len(triangles))
    crossings = np.empty((len(triangles), 2, 3))
    for side in (0, 1):
        one, other = alone, (alone + 1 + side) % 3
        swapped = _is_higher(points[triangles[row, one]], points[triangles[row, other]])
        one, other = np.where(swapped, other, one), np.where(swapped, one, other)
        start, stop = distances[row, one], distances[row, other]
        share = (start / (start - stop))[:, np.newaxis]
        p, q = points[triangles[row, one]], points[triangles[row, other]]
        crossings[:, side] = p + share * (q - p)
    return crossings


def _is_higher(p: Float64Array, q: Float64Array) -> BoolArray:
    """Say whether points p (k, 3) come after points q in lexicographic order."""
    x, y, z = (p[:, axis] > q[:, axis] for axis in range(3))
    return np.asarray(np.where(p[:, 0] != q[:, 0], x, np.where(p[:, 1] != q[:, 1], y, z)))
