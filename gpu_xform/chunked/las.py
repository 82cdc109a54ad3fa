"""LAS and LAZ files, and COPC to read, as chunked points."""

import os
import shutil
import struct
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._core.error_context import prefix_errors
from .._core.types import Float64Array, StrPath
from ..errors import ArgumentError, MeshError
from ..formats._warn import warn
from ..formats.las import import_laspy, parse_laspy_header, warn_of_points_behind
from ..formats.las_header import (
    COPC_USER,
    CRS_USER,
    EXTRA_BYTES_VLR,
    LAZ_VLR,
    LasHeader,
    build_head,
    choose_grid,
    patch_head,
    read_las_header,
    require_points_counted,
)
from ..formats.laz import CHUNK_POINTS, ChunkTable, LazError, compress, import_lazrs, make_laz_record, write_table
from .las_fields import describe_record, list_fixed_normals
from .npy import SCAN_POINTS, find_extremes
from .partial_files import FileSink
from .protocol import Block, Bounds, ChunkError, Encoded, GridError, PointSource, describe_file

AXES = ("X", "Y", "Z")
_INT32 = np.iinfo(np.int32)
DEFAULT_SCALE = 0.001
_NORMAL_NAMES = ("nx", "ny", "nz")
_CHUNK_POINTS_OF_LAS = 1


def read_laspy_header(path: StrPath) -> Any:
    """Return the header as laspy reads it; raise MeshError where it does not, as for names that are no UTF-8."""
    with Path(path).open("rb") as file, prefix_errors(os.fspath(path)):
        return parse_laspy_header(file)


class LasSource:
    """A LAS or LAZ file, point formats 0 to 10."""

    n_columns = 3
    dtype = np.dtype(np.float64)

    def __init__(self, path: StrPath) -> None:
        self.path = os.fspath(path)
        self._file = Path(path).open("rb")  # noqa: SIM115 - closed by `close`
        try:
            self.header = read_las_header(self._file)
            require_points_counted(self.header)
            self.file_type = "laz" if self.header.is_compressed else "las"
            self._table = ChunkTable(self._file, self.header) if self.header.is_compressed else None
        except MeshError as error:
            self._file.close()
            raise MeshError(f"{self.path}: {error}") from None
        except BaseException:
            self._file.close()
            raise
        self.n_points = self.header.n_points
        self.point_bytes = self.header.record_bytes
        self.record_dtype, self.directions = describe_record(self.header)
        self.world_from_stored = grid_matrix(self.header.scales, self.header.offsets)
        self._buffer, self._spare = bytearray(), bytearray()
        self._counted: Bounds | None = None
        self._told: set[str] = set()

    def warn_of_points_behind(self) -> None:
        """Warn, once, if more points are in the file than the header counts."""
        if "points behind" not in self._told:
            warn_of_points_behind(self.header, self._table, self.path)
        self._told.add("points behind")

    def warn_of_fixed_normals(self) -> None:
        """Warn of normals that no matrix turns."""
        if names := list_fixed_normals(self.header):
            self.warn_once(f"{', '.join(names)} are integers, which are left as they were")

    def warn_once(self, message: str) -> None:
        """Warn of this file, but not again where a run is planned anew for bounds that were counted."""
        if message not in self._told:
            warn(f"{self.path}: {message}")
        self._told.add(message)

    def list_records(self) -> list[str]:
        """Return in words what it holds of the whole cloud, but for records that tell how its points are stored."""
        header, own = self.header, (LAZ_VLR, EXTRA_BYTES_VLR)
        users = [vlr.user for vlr in header.vlrs if (vlr.user, vlr.number) not in own] + [
            evlr[0] for evlr in header.evlrs
        ]
        n_others = sum(user not in (COPC_USER, CRS_USER) for user in users)
        found = ["the coordinate system"] if header.has_crs else []
        return found + ([f"{n_others} {'other ' * header.has_crs}record{'s' * (n_others > 1)}"] if n_others else [])

    @property
    def chunk_points(self) -> int:
        """How many points are read together; 1 where it varies, as in COPC, chunks are too large, or there are none."""
        table = self._table
        return 1 if table is None or table.chunk_points is None or table.is_large(0) else table.chunk_points

    @property
    def is_copc(self) -> bool:
        """Whether it holds an index of COPC."""
        return self.header.find_vlr((COPC_USER, 1)) is not None

    def read(self, start: int, stop: int) -> Block:
        """Return whole points, in memory that the call after the next one may use again."""
        if self._table is None:
            records = self._read_plain(start, stop)
        else:
            records = self._read_compressed(self._table, start, stop)
        return Block(start, _view_positions(records), records)

    def _read_plain(self, start: int, stop: int) -> npt.NDArray[Any]:
        n_bytes = (stop - start) * self.point_bytes
        self._buffer, self._spare = self._spare, self._buffer
        if len(self._buffer) < n_bytes:
            self._buffer = bytearray(n_bytes)
        self._file.seek(self.header.points_start + start * self.point_bytes)
        if self._file.readinto(memoryview(self._buffer)[:n_bytes]) != n_bytes:
            raise ArgumentError.expecting("source", "not shrink meanwhile", repr(self.path))
        return np.frombuffer(self._buffer, self.record_dtype, stop - start)

    def _read_compressed(self, table: ChunkTable, start: int, stop: int) -> npt.NDArray[Any]:
        if start == stop:
            return np.empty(0, self.record_dtype)
        try:
            points = table.read_points(self._file, start, stop)
        except LazError as error:
            if error.chunk is None:
                raise
            begin, end = map(int, table.starts[error.chunk : error.chunk + 2])
            raise ChunkError(
                f"{self.path}: chunk {error.chunk} (points {begin} to {end - 1}) does not decompress: {error}",
                *(begin, end),
            ) from None
        return np.frombuffer(points, self.record_dtype)

    def read_raw(self, start: int, stop: int) -> Block:
        """Return a chunk as it is compressed."""
        assert self._table is not None  # noqa: S101
        first, last = self._table.span(start, stop)
        return Block(start, np.empty((0, 3)), None, (stop - start, self._table.read_raw(self._file, first, last)))

    def read_bounds(self) -> Bounds:
        """Return the box that the header says, which is true in most files; that of the points once it was counted."""
        if self._counted is None and not self.header.has_bounds:
            self.count_bounds()
        return self._counted or (self.header.low, self.header.high)

    def count_bounds(self) -> bool:
        """Read all points for their box; return whether it differs from the header's, of which a warning tells then."""
        if self._counted is not None:
            return False
        header = self.header
        cells = np.array([[_INT32.max] * 3, [_INT32.min] * 3], np.int64)
        for block in self._read_what_decompresses():
            low, high = find_extremes(np.ascontiguousarray(block.positions))
            cells = np.stack([np.minimum(cells[0], low), np.maximum(cells[1], high)])
        if (cells[0] > cells[1]).any():  # there are no points, or none that can be read
            self._counted = np.zeros(3), np.zeros(3)
            return False
        low, high = cells * header.scales + header.offsets
        self._counted = low, high
        with np.errstate(over="ignore", invalid="ignore"):
            is_other = not (np.abs(np.stack([low - header.low, high - header.high])) <= 2 * header.scales).all()
        if is_other:
            counted, said = (" to ".join(map(_write_corner, box)) for box in ((low, high), (header.low, header.high)))
            warn(
                f"{self.path}: its points lie from {counted}, its header says {said}: counted, for the grid of the "
                "result"
            )
        return is_other

    def _read_what_decompresses(self) -> Iterator[Block]:
        """Yield all points but those of chunks that do not decompress, which the run itself will name."""
        step = max(SCAN_POINTS // self.chunk_points, 1) * self.chunk_points
        start = 0
        while start < self.n_points:
            stop = min(start - start % step + step, self.n_points)
            try:
                block = self.read(start, stop)
            except ChunkError as error:
                if start < error.start:
                    yield self.read(start, error.start)
                start = error.stop
            else:
                yield block
                start = stop

    @property
    def attributes(self) -> Sequence[str]:
        """Names of all dimensions but X, Y and Z, as laspy has them; those of normals are nx, ny and nz."""
        return list(self._name_dimensions(read_laspy_header(self.path).point_format).values())

    def _name_dimensions(self, point_format: Any) -> dict[str, str]:
        normals = next((each.fields for each in self.directions if each.is_normal), ())
        renamed = dict(zip(normals, _NORMAL_NAMES, strict=False))
        return {name: renamed.get(name, name) for name in point_format.dimension_names if name not in AXES}

    def read_columns(self, block: Block) -> Mapping[str, npt.NDArray[Any]]:
        """Return all dimensions but X, Y and Z, bit fields as numbers."""
        laspy = import_laspy()
        point_format = read_laspy_header(self.path).point_format
        assert block.records is not None  # noqa: S101
        array = np.ndarray(len(block.records), point_format.dtype(), block.records.data)
        points = laspy.PackedPointRecord(array, point_format)
        return {name: np.asarray(points[old]) for old, name in self._name_dimensions(point_format).items()}

    def describe_state(self) -> list[Any]:
        """Return size and time."""
        return describe_file(self.path)

    def copy_tail(self, destination: BinaryIO) -> tuple[int, tuple[int, int] | None]:
        """Copy the records behind the points; return by how much they have moved, and place and number of EVLRs."""
        header = self.header
        start = header.tail_start
        shift = destination.tell() - start
        kept = [evlr for evlr in header.evlrs if evlr[0] != COPC_USER]
        with Path(self.path).open("rb") as file:
            if len(kept) == len(header.evlrs):
                file.seek(start)
                shutil.copyfileobj(file, destination)
                first = kept[0][2] + shift if kept else 0
                return shift, ((first, len(kept)) if header.version >= 4 else None)
            first = destination.tell()
            for _, _, place, length in kept:
                file.seek(place)
                destination.write(file.read(length))
        return shift, (first if kept else 0, len(kept))

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class LasSink(FileSink):
    """A LAS or LAZ file that grows; from LAS or LAZ all fields but those that a matrix changes stay as they are."""

    is_patched = True
    has_journal = True
    keeps_raw = True

    def __init__(
        self, destination: StrPath, path: Path, is_stream: bool, header: LasHeader, grid: Any, is_compressed: bool
    ) -> None:
        """Take the header of the source, and `grid`: scales and offsets of the destination."""
        super().__init__(destination, path, is_stream)
        self._header = header
        self.scales, self.offsets = grid
        self._record = make_laz_record(header) if is_compressed else None
        self.head = build_head(header, self.scales, self.offsets, self._record)
        self._points_start = len(self.head)
        if is_compressed:
            self.head += bytes(8)
        self.chunk_points = CHUNK_POINTS if is_compressed else _CHUNK_POINTS_OF_LAS
        self.point_bytes = header.record_bytes
        self.world_from_stored = grid_matrix(self.scales, self.offsets)
        self._source_path: str | None = None

    def encode(self, block: Block, positions: npt.NDArray[Any], source: PointSource) -> Encoded:
        """Return whole points, rounded to the grid; raise ArgumentError where int32 cannot hold them."""
        if block.raw is not None:
            return self._keep_raw(block, source)
        records = self._make_records(block, source)
        low, high = round_to_grid(positions)
        if len(positions) and not (low.min() >= _INT32.min and high.max() <= _INT32.max):
            self._refuse(block, positions, source)
        _view_positions(records)[:] = positions
        facts: dict[str, Any] = {"low": low.tolist(), "high": high.tolist()} if len(positions) else {}
        facts |= self._describe_records(records)
        body: Any = np.ascontiguousarray(records).view(np.uint8).data
        if self._record is not None:
            try:
                body, facts["table"] = compress(self._record, body)
            except LazError as error:
                stop = block.start + len(positions)
                raise ArgumentError(
                    f"{self._destination}: points {block.start} to {stop - 1} cannot be compressed: {error}; write .las"
                ) from None
        return Encoded(block.start, len(positions), body, facts)

    def _keep_raw(self, block: Block, source: PointSource) -> Encoded:
        n_points, body = block.raw
        is_laz = self._record is not None and source.file_type == "laz"
        if not is_laz or (n_points != CHUNK_POINTS and block.start + n_points != self._header.n_points):
            raise ArgumentError(
                f"{self._destination}: cannot hold a chunk that does not decompress; a .laz file with chunks of "
                f"{CHUNK_POINTS:,} points, from another such file, can"
            )
        return Encoded(block.start, n_points, body, {"table": [[n_points, len(body)]]})

    def _make_records(self, block: Block, source: PointSource) -> npt.NDArray[Any]:
        assert isinstance(source, LasSource)  # noqa: S101
        assert block.records is not None  # noqa: S101
        return block.records

    def _describe_records(self, records: npt.NDArray[Any]) -> dict[str, Any]:  # noqa: ARG002 - of new files alone
        """Return what `finish` needs to know of points beside their bounds."""
        return {}

    def _refuse(self, block: Block, positions: npt.NDArray[Any], source: PointSource) -> None:
        fits = ((positions >= _INT32.min) & (positions <= _INT32.max)).all(axis=1)  # False for NaN
        i = int(np.argmin(fits))
        world = positions[i] * self.scales + self.offsets
        raise GridError(
            f"{source.path}: point {block.start + i} comes to {world.tolist()}, which 32-bit integers of scale "
            f"{self.scales.tolist()} around {self.offsets.tolist()} cannot hold: give another "
            f"scale and offset"
        )

    def finish(self, file: BinaryIO, facts: list[dict[str, Any]]) -> None:
        """Write the table of chunks, the records behind the points, and the bounds in the header."""
        if self._record is not None:
            table = [(int(count), int(size)) for part in facts for count, size in part["table"]]
            write_table(file, self._record, self._points_start, table)
        shift, evlrs = self._copy_tail(file)
        boxes = [(part["low"], part["high"]) for part in facts if "low" in part]
        low = high = np.zeros(3)
        if boxes:
            low = np.min([low for low, _ in boxes], axis=0) * self.scales + self.offsets
            high = np.max([high for _, high in boxes], axis=0) * self.scales + self.offsets
        patch_head(self._header, file, low, high, shift, evlrs)
        file.seek(0, os.SEEK_END)

    def _copy_tail(self, file: BinaryIO) -> tuple[int, tuple[int, int] | None]:
        if self._source_path is None:
            return 0, ((0, 0) if self._header.version >= 4 else None)
        source = LasSource(self._source_path)
        try:
            return source.copy_tail(file)
        finally:
            source.close()

    def keep_tail_of(self, source: LasSource) -> None:
        """Copy the records behind the points of a source at the end."""
        self._source_path = source.path


class NewLasSink(LasSink):
    """A LAS or LAZ file of points from other formats: their properties become fields and extra bytes."""

    def __init__(
        self,
        destination: StrPath,
        path: Path,
        is_stream: bool,
        n_points: int,
        columns: Mapping[str, np.dtype[Any]],
        grid: Any,
        is_compressed: bool,
    ) -> None:
        if is_compressed:
            import_lazrs()
        laspy_header = make_laspy_header(columns)
        laspy_header.scales, laspy_header.offsets = grid
        file = BytesIO()
        laspy_header.write_to(file)
        header = read_las_header(file)
        header.n_points = n_points
        super().__init__(destination, path, is_stream, header, grid, is_compressed)
        self._format = laspy_header.point_format
        self._places = _place_columns(columns)
        self.head = set_count(self.head, n_points)

    def _make_records(self, block: Block, source: PointSource) -> npt.NDArray[Any]:
        laspy = import_laspy()
        points = laspy.PackedPointRecord.zeros(len(block.positions), self._format)
        for name, column in source.read_columns(block).items():
            if name not in self._places:
                continue
            target, factor = self._places[name]
            points[target] = (
                column if factor == 1 else np.rint(column * np.float64(factor)).astype(points[target].dtype)
            )
        n_returns, number = "number_of_returns", "return_number"
        names = source.attributes
        if n_returns not in names and number not in names:
            points[n_returns] = points[number] = np.ones(len(points), np.uint8)
        return points.array  # type: ignore[no-any-return]

    def _describe_records(self, records: npt.NDArray[Any]) -> dict[str, Any]:
        numbers = records.view(np.uint8).reshape(len(records), self.point_bytes)[:, _RETURN_BYTE] & _RETURN_MASK
        return {"returns": np.bincount(numbers, minlength=_RETURN_MASK + 1)[1:].tolist()}

    def finish(self, file: BinaryIO, facts: list[dict[str, Any]]) -> None:
        """Write the counts by return as well."""
        super().finish(file, facts)
        if facts:
            file.seek(_RETURNS_PLACE)
            file.write(struct.pack("<15Q", *np.sum([part["returns"] for part in facts], axis=0)))
            file.seek(0, os.SEEK_END)


_COLORS = ("red", "green", "blue")
_STANDARD = {
    "intensity": "u2",
    "gps_time": "f8",
    "classification": "u1",
    "return_number": "u1",
    "number_of_returns": "u1",
    "user_data": "u1",
    "point_source_id": "u2",
    "scan_angle": "i2",
}
_RETURN_BYTE, _RETURN_MASK = 14, 0x0F  # in points of formats 6 and 7
_RETURNS_PLACE = 255  # in a header of LAS 1.4
_ANGLES_PER_DEGREE = 1 / 0.006  # of the formats from 6 on; those before have whole degrees, called rank


def make_laspy_header(columns: Mapping[str, np.dtype[Any]]) -> Any:
    """Return laspy's header of a file of format 6, or 7 with colours, that holds columns."""
    laspy = import_laspy()
    places = _place_columns(columns)
    has_colors = any(target in _COLORS for target, _ in places.values())
    header = laspy.LasHeader(point_format=7 if has_colors else 6, version="1.4")
    known = set(header.point_format.dimension_names)
    extra = [
        laspy.ExtraBytesParams(places[name][0], dtype.newbyteorder("="))
        for name, dtype in columns.items()
        if places[name][0] not in known
    ]
    header.add_extra_dims(extra)
    return header


def _place_columns(columns: Mapping[str, np.dtype[Any]]) -> dict[str, tuple[str, float]]:
    """Return which dimension holds each column, and the factor of its numbers."""
    places: dict[str, tuple[str, float]] = {name: _place_column(name, dtype) for name, dtype in columns.items()}
    if columns.get("scan_angle_rank") == np.int8 and "scan_angle" not in columns:
        places["scan_angle_rank"] = "scan_angle", _ANGLES_PER_DEGREE
    return places


def _place_column(name: str, dtype: np.dtype[Any]) -> tuple[str, int]:
    """Return which dimension holds a column, and the factor of its numbers: colours of 8 bits become those of 16."""
    dtype = dtype.newbyteorder("=")
    if name in _COLORS and dtype.kind == "u" and dtype.itemsize <= 2:
        return name, 257 if dtype.itemsize == 1 else 1
    if name in _STANDARD and (
        dtype == np.dtype(_STANDARD[name])
        or (dtype.kind == "u" and dtype.itemsize < np.dtype(_STANDARD[name]).itemsize)
    ):
        return name, 1
    return (f"{name}_" if name in (*_COLORS, *_STANDARD) else name), 1


def set_count(head: bytes, n_points: int) -> bytes:
    """Return a head of LAS 1.4 that tells how many points there are, all first returns until they are counted."""
    changed = bytearray(head)
    changed[247:255] = n_points.to_bytes(8, "little")
    changed[255:263] = n_points.to_bytes(8, "little")
    return bytes(changed)


def grid_matrix(scales: Any, offsets: Any) -> Float64Array:
    """Return the matrix (4, 4) from integers of a grid to coordinates."""
    matrix = np.diag([*np.asarray(scales, np.float64), 1.0])
    matrix[:3, 3] = offsets
    return matrix


def _write_corner(corner: Float64Array) -> str:
    """Return coordinates without the last digits, which are noise of float64."""
    return f"[{', '.join(f'{x:.12g}' for x in corner)}]"


def round_to_grid(positions: npt.NDArray[Any]) -> Bounds:
    """Round positions in place; return their least and greatest numbers, NaN where there is one."""
    if len(positions) == 0:
        return np.zeros(3), np.zeros(3)
    np.rint(positions, out=positions)
    return find_extremes(positions)


def _view_positions(records: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the integers X, Y and Z of points as columns, in their memory: (n, 3)."""
    return np.ndarray((len(records), 3), "<i4", records.view(np.uint8).data, 0, (records.dtype.itemsize, 4))


def move_bounds(bounds: Bounds, matrix: Float64Array, project: bool) -> Bounds:
    """Return the box of a box that a matrix moves; raise MeshError if a projection has no place for parts of it."""
    low, high = bounds
    corners = np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        moved = corners @ matrix[:3, :3].T + matrix[:3, 3]
        if project:
            w = corners @ matrix[3, :3] + matrix[3, 3]
            if not ((w > 0).all() or (w < 0).all()):
                raise MeshError("w is zero within the bounds of the points, which have no place after the division")
            moved /= w[:, None]
        return moved.min(axis=0), moved.max(axis=0)


def choose_las_grid(
    bounds: Bounds, matrix: Float64Array, scales: Any, scale: Any, offset: Any, project: bool
) -> tuple[Float64Array, Float64Array]:
    """Return scales and offsets for a box that a matrix moves; see `choose_grid`."""
    low, high = move_bounds(bounds, matrix, project)
    return choose_grid(low, high, scales if scale is None else scale, scale is not None, offset)


def list_las_losses(columns: Mapping[str, np.dtype[Any]]) -> list[str]:
    """Return which columns a LAS file cannot hold: names over 32 bytes and types without a place in extra bytes."""
    return [name for name, dtype in columns.items() if len(name) > 32 or dtype.kind not in "uif" or dtype.itemsize > 8]
