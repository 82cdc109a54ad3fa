"""Binary glTF 2.0 (`.glb`), through trimesh, which is only given files that `glb_check` finds sound."""

from typing import BinaryIO

from ..mesh import Mesh
from . import _trimesh
from .glb_check import check


def read(data: bytes) -> Mesh:
    """Return all triangles of the scene, each mesh where its nodes put it."""
    check(data)
    return _trimesh.load_scene(data, "glb")


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write one mesh in one node."""
    _trimesh.export(mesh, file, "glb")
