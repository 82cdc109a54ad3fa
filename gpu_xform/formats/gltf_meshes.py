"""The meshes of a glTF document, read from its buffers with all bounds checked."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.mesh import Mesh
from ._text import quote

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COLUMNS = {"SCALAR": 1, "VEC3": 3}
_POINTS, _LINES, _LINE_LOOP, _LINE_STRIP, _TRIANGLES, _TRIANGLE_STRIP, _TRIANGLE_FAN = range(7)
# Primitives can use an array many times: a file may draw so many numbers more than twice its bytes.
_NUMBER_ALLOWANCE = 1 << 25

Buffers = Sequence[bytes | memoryview]


def read_meshes(document: Any, buffers: Buffers) -> list[list[Mesh]]:
    """Return one Mesh per primitive, for each mesh of the document; primitives of points are left out.

    Raises MeshError if buffers, views, accessors and primitives contradict each other.
    """
    found: list[list[Mesh]] = []
    n_numbers, n_bytes = 0, sum(map(len, buffers))
    for i, mesh in enumerate(document.get("meshes", [])):
        found.append([])
        for primitive in mesh["primitives"]:
            mode = get_count(primitive, "mode", _TRIANGLES)
            if mode == _POINTS:
                continue
            positions = _read_positions(document, buffers, get_count(primitive["attributes"], "POSITION"))
            corners = np.arange(len(positions))
            if "indices" in primitive:
                corners = _read_corners(document, buffers, get_count(primitive, "indices"))
            faces = _assemble_faces(corners, mode, f"mesh {i}")
            n_numbers += positions.size + faces.size
            if n_numbers > _NUMBER_ALLOWANCE + 2 * n_bytes:
                raise MeshError(f"its meshes draw {n_numbers} numbers, its buffers have {n_bytes} bytes")
            if len(faces):
                found[i].append(Mesh(positions, faces))
    return found


def get_count(holder: Any, key: str, default: int | None = None) -> int:
    """Return a count, an offset or an index that `holder` has under `key`."""
    value = holder[key] if default is None else holder.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise MeshError(f"{key} must be an integer of at least 0, got {quote(repr(value))}")
    return value


def _read_positions(document: Any, buffers: Buffers, i: int) -> Float64Array:
    """Return accessor i as points (n, 3); normalized integers become fractions (3.6.2.2)."""
    rows = _view_rows(document, buffers, i, "VEC3")
    positions = rows.astype(np.float64)
    if document["accessors"][i].get("normalized") and rows.dtype.kind in "iu":
        positions = np.maximum(positions / np.iinfo(rows.dtype).max, -1.0)
    return positions


def _read_corners(document: Any, buffers: Buffers, i: int) -> IndexArray:
    """Return accessor i as indices of points (c,)."""
    rows = _view_rows(document, buffers, i, "SCALAR")
    if rows.dtype.kind != "u":
        raise MeshError(f"accessor {i} holds indices, which must be unsigned integers, got {rows.dtype.name}")
    return rows[:, 0].astype(np.int64)


def _view_rows(document: Any, buffers: Buffers, i: int, kind: str) -> npt.NDArray[Any]:
    """Return a view of accessor i with one row per element; raise MeshError if it does not fit its buffer (3.6.2)."""
    accessor = document["accessors"][i]
    if "bufferView" not in accessor or "sparse" in accessor:
        raise MeshError(f"accessor {i} is sparse or compressed, which cannot be read")
    if accessor["type"] != kind:
        raise MeshError(f"accessor {i} must be of type {kind}, got {quote(repr(accessor['type']))}")
    v = get_count(accessor, "bufferView")
    view = document["bufferViews"][v]
    buffer = buffers[get_count(view, "buffer")]
    view_start, view_bytes = get_count(view, "byteOffset", 0), get_count(view, "byteLength")
    if view_start + view_bytes > len(buffer):
        raise MeshError(f"buffer view {v} ends at byte {view_start + view_bytes}, the buffer has {len(buffer)}")
    dtype = np.dtype(_COMPONENTS[accessor["componentType"]])
    row_bytes = _COLUMNS[kind] * dtype.itemsize
    stride = get_count(view, "byteStride", row_bytes)
    if stride < row_bytes:
        raise MeshError(f"accessor {i} has rows of {row_bytes} bytes every {stride} bytes")
    start, count = get_count(accessor, "byteOffset", 0), get_count(accessor, "count")
    end = start + (stride * (count - 1) + row_bytes if count else 0)
    if end > view_bytes:
        raise MeshError(f"accessor {i} with {count} rows ends at byte {end} of a view of {view_bytes}")
    return np.ndarray((count, _COLUMNS[kind]), dtype, buffer, view_start + start, (stride, dtype.itemsize))


def _assemble_faces(corners: IndexArray, mode: int, owner: str) -> IndexArray:
    """Return the triangles (t, 3) or segments (s, 2) that corners form in a primitive mode (3.7.2.1)."""
    first, second, third = corners[:-2], corners[1:-1], corners[2:]
    if mode in (_LINES, _TRIANGLES):
        size = 2 if mode == _LINES else 3
        if len(corners) % size:
            raise MeshError(f"{owner} has {len(corners)} corners, which must be a multiple of {size}")
        return corners.reshape(-1, size)
    if mode == _LINE_STRIP:
        return np.stack([corners[:-1], corners[1:]], axis=1)
    if mode == _LINE_LOOP:
        return np.stack([corners, np.roll(corners, -1)], axis=1)
    if mode == _TRIANGLE_FAN:
        return np.stack([second, third, np.broadcast_to(corners[:1], third.shape)], axis=1)
    if mode == _TRIANGLE_STRIP:
        is_odd = np.arange(len(first)) % 2 == 1
        faces = np.stack([first, np.where(is_odd, third, second), np.where(is_odd, second, third)], axis=1)
        degenerate = (first == second) | (second == third) | (third == first)  # they join strips
        kept: IndexArray = faces[~degenerate]
        return kept
    raise MeshError(f"{owner} must have a mode of at most {_TRIANGLE_FAN}, got {mode}")
