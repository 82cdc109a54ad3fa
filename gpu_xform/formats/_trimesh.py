"""Reading and writing with trimesh, for formats that hold triangles alone."""

from typing import BinaryIO

import numpy as np

from ..errors import MeshError
from ..geometry.mesh import Mesh


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
