"""Corner normals: the directions in which a smooth surface turns at the corners of the faces that stand for it."""

from typing import NamedTuple

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from .._core.widen import widen
from .components import number_components
from .edges import compute_plane_normals, find_edge_faces, measure_turns, merge_coincident_points
from .mesh import Mesh, pack_pairs

NORMAL = "normal"  # the attribute


def find_corner_normals(mesh: Mesh, crease_angle: float) -> Float64Array:
    """Return the unit normal at each corner, in the order of `mesh.indices`: (c, 3); zero at those of segments.

    They are the attribute "normal" of the mesh, per corner or per point. Where there is none, or one of length zero, it
    is the mean of the normals of the faces about the point, weighted by their angles there: Thürmer and Wüthrich,
    "Computing vertex normals from polygonal facets", 1998. Faces count that are joined by edges at which they turn by
    at most `crease_angle` degrees, so that sharp edges stay sharp. Points that coincide, but for rounding, are one.
    """
    own = _own_normals(mesh)
    if own is None:
        return _compute_corner_normals(mesh, crease_angle)
    is_missing = ~own.any(axis=1)
    if is_missing.any():
        own[is_missing] = _compute_corner_normals(mesh, crease_angle)[is_missing]
    return own


def _own_normals(mesh: Mesh) -> Float64Array | None:
    """Return the attribute "normal" at each corner (c, 3), of length 1, or 0 where it says nothing; None without it."""
    for table, rows in ((mesh.attributes.corner, slice(None)), (mesh.attributes.point, mesh.indices)):
        column = table.get(NORMAL)
        if isinstance(column, np.ndarray) and column.dtype.kind in "iuf" and column.shape[1:] == (3,):
            normals: Float64Array = widen(column[rows])
            return _normalize(np.where(np.isfinite(normals).all(axis=1, keepdims=True), normals, 0.0))
    return None


def _compute_corner_normals(mesh: Mesh, crease_angle: float) -> Float64Array:
    face_normals = compute_plane_normals(mesh, lambda: find_edge_faces(mesh))
    sizes = np.diff(mesh.offsets)
    face_of = np.repeat(np.arange(mesh.n_faces), sizes)
    after = np.arange(1, len(mesh.indices) + 1)
    has_corners = sizes > 0
    after[mesh.offsets[1:][has_corners] - 1] = mesh.offsets[:-1][has_corners]
    halves = _pair_half_edges(mesh, face_of, after)
    one, other = face_normals[face_of[halves.pairs]].transpose(1, 0, 2)
    is_smooth = measure_turns(one, other, halves.is_same_way) <= crease_angle
    is_smooth |= ~(one.any(axis=1) & other.any(axis=1))  # a face without area makes no crease
    first, second = halves.pairs[is_smooth].T
    is_same_way = halves.is_same_way[is_smooth]
    links = np.concatenate(
        [
            np.column_stack([first, np.where(is_same_way, second, after[second])]),
            np.column_stack([after[first], np.where(is_same_way, after[second], second)]),
        ]
    )
    groups = _group_corners(halves.points, links, _corners_at_breaks(halves, is_smooth, after))
    corner_normals = face_normals[face_of]
    turned = _find_turned(groups, links[np.tile(is_same_way, 2)], corner_normals)
    weights = np.where(turned, -1.0, 1.0) * _corner_angles(mesh, after)
    sums = np.zeros((groups.max(initial=-1) + 1, 3))
    for axis in range(3):
        sums[:, axis] = np.bincount(groups, weights * corner_normals[:, axis], len(sums))
    result = _normalize(sums)[groups]
    result[turned] *= -1.0
    return np.where(result.any(axis=1, keepdims=True), result, corner_normals)


class _HalfEdges(NamedTuple):
    """The sides of the faces: half-edge i goes from corner i to the next one of its face.

    points : (c,) the number of each corner's point; coincident points of edges of one face share it
    pairs : (p, 2) half-edges along one edge that has two faces
    is_same_way : (p,) both pass it in one direction: the faces are wound in opposite senses
    """

    points: IndexArray
    pairs: IndexArray
    is_same_way: BoolArray


def _pair_half_edges(mesh: Mesh, face_of: IndexArray, after: IndexArray) -> _HalfEdges:
    """Pair half-edges as `find_edge_faces` does faces: by their points, and alone ones by where these are."""
    points = mesh.indices.astype(np.int64)
    is_proper = np.diff(mesh.offsets)[face_of] > 2
    half_edges = np.flatnonzero(is_proper & (points != points[after]))
    pairs, lone = _pair(half_edges, points, after, face_of)
    if len(lone):
        ends = np.unique(np.append(points[lone], points[after[lone]]))
        merged = merge_coincident_points(mesh.positions, ends)
        if len(np.unique(merged)) < len(ends):
            numbers = np.arange(mesh.n_points)
            numbers[ends] = mesh.n_points + merged
            points = numbers[points]
            more, _ = _pair(lone[points[lone] != points[after[lone]]], points, after, face_of)
            pairs = np.concatenate([pairs, more])
    first, second = pairs.T
    return _HalfEdges(points, pairs, points[first] == points[second])


def _pair(
    half_edges: IndexArray, points: IndexArray, after: IndexArray, face_of: IndexArray
) -> tuple[IndexArray, IndexArray]:
    """Return pairs (p, 2) of half-edges of two faces along one edge, and those (q,) that are alone on theirs."""
    keys = pack_pairs(points[half_edges], points[after[half_edges]])
    order = np.argsort(keys, kind="stable")
    keys, half_edges = keys[order], half_edges[order]
    starts = np.flatnonzero(np.append(True, keys[1:] != keys[:-1])) if len(keys) else np.empty(0, np.int64)
    counts = np.diff(starts, append=len(keys))
    two = starts[counts == 2]
    pairs = np.column_stack([half_edges[two], half_edges[two + 1]])
    return pairs[face_of[pairs[:, 0]] != face_of[pairs[:, 1]]], half_edges[starts[counts == 1]]


def _corners_at_breaks(halves: _HalfEdges, is_smooth: BoolArray, after: IndexArray) -> BoolArray:
    """Return which corners (c,) are at points of edges across which the surface does not go on smoothly."""
    goes_on = np.zeros(len(halves.points), np.bool_)
    goes_on[halves.pairs[is_smooth]] = True
    is_at_break = np.zeros(int(halves.points.max(initial=-1)) + 1, np.bool_)
    is_at_break[halves.points[~goes_on]] = is_at_break[halves.points[after[~goes_on]]] = True
    result: BoolArray = is_at_break[halves.points]
    return result


def _group_corners(points: IndexArray, links: IndexArray, is_at_break: BoolArray) -> IndexArray:
    """Return the number of each corner's group (c,): all about a point, or only those that links (l, 2) join there."""
    number = np.full(len(points), -1)
    loose = np.flatnonzero(is_at_break)
    number[loose] = np.arange(len(loose))
    groups = points.copy()
    groups[loose] = points.max(initial=-1) + 1 + number_components(len(loose), number[links[is_at_break[links[:, 0]]]])
    return groups


def _find_turned(groups: IndexArray, reversing: IndexArray, normals: Float64Array) -> BoolArray:
    """Return which corners' faces are wound against the first one of their group, if some of a group are.

    reversing : (r, 2) corners that are joined at an edge whose two faces are wound in opposite senses
    normals : (c, 3) of the faces of the corners
    """
    turned = np.zeros(len(groups), np.bool_)
    if len(reversing):
        is_mixed = np.zeros(groups.max() + 1, np.bool_)
        is_mixed[groups[reversing[:, 0]]] = True
        corners = np.flatnonzero(is_mixed[groups])
        _, first, inverse = np.unique(groups[corners], return_index=True, return_inverse=True)
        turned[corners] = np.einsum("ij,ij->i", normals[corners], normals[corners[first]][inverse]) < 0.0
    return turned


def _corner_angles(mesh: Mesh, after: IndexArray) -> Float64Array:
    """Return the angle between the sides of a face at each corner: (c,) radians."""
    ends = 0.5 * mesh.positions[mesh.indices]  # halves, whose difference cannot overflow
    along = _normalize(ends[after] - ends)
    before = np.empty_like(along)
    before[after] = -along
    apart, together = (np.sqrt(np.einsum("ij,ij->i", vector, vector)) for vector in (along - before, along + before))
    angles: Float64Array = 2.0 * np.arctan2(apart, together)
    return angles


def _normalize(vectors: Float64Array) -> Float64Array:
    """Return vectors (n, 3) of length 1, and zero ones as they are."""
    largest = np.abs(vectors).max(axis=1, keepdims=True, initial=0.0)
    scaled = vectors / np.where(largest > 0.0, largest, 1.0)
    lengths = np.sqrt(np.einsum("ij,ij->i", scaled, scaled))
    result: Float64Array = scaled / np.where(lengths > 0.0, lengths, 1.0)[:, np.newaxis]
    return result
