"""A mesh for a page: positions on a grid, faces, and what the page cannot find out about its edges by itself."""

from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray
from ..drawing.geometry_source import MeshSource
from ..drawing.layer import Layer
from ..drawing.silhouettes import NO_FACE
from ..geometry.edges import compute_face_normals, compute_plane_normals, find_edge_faces, is_drawable, resolve_edges
from ..geometry.mesh import Mesh, pack_pairs
from .arrays import ArrayStore

GRID_STEPS = (
    1 << 19
) - 1  # from the centre of a model to its farthest coordinate: 2^-20 of it is too little to be seen
_MAX_GRID_VALUE = 1 << 30  # of points that nothing shows


def describe_mesh(source: MeshSource, layer: Layer, store: ArrayStore) -> dict[str, Any]:
    """Return what `js/mesh.js` makes a mesh of; arrays go to `store`.

    layer : whose feature angle counts
    """
    mesh = source.mesh
    center, half_size = source.model_from_points[:3, 3], float(source.model_from_points[0, 0])
    grid = np.rint(source.in_unit_cube() * GRID_STEPS)
    sizes = np.diff(mesh.offsets)
    is_uniform = len(sizes) > 0 and (sizes == sizes[0]).all()
    given: dict[str, Any] = {
        "center": center.tolist(),
        "half_size": half_size,
        "step": 1.0 / GRID_STEPS,
        "positions": store.add_integers(np.clip(grid, -_MAX_GRID_VALUE, _MAX_GRID_VALUE).astype(np.int64)),
        "indices": store.add_indices(_by_corner(mesh.indices, sizes)),
        "sizes": store.add_integers(sizes[:1] if is_uniform else sizes),
        "n_points": mesh.n_points,
        "n_edges": len(mesh.edges),
    }
    if mesh.n_faces:
        given |= _describe_triangles(source, store)
        given |= _describe_edges(mesh, layer.feature_angle, store)
    return given


def _by_corner(indices: IndexArray, sizes: IndexArray) -> IndexArray:
    """Return corners as a table with a row per face if all have as many, which compresses better."""
    is_uniform = len(sizes) > 0 and (sizes == sizes[0]).all()
    return indices.reshape(-1, int(sizes[0])) if is_uniform else indices


def _describe_triangles(source: MeshSource, store: ArrayStore) -> dict[str, Any]:
    corners, faces = source.triangles()
    fan_corners, fan_faces = _make_fans(source.mesh)
    if np.array_equal(corners, fan_corners) and np.array_equal(faces, fan_faces):
        return {}
    return {"triangles": store.add_indices(corners), "triangle_faces": store.add_integers(faces)}


def _make_fans(mesh: Mesh) -> tuple[IndexArray, IndexArray]:
    """Return the triangles around the first corner of each face, and their faces, as the page makes them."""
    sizes = np.diff(mesh.offsets)
    faces = np.repeat(np.arange(mesh.n_faces), np.maximum(sizes - 2, 0))
    first = mesh.offsets[:-1][faces]
    starts = np.cumsum(np.maximum(sizes - 2, 0)) - np.maximum(sizes - 2, 0)
    k = np.arange(len(faces)) - starts[faces] + 1
    return np.stack([mesh.indices[first], mesh.indices[first + k], mesh.indices[first + k + 1]], axis=1), faces


def _describe_edges(mesh: Mesh, feature_angle: float, store: ArrayStore) -> dict[str, Any]:
    found = find_edge_faces(mesh)
    keys = pack_pairs(*mesh.edges.T)
    described: dict[str, Any] = {}
    for name in ("feature", "boundary"):
        chosen = np.isin(keys, pack_pairs(*resolve_edges(mesh, name, feature_angle).T))
        if chosen.any():
            described[name] = store.add_integers(np.packbits(chosen, bitorder="little"))
    drawable = is_drawable(mesh, found)
    between_two = (found.n_faces == 2) & ~found.segments
    faces = np.where(between_two[:, None], found.faces, NO_FACE)
    turned = found.inconsistent_winding & between_two
    rows = np.searchsorted(keys, pack_pairs(*found.edges.T))
    candidates = np.column_stack([rows, faces, turned])[drawable].astype(np.int64)
    if not np.array_equal(candidates, _find_candidates(mesh)):
        described["candidates"] = store.add_integers(candidates)
    slivers = np.flatnonzero((compute_face_normals(mesh) != compute_plane_normals(mesh, lambda: found)).any(axis=1))
    if len(slivers):
        described["sliver_faces"] = store.add_integers(slivers)
        described["sliver_normals"] = store.add_floats(compute_plane_normals(mesh, lambda: found)[slivers])
    return described


def _find_candidates(mesh: Mesh) -> npt.NDArray[np.int64]:
    """Return the edges that can be seen edge-on, as `PageMesh.candidates` finds them, which merges no points."""
    start, end = mesh.face_edges.T
    proper = start != end
    start, end, faces = start[proper], end[proper], mesh.face_edge_faces[proper]
    order = np.argsort(pack_pairs(start, end), kind="stable")
    keys, faces, forward = pack_pairs(start, end)[order], faces[order], (start < end)[order]
    is_segment = (np.diff(mesh.offsets) == 2)[faces]
    same_next = np.zeros(len(keys), np.bool_)
    same_next[:-1] = (keys[1:] == keys[:-1]) & (faces[1:] == faces[:-1])
    beside = ~is_segment & ~same_next & ~np.roll(same_next, 1)
    group = np.cumsum(np.diff(keys, prepend=keys[:1] - np.uint64(1)) != 0) - 1
    n = len(mesh.edges)
    n_faces = np.bincount(group[beside], minlength=n)
    has_segment = np.bincount(group[is_segment], minlength=n) > 0
    a, b = mesh.positions[mesh.edges.T]
    shown = has_segment | ((n_faces > 0) & (a != b).any(axis=1))
    result = np.full((n, 4), NO_FACE, np.int64)
    result[:, 0], result[:, 3] = np.arange(n), 0
    two = (n_faces == 2) & ~has_segment
    first = np.searchsorted(group[beside], np.flatnonzero(two))
    one, other = np.flatnonzero(beside)[first], np.flatnonzero(beside)[first + 1]
    result[two, 1], result[two, 2], result[two, 3] = faces[one], faces[other], forward[one] == forward[other]
    candidates: npt.NDArray[np.int64] = result[shown]
    return candidates
