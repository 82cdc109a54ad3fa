"""One level of subdivision as a sparse matrix: Catmull and Clark's scheme for polygons, and Loop's for triangles.

Sources: E. Catmull, J. Clark, "Recursively generated B-spline surfaces on arbitrary topological meshes" (1978);
C. Loop, "Smooth subdivision surfaces based on triangles" (1987); for creases T. DeRose, M. Kass, T. Truong,
"Subdivision surfaces in character animation" (1998), with the rules of Pixar's OpenSubdiv: an edge of sharpness s is
sharp for s levels, and between two rules a point is their mean, weighted by the fraction of s.
"""

from typing import Any, TypeAlias

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from .cage import Cage

Sparse: TypeAlias = Any  # a scipy.sparse.csr_array


def refine_catmull_clark(cage: Cage) -> Sparse:
    """Return the matrix to the points of the next level: those of the cage, one per edge, and one per face."""
    face_points = _average_faces(cage)
    edge_midpoints = _average_edges(cage)
    faces_of_edge = _sparse(0.5, cage.edge, cage.face, (cage.n_edges, cage.n_faces))
    smooth_edges = 0.5 * edge_midpoints + 0.5 * (faces_of_edge @ face_points)
    edges = _blend(smooth_edges, edge_midpoints, np.minimum(cage.sharpness, 1.0))
    # (n - 2) / n of the point, 1 / n^2 of each edge's far end, 1 / n^2 of each face's point, for n edges.
    n_edges = np.maximum(_count_edges(cage), 1)
    by_faces = _sparse(1.0, cage.indices, cage.face, (cage.n_points, cage.n_faces))
    around = _scale_rows(by_faces @ face_points + _neighbours(cage), 1.0 / n_edges**2)
    points = _apply_vertex_rules(cage, _diagonal(1.0 - 2.0 / n_edges) + around)
    return _stack([points, edges, face_points])


def divide_into_quads(cage: Cage) -> Cage:
    """Return the next level of Catmull and Clark's scheme.

    Corner c becomes the quad of its point, the edge behind it, its face, and the edge before it.
    """
    n = cage.n_points
    before = cage.edge[cage.preceding]
    at_face = n + cage.n_edges + cage.face
    quads = np.stack([cage.indices, n + cage.edge, at_face, n + before], axis=1)
    inner = 2 * cage.n_edges + np.arange(len(cage.indices))  # from the middle of the edge behind a corner to the face
    edges = [_find_half(cage, cage.edge), inner, inner[cage.preceding], _find_half(cage, before)]
    inner_ends = np.stack([n + cage.edge, at_face], axis=1)
    return _make_child(cage, quads, np.stack(edges, axis=1), inner_ends, n + cage.n_edges + cage.n_faces)


def refine_loop(cage: Cage) -> Sparse:
    """Return the matrix to the points of the next level: those of the cage of triangles, and one per edge."""
    edge_midpoints = _average_edges(cage)
    opposite = cage.indices[cage.preceding]
    wings = _sparse(0.125, cage.edge, opposite, (cage.n_edges, cage.n_points))
    edges = _blend(0.75 * edge_midpoints + wings, edge_midpoints, np.minimum(cage.sharpness, 1.0))
    n_edges = np.maximum(_count_edges(cage), 1)
    beta = (0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / n_edges)) ** 2) / n_edges
    smooth = _diagonal(1.0 - n_edges * beta) + _scale_rows(_neighbours(cage), beta)
    return _stack([_apply_vertex_rules(cage, smooth), edges])


def divide_into_triangles(cage: Cage) -> Cage:
    """Return the next level of Loop's scheme: a triangle becomes one at each of its corners, and the middle."""
    n = cage.n_points
    a, b, c = cage.indices.reshape(-1, 3).T
    ab, bc, ca = (n + cage.edge).reshape(-1, 3).T
    fours = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1)
    inner = 2 * cage.n_edges + np.arange(len(cage.indices))  # between the middles of both edges of a corner
    in_a, in_b, in_c = inner.reshape(-1, 3).T
    a_ab, b_bc, c_ca = _find_half(cage, cage.edge).reshape(-1, 3).T
    a_ca, b_ab, c_bc = _find_half(cage, cage.edge[cage.preceding]).reshape(-1, 3).T
    edges = np.stack([a_ab, in_a, a_ca, b_ab, b_bc, in_b, in_c, c_bc, c_ca, in_b, in_c, in_a], axis=1)
    inner_ends = np.stack([n + cage.edge, n + cage.edge[cage.preceding]], axis=1)
    return _make_child(cage, fours.reshape(-1, 3), edges.reshape(-1, 3), inner_ends, n + cage.n_edges)


def _find_half(cage: Cage, edge: IndexArray) -> IndexArray:
    """Return, for each corner and an edge of its own, the half of that edge at the corner's point."""
    half: IndexArray = 2 * edge + (cage.indices != cage.ends[edge, 0])
    return half


def _make_child(cage: Cage, faces: IndexArray, edges: IndexArray, inner_ends: IndexArray, n_points: int) -> Cage:
    """Return the next level: both halves of each edge keep what is left of its sharpness, edges within faces have none.

    faces, edges : the points and the edges of the corners (f, k); the halves of edge e are 2 e and 2 e + 1
    inner_ends : of the edges within faces
    """
    n_faces, size = faces.shape
    corner = np.arange(faces.size).reshape(n_faces, size)
    middles = np.repeat(cage.n_points + np.arange(cage.n_edges), 2)
    nothing = np.zeros(len(inner_ends))
    left = _soften(cage.corner_sharpness)
    return Cage(
        n_points=n_points,
        offsets=np.arange(0, faces.size + 1, size),
        indices=faces.reshape(-1),
        following=np.roll(corner, -1, axis=1).reshape(-1),
        preceding=np.roll(corner, 1, axis=1).reshape(-1),
        edge=edges.reshape(-1),
        ends=np.concatenate([np.stack([cage.ends.reshape(-1), middles], axis=1), inner_ends]),
        n_edge_faces=np.concatenate([np.repeat(cage.n_edge_faces, 2), np.full(len(inner_ends), 2)]),
        sharpness=np.concatenate([np.repeat(_soften(cage.sharpness), 2), nothing]),
        corner_sharpness=np.concatenate([left, np.zeros(n_points - cage.n_points)]),
    )


def _apply_vertex_rules(cage: Cage, smooth: Sparse) -> Sparse:
    """Return the rows of the cage's own points: smooth, on a crease, or corners that stay; blended between levels."""
    kinds = _classify(cage, cage.sharpness, cage.corner_sharpness)
    after = _classify(cage, _soften(cage.sharpness), _soften(cage.corner_sharpness))
    if not kinds.any() and not after.any():
        return smooth
    weight = np.where(kinds == after, 1.0, _weigh_transitions(cage))
    result: Sparse = 0.0
    rules = [(kinds, cage.sharpness, weight), (after, _soften(cage.sharpness), 1.0 - weight)]
    for kind, sharpness, share in rules:
        masks = (smooth, _crease_rows(cage, sharpness > 0, kind == _CREASE), _diagonal(np.ones(cage.n_points)))
        for number, mask in enumerate(masks):
            rows = np.where(kind == number, share, 0.0)
            if rows.any():
                result = result + _scale_rows(mask, rows)
    return result


_SMOOTH, _CREASE, _CORNER = range(3)


def _classify(cage: Cage, sharpness: Float64Array, corner_sharpness: Float64Array) -> IndexArray:
    """Return the rule of each point: a dart, which has one sharp edge, is smooth, and one of three is a corner."""
    n_sharp = np.bincount(cage.ends[sharpness > 0].reshape(-1), minlength=cage.n_points)
    kinds = np.where(n_sharp > 2, _CORNER, np.where(n_sharp == 2, _CREASE, _SMOOTH))
    is_loose = np.bincount(cage.indices, minlength=cage.n_points) == 0
    return np.where((corner_sharpness > 0) | is_loose, _CORNER, kinds)


def _crease_rows(cage: Cage, is_sharp: BoolArray, on_crease: BoolArray) -> Sparse:
    """Return rows of 3/4 of the point itself and 1/8 of both neighbours along its sharp edges."""
    a, b = cage.ends[is_sharp].T
    rows, columns = np.concatenate([a, b]), np.concatenate([b, a])
    used = on_crease[rows]
    neighbours = _sparse(0.125, rows[used], columns[used], (cage.n_points, cage.n_points))
    return _diagonal(np.where(on_crease, 0.75, 0.0)) + neighbours


def _soften(sharpness: Float64Array) -> Float64Array:
    """Return what is left of sharpness one level on."""
    return np.maximum(sharpness - 1.0, 0.0)


def _weigh_transitions(cage: Cage) -> Float64Array:
    """Return the weight of this level's rule for each point: the mean sharpness of what ceases to be sharp, up to 1."""
    ceases = (cage.sharpness > 0) & (cage.sharpness <= 1)
    total = np.bincount(
        cage.ends[ceases].reshape(-1), weights=np.repeat(cage.sharpness[ceases], 2), minlength=cage.n_points
    )
    count = np.bincount(cage.ends[ceases].reshape(-1), minlength=cage.n_points)
    return np.minimum(total / np.maximum(count, 1), 1.0)


def _count_edges(cage: Cage) -> IndexArray:
    return np.bincount(cage.ends.reshape(-1), minlength=cage.n_points)


def _neighbours(cage: Cage) -> Sparse:
    """Return the matrix that adds the far ends of the edges of each point."""
    a, b = cage.ends.T
    shape = (cage.n_points, cage.n_points)
    return _sparse(1.0, np.concatenate([a, b]), np.concatenate([b, a]), shape)


def _average_faces(cage: Cage) -> Sparse:
    """Return the matrix of the centroids of the corners of each face."""
    return _scale_rows(_sparse(1.0, cage.face, cage.indices, (cage.n_faces, cage.n_points)), 1.0 / cage.sizes)


def _average_edges(cage: Cage) -> Sparse:
    """Return the matrix of the middles of edges."""
    rows = np.repeat(np.arange(cage.n_edges), 2)
    return _sparse(0.5, rows, cage.ends.reshape(-1), (cage.n_edges, cage.n_points))


def _blend(smooth: Sparse, sharp: Sparse, weight: Float64Array) -> Sparse:
    """Return the rows of two matrices, mixed by the weight of the second."""
    if not weight.any():
        return smooth
    return _scale_rows(smooth, 1.0 - weight) + _scale_rows(sharp, weight)


def _sparse(value: float, rows: IndexArray, columns: IndexArray, shape: tuple[int, int]) -> Sparse:
    from scipy.sparse import csr_array

    # SciPy looks through wide indices before it narrows them itself.
    narrow = rows.astype(np.int32), columns.astype(np.int32)
    return csr_array((np.full(len(rows), value), narrow), shape=shape)


def _diagonal(values: Float64Array) -> Sparse:
    from scipy.sparse import csr_array

    n = len(values)
    return csr_array((values, np.arange(n, dtype=np.int32), np.arange(n + 1, dtype=np.int32)), shape=(n, n))


def _scale_rows(matrix: Sparse, factors: Float64Array) -> Sparse:
    scaled = matrix.copy()
    scaled.data *= np.repeat(factors, np.diff(matrix.indptr))
    return scaled


def _stack(parts: list[Sparse]) -> Sparse:
    from scipy.sparse import vstack

    return vstack(parts, format="csr")
