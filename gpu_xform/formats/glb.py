"""Binary glTF 2.0 (`.glb`): a JSON chunk and a binary chunk."""

from typing import BinaryIO

from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from . import gltf, gltf_document, gltf_write
from .gltf_document import read_glb


def read(data: bytes) -> Mesh:
    """Return all triangles, lines and points of the scene, each mesh where its nodes put it."""
    return gltf.read_mesh(read_glb(data))


def read_scene(data: bytes) -> Scene:
    """Return the nodes of the scene, each with the meshes that it shows; what several show is one mesh."""
    return gltf.make_scene(read_glb(data))


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write one mesh in one node."""
    gltf_document.write_glb(gltf_write.make_document(mesh), file)
