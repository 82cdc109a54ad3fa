"""glTF 2.0 as text (`.gltf`), and what it shares with `.glb`. Section numbers are those of the specification."""

import base64
import binascii
import json
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ..errors import ArgumentError, MeshError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from . import gltf_meshes, gltf_nodes
from ._concatenate import joined
from ._text import printable

# Nodes can show one mesh many times: what they may draw beyond so many copies of everything.
_SPARE_NUMBERS = 1 << 25
_MOST_COPIES = 8


def read_scene(data: bytes, folder: Path | None = None, binary: bytes | memoryview | None = None) -> Scene:
    """Return the nodes of a document, each with the meshes that it shows; what several show is one mesh.

    folder : where its buffers may lie, if they are files
    binary : the first buffer, if it is a chunk of a `.glb`
    """
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise MeshError(f"the JSON is malformed: {error}") from None
    try:
        buffers = [
            _buffer(buffer, i, folder, binary if i == 0 else None)
            for i, buffer in enumerate(document.get("buffers", []))
        ]
        return gltf_nodes.scene(document, gltf_meshes.meshes(document, buffers))
    except (AttributeError, IndexError, KeyError, TypeError) as error:
        raise MeshError(f"the JSON is not glTF: {type(error).__name__}: {error}") from None


def read(data: bytes, folder: Path | None = None) -> Mesh:
    """Return all triangles and lines of a document, each mesh where its nodes put it."""
    return merged(read_scene(data, folder))


def merged(scene: Scene) -> Mesh:
    """Return all that a scene of meshes shows as one mesh in the world."""
    try:
        placed = [(layer.model, layer.transform) for layer in scene.layers() if isinstance(layer.model, Mesh)]
    except ArgumentError as error:  # a world matrix that overflows
        raise MeshError(str(error)) from None
    if not placed:
        raise MeshError("it shows no triangles and no lines")
    sizes = np.array([mesh.positions.size + mesh.indices.size for mesh, _ in placed])
    n_numbers = int(sizes @ [len(matrices) for _, matrices in placed])
    if n_numbers > _SPARE_NUMBERS + _MOST_COPIES * sizes.sum():
        raise MeshError(f"its nodes draw {n_numbers} numbers, its meshes have {sizes.sum()}")
    return joined([mesh.transformed(matrix) for mesh, matrices in placed for matrix in matrices])


def _buffer(buffer: Any, i: int, folder: Path | None, binary: bytes | memoryview | None) -> bytes | memoryview:
    """Return the content of buffer i (3.6.1)."""
    content: bytes | memoryview
    if "uri" in buffer:
        content = _fetched(buffer["uri"], folder)
    elif binary is not None:
        content = binary
    else:
        raise MeshError(f"buffer {i} has no content")
    declared = gltf_meshes.whole(buffer, "byteLength")
    if declared > len(content):
        raise MeshError(f"buffer {i} declares {declared} bytes, it has {len(content)}")
    return content


def _fetched(uri: str, folder: Path | None) -> bytes:
    """Return what a URI holds, or the file in `folder` that it names; no other file is opened."""
    if uri.startswith("data:"):
        kind, _, text = uri.partition(",")
        try:
            if kind.endswith(";base64"):
                return base64.b64decode(text, validate=True)
        except (binascii.Error, ValueError):
            pass
        raise MeshError(f"a data URI must be base64, got {printable(uri)}")
    if folder is None:
        raise MeshError(f"its buffer is another file, {printable(uri)}, which is not opened")
    try:
        path = (folder / unquote(uri)).resolve()
        is_beside = path.is_relative_to(folder.resolve()) and path.is_file()
    except (OSError, RuntimeError, ValueError):  # a name too long, links in a circle, a NUL
        is_beside = False
    if not is_beside:
        raise MeshError(f"its buffer must be a file beside it, got {printable(uri)}")
    return path.read_bytes()
