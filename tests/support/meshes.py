"""Meshes as arrays."""

from gpu_xform import Mesh
from gpu_xform._core.types import IndexArray
from gpu_xform.geometry.triangulation import triangulate


def triangles_of(mesh: Mesh) -> tuple[IndexArray, IndexArray]:
    """Return the triangles (t, 3) of a mesh, and the face of each (t,)."""
    return triangulate(mesh.positions, mesh.offsets, mesh.indices)
