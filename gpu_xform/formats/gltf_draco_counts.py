"""What streams of Draco declare, found without decoding them: how large they get is known before.

The sections are those of the Draco Bitstream Specification, version 2.2, which KHR_draco_mesh_compression asks for.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from ..errors import MeshError

_VERSION = (2, 2)
_MESH, _SEQUENTIAL, _EDGEBREAKER = 1, 0, 1
_HAS_METADATA = 1 << 15
_STANDARD, _VALENCE = 0, 2
_N_VALENCES = 6
_PACKED_CORNERS = 0
_TAGGED = 0
_ZEROS = 3  # in place of the number of further bytes
_TAG_PRECISION = 1 << 12
_TAG_BASE = 4 * _TAG_PRECISION


@dataclass(frozen=True)
class DracoCounts:
    """How much a stream declares to hold."""

    n_points: int
    """At least."""
    n_faces: int
    n_seams: int
    """Attributes with an own connectivity."""


def count_draco(data: bytes) -> DracoCounts:
    """Return what the header of a stream declares (2, 3); raise MeshError for a stream of another kind."""
    with _read(data) as reader:
        return _read_header(reader)[0]


def count_components(data: bytes) -> int:
    """Return how many numbers all attributes together have per point; raise MeshError for a damaged stream.

    Its time may grow with the number of faces, which `count_draco` tells before.
    """
    with _read(data) as reader:
        counts, traversal = _read_header(reader)
        if traversal is None:
            _skip_corners(reader, counts)
        else:
            _skip_traversal(reader, traversal, counts)
        return _count_attributes(reader, traversal is None)


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

    def skip_varints(self, n: int) -> None:
        if n:
            ends = np.flatnonzero(np.frombuffer(self._data, np.uint8)[self._place :] < 128)
            self._place += int(ends[n - 1]) + 1

    def block(self) -> bytes:
        """Return the bytes whose number stands before them."""
        n_bytes = self.varint()
        self.skip(n_bytes)
        return self._data[self._place - n_bytes : self._place]


@contextmanager
def _read(data: bytes) -> Iterator[_Reader]:
    if data[:5] != b"DRACO":
        raise MeshError("expected a stream that begins with 'DRACO'")
    try:
        yield _Reader(data, 5)
    except IndexError:
        raise MeshError(f"its {len(data)} bytes end too soon") from None


def _read_header(reader: _Reader) -> tuple[DracoCounts, int | None]:
    """Return the counts of a stream and how its faces are traversed, None if they are in sequence (2.1, 3)."""
    major, minor, kind, method = (reader.byte() for _ in range(4))
    if (major, minor) != _VERSION or kind != _MESH or method not in (_SEQUENTIAL, _EDGEBREAKER):
        raise MeshError(
            f"expected a mesh of bitstream 2.2, got type {kind} and method {method} of bitstream {major}.{minor}"
        )
    flags = reader.byte() | reader.byte() << 8
    if flags & _HAS_METADATA:
        _skip_metadata(reader)
    if method == _SEQUENTIAL:
        n_faces, n_points = reader.varint(), reader.varint()
        return DracoCounts(n_points, n_faces, 0), None
    traversal = reader.byte()
    n_points, n_faces = reader.varint(), reader.varint()
    return DracoCounts(n_points, n_faces, reader.byte()), traversal


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


def _skip_corners(reader: _Reader, counts: DracoCounts) -> None:
    """Move on to behind faces in sequence (3.1)."""
    n_corners = 3 * counts.n_faces
    if reader.byte() == _PACKED_CORNERS:
        _skip_symbols(reader, n_corners)
    elif 1 << 16 <= counts.n_points < 1 << 21:
        reader.skip_varints(n_corners)
    else:
        reader.skip(n_corners * (1 if counts.n_points < 1 << 8 else 2 if counts.n_points < 1 << 16 else 4))


def _skip_traversal(reader: _Reader, traversal: int, counts: DracoCounts) -> None:
    """Move on to behind the faces of Edgebreaker (3.2)."""
    reader.varint()  # symbols
    reader.varint()  # those that split
    n_splits = reader.varint()
    for _ in range(2 * n_splits):
        reader.varint()
    reader.skip(-(-n_splits // 8))
    if traversal == _STANDARD:
        reader.block()
    elif traversal != _VALENCE:
        raise MeshError(f"its faces are traversed in a way, {traversal}, that bitstream 2.2 does not know")
    for _ in range(1 + counts.n_seams):  # the first faces, and the seams of each attribute
        reader.byte()
        reader.block()
    if traversal == _VALENCE:
        for _ in range(_N_VALENCES):
            n_symbols = reader.varint()
            if n_symbols > counts.n_faces:
                raise MeshError(f"it has {n_symbols} symbols for {counts.n_faces} faces")
            if n_symbols:
                _skip_symbols(reader, n_symbols)


def _skip_symbols(reader: _Reader, n_symbols: int) -> None:
    """Move on to behind symbols that are packed by their frequency (5)."""
    if reader.byte() == _TAGGED:
        frequencies = _read_frequencies(reader)
        # What the symbols themselves take is known by their lengths, which are packed.
        reader.skip(-(-_sum_symbols(reader.block(), frequencies, n_symbols) // 8))
    else:
        reader.byte()  # of how many bits they are
        _read_frequencies(reader)
        reader.block()


def _read_frequencies(reader: _Reader) -> dict[int, int]:
    """Return how often each symbol comes, of those that come at all."""
    n_symbols, symbol = reader.varint(), 0
    frequencies: dict[int, int] = {}
    while symbol < n_symbols:
        byte = reader.byte()
        n_more, value = byte & 3, byte >> 2
        if n_more == _ZEROS:
            symbol += value + 1
            continue
        for k in range(n_more):
            value |= reader.byte() << (8 * k + 6)
        frequencies[symbol] = value
        symbol += 1
    return frequencies


def _sum_symbols(data: bytes, frequencies: dict[int, int], n_symbols: int) -> int:
    """Return the sum of so many symbols that an rANS coder has packed (5.1)."""
    if sum(frequencies.values()) != _TAG_PRECISION:
        raise MeshError("its symbols are damaged")
    found = [symbol for symbol, frequency in frequencies.items() for _ in range(frequency)]
    before = dict(zip(frequencies, accumulate(frequencies.values(), initial=0), strict=False))
    n_rest = len(data) - 1 - (data[-1] >> 6)
    n_bits = 8 * (len(data) - n_rest) - 2
    state = _TAG_BASE + (int.from_bytes(data[n_rest:], "little") & (1 << n_bits) - 1)
    total = 0
    for _ in range(n_symbols):
        while state < _TAG_BASE:
            n_rest -= 1
            state = state << 8 | data[n_rest]
        quotient, rest = divmod(state, _TAG_PRECISION)
        symbol = found[rest]
        state = quotient * frequencies[symbol] + rest - before[symbol]
        total += symbol
    return total


def _count_attributes(reader: _Reader, is_sequential: bool) -> int:
    """Return how many components the attributes have together (4)."""
    n_decoders, n_components = reader.byte(), 0
    if not is_sequential:
        reader.skip(3 * n_decoders)
    for _ in range(n_decoders):
        n_attributes = reader.varint()
        for _ in range(n_attributes):
            reader.skip(2)  # its meaning and type
            n_components += reader.byte()
            reader.skip(1)  # whether it is normalized
            reader.varint()  # its id
        reader.skip(n_attributes)
    return n_components
