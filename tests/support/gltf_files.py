"""glTF files written by hand, which tests modify."""

import base64
import json
import struct
from collections.abc import Callable
from typing import Any

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
