"""Compressed LAS, by lazrs: chunks by their table, and parts that are compressed apart and joined.

A part of whole chunks, compressed by itself, is the same bytes as in a file that one writer makes: so parts may come
from several processes, and an unfinished file may be continued.
"""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any, BinaryIO

import numpy as np

from .._core.interrupts import defer_interrupts
from ..errors import MeshError, MissingExtraError
from .las_header import LAZ_VLR, POINT_BYTES, UNCLOSED_WORDS, LasHeader, is_padding

CHUNK_POINTS = 50_000
# Chunks that unpack to more are decompressed in pieces where they are not read whole.
MAX_CHUNK_BYTES = 32 << 20
_PIECE_BYTES = 1 << 20
_VARIABLE = 0xFFFFFFFF
_POINTS_IN_CHUNKS, _LAYERS_IN_CHUNKS = 2, 3  # kinds of compression
_FIRST_LAYERED = 6  # of the point formats
# Items of a point, each a type and a number of bytes, by point format.
_POINT10, _GPS_TIME, _RGB12, _WAVE13 = (6, 20), (7, 8), (8, 6), (9, 29)
_POINT14, _RGB14, _RGB_NIR, _WAVE14 = (10, 30), (11, 6), (12, 8), (13, 29)
_ITEMS = (
    *([_POINT10], [_POINT10, _GPS_TIME], [_POINT10, _RGB12], [_POINT10, _GPS_TIME, _RGB12]),
    *([_POINT10, _GPS_TIME, _WAVE13], [_POINT10, _GPS_TIME, _RGB12, _WAVE13]),
    *([_POINT14], [_POINT14, _RGB14], [_POINT14, _RGB_NIR], [_POINT14, _WAVE14], [_POINT14, _RGB_NIR, _WAVE14]),
)
_EXTRA_BYTES, _EXTRA_BYTES14 = 0, 14
# Layers per chunk that each begins with a size, by item; one for each extra byte.
_LAYERS = {_POINT14: 9, _RGB14: 1, _RGB_NIR: 2, _WAVE14: 1}
_WAVE_ITEM = _WAVE14[0]  # the part of a point that tells of its waveform, in formats 9 and 10
_CHANNEL_BYTE, _CHANNEL_BITS = 15, 0x30


def import_lazrs() -> Any:
    """Return lazrs; raise MissingExtraError without it."""
    try:
        with defer_interrupts():
            import lazrs
    except ImportError:
        raise MissingExtraError("LAZ needs lazrs: pip install 'gpu_xform[las]'") from None
    return lazrs


def start_threads() -> None:
    """Let lazrs start its threads, which it fails to do, or waits for for ever, once there is no memory."""
    lazrs = import_lazrs()
    record = lazrs.LazVlr.new_for_compression(0, 0).record_data()
    lazrs.decompress_points_with_chunk_table(b"", record, bytearray(), [])


class ChunkTable:
    """Where the chunks of a compressed file are.

    chunk_points : how many points each but the last holds; None where they differ
    n_behind : how many points lie behind those that the header counts, as far as the last chunk tells: formats 6 to 10
    """

    def __init__(self, file: BinaryIO, header: LasHeader) -> None:
        lazrs = import_lazrs()
        vlr = header.find_vlr(LAZ_VLR)
        if vlr is None:
            raise MeshError("the points are compressed, and no record says how")
        self.record = vlr.body
        self._n_layers = _count_layers(self.record, header)
        (chunk_points,) = struct.unpack_from("<I", self.record, 12)
        self.chunk_points = None if chunk_points == _VARIABLE else int(chunk_points)
        self._point_bytes = header.record_bytes
        counts, sizes = self._read(lazrs, file, header)
        self.starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        self.places = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64) + header.points_start + 8
        self.n_behind = self._count_behind(file)
        self._pieces: _Pieces | None = None

    @property
    def n_chunks(self) -> int:
        """How many chunks there are."""
        return len(self.starts) - 1

    def is_large(self, chunk: int) -> bool:
        """Return whether a chunk unpacks to more than is held at once where it is not read whole."""
        return int(self.starts[chunk + 1] - self.starts[chunk]) * self._point_bytes > MAX_CHUNK_BYTES

    def _read(self, lazrs: Any, file: BinaryIO, header: LasHeader) -> tuple[list[int], list[int]]:
        file.seek(header.points_start)
        place = file.read(8)
        end = struct.unpack("<q", place)[0] if len(place) == 8 else -1
        if header.n_points == 0:
            _require_nothing(file, header, end)
            return [], []
        if end == -1 and header.file_bytes >= 8:  # a writer that could not seek puts it last
            file.seek(header.file_bytes - 8)
            (end,) = struct.unpack("<q", file.read(8))
        if header.points_start + 8 <= header.file_bytes - 8 < end < 1 << 48:  # larger ones are no places
            raise MeshError(
                f"the file is cut off: it has {header.file_bytes:,} bytes, its table of chunks is at byte {end:,}"
            )
        if not header.points_start + 8 <= end <= header.file_bytes - 8:
            raise MeshError(f"the table of chunks is said to be at byte {end:,} of {header.file_bytes:,}")
        file.seek(end)
        _, n_chunks = struct.unpack("<II", file.read(8))
        if n_chunks > header.file_bytes:
            raise MeshError(f"the table tells of {n_chunks:,} chunks, more than the file has bytes")
        file.seek(end)
        try:
            table = call_lazrs(lazrs.read_chunk_table_only, file, call_lazrs(lazrs.LazVlr, self.record))
        except LazError as error:
            raise MeshError(f"the table of chunks cannot be read: {error}") from None
        counts, sizes = [count for count, _ in table], [size for _, size in table]
        if self.chunk_points is not None:  # then the table has no counts
            counts = [self.chunk_points] * len(table)
            counts[-1:] = [header.n_points - sum(counts[:-1])]
            is_true = len(table) > 0 and 0 < counts[-1] <= self.chunk_points
        else:
            is_true = sum(counts) == header.n_points
        if not is_true:
            raise MeshError(f"the header says {header.n_points:,} points, the table of {len(table):,} chunks does not")
        if header.points_start + 8 + sum(sizes) > end:
            raise MeshError("the table of chunks tells of more bytes than there are")
        return counts, sizes

    def _count_behind(self, file: BinaryIO) -> int:
        """Return how many points the last chunk holds beyond the header's count, if its layers say how many it has."""
        if self._n_layers == 0 or self.chunk_points is None or len(self.starts) < 2:
            return 0
        file.seek(int(self.places[-2]) + self._point_bytes)  # behind its first point
        data = file.read(4)
        held = int.from_bytes(data, "little") if len(data) == 4 else 0
        return max(held - int(self.starts[-1] - self.starts[-2]), 0) if held <= self.chunk_points else 0

    def span(self, start: int, stop: int) -> tuple[int, int]:
        """Return the first chunk and the one behind the last that hold points `start` up to `stop`."""
        first = int(np.searchsorted(self.starts, start, "right")) - 1
        return first, int(np.searchsorted(self.starts, stop, "left"))

    def read_points(self, file: BinaryIO, start: int, stop: int) -> memoryview:
        """Return the bytes of points `start` up to `stop`; raise LazError with the chunk that does not decompress.

        Large chunks are quick to read in the order of their points, each behind the last.
        """
        first, last = self.span(start, stop)
        if any(map(self.is_large, range(first, last))):
            return self._read_pieces(file, start, stop)
        try:
            points = self.decompress(file, first, last)
        except LazError:
            for chunk in range(first, last):
                with _name_chunk(chunk):
                    self.decompress(file, chunk, chunk + 1)
            raise
        skipped = (start - int(self.starts[first])) * self._point_bytes
        return memoryview(points)[skipped:][: (stop - start) * self._point_bytes]

    def _read_pieces(self, file: BinaryIO, start: int, stop: int) -> memoryview:
        points = memoryview(bytearray((stop - start) * self._point_bytes))
        place = start
        for chunk in range(*self.span(start, stop)):
            begin, end = int(self.starts[chunk]), min(int(self.starts[chunk + 1]), stop)
            pieces, self._pieces = self._pieces, None  # none to go on with if it fails
            with _name_chunk(chunk):
                if pieces is None or pieces.chunk != chunk or pieces.place > place - begin:
                    n_points, data = int(self.starts[chunk + 1]) - begin, self._read_chunks(file, chunk, chunk + 1)
                    pieces = _Pieces(chunk, self.record, n_points, data, self._point_bytes)
                pieces.skip_to(place - begin)
                pieces.read_into(points[(place - start) * self._point_bytes : (end - start) * self._point_bytes])
            self._pieces, place = pieces, end
        return points

    def decompress(self, file: BinaryIO, first: int, last: int) -> bytearray:
        """Return the points of chunks `first` up to `last`; raise LazError."""
        lazrs = import_lazrs()
        counts = np.diff(self.starts[first : last + 1]).tolist()
        data = self._read_chunks(file, first, last)
        points = bytearray(sum(counts) * self._point_bytes)
        sizes = np.diff(self.places[first : last + 1]).tolist()
        call_lazrs(
            *(lazrs.decompress_points_with_chunk_table, data, self.record, points),
            list(zip(counts, sizes, strict=True)),
        )
        return points

    def _read_chunks(self, file: BinaryIO, first: int, last: int) -> bytes:
        """Return chunks as they are; raise LazError for those that lazrs would take too much memory for."""
        sizes = np.diff(self.places[first : last + 1]).tolist()
        data = self.read_raw(file, first, last)
        if len(data) != sum(sizes):
            raise LazError("the file ends within it")
        self._require_layers(data, sizes)
        return data

    def _require_layers(self, data: bytes, sizes: list[int]) -> None:
        """Raise LazError if layers of a chunk are said to be larger than it: lazrs would take memory for them."""
        if self._n_layers == 0:
            return
        start, head = 0, self._point_bytes + 4
        for size in sizes:
            end = start + head + 4 * self._n_layers
            layers = struct.unpack_from(f"<{self._n_layers}I", data, start + head) if end <= start + size else (size,)
            if head + sum(layers) > size:
                raise LazError(f"its layers of {sum(layers):,} bytes do not fit into its {size:,}")
            start += size

    def read_raw(self, file: BinaryIO, first: int, last: int) -> bytes:
        """Return chunks `first` up to `last` as they are."""
        file.seek(int(self.places[first]))
        return file.read(int(self.places[last] - self.places[first]))


class _Pieces:
    """A chunk that is decompressed piece by piece; `place` is the point that comes next."""

    def __init__(self, chunk: int, record: bytes, n_points: int, data: bytes, point_bytes: int) -> None:
        lazrs = import_lazrs()
        self.chunk, self.place, self._point_bytes = chunk, 0, point_bytes
        table = BytesIO()
        call_lazrs(lazrs.write_chunk_table, table, [(n_points, len(data))], call_lazrs(lazrs.LazVlr, record))
        file = BytesIO(b"".join([struct.pack("<q", 8 + len(data)), data, table.getbuffer()]))
        self._decompressor = call_lazrs(lazrs.LasZipDecompressor, file, record)

    def skip_to(self, place: int) -> None:
        """Decompress the points before a place, and forget them."""
        while self.place < place:
            n = min(place - self.place, max(_PIECE_BYTES // self._point_bytes, 1))
            self.read_into(memoryview(bytearray(n * self._point_bytes)))

    def read_into(self, points: memoryview) -> None:
        """Decompress the points that come next."""
        call_lazrs(self._decompressor.decompress_many, points)
        self.place += len(points) // self._point_bytes


def _count_layers(record: bytes, header: LasHeader) -> int:
    """Return how many layers that have a size each chunk has, 0 for points that are compressed one after the other.

    Raises MeshError for a record that is not about points as the header tells of: lazrs would take what it finds for
    sizes, and gigabytes of memory for them.
    """
    size = len(record)
    kind = struct.unpack_from("<H", record)[0] if size >= 2 else None
    if kind not in (_POINTS_IN_CHUNKS, _LAYERS_IN_CHUNKS, None):
        raise MeshError("the points are compressed in one piece, not in chunks, as LASzip 1 did: lazrs lacks it")
    if size < 34 or size < 34 + 6 * struct.unpack_from("<H", record, 32)[0]:
        raise MeshError("the record about compression is too short")
    items = [struct.unpack_from("<HH", record, 34 + 6 * i) for i in range(struct.unpack_from("<H", record, 32)[0])]
    n_bytes = sum(n for _, n in items)
    if n_bytes != header.record_bytes:
        raise MeshError(f"compressed points take {n_bytes} bytes, the header says {header.record_bytes}")
    is_layered = header.point_format >= _FIRST_LAYERED
    extra = header.record_bytes - POINT_BYTES[header.point_format]
    known = [
        *_ITEMS[header.point_format],
        *([(_EXTRA_BYTES14 if is_layered else _EXTRA_BYTES, extra)] if extra else []),
    ]
    if items != known or kind != (_LAYERS_IN_CHUNKS if is_layered else _POINTS_IN_CHUNKS):
        found = ", ".join(f"{n} bytes of type {number}" for number, n in items)
        raise MeshError(f"compressed points are not those of format {header.point_format}: kind {kind}, {found}")
    return extra + sum(_LAYERS[item] for item in _ITEMS[header.point_format]) if is_layered else 0


def _require_nothing(file: BinaryIO, header: LasHeader, table_place: int) -> None:
    """Raise MeshError if points lie in a file whose header counts none."""
    start = header.points_start + 8
    end = table_place if start <= table_place <= header.tail_start else header.tail_start
    if end - start >= header.record_bytes and not is_padding(file, start, header.record_bytes):
        raise MeshError(
            f"the header counts 0 points, and {end - start:,} bytes of compressed points are there: {UNCLOSED_WORDS}"
        )


class LazError(Exception):
    """What lazrs does not take; `chunk` is the number of the chunk that it is about, if that is known."""

    chunk: int | None = None


@contextmanager
def _name_chunk(chunk: int) -> Iterator[None]:
    """Let an error of the block know which chunk it is about."""
    try:
        yield
    except LazError as error:
        error.chunk = chunk
        raise


def call_lazrs(function: Any, *arguments: Any) -> Any:
    """Call a function of lazrs; raise LazError where it fails, also where it panics, which is no `Exception`."""
    try:
        return function(*arguments)
    except (KeyboardInterrupt, SystemExit, MemoryError):
        raise
    except BaseException as error:
        if isinstance(error, Exception) or type(error).__name__ == "PanicException":
            raise LazError(str(error)) from None
        raise


def make_laz_record(header: LasHeader) -> bytes:
    """Return the body of the record that tells how points of a header will be compressed."""
    lazrs = import_lazrs()
    n_extra = header.record_bytes - POINT_BYTES[header.point_format]
    return bytes(lazrs.LazVlr.new_for_compression(header.point_format, n_extra).record_data())


def compress(record: bytes, points: Any) -> tuple[bytes, list[tuple[int, int]]]:
    """Return a part of whole chunks, compressed, and its lines of the table of chunks.

    Raises LazError where lazrs loses something: of waveforms whose scanner changes.
    """
    lazrs = import_lazrs()
    vlr = lazrs.LazVlr(record)
    out = BytesIO()
    compressor = lazrs.ParLasZipCompressor(out, vlr)
    compressor.compress_many(np.frombuffer(points, np.uint8))
    compressor.done()
    whole = out.getbuffer()
    (end,) = struct.unpack_from("<q", whole)
    out.seek(end)
    table = lazrs.read_chunk_table_only(out, vlr)
    n_points = len(points) // vlr.item_size()
    counts = [min(CHUNK_POINTS, n_points - start) for start in range(0, n_points, CHUNK_POINTS)]
    lines = [(count, int(size)) for count, (_, size) in zip(counts, table, strict=True)]
    body = bytes(whole[8:end])
    if _changes_scanner(vlr, points):
        back = bytearray(len(points))
        call_lazrs(lazrs.decompress_points_with_chunk_table, body, record, back, lines)
        if back != points:
            raise LazError("lazrs loses the waveform fields of points whose scanner channel changes")
    return body, lines


def _changes_scanner(vlr: Any, points: Any) -> bool:
    """Return whether points have waveforms, of formats 9 and 10, and several scanners: lazrs 0.8 mistakes contexts."""
    record = vlr.record_data()
    kinds = {struct.unpack_from("<H", record, place)[0] for place in range(34, len(record) - 5, 6)}
    if _WAVE_ITEM not in kinds:
        return False
    channels = np.frombuffer(points, np.uint8).reshape(-1, vlr.item_size())[:, _CHANNEL_BYTE] & _CHANNEL_BITS
    return bool((channels != channels[:1]).any())


def write_table(file: BinaryIO, record: bytes, points_start: int, table: list[tuple[int, int]]) -> None:
    """Write the table of chunks at the end of a file, and its place before the points."""
    lazrs = import_lazrs()
    end = file.tell()
    buffer = BytesIO()
    lazrs.write_chunk_table(buffer, table, lazrs.LazVlr(record))
    file.write(buffer.getbuffer())
    file.seek(points_start)
    file.write(struct.pack("<q", end))
    file.seek(0, 2)
