"""Compressed LAS, by lazrs: chunks by their table, and parts that are compressed apart and joined.

A part of whole chunks, compressed by itself, is the same bytes as in a file that one writer makes: so parts may come
from several processes, and an unfinished file may be continued.
"""

import struct
from io import BytesIO
from typing import Any, BinaryIO

import numpy as np

from ..errors import MeshError, MissingExtraError
from .las_header import LAZ_VLR, POINT_BYTES, UNCLOSED_WORDS, LasHeader, is_padding

CHUNK_POINTS = 50_000
_VARIABLE = 0xFFFFFFFF
_CHUNKED = (2, 3)  # kinds of compression: points in chunks, layers in chunks
# Layers per chunk that each begins with a size, by point format; one more for each extra byte.
_LAYERS = {6: 9, 7: 10, 8: 11, 9: 10, 10: 12}
_WAVE_ITEM = 13  # the part of a point that tells of its waveform, in formats 9 and 10
_CHANNEL_BYTE, _CHANNEL_BITS = 15, 0x30


def import_lazrs() -> Any:
    """Return lazrs; raise MissingExtraError without it."""
    try:
        import lazrs
    except ImportError:
        raise MissingExtraError("LAZ needs lazrs: pip install 'gpu_xform[las]'") from None
    return lazrs


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
        size = len(self.record)
        if size >= 2 and struct.unpack_from("<H", self.record)[0] not in _CHUNKED:
            raise MeshError("the points are compressed in one piece, not in chunks, as LASzip 1 did: lazrs lacks it")
        if size < 34 or size < 34 + 6 * struct.unpack_from("<H", self.record, 32)[0]:
            raise MeshError("the record about compression is too short")
        item_bytes = sum(struct.unpack_from("<H", self.record, 36 + 6 * i)[0] for i in range((size - 34) // 6))
        if item_bytes != header.record_bytes:
            raise MeshError(f"compressed points take {item_bytes} bytes, the header says {header.record_bytes}")
        (chunk_points,) = struct.unpack_from("<I", self.record, 12)
        self.chunk_points = None if chunk_points == _VARIABLE else int(chunk_points)
        n_extra = header.record_bytes - POINT_BYTES[header.point_format]
        self._point_bytes = header.record_bytes
        self._n_layers = _LAYERS[header.point_format] + n_extra if header.point_format in _LAYERS else 0
        counts, sizes = self._read(lazrs, file, header)
        self.starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        self.places = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64) + header.points_start + 8
        self.n_behind = self._count_behind(file)

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

    def decompress(self, file: BinaryIO, first: int, last: int, record_bytes: int) -> bytearray:
        """Return the points of chunks `first` up to `last`; raise LazError."""
        lazrs = import_lazrs()
        counts = np.diff(self.starts[first : last + 1]).tolist()
        sizes = np.diff(self.places[first : last + 1]).tolist()
        points = bytearray(sum(counts) * record_bytes)
        data = self.read_raw(file, first, last)
        if len(data) != sum(sizes):
            raise LazError("the file ends within it")
        self._require_layers(data, sizes)
        call_lazrs(
            *(lazrs.decompress_points_with_chunk_table, data, self.record, points),
            list(zip(counts, sizes, strict=True)),
        )
        return points

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


def _require_nothing(file: BinaryIO, header: LasHeader, table_place: int) -> None:
    """Raise MeshError if points lie in a file whose header counts none."""
    start = header.points_start + 8
    end = table_place if start <= table_place <= header.tail_start else header.tail_start
    if end - start >= header.record_bytes and not is_padding(file, start, header.record_bytes):
        raise MeshError(
            f"the header counts 0 points, and {end - start:,} bytes of compressed points are there: {UNCLOSED_WORDS}"
        )


class LazError(Exception):
    """What lazrs does not take."""


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
