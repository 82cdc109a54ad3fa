"""STL, binary and ASCII; corners with equal coordinates become one point."""

import re
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.attributes import Attributes
from ..geometry.mesh import Mesh
from ..geometry.triangulation import triangulate
from ._line_names import list_name_losses, make_names
from ._losses import list_attributes, list_rounding
from ._text import parse_float, parse_numbers, plain_text, quote, without_mark
from ._warn import warn

_HEADER_BYTES = 84
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"^[ \t]*vertex[ \t]+([^\n]*)", re.MULTILINE | re.IGNORECASE)
_END = re.compile(rb"^[ \t]*(endfacet|endsolid)\b", re.MULTILINE | re.IGNORECASE)
_SOLID = re.compile(rb"^[ \t]*solid\b[ \t]*([^\n]*)", re.MULTILINE | re.IGNORECASE)
# Statements need not begin a line.
_ANY_VERTEX = re.compile(rb"(?<!\S)vertex\s+([-+.\dni]\S*\s+\S+\s+\S+)", re.IGNORECASE)
_ANY_END = re.compile(rb"(?<!\S)(endfacet|endsolid)(?!\S)", re.IGNORECASE)
# Odd factors that spread the bits of coordinates over a hash.
_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
_MAX_ROUNDS = 8
_ROWS_PER_WRITE = 1 << 14

_Corners = npt.NDArray[np.floating[Any]]


def read(data: bytes) -> Mesh:
    """Return the mesh of an STL file; raise MeshError if it is truncated, or a coordinate is not finite.

    The two bytes behind each triangle become an attribute per face, unless they are all 0, as the format wants it. The
    solids of an ASCII file become objects, if there are several.
    """
    text = without_mark(data)
    attributes: Attributes | None = None
    layout: dict[str, Any]
    if _is_text(text):
        text = plain_text(text)
        corners = _read_text(text)
        attributes, layout = _read_solids(text, len(corners) // 3)
    else:
        corners, attributes = _read_binary(data)
        layout = {"encoding": "binary", "header": data[: _HEADER_BYTES - 4]}
    if len(corners) == 0:
        raise MeshError("the file has no triangles")
    if not np.isfinite(corners).all():
        wrong = int(np.argmax(~np.isfinite(corners).all(axis=1)))
        raise MeshError(f"triangle {wrong // 3}: coordinates must be finite, got {corners[wrong].tolist()}")
    mesh = _merge_points(corners)
    return mesh.with_attributes(attributes, metadata={"stl": layout})


def _is_text(data: bytes) -> bool:
    """Tell whether a file is ASCII: some binary ones begin with "solid" as well; NULs or their length tell them."""
    begins = data[:512].lstrip()[:5].lower() == b"solid"
    return begins and len(data) != _compute_expected_bytes(data) and b"\0" not in data[:_HEADER_BYTES]


def _compute_expected_bytes(data: bytes) -> int:
    return _HEADER_BYTES + _TRIANGLE.itemsize * int.from_bytes(data[80:84], "little")


def _read_binary(data: bytes) -> tuple[_Corners, Attributes | None]:
    """Return (3 n, 3) float32, three corners per triangle, and the attribute bytes unless they are all 0."""
    if len(data) < _HEADER_BYTES:
        raise MeshError(
            f"expected a binary STL header of {_HEADER_BYTES} bytes or the word solid, got {len(data)} bytes"
        )
    expected = _compute_expected_bytes(data)
    count = (expected - _HEADER_BYTES) // _TRIANGLE.itemsize
    if len(data) < expected:
        raise MeshError(f"declares {count} triangles, which make {expected} bytes, got {len(data)}")
    if len(data) > expected:
        warn(f"{len(data) - expected} bytes behind its {count} triangles are left out")
    triangles = np.frombuffer(data, _TRIANGLE, count, offset=_HEADER_BYTES)
    attributes = Attributes(face={"attribute": triangles["attribute"]}) if triangles["attribute"].any() else None
    return triangles["corners"].reshape(-1, 3).astype(np.float32, copy=False), attributes


def _read_solids(data: bytes, n_triangles: int) -> tuple[Attributes | None, dict[str, Any]]:
    """Return which solid each triangle of an ASCII file belongs to, if there are several, and the name of one."""
    starts = list(_SOLID.finditer(data))
    names = [match[1].strip().decode("utf-8", "replace") for match in starts]
    if len(names) < 2:
        return None, {"encoding": "ascii", "name": "".join(names)}
    bounds = [*(match.start() for match in starts), len(data)]
    counts = [_count(_ANY_END.findall(data, start, end), b"endfacet") for start, end in pairwise(bounds)]
    if sum(counts) != n_triangles:
        return None, {"encoding": "ascii", "name": names[0]}
    labels = list(dict.fromkeys(names))
    number_of = {name: number for number, name in enumerate(labels)}
    numbers = np.repeat(np.array([number_of[name] for name in names], np.int32), counts)
    return Attributes(face={"object": numbers}, labels={"object": labels}), {"encoding": "ascii", "name": ""}


def _read_text(data: bytes) -> _Corners:
    """Return (3 n, 3) float64, three corners per triangle."""
    pattern, rows, ends = _VERTEX, _VERTEX.findall(data), _END.findall(data)
    if not rows or len(rows) != 3 * _count(ends, b"endfacet"):
        loose, loose_ends = _ANY_VERTEX.findall(data), _ANY_END.findall(data)
        if len(loose) == 3 * _count(loose_ends, b"endfacet"):
            pattern, rows, ends = _ANY_VERTEX, loose, loose_ends
    n_facets, n_solids = _count(ends, b"endfacet"), _count(ends, b"endsolid")
    if len(rows) != 3 * n_facets:
        raise MeshError(f"cut off: {len(rows)} vertex, {n_facets} endfacet and {n_solids} endsolid statements")
    if n_solids == 0 and n_facets:
        warn(f"ends behind {n_facets} triangles without endsolid, as if cut off")
    try:
        # NaNs between the rows show whether each row has three numbers.
        table = parse_numbers(b"".join([row + b" nan " for row in rows]), "float").reshape(-1, 4)
        if not np.array_equal(np.isnan(table), np.broadcast_to([False, False, False, True], table.shape)):
            raise ValueError("a row has more or less than three numbers")
    except ValueError:
        return _read_text_lines(data, pattern)
    return table[:, :3]


def _count(words: list[bytes], keyword: bytes) -> int:
    return sum(word.lower() == keyword for word in words)


def _read_text_lines(data: bytes, pattern: re.Pattern[bytes]) -> _Corners:
    """Return what `_read_text` does, or raise MeshError for the line that is wrong."""
    corners = []
    line, counted = 1, 0
    for match in pattern.finditer(data):
        line += data.count(b"\n", counted, match.start())
        counted = match.start()
        words = match[1].split()
        if len(words) != 3:
            raise MeshError(f"line {line}: expected vertex and 3 numbers, got {quote(match[0].strip())}")
        corners.append([parse_float(word, line) for word in words])
    return np.array(corners).reshape(-1, 3)


def _merge_points(corners: _Corners) -> Mesh:
    """Return the mesh of triangles given by their corners, equal points made one in the order of their first use."""
    points = corners + corners.dtype.type(0.0)  # no -0.0
    owners = _find_first_equal(np.ascontiguousarray(points).view(f"u{points.itemsize}"))
    is_first = owners == np.arange(len(owners))
    ranks = np.cumsum(is_first) - 1
    return Mesh(points[is_first], ranks[owners].reshape(-1, 3))


def _find_first_equal(rows: npt.NDArray[np.unsignedinteger[Any]]) -> IndexArray:
    """Return the first of the rows (n, 3) that equals each row: (n,).

    A hash table without chains: the first row that claims a slot gets it; the rows that are not equal to their slot's
    owner claim slots of another hash in the next round.
    """
    columns = np.ascontiguousarray(rows.T)
    n_bits = max(4, len(rows).bit_length())
    table = np.empty(1 << n_bits, np.int32 if len(rows) < 2**31 else np.int64)
    every = np.arange(len(rows), dtype=table.dtype)
    owners, left = _claim_slots(columns, every, table, _FACTORS.astype(rows.dtype))
    for turn in range(1, _MAX_ROUNDS):
        if len(left) == 0:
            break
        factors = np.roll(_FACTORS, turn).astype(rows.dtype) + rows.dtype.type(2 * turn)
        owners[left], left = _claim_slots(np.take(columns, left, axis=1), left, table, factors)
    if len(left):
        _, first, inverse = np.unique(rows[left], axis=0, return_index=True, return_inverse=True)
        owners[left] = left[first][inverse.ravel()]
    return owners.astype(np.int64)


def _claim_slots(
    columns: npt.NDArray[Any], ids: npt.NDArray[Any], table: npt.NDArray[Any], factors: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Return the owner of the slot that each of the columns (3, n) falls into, and which `ids` differ from theirs.

    ids : (n,), ascending; owners are ids
    """
    dtype = columns.dtype
    keys = columns[0] * factors[0]
    keys += columns[1] * factors[1]
    keys += columns[2] * factors[2]
    keys ^= keys >> dtype.type(4 * dtype.itemsize - 1)
    keys *= factors[0]
    keys >>= dtype.type(8 * dtype.itemsize - (len(table).bit_length() - 1))
    slots = keys.astype(np.intp)
    places = np.arange(len(ids), dtype=table.dtype)
    table[slots[::-1]] = places[::-1]  # of equal slots NumPy keeps the last value, which is the first place
    found = np.take(table, slots)
    equal = np.take(columns[0], found) == columns[0]
    for column in columns[1:]:
        equal &= np.take(column, found) == column
    return np.take(ids, found), ids[~equal]


def list_losses(mesh: Mesh) -> list[str]:
    """Return what of a mesh STL cannot hold; raise MeshError for one that it cannot hold at all."""
    _require_triangles(mesh)
    held = set()
    if _can_hold_attribute(mesh):
        held.add("attribute per face")
    names: list[str] = []
    if _find_objects(mesh) is not None:
        held.add("object per face")
        names = list_name_losses(mesh.attributes.labels["object"], "solid", "object")
    lost = [name for name in list_attributes(mesh) if name not in held] + names
    return lost if _is_written_as_text(mesh) else lost + list_rounding(mesh.positions)


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write triangles with their normals: in ASCII if the mesh was read from such a file, else in binary."""
    _require_triangles(mesh)
    corners, owners = triangulate(mesh.positions, mesh.offsets, mesh.indices)
    points = mesh.positions[corners]
    normals = _compute_normals(points)
    layout = mesh.metadata.get("stl", {})
    if _is_written_as_text(mesh):
        for name, chosen in _split_solids(mesh, owners, layout.get("name", "")):
            _write_solid(file, name, normals[chosen], points[chosen])
        return
    table = np.zeros(len(points), _TRIANGLE)
    table["normal"], table["corners"] = normals, points
    if _can_hold_attribute(mesh):
        table["attribute"] = mesh.attributes.face["attribute"][owners]
    file.write(layout.get("header", b"").ljust(_HEADER_BYTES - 4, b"\0")[: _HEADER_BYTES - 4])
    file.write(len(table).to_bytes(4, "little"))
    file.write(table.tobytes())


def _require_triangles(mesh: Mesh) -> None:
    """Raise MeshError for a mesh that STL cannot hold."""
    n_segments = int((np.diff(mesh.offsets) == 2).sum())
    if mesh.n_faces == 0:
        raise MeshError("STL holds triangles only, this mesh has no faces")
    if n_segments:
        raise MeshError(f"STL holds triangles only, this mesh has {n_segments} segments")
    largest = np.abs(mesh.positions).max()
    if not _is_written_as_text(mesh) and largest > np.finfo(np.float32).max:
        raise MeshError(f"STL holds float32, this mesh has a coordinate of {largest:g}")


def _is_written_as_text(mesh: Mesh) -> bool:
    return bool(mesh.metadata.get("stl", {}).get("encoding") == "ascii")


def _can_hold_attribute(mesh: Mesh) -> bool:
    """Return whether the attribute of that name fits into two bytes per triangle."""
    column = mesh.attributes.face.get("attribute")
    if not isinstance(column, np.ndarray) or column.ndim != 1 or column.dtype.kind not in "iu" or len(column) == 0:
        return False
    return bool(column.min() >= 0 and column.max() < 2**16)


def _compute_normals(points: Float64Array) -> Float64Array:
    """Return the unit normals of triangles (t, 3, 3); zeros for those without area."""
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = points / (np.abs(points).max() or 1.0)
        normals = np.cross(scaled[:, 1] - scaled[:, 0], scaled[:, 2] - scaled[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    lengths[lengths == 0] = 1.0
    unit: Float64Array = normals / lengths
    return unit


def _find_objects(mesh: Mesh) -> IndexArray | None:
    """Return the number of the solid of each face in ASCII, if there are such numbers, with names."""
    column = mesh.attributes.face.get("object")
    is_held = isinstance(column, np.ndarray) and column.ndim == 1 and column.dtype.kind in "iu"
    return column if is_held and "object" in mesh.attributes.labels and _is_written_as_text(mesh) else None


def _split_solids(mesh: Mesh, owners: IndexArray, name: str) -> Iterator[tuple[str, slice]]:
    """Yield the name and the triangles of each solid: the objects of the mesh, or all under one name."""
    found = _find_objects(mesh)
    if found is None:
        yield name, slice(None)
        return
    labels, objects = mesh.attributes.labels["object"], found[owners]
    names = make_names(labels, "solid")
    starts = [0, *(np.flatnonzero(np.diff(objects)) + 1).tolist(), len(objects)]
    for start, end in pairwise(starts):
        number = int(objects[start])
        yield names[labels[number]] if 0 <= number < len(labels) else "", slice(start, end)


def _write_solid(file: BinaryIO, name: str, normals: Float64Array, points: Float64Array) -> None:
    """Write triangles in ASCII, every coordinate exact."""
    facet = b" facet normal %a %a %a\n  outer loop\n" + b"   vertex %a %a %a\n" * 3 + b"  endloop\n endfacet\n"
    numbers = np.concatenate([normals[:, np.newaxis], points], axis=1).reshape(-1, 12) + 0.0
    file.write(b"solid " + name.encode() + b"\n")
    for start in range(0, len(numbers), _ROWS_PER_WRITE):
        rows = numbers[start : start + _ROWS_PER_WRITE]
        file.write((facet * len(rows)) % tuple(rows.ravel().tolist()))
    file.write(b"endsolid " + name.encode() + b"\n")
