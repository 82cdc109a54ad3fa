"""PLY files of points without faces, binary, as chunked points; other PLY files are meshes, read whole."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import StrPath
from ..errors import ArgumentError, MeshError
from ..formats.ply_header import (
    MAX_BLANK_BYTES,
    NAMES_OF_TYPES,
    Header,
    parse_header,
    split_attributes,
    warn_of_bytes_behind,
)
from .npy import find_extremes, scan_bounds
from .partial_files import FileSink
from .protocol import Block, Bounds, ChunkError, Directions, Encoded, PointSource, describe_file

AXES = ("x", "y", "z")
_MAX_HEADER_BYTES = 1 << 20
_MAX_FLOAT32 = float(np.finfo(np.float32).max)
_NORMAL = Directions(("nx", "ny", "nz"), True)


def is_cloud(path: StrPath) -> bool:
    """Return whether a file is a PLY that can be streamed: binary, points without lists, and no faces."""
    try:
        with Path(path).open("rb") as file:
            return _is_cloud(parse_header(file.read(_MAX_HEADER_BYTES)))
    except (MeshError, OSError):
        return False


def _is_cloud(header: Header) -> bool:
    elements = [element for element in header.elements if element.count or element.name == "vertex"]
    names = {element.name for element in header.elements}
    if header.encoding == "ascii" or [element.name for element in elements] != ["vertex"] or names - {"vertex", "face"}:
        return False
    properties = {p.name: p for p in elements[0].properties}
    return properties.keys() >= {*AXES} and all(
        p.count_dtype is None and (p.name not in AXES or p.dtype.kind == "f") for p in properties.values()
    )


class PlySource:
    """A binary PLY file of points alone."""

    file_type = "ply"
    n_columns = 3
    dtype = np.dtype(np.float64)
    chunk_points = 1

    def __init__(self, path: StrPath) -> None:
        self.path = os.fspath(path)
        self._file = Path(path).open("rb")  # noqa: SIM115 - closed by `close`
        try:
            self.head = self._file.read(_MAX_HEADER_BYTES)
            header = parse_header(self.head)
            if not _is_cloud(header):
                raise ArgumentError.expecting(
                    "source",
                    "be a binary PLY file of points, without faces and lists",
                    repr(self.path),
                    reason="others are models, which load_mesh reads whole",
                )
            self.head = self.head[: header.end]
            self.header = header
            (vertex,) = (element for element in header.elements if element.name == "vertex")
            self.record_dtype = np.dtype([(p.name, p.dtype) for p in vertex.properties])
            self.n_points, self.point_bytes = vertex.count, self.record_dtype.itemsize
            held = os.fstat(self._file.fileno()).st_size - header.end
            if held < self.n_points * self.point_bytes:
                n_held = held // self.point_bytes
                raise MeshError(f"vertex {n_held}: the file ends within this row, of {self.n_points} declared")
        except MeshError as error:
            self._file.close()
            raise MeshError(f"{self.path}: {error}") from None
        except BaseException:
            self._file.close()
            raise
        names = self.record_dtype.names or ()
        self.attributes: Sequence[str] = [name for name in names if name not in AXES]
        is_turned = {*_NORMAL.fields} <= {*names} and len({self.record_dtype[name] for name in _NORMAL.fields}) == 1
        self.directions: Sequence[Directions] = [_NORMAL] if is_turned else []
        self.world_from_stored = np.identity(4)
        self._buffer, self._spare = bytearray(), bytearray()

    def read(self, start: int, stop: int) -> Block:
        """Return whole points, in memory that the call after the next one may use again."""
        n_bytes = (stop - start) * self.point_bytes
        self._buffer, self._spare = self._spare, self._buffer
        if len(self._buffer) < n_bytes:
            self._buffer = bytearray(n_bytes)
        self._file.seek(self.header.end + start * self.point_bytes)
        if self._file.readinto(memoryview(self._buffer)[:n_bytes]) != n_bytes:
            raise ArgumentError.expecting("source", "not shrink meanwhile", repr(self.path))
        records = np.frombuffer(self._buffer, self.record_dtype, stop - start)
        positions = np.empty((len(records), 3))
        with np.errstate(invalid="ignore"):  # of signalling NaNs
            for i, axis in enumerate(AXES):
                positions[:, i] = records[axis]
        return Block(start, positions, records)

    def warn_of_bytes_behind(self) -> None:
        """Warn if the file goes on behind its points."""
        end = self.header.end + self.n_points * self.point_bytes
        self._file.seek(end)
        first = self._file.read(MAX_BLANK_BYTES)
        warn_of_bytes_behind(os.fstat(self._file.fileno()).st_size - end, first, self.path)

    def read_raw(self, start: int, stop: int) -> Block:
        """Raise: nothing here is compressed."""
        raise ChunkError(f"{self.path}: not compressed", start, stop)

    def read_bounds(self) -> Bounds:
        """Return the corners of the box of all points, which are read for it."""
        return scan_bounds(self)

    def read_columns(self, block: Block) -> Mapping[str, npt.NDArray[Any]]:
        """Return all properties but x, y and z."""
        assert block.records is not None  # noqa: S101
        return {name: block.records[name] for name in self.attributes}

    def describe_state(self) -> list[Any]:
        """Return size and time."""
        return describe_file(self.path)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class PlySink(FileSink):
    """A binary PLY file of points that grows: as its source if that is one, else little-endian."""

    chunk_points = 1

    def __init__(
        self,
        destination: StrPath,
        path: Path,
        is_stream: bool,
        n_points: int,
        dtype: np.dtype[Any],
        columns: Mapping[str, np.dtype[Any]],
    ) -> None:
        super().__init__(destination, path, is_stream)
        axis = np.dtype(f"<f{dtype.itemsize}")
        self._attributes = {part: name for name, parts in name_properties(columns).items() for part in parts}
        fields = [(name, axis) for name in AXES]
        fields += [(part, columns[name].newbyteorder("<")) for part, name in self._attributes.items()]
        self._record_dtype = np.dtype(fields)
        self.point_bytes = self._record_dtype.itemsize
        self.world_from_stored = np.identity(4)
        self.head = "".join(
            [
                f"ply\nformat binary_little_endian 1.0\nelement vertex {n_points}\n",
                *(f"property {NAMES_OF_TYPES[kind.str[1:]]} {name}\n" for name, kind in fields),
                "end_header\n",
            ]
        ).encode("latin-1")

    def encode(self, block: Block, positions: npt.NDArray[Any], source: PointSource) -> Encoded:
        """Return whole points; raise MeshError for a coordinate that is not finite."""
        records = np.empty(len(positions), self._record_dtype)
        columns = source.read_columns(block)
        for part, name in self._attributes.items():
            records[part] = columns[name]
        return _put_positions(records, positions, block, source)


class SamePlySink(FileSink):
    """A PLY file with the header of its source."""

    chunk_points = 1

    def __init__(self, destination: StrPath, path: Path, is_stream: bool, source: PlySource) -> None:
        super().__init__(destination, path, is_stream)
        self.point_bytes = source.point_bytes
        self.world_from_stored = np.identity(4)
        self.head = source.head

    def encode(self, block: Block, positions: npt.NDArray[Any], source: PointSource) -> Encoded:
        """Return whole points; raise MeshError for a coordinate that is not finite."""
        assert block.records is not None  # noqa: S101
        return _put_positions(block.records, positions, block, source)


def name_properties(columns: Mapping[str, np.dtype[Any]]) -> dict[str, dict[str, Any]]:
    """Return the properties of the columns that PLY has a type for, by column."""
    return split_attributes(
        {name: kind for name, kind in columns.items() if kind.str[1:] in NAMES_OF_TYPES}, set(), AXES
    )


def _put_positions(
    records: npt.NDArray[Any], positions: npt.NDArray[Any], block: Block, source: PointSource
) -> Encoded:
    if len(positions) == 0:
        return Encoded(block.start, 0, b"")
    if not _are_small(positions):
        _require_places(records, positions, block, source)
    for i, axis in enumerate(AXES):
        records[axis] = positions[:, i]
    return Encoded(block.start, len(records), records.view(np.uint8).data)


def _are_small(positions: npt.NDArray[Any]) -> bool:
    """Return whether all coordinates are finite and fit into a float32, as their sum of squares tells in one pass."""
    flat = positions.reshape(-1)
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.einsum("i,i->", flat, flat)) < _MAX_FLOAT32**2


def _require_places(records: npt.NDArray[Any], positions: npt.NDArray[Any], block: Block, source: PointSource) -> None:
    """Raise MeshError for a coordinate that is not finite, or that the type of its column cannot hold."""
    reach = np.abs(find_extremes(positions)).max(axis=0)
    if not np.isfinite(reach).all():  # in the source or since
        for where, points in ((f"{source.path}: vertex", block.positions), (f"{source.path}: moved vertex", positions)):
            is_finite = np.isfinite(points).all(axis=1)
            if not is_finite.all():
                row = int(np.argmin(is_finite))
                raise MeshError(f"{where} {block.start + row}: coordinates must be finite, got {points[row].tolist()}")
    for i, axis in enumerate(AXES):
        if records.dtype[axis].itemsize == 4 and reach[i] > _MAX_FLOAT32:
            raise MeshError(f"{source.path}, transformed: coordinates overflow the float of {axis}")
