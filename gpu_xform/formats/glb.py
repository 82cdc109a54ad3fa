"""Binary glTF 2.0 (`.glb`): a JSON chunk and a binary chunk. Section numbers are those of the specification."""

from typing import BinaryIO

from ..errors import MeshError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from . import _trimesh, gltf
from ._text import printable


def read(data: bytes) -> Mesh:
    """Return all triangles and lines of the scene, each mesh where its nodes put it."""
    return gltf.merged(read_scene(data))


def read_scene(data: bytes) -> Scene:
    """Return the nodes of the scene, each with the meshes that it shows; what several show is one mesh."""
    content, binary = _chunks(data)
    return gltf.read_scene(content, binary=binary)


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write one mesh in one node."""
    _trimesh.export(mesh, file, "glb")


def _chunks(data: bytes) -> tuple[bytes, memoryview]:
    """Return the JSON chunk and the binary chunk (4.4)."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise MeshError(f"byte 0: expected 'glTF' and two headers, got {printable(data[:20])}")
    version, length = (int.from_bytes(data[i : i + 4], "little") for i in (4, 8))
    if version != 2:
        raise MeshError(f"byte 4: expected version 2, got {version}")
    if length != len(data):
        raise MeshError(f"byte 8: declares {length} bytes, got {len(data)}")
    chunks: dict[bytes, memoryview] = {}
    place = 12
    while place < length:
        size, kind = int.from_bytes(data[place : place + 4], "little"), data[place + 4 : place + 8]
        if place + 8 + size > length:
            raise MeshError(f"byte {place}: a chunk declares {size} bytes, {max(0, length - place - 8)} are left")
        if kind == b"JSON" and place != 12:
            raise MeshError(f"byte {place}: a second JSON chunk")
        chunks.setdefault(kind, memoryview(data)[place + 8 : place + 8 + size])
        place += 8 + size
    if b"JSON" not in chunks:
        raise MeshError("byte 12: expected a JSON chunk")
    return bytes(chunks[b"JSON"]), chunks.get(b"BIN\0", memoryview(b""))
