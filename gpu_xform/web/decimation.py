"""Meshes of fewer edges, for pages that would be too large: points that lie in one cell of a grid become one."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from .._core.types import IndexArray
from ..drawing.layer import Layer
from ..errors import ArgumentError
from ..geometry.edges import list_edge_parts
from ..geometry.mesh import Mesh

MAX_TRIALS = 12
SMALL_EDGES = 100  # of a mesh that stays as it is
AIM = 0.97  # of the edges that may stay


class Decimated(NamedTuple):
    """A mesh, and which point and which face of the original each of its own stands for."""

    mesh: Mesh
    points: IndexArray
    faces: IndexArray


def decimate_layers(layers: Sequence[Layer], max_edges: int) -> list[Layer]:
    """Return layers of at most about `max_edges` edges together; each mesh keeps its share.

    Raises `ArgumentError` for edges by index and their colours, which would be gone, and if nothing would be left.
    """
    n_edges = sum(len(layer.model.edges) for layer in layers if isinstance(layer.model, Mesh))
    if n_edges <= max_edges:
        return list(layers)
    large = [layer.model for layer in layers if isinstance(layer.model, Mesh) and len(layer.model.edges) > SMALL_EDGES]
    n_large = sum(len(mesh.edges) for mesh in large)
    rest = max(max_edges - (n_edges - n_large), 1)
    made: dict[int, Decimated] = {}
    for mesh in large:
        if id(mesh) not in made:
            made[id(mesh)] = decimate(mesh, max(rest * len(mesh.edges) // n_large, 1))
    return [_replace_model(layer, made[id(layer.model)]) if id(layer.model) in made else layer for layer in layers]


def decimate(mesh: Mesh, max_edges: int) -> Decimated:
    """Return a mesh of at most `max_edges` edges, by clustering its points in cells of a grid, as fine as that allows.

    Rossignac and Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993. A cell's point is the
    mean of those in it; faces that lose a dimension are left out.
    """
    best: Decimated | None = None
    n_cells = max(np.sqrt(max_edges / 3.0), 2.0)
    for _ in range(MAX_TRIALS):
        found = _cluster(mesh, n_cells)
        n_edges = len(found.mesh.edges)
        if n_edges <= max_edges and (best is None or n_edges > len(best.mesh.edges)):
            best = found
        if AIM * AIM * max_edges <= n_edges <= max_edges:
            break
        n_cells *= float(np.clip(np.sqrt(AIM * max_edges / max(n_edges, 1)), 0.25, 4.0))
    if best is None or best.mesh.n_faces == 0:
        raise ArgumentError.expecting("max_edges", "leave some edges of each model", max_edges)
    return best


def _cluster(mesh: Mesh, n_cells: float) -> Decimated:
    """Return the mesh with one point per cell of a grid of `n_cells` along the longest side of its box."""
    low, high = mesh.bounds
    cells = np.floor((mesh.positions - low) * (n_cells / float((high - low).max() or 1.0))).astype(np.int64)
    spans = cells.max(axis=0) + 1
    keys = (cells[:, 0] * spans[1] + cells[:, 1]) * spans[2] + cells[:, 2]
    _, first, cluster = np.unique(keys, return_index=True, return_inverse=True)
    counts = np.bincount(cluster)
    means = np.stack([np.bincount(cluster, weights=column) / counts for column in mesh.positions.T], axis=1)
    sizes = np.diff(mesh.offsets)
    corners = cluster[mesh.indices]
    following = np.roll(corners, -1)
    following[mesh.offsets[1:] - 1] = corners[mesh.offsets[:-1]]
    is_kept = corners != following
    new_sizes = np.add.reduceat(is_kept.astype(np.int64), mesh.offsets[:-1]) if len(sizes) else sizes
    faces = np.flatnonzero(new_sizes >= np.where(sizes == 2, 2, 3))
    of_face = np.repeat(np.isin(np.arange(len(sizes)), faces), sizes)
    indices, kept_sizes = corners[is_kept & of_face], new_sizes[faces]
    if len(faces) and (kept_sizes == 3).all():  # two faces may have come to lie in one place
        _, once = np.unique(np.sort(indices.reshape(-1, 3), axis=1), axis=0, return_index=True)
        once.sort()
        indices, kept_sizes, faces = indices.reshape(-1, 3)[once].ravel(), kept_sizes[once], faces[once]
    used, compact = np.unique(indices, return_inverse=True)
    offsets = np.concatenate([[0], np.cumsum(kept_sizes)])
    return Decimated(Mesh.from_offsets(means[used], offsets, compact), first[used], faces)


def _replace_model(layer: Layer, found: Decimated) -> Layer:
    parts = [] if layer.edges is None else list_edge_parts(layer.edges)
    if any(not isinstance(part, str) for part in parts):
        raise ArgumentError(
            "max_edges cannot go with edges by index, of which it leaves points out", argument="max_edges"
        )
    if layer.edge_colors is not None:
        raise ArgumentError("max_edges cannot go with edge_colors, of which it leaves edges out", argument="max_edges")
    changes: dict[str, Any] = {"model": found.mesh}
    n_faces = len(layer.model.offsets) - 1 if isinstance(layer.model, Mesh) else 0
    for name, rows in (("vertex_colors", found.points), ("scalars", found.points), ("face_colors", found.faces)):
        value = getattr(layer, name)
        if value is not None:
            changes[name] = [value[row] for row in rows] if isinstance(value, list) else np.asarray(value)[rows]
    fill = layer.fill
    if fill is not None and not isinstance(fill, str) and len(fill) == n_faces and n_faces > 4:
        changes["fill"] = (
            [fill[row] for row in found.faces] if isinstance(fill, list) else np.asarray(fill)[found.faces]
        )
    return replace(layer, **changes)
