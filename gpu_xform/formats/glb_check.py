"""What a GLB file must satisfy before a loader may trust its numbers.

Section numbers are those of the glTF 2.0 specification.
"""

import json
from typing import Any

from ..errors import MeshError
from ._text import printable

_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_TRIANGLE_FAN = 6
_DEEPEST = 256
# Nodes can instance one mesh many times: what they may draw beyond what the file itself spells out.
_SPARE_NUMBERS = 1 << 25


def check(data: bytes) -> None:
    """Raise MeshError unless headers, buffers, accessors and nodes of a GLB file agree with one another."""
    content, n_bytes = _chunks(data)
    try:
        document = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise MeshError(f"the JSON chunk is malformed: {error}") from None
    try:
        _check_views(document, n_bytes)
        counts = [_checked_count(document, i) for i in range(len(document.get("accessors", [])))]
        _check_nodes(document.get("nodes", []))
        _check_work(document, counts, len(data))
    except (AttributeError, IndexError, KeyError, TypeError) as error:
        raise MeshError(f"the JSON chunk is not glTF: {type(error).__name__}: {error}") from None


def _chunks(data: bytes) -> tuple[bytes, int]:
    """Return the JSON chunk and the size of the binary chunk (4.4)."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise MeshError(f"byte 0: expected 'glTF' and two headers, got {printable(data[:20])}")
    version, length = (int.from_bytes(data[i : i + 4], "little") for i in (4, 8))
    if version != 2:
        raise MeshError(f"byte 4: expected version 2, got {version}")
    if length != len(data):
        raise MeshError(f"byte 8: declares {length} bytes, got {len(data)}")
    chunks: dict[bytes, bytes] = {}
    place = 12
    while place < length:
        size, kind = int.from_bytes(data[place : place + 4], "little"), data[place + 4 : place + 8]
        if place + 8 + size > length:
            raise MeshError(f"byte {place}: a chunk declares {size} bytes, {max(0, length - place - 8)} are left")
        if kind == b"JSON" and place != 12:
            raise MeshError(f"byte {place}: a second JSON chunk")
        chunks.setdefault(kind, data[place + 8 : place + 8 + size])
        place += 8 + size
    if b"JSON" not in chunks:
        raise MeshError("byte 12: expected a JSON chunk")
    return chunks[b"JSON"], len(chunks.get(b"BIN\0", b""))


def _whole(holder: Any, key: str, default: int | None = None) -> int:
    """Return a count or an offset of the document."""
    value = holder[key] if default is None else holder.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise MeshError(f"{key} must be an integer of at least 0, got {printable(repr(value))}")
    return value


def _check_views(document: Any, n_bytes: int) -> None:
    """Raise MeshError unless there is one buffer, the binary chunk, and every view lies in it (3.6.1)."""
    buffers = document.get("buffers", [])
    if len(buffers) > 1 or any("uri" in buffer for buffer in buffers):
        raise MeshError("the only buffer must be the binary chunk: other files are not opened")
    for buffer in buffers:
        if (declared := _whole(buffer, "byteLength")) > n_bytes:
            raise MeshError(f"the buffer declares {declared} bytes, the binary chunk has {n_bytes}")
    for i, view in enumerate(document.get("bufferViews", [])):
        end = _whole(view, "byteOffset", 0) + _whole(view, "byteLength")
        if _whole(view, "buffer") != 0 or end > n_bytes:
            raise MeshError(f"buffer view {i} ends at byte {end}, the binary chunk has {n_bytes}")


def _checked_count(document: Any, i: int) -> int:
    """Return how many numbers accessor i gives; raise MeshError unless its view holds them (3.6.2)."""
    accessor = document["accessors"][i]
    if "bufferView" not in accessor or "sparse" in accessor:
        raise MeshError(f"accessor {i} is sparse or compressed, which cannot be read")
    view = document["bufferViews"][_whole(accessor, "bufferView")]
    count, columns = _whole(accessor, "count"), _COMPONENTS[accessor["type"]]
    row = columns * _COMPONENT_BYTES[accessor["componentType"]]
    stride = _whole(view, "byteStride", row)
    if stride < row:
        raise MeshError(f"accessor {i} has rows of {row} bytes every {stride} bytes")
    end = _whole(accessor, "byteOffset", 0) + (stride * (count - 1) + row if count else 0)
    if end > _whole(view, "byteLength"):
        raise MeshError(f"accessor {i} with {count} rows ends at byte {end} of a view of {view['byteLength']}")
    return count * columns


def _check_nodes(nodes: Any) -> None:
    """Raise MeshError unless the nodes form trees (3.5.2) of a depth that a loader can walk."""
    has_parent = [False] * len(nodes)
    for i, node in enumerate(nodes):
        for child in node.get("children", []):
            if has_parent[child] or child < 0:
                raise MeshError(f"node {i} has the child {child}, which already has a parent")
            has_parent[child] = True
    level = [i for i, has in enumerate(has_parent) if not has]
    n_reached, depth = 0, 0
    while level:
        n_reached, depth = n_reached + len(level), depth + 1
        if depth > _DEEPEST:
            raise MeshError(f"nodes are nested more than {_DEEPEST} deep")
        level = [child for i in level for child in nodes[i].get("children", [])]
    if n_reached < len(nodes):
        raise MeshError(f"{len(nodes) - n_reached} nodes are descendants of themselves")


def _check_work(document: Any, counts: list[int], n_bytes: int) -> None:
    """Raise MeshError where the primitives of all meshes and of all nodes draw more than the file can mean."""
    costs = []
    for i, mesh in enumerate(document.get("meshes", [])):
        cost = 0
        for primitive in mesh["primitives"]:
            if primitive.get("mode") == _TRIANGLE_FAN:
                raise MeshError(f"mesh {i} is made of triangle fans, which cannot be read")
            used = [_whole(primitive, "indices")] if "indices" in primitive else []
            used += [_whole(primitive["attributes"], name) for name in primitive["attributes"]]
            cost += sum(counts[accessor] for accessor in used)
        costs.append(cost)
    drawn = sum(costs) + sum(costs[_whole(node, "mesh")] for node in document.get("nodes", []) if "mesh" in node)
    if drawn > _SPARE_NUMBERS + 2 * n_bytes:
        raise MeshError(f"its nodes draw {drawn} numbers, the file has {n_bytes} bytes")
