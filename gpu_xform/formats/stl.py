"""STL, binary and ASCII; corners with equal coordinates become one point."""

import re
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray
from ..errors import MeshError
from ..geometry.mesh import Mesh
from . import _trimesh
from ._text import parse_float, parse_numbers, plain_text, quote, without_mark
from ._warn import warn

_HEADER_BYTES = 84
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"^[ \t]*vertex[ \t]+([^\n]*)", re.MULTILINE | re.IGNORECASE)
_END = re.compile(rb"^[ \t]*(endfacet|endsolid)\b", re.MULTILINE | re.IGNORECASE)
# Statements need not begin a line.
_ANY_VERTEX = re.compile(rb"(?<!\S)vertex\s+([-+.\dni]\S*\s+\S+\s+\S+)", re.IGNORECASE)
_ANY_END = re.compile(rb"(?<!\S)(endfacet|endsolid)(?!\S)", re.IGNORECASE)
# Odd factors that spread the bits of coordinates over a hash.
_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
_MAX_ROUNDS = 8

_Corners = npt.NDArray[np.floating[Any]]


def read(data: bytes) -> Mesh:
    """Return the mesh of an STL file; raise MeshError if it is truncated, or a coordinate is not finite."""
    text = without_mark(data)
    corners = _read_text(plain_text(text)) if _is_text(text) else _read_binary(data)
    if len(corners) == 0:
        raise MeshError("the file has no triangles")
    if not np.isfinite(corners).all():
        wrong = int(np.argmax(~np.isfinite(corners).all(axis=1)))
        raise MeshError(f"triangle {wrong // 3}: coordinates must be finite, got {corners[wrong].tolist()}")
    return _merge_points(corners)


def _is_text(data: bytes) -> bool:
    """Tell whether a file is ASCII: some binary ones begin with "solid" as well; NULs or their length tell them."""
    begins = data[:512].lstrip()[:5].lower() == b"solid"
    return begins and len(data) != _compute_expected_bytes(data) and b"\0" not in data[:_HEADER_BYTES]


def _compute_expected_bytes(data: bytes) -> int:
    return _HEADER_BYTES + _TRIANGLE.itemsize * int.from_bytes(data[80:84], "little")


def _read_binary(data: bytes) -> _Corners:
    """Return (3 n, 3) float32, three corners per triangle."""
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
    corners = np.frombuffer(data, _TRIANGLE, count, offset=_HEADER_BYTES)["corners"]
    return corners.reshape(-1, 3).astype(np.float32, copy=False)


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
    n_bits = max(4, len(rows).bit_length())
    table = np.empty(1 << n_bits, np.int32 if len(rows) < 2**31 else np.int64)
    owners = np.arange(len(rows), dtype=table.dtype)
    factors = _FACTORS.astype(rows.dtype)
    left = owners.copy()
    for _ in range(_MAX_ROUNDS):
        claims = rows if len(left) == len(rows) else rows[left]
        keys = claims[:, 0] * factors[0]
        keys += claims[:, 1] * factors[1]
        keys += claims[:, 2] * factors[2]
        keys ^= keys >> rows.dtype.type(4 * rows.itemsize - 1)
        keys *= factors[0]
        slots = (keys >> rows.dtype.type(8 * rows.itemsize - n_bits)).astype(np.intp)
        table[slots[::-1]] = left[::-1]  # of equal slots NumPy keeps the last value, which is the first row
        found = table[slots]
        equal = (np.take(rows, found, axis=0) == claims).all(axis=1)
        owners[left] = found
        left = left[~equal]
        if len(left) == 0:
            return owners.astype(np.int64)
        factors = factors[[1, 2, 0]] * factors[0] + factors.dtype.type(2)
    _, first, inverse = np.unique(rows[left], axis=0, return_index=True, return_inverse=True)
    owners[left] = left[first][inverse.ravel()]
    return owners.astype(np.int64)


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write binary STL."""
    _trimesh.export(mesh, file, "stl")
