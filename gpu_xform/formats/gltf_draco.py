"""Streams of Draco in glTF: what their headers declare, and what they hold.

The sections are those of the Draco Bitstream Specification, version 2.2, which KHR_draco_mesh_compression asks for.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.interrupts import defer_interrupts
from ..errors import MeshError

_VERSION = (2, 2)
_MESH, _SEQUENTIAL, _EDGEBREAKER = 1, 0, 1
_HAS_METADATA = 1 << 15


@dataclass(frozen=True)
class DracoCounts:
    """How much a stream declares to hold."""

    n_points: int
    """At least."""
    n_faces: int
    n_seams: int
    """Attributes with an own connectivity."""


@dataclass(frozen=True, eq=False)
class DracoMesh:
    """What a stream holds."""

    columns: dict[int, npt.NDArray[Any]]
    """By the id of the attribute."""
    corners: npt.NDArray[np.uint32]
    """(c, 1)"""


def count_draco(data: bytes) -> DracoCounts:
    """Return what the header of a stream declares (2, 3); raise MeshError for a stream of another kind."""
    if data[:5] != b"DRACO":
        raise MeshError("expected a stream that begins with 'DRACO'")
    reader = _Reader(data, 5)
    try:
        major, minor, kind, method = (reader.byte() for _ in range(4))
        if (major, minor) == _VERSION and kind == _MESH and method in (_SEQUENTIAL, _EDGEBREAKER):
            flags = reader.byte() | reader.byte() << 8
            if flags & _HAS_METADATA:
                _skip_metadata(reader)
            if method == _SEQUENTIAL:
                n_faces, n_points = reader.varint(), reader.varint()
                return DracoCounts(n_points, n_faces, 0)
            reader.byte()  # the kind of its traversal
            n_points, n_faces = reader.varint(), reader.varint()
            return DracoCounts(n_points, n_faces, reader.byte())
    except IndexError:
        raise MeshError(f"its {len(data)} bytes end within their header") from None
    raise MeshError(
        f"expected a mesh of bitstream 2.2, got type {kind} and method {method} of bitstream {major}.{minor}"
    )


def decode_draco(data: bytes, require: Callable[[DracoCounts], None]) -> DracoMesh:
    """Return what a stream holds; raise MeshError if it is damaged, and ImportError without DracoPy.

    require : raises an error if it is too much
    """
    with defer_interrupts():
        import DracoPy

    require(count_draco(data))
    try:
        mesh = DracoPy.decode(data)
    except MemoryError:
        raise
    except Exception as error:  # whatever damaged content brings the library to
        raise MeshError(str(error)) from None
    columns = {attribute["unique_id"]: attribute["data"] for attribute in mesh.attributes}
    return DracoMesh(columns, np.asarray(mesh.faces, np.uint32).reshape(-1, 1))


class _Reader:
    """A place in bytes that moves on; beyond their end is an IndexError."""

    def __init__(self, data: bytes, place: int) -> None:
        self._data = data
        self._place = place

    def byte(self) -> int:
        self._place += 1
        return self._data[self._place - 1]

    def varint(self) -> int:
        """Return an integer of seven bits per byte, the lowest first."""
        value, shift, more = 0, 0, True
        while more:
            byte = self.byte()
            value |= (byte & 127) << shift
            shift, more = shift + 7, byte > 127 and shift < 63
        return value

    def skip(self, n_bytes: int) -> None:
        self._place += n_bytes


def _skip_metadata(reader: _Reader) -> None:
    """Move on to behind the metadata of a stream and of its attributes (2.2)."""
    n_attributes = reader.varint()
    for i in range(n_attributes + 1):
        if i < n_attributes:
            reader.varint()  # the id of an attribute
        waiting, is_named = 1, False
        while waiting:
            if is_named:
                reader.skip(reader.byte())
            for _ in range(reader.varint()):
                reader.skip(reader.byte())
                reader.skip(reader.varint())
            waiting, is_named = waiting - 1 + reader.varint(), True
