"""STL, binary and ASCII, through trimesh; corners at the same point become one point."""

import re
from typing import BinaryIO

import numpy as np

from ..errors import MeshError
from ..mesh import Mesh
from . import _trimesh

_HEADER_BYTES = 84
_TRIANGLE_BYTES = 50
_STATEMENT = re.compile(rb"^[ \t]*(vertex|endfacet|endsolid)\b", re.MULTILINE | re.IGNORECASE)


def read(data: bytes) -> Mesh:
    """Return the mesh of an STL file; raise MeshError for one that is cut off or has a NaN or an infinity."""
    is_text = data[:512].lstrip()[:5].lower() == b"solid" and b"facet" in data[:4096].lower()
    if is_text and _expected_bytes(data) != len(data):
        _check_text(data)
        return _joined(_trimesh.load_scene(data, "stl_ascii"))
    if len(data) < _HEADER_BYTES:
        raise MeshError(
            f"expected a binary STL header of {_HEADER_BYTES} bytes or the word solid, got {len(data)} bytes"
        )
    if len(data) != (expected := _expected_bytes(data)):
        count = (expected - _HEADER_BYTES) // _TRIANGLE_BYTES
        raise MeshError(f"declares {count} triangles, which make {expected} bytes, got {len(data)}")
    return _joined(_trimesh.load_scene(data, "stl"))


def _expected_bytes(data: bytes) -> int:
    return _HEADER_BYTES + _TRIANGLE_BYTES * int.from_bytes(data[80:84], "little")


def _check_text(data: bytes) -> None:
    """Raise MeshError unless every facet is whole and every solid is closed."""
    words = [word.lower() for word in _STATEMENT.findall(data.replace(b"\r", b"\n"))]
    corners, facets, solids = (words.count(word) for word in (b"vertex", b"endfacet", b"endsolid"))
    if corners != 3 * facets or not solids:
        raise MeshError(f"an ASCII STL cut off: {corners} vertex, {facets} endfacet and {solids} endsolid statements")


def _joined(mesh: Mesh) -> Mesh:
    """Return the mesh with equal points made one, in the order in which they first appear."""
    points = mesh.positions + 0.0  # no -0.0
    order = np.lexsort(points.T)
    ordered = points[order]
    is_new = np.ones(len(points), bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    group = np.empty(len(points), np.int64)
    group[order] = np.cumsum(is_new) - 1
    first = order[is_new]  # lexsort is stable: the lowest place of each group
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return Mesh.from_offsets(points[np.sort(first)], mesh.offsets, rank[group[mesh.indices]])


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write binary STL."""
    _trimesh.export(mesh, file, "stl")
