"""glTF 2.0 as text (`.gltf`), and its parts that `.glb` shares. Section numbers are those of the specification."""

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
from ._concatenate import concatenate
from ._text import quote

# Nodes can show a mesh many times: a scene may have so many numbers, plus so many copies of all its meshes.
_NUMBER_ALLOWANCE = 1 << 25
_MAX_COPIES = 8


def read_scene(data: bytes, folder: Path | None = None, binary: bytes | memoryview | None = None) -> Scene:
    """Return the nodes of a document with their meshes; a mesh that several nodes show is one object.

    folder : the folder in which buffers may be files
    binary : the first buffer, if it is a chunk of a `.glb`
    """
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise MeshError(f"the JSON is malformed: {error}") from None
    try:
        buffers = [
            _read_buffer(buffer, i, folder, binary if i == 0 else None)
            for i, buffer in enumerate(document.get("buffers", []))
        ]
        return gltf_nodes.build_scene(document, gltf_meshes.read_meshes(document, buffers))
    except (AttributeError, IndexError, KeyError, TypeError) as error:
        raise MeshError(f"the JSON is not glTF: {type(error).__name__}: {error}") from None


def read(data: bytes, folder: Path | None = None) -> Mesh:
    """Return all triangles and lines of a document, transformed to the world by its nodes."""
    return merge_scene(read_scene(data, folder))


def merge_scene(scene: Scene) -> Mesh:
    """Return one mesh, in the world, of all meshes that a scene shows."""
    try:
        placed = [(layer.model, layer.transform) for layer in scene.layers() if isinstance(layer.model, Mesh)]
    except ArgumentError as error:  # a world matrix that overflows
        raise MeshError(str(error)) from None
    if not placed:
        raise MeshError("it shows no triangles and no lines")
    sizes = np.array([mesh.positions.size + mesh.indices.size for mesh, _ in placed])
    n_numbers = int(sizes @ [len(matrices) for _, matrices in placed])
    if n_numbers > _NUMBER_ALLOWANCE + _MAX_COPIES * sizes.sum():
        raise MeshError(f"its nodes draw {n_numbers} numbers, its meshes have {sizes.sum()}")
    return concatenate([mesh.transformed(matrix) for mesh, matrices in placed for matrix in matrices])


def _read_buffer(buffer: Any, i: int, folder: Path | None, binary: bytes | memoryview | None) -> bytes | memoryview:
    """Return the content of buffer i (3.6.1)."""
    content: bytes | memoryview
    if "uri" in buffer:
        content = _fetch(buffer["uri"], folder)
    elif binary is not None:
        content = binary
    else:
        raise MeshError(f"buffer {i} has no content")
    declared = gltf_meshes.get_count(buffer, "byteLength")
    if declared > len(content):
        raise MeshError(f"buffer {i} declares {declared} bytes, it has {len(content)}")
    return content


def _fetch(uri: str, folder: Path | None) -> bytes:
    """Return the content of a data URI, or of the file in `folder` that a URI names; no other file is opened."""
    if uri.startswith("data:"):
        kind, _, text = uri.partition(",")
        try:
            if kind.endswith(";base64"):
                return base64.b64decode(text, validate=True)
        except (binascii.Error, ValueError):
            pass
        raise MeshError(f"a data URI must be base64, got {quote(uri)}")
    if folder is None:
        raise MeshError(f"its buffer is another file, {quote(uri)}, which is not opened")
    try:
        path = (folder / unquote(uri)).resolve()
        is_beside = path.is_relative_to(folder.resolve()) and path.is_file()
    except (OSError, RuntimeError, ValueError):  # a name too long, a cycle of links, a NUL
        is_beside = False
    if not is_beside:
        raise MeshError(f"its buffer must be a file beside it, got {quote(uri)}")
    return path.read_bytes()
