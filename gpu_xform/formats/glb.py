"""Binary glTF 2.0 (`.glb`): a JSON chunk and a binary chunk. Section numbers are those of the specification."""

from typing import BinaryIO

from ..errors import MeshError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from . import _trimesh, gltf
from ._text import quote


def read(data: bytes) -> Mesh:
    """Return all triangles and lines of the scene, transformed to the world by its nodes."""
    return gltf.merge_scene(read_scene(data))


def read_scene(data: bytes) -> Scene:
    """Return the nodes of the scene with their meshes; a mesh that several nodes show is one object."""
    content, binary = _split_chunks(data)
    return gltf.read_scene(content, binary=binary)


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write a scene of one node that shows the mesh."""
    _trimesh.export(mesh, file, "glb")


def _split_chunks(data: bytes) -> tuple[bytes, memoryview]:
    """Return the JSON chunk and the binary chunk (4.4)."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise MeshError(f"byte 0: expected 'glTF' and two headers, got {quote(data[:20])}")
    version, length = (int.from_bytes(data[i : i + 4], "little") for i in (4, 8))
    if version != 2:
        raise MeshError(f"byte 4: expected version 2, got {version}")
    if length != len(data):
        raise MeshError(f"byte 8: declares {length} bytes, got {len(data)}")
    chunks: dict[bytes, memoryview] = {}
    start = 12
    while start < length:
        size, kind = int.from_bytes(data[start : start + 4], "little"), data[start + 4 : start + 8]
        if start + 8 + size > length:
            raise MeshError(f"byte {start}: a chunk declares {size} bytes, {max(0, length - start - 8)} are left")
        if kind == b"JSON" and start != 12:
            raise MeshError(f"byte {start}: a second JSON chunk")
        chunks.setdefault(kind, memoryview(data)[start + 8 : start + 8 + size])
        start += 8 + size
    if b"JSON" not in chunks:
        raise MeshError("byte 12: expected a JSON chunk")
    return bytes(chunks[b"JSON"]), chunks.get(b"BIN\0", memoryview(b""))
