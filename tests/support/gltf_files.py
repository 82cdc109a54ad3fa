"""glTF files written by hand, which tests modify."""

import base64
import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np

from gpu_xform.geometry.mesh import Mesh

TRIANGLE = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])


def document() -> dict[str, Any]:
    """Return the JSON of one triangle in one node."""
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "buffers": [{"byteLength": 42}],
    }


POINTS = TRIANGLE.positions.astype("<f4").tobytes()
BINARY = POINTS + struct.pack("<3H", 0, 1, 2)


def pack(content: Any, binary: bytes = BINARY) -> bytes:
    """Return a GLB file."""
    text = content if isinstance(content, bytes) else json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<I", len(text)) + b"JSON" + text + struct.pack("<I", len(binary)) + b"BIN\0" + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def data_uri(data: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def as_text(*uris: str | None, content: Any = None) -> bytes:
    """Return a document as `.gltf`, by default the triangle, with one buffer, or one for points and one for indices."""
    content = document() if content is None else content
    if len(uris) == 2:
        content["buffers"] = [{"byteLength": 36}, {"byteLength": 6}]
        content["bufferViews"][1].update(buffer=1, byteOffset=0)
    for buffer, uri in zip(content["buffers"], uris, strict=True):
        if uri is not None:
            buffer["uri"] = uri
    return json.dumps(content).encode()


def change(path: str, value: Any) -> Callable[[dict[str, Any]], None]:
    """Return a function that sets one value of a document, or removes it if `value` is None."""
    *parents, last = (int(step) if step.isdigit() else step for step in path.split("."))

    def apply(content: Any) -> None:
        for step in parents:
            content = content[step]
        if value is None:
            del content[last]
        else:
            content[last] = value

    return apply


class Builder:
    """A document that grows, with one buffer."""

    def __init__(self) -> None:
        self.content: dict[str, Any] = {"asset": {"version": "2.0"}, "nodes": [], "meshes": []}
        self.binary = b""

    def view(self, data: bytes, **more: Any) -> int:
        """Add a buffer view, and return its index."""
        self.binary += b"\0" * (-len(self.binary) % 4)
        views = self.content.setdefault("bufferViews", [])
        views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **more})
        self.binary += data
        self.content["buffers"] = [{"byteLength": len(self.binary)}]
        return len(views) - 1

    def array(self, values: Any, dtype: str = "<f4", **more: Any) -> int:
        """Add an accessor of rows (n, columns), (n,) or matrices (n, 4, 4), and return its index."""
        array = np.asarray(values, dtype)
        if array.ndim == 3:
            array = array.transpose(0, 2, 1)
        kind = {1: "SCALAR", 2: f"VEC{array.shape[-1]}", 3: "MAT4"}[array.ndim]
        accessors = self.content.setdefault("accessors", [])
        component = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}[dtype[-2:]]
        accessors.append({"componentType": component, "count": len(array), "type": kind, **more})
        if "bufferView" not in more:
            accessors[-1]["bufferView"] = self.view(array.tobytes())
        return len(accessors) - 1

    def mesh(self, *primitives: dict[str, Any], **more: Any) -> int:
        """Add a mesh, and return its index."""
        self.content["meshes"].append({"primitives": list(primitives), **more})
        return len(self.content["meshes"]) - 1

    def node(self, **node: Any) -> int:
        """Add a node, and return its index."""
        self.content["nodes"].append(node)
        return len(self.content["nodes"]) - 1

    def pack(self) -> bytes:
        """Return a GLB file."""
        return pack(self.content, self.binary)
