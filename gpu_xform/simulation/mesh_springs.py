"""Springs of a mesh: along edges, across polygons, and between faces that share an edge."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array, IndexArray
from ..geometry.mesh import Mesh, pack_pairs, unpack_pairs
from ..geometry.triangulation import triangulate

_Keys: TypeAlias = npt.NDArray[np.uint64]


def list_mesh_springs(mesh: Mesh) -> tuple[IndexArray, IndexArray, IndexArray]:
    """Return the pairs of points (k, 2) that springs for stretch, shear and bending join; no pair comes twice.

    Stretch: every edge. Shear: the diagonals of each quad. Bending: around each end of an edge between two faces, the
    neighbours of that end in the two faces; so for triangles their opposite corners, and for quads the points two edges
    apart along a row. At a point where two segments meet, their other ends.
    """
    stretch = pack_pairs(*mesh.edges.T)
    shear = np.setdiff1d(_diagonals(mesh), stretch)
    bend = np.setdiff1d(np.concatenate([_across_edges(mesh), _across_joints(mesh)]), np.concatenate([stretch, shear]))
    return unpack_pairs(stretch), unpack_pairs(shear), unpack_pairs(bend)


def list_triangles(mesh: Mesh) -> IndexArray:
    """Return the polygons as triangles (t, 3)."""
    return triangulate(mesh.positions, mesh.offsets, mesh.indices)[0]


def share_areas(mesh: Mesh) -> Float64Array:
    """Return the area around each point (n,): of each face, the same part for each corner."""
    corners, faces = triangulate(mesh.positions, mesh.offsets, mesh.indices)
    a, b, c = (mesh.positions[corner] for corner in corners.T)
    face_areas = np.bincount(faces, 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1), mesh.n_faces)
    sizes = np.diff(mesh.offsets)
    weights = np.repeat(face_areas / sizes, sizes)
    return np.bincount(mesh.indices, weights, mesh.n_points).astype(np.float64)


def _diagonals(mesh: Mesh) -> _Keys:
    """Return the keys of the diagonals of every quad."""
    starts = mesh.offsets[:-1][np.diff(mesh.offsets) == 4]
    corners = mesh.indices[starts[:, np.newaxis] + np.arange(4)]
    first, second = corners[:, :2].ravel(), corners[:, 2:].ravel()
    return _key_distinct(first, second)


def _across_edges(mesh: Mesh) -> _Keys:
    """Return the keys of the pairs that bending joins across every edge that two polygons share."""
    sizes = np.diff(mesh.offsets)
    is_polygon = np.repeat(sizes > 2, sizes)
    ends = np.repeat(mesh.offsets[1:], sizes)
    starts = np.repeat(mesh.offsets[:-1], sizes)
    corner = np.arange(len(mesh.indices))
    following = np.where(corner + 1 == ends, starts, corner + 1)
    beyond = np.where(following + 1 == ends, starts, following + 1)
    preceding = np.where(corner == starts, ends - 1, corner - 1)
    a, b = mesh.indices, mesh.indices[following]
    beside_a, beside_b = mesh.indices[preceding], mesh.indices[beyond]
    keep = is_polygon & (a != b)
    a, b, beside_a, beside_b = a[keep], b[keep], beside_a[keep], beside_b[keep]
    beside_lower, beside_upper = np.where(a < b, beside_a, beside_b), np.where(a < b, beside_b, beside_a)
    keys = pack_pairs(a, b)
    order = np.argsort(keys, kind="stable")
    one, other = order[:-1], order[1:]
    shared = _is_pair(keys[order])
    one, other = one[shared], other[shared]
    first = np.concatenate([beside_lower[one], beside_upper[one]])
    second = np.concatenate([beside_lower[other], beside_upper[other]])
    return _key_distinct(first, second)


def _is_pair(keys: _Keys) -> BoolArray:
    """Return for all sorted keys but the last whether exactly that key and the next are equal."""
    same = keys[1:] == keys[:-1]
    before, after = np.r_[False, same[:-1]], np.r_[same[1:], False]
    pairs: BoolArray = same & ~before[: len(same)] & ~after[: len(same)]
    return pairs


def _key_distinct(first: IndexArray, second: IndexArray) -> _Keys:
    """Return the keys of the pairs of two different points."""
    keys: _Keys = pack_pairs(first, second)[first != second]
    return keys


def _across_joints(mesh: Mesh) -> _Keys:
    """Return the keys of the other ends of two segments that meet at a point where nothing else does."""
    sizes = np.diff(mesh.offsets)
    starts = mesh.offsets[:-1][sizes == 2]
    segments = mesh.indices[starts[:, np.newaxis] + np.arange(2)]
    segments = unpack_pairs(np.unique(pack_pairs(*segments.T)[segments[:, 0] != segments[:, 1]]))
    points, others = segments.ravel(), segments[:, ::-1].ravel()
    in_polygon = np.zeros(mesh.n_points, np.bool_)
    in_polygon[mesh.indices[np.repeat(sizes > 2, sizes)]] = True
    joints = (np.bincount(points, minlength=mesh.n_points) == 2) & ~in_polygon
    order = np.argsort(points, kind="stable")
    pairs = others[order][joints[points[order]]].reshape(-1, 2)
    return pack_pairs(*pairs.T)
