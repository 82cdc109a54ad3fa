"""STL, binary and ASCII; corners with equal coordinates become one point."""

import re
from typing import BinaryIO

import numpy as np

from .._core.types import Float64Array
from ..errors import MeshError
from ..geometry.mesh import Mesh
from . import _trimesh
from ._text import parse_float, parse_numbers, quote

_HEADER_BYTES = 84
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"^[ \t]*vertex[ \t]+([^\n]*)", re.MULTILINE | re.IGNORECASE)
_END = re.compile(rb"^[ \t]*(endfacet|endsolid)\b", re.MULTILINE | re.IGNORECASE)


def read(data: bytes) -> Mesh:
    """Return the mesh of an STL file; raise MeshError if it is truncated, or a coordinate is not finite."""
    # Some binary files begin with "solid" too; their length distinguishes them.
    is_text = data[:512].lstrip()[:5].lower() == b"solid" and len(data) != _compute_expected_bytes(data)
    corners = _read_text(data) if is_text else _read_binary(data)
    if len(corners) == 0:
        raise MeshError("the file has no triangles")
    if not np.isfinite(corners).all():
        wrong = int(np.argmax(~np.isfinite(corners).all(axis=1)))
        raise MeshError(f"triangle {wrong // 3}: coordinates must be finite, got {corners[wrong].tolist()}")
    return _merge_points(corners)


def _compute_expected_bytes(data: bytes) -> int:
    return _HEADER_BYTES + _TRIANGLE.itemsize * int.from_bytes(data[80:84], "little")


def _read_binary(data: bytes) -> Float64Array:
    """Return corners (3 n, 3), three per triangle."""
    if len(data) < _HEADER_BYTES:
        raise MeshError(
            f"expected a binary STL header of {_HEADER_BYTES} bytes or the word solid, got {len(data)} bytes"
        )
    expected = _compute_expected_bytes(data)
    if len(data) != expected:
        count = (expected - _HEADER_BYTES) // _TRIANGLE.itemsize
        raise MeshError(f"declares {count} triangles, which make {expected} bytes, got {len(data)}")
    corners = np.frombuffer(data, _TRIANGLE, offset=_HEADER_BYTES)["corners"]
    return corners.reshape(-1, 3).astype(np.float64)


def _read_text(data: bytes) -> Float64Array:
    """Return corners (3 n, 3), three per triangle."""
    data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    rows = _VERTEX.findall(data)
    ends = [word.lower() for word in _END.findall(data)]
    n_facets, n_solids = ends.count(b"endfacet"), ends.count(b"endsolid")
    if len(rows) != 3 * n_facets or n_solids == 0:
        raise MeshError(f"cut off: {len(rows)} vertex, {n_facets} endfacet and {n_solids} endsolid statements")
    try:
        # NaNs between the rows show whether each row has three numbers.
        table = parse_numbers(b"".join([row + b" nan " for row in rows]), "float").reshape(-1, 4)
        if not np.array_equal(np.isnan(table), np.broadcast_to([False, False, False, True], table.shape)):
            raise ValueError("a row has more or less than three numbers")
    except ValueError:
        return _read_text_lines(data)
    return table[:, :3]


def _read_text_lines(data: bytes) -> Float64Array:
    """Return the same as `_read_text`, or raise MeshError with the line that is malformed."""
    corners = []
    for line, text in enumerate(data.split(b"\n"), 1):
        words = text.split()
        if words and words[0].lower() == b"vertex":
            if len(words) != 4:
                raise MeshError(f"line {line}: expected vertex and 3 numbers, got {quote(text.strip())}")
            corners.append([parse_float(word, line) for word in words[1:]])
    return np.array(corners).reshape(-1, 3)


def _merge_points(corners: Float64Array) -> Mesh:
    """Return the mesh of triangles with corners (3 n, 3); equal corners become one point, in the order of first use."""
    points = corners + 0.0  # no -0.0
    bits = points.view(np.uint64)
    bits = bits ^ (bits >> np.uint64(32))  # float32 in float64 leaves the low bits empty
    # Equal points have equal keys; the rare different points with equal keys are separated below, by coordinates.
    keys = bits @ np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
    order = np.argsort(keys, kind="stable")
    ordered = points[order]
    is_new = np.ones(len(points), bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    first = order[is_new]  # the first appearance of each point, because the sort is stable
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    triangles = np.empty(len(points), np.int64)
    triangles[order] = rank[np.cumsum(is_new) - 1]
    return Mesh(points[np.sort(first)], triangles.reshape(-1, 3))


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write binary STL."""
    _trimesh.export(mesh, file, "stl")
