"""Reading and writing with trimesh, for formats that hold triangles alone."""

from io import BytesIO
from typing import Any, BinaryIO

import numpy as np

from ..errors import MeshError
from ..geometry.mesh import Mesh
from ._concatenate import concatenate


def load(data: bytes, file_type: str) -> Mesh:
    """Return all triangles of a file that trimesh reads, transformed to the world by the nodes of its scene."""
    import trimesh

    try:
        scene = trimesh.load_scene(BytesIO(data), file_type=file_type, process=False, skip_materials=True)
        parts = [_transform_geometry(scene, node) for node in scene.graph.nodes_geometry]
    except MemoryError:
        raise
    except Exception as error:  # a damaged file can make trimesh raise anything
        raise MeshError(f"trimesh cannot read this {file_type.upper()}: {type(error).__name__}: {error}") from error
    parts = [part for part in parts if len(part[1])]
    if not parts:
        raise MeshError(f"this {file_type.upper()} has no triangles")
    return concatenate([Mesh(points, triangles) for points, triangles in parts])


def _transform_geometry(scene: Any, node: str) -> tuple[Any, Any]:
    """Return the points in the world and the triangles of a node's geometry."""
    matrix, name = scene.graph[node]
    geometry = scene.geometry[name]
    if not hasattr(geometry, "faces"):
        return np.empty((0, 3)), np.empty((0, 3), np.int64)
    with np.errstate(over="ignore", invalid="ignore"):
        points = np.asarray(geometry.vertices, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    return points, np.asarray(geometry.faces)


def export(mesh: Mesh, file: BinaryIO, file_type: str) -> None:
    """Write the polygons of a mesh as triangles; raise MeshError for a mesh with segments or without faces."""
    kind = file_type.upper()
    n_segments = int((np.diff(mesh.offsets) == 2).sum())
    if mesh.n_faces == 0:
        raise MeshError(f"{kind} holds triangles only, this mesh has no faces")
    if n_segments:
        raise MeshError(f"{kind} holds triangles only, this mesh has {n_segments} segments")
    if np.abs(mesh.positions).max() > np.finfo(np.float32).max:
        raise MeshError(f"{kind} holds float32, this mesh has a coordinate of {np.abs(mesh.positions).max():g}")
    file.write(mesh.to_trimesh().export(file_type=file_type))
