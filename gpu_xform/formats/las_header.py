"""Headers of LAS 1.0 to 1.4: read, checked, and changed byte by byte, so that all that is not meant to change stays.

Source: ASPRS, "LAS Specification 1.4 - R15".
"""

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from .._core.types import Float64Array
from ..errors import MeshError

HEADER_BYTES = {0: 227, 1: 227, 2: 227, 3: 235, 4: 375}
POINT_BYTES = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)
WAVE_PACKET_OFFSETS = {4: 28, 5: 34, 9: 30, 10: 38}
_VLR_BYTES, EVLR_BYTES = 54, 60

# Offsets of fields in a header.
_MINOR_VERSION, _HEADER_SIZE, _POINTS_START, _N_VLRS, _POINT_FORMAT, _RECORD_BYTES = 25, 94, 96, 100, 104, 105
_LEGACY_COUNT, _SCALES, _OFFSETS, _BOUNDS, _WAVEFORM_START, _EVLRS_START, _N_EVLRS, _COUNT = (
    *(107, 131, 155, 179, 227, 235),
    *(243, 247),
)
_COMPRESSED = 0xC0

LAZ_VLR = ("laszip encoded", 22204)
COPC_USER = "copc"
EXTRA_BYTES_VLR = ("LASF_Spec", 4)
CRS_USER = "LASF_Projection"
UNCLOSED_WORDS = "what wrote the file did not close it; lasinfo -repair of LAStools counts again"


class Vlr(NamedTuple):
    """A variable-length record: whose it is, and all its bytes with its own header."""

    user: str
    number: int
    data: bytes
    header_bytes: int

    @property
    def body(self) -> bytes:
        """The bytes behind its header."""
        return self.data[self.header_bytes :]


@dataclass
class LasHeader:
    """What a header says; `head` are the bytes up to the first point."""

    head: bytearray
    version: int
    point_format: int
    is_compressed: bool
    record_bytes: int
    n_points: int
    scales: Float64Array
    offsets: Float64Array
    low: Float64Array
    high: Float64Array
    vlrs: list[Vlr]
    padding: bytes
    points_start: int
    file_bytes: int
    evlrs: list[tuple[str, int, int, int]] = field(default_factory=list)
    """User, number, place and length with its header of each."""
    waveform_start: int = 0
    n_behind: int = 0
    """How many whole records lie behind those that it counts, in a file that is not compressed."""

    def find_vlr(self, key: tuple[str, int]) -> Vlr | None:
        """Return the record of a user and a number."""
        return next((vlr for vlr in self.vlrs if (vlr.user, vlr.number) == key), None)

    @property
    def has_bounds(self) -> bool:
        """Whether its bounds can be those of points; some writers leave them at zero, or at the limits of doubles."""
        is_box = bool(np.isfinite([self.low, self.high]).all() and (self.low <= self.high).all())
        return is_box and (bool(np.any([self.low, self.high])) or self.n_points == 0)

    @property
    def has_crs(self) -> bool:
        """Whether it names a coordinate system."""
        return any(vlr.user == CRS_USER for vlr in self.vlrs) or any(user == CRS_USER for user, *_ in self.evlrs)

    @property
    def tail_start(self) -> int:
        """Where the first record behind the points begins; the end of the file if there is none."""
        starts = [start for _, _, start, _ in self.evlrs]
        if self.waveform_start:
            starts.append(self.waveform_start)
        return min(starts, default=self.file_bytes)


def read_las_header(file: BinaryIO) -> LasHeader:
    """Return the header of a LAS or LAZ file; raise MeshError for one that cannot be true."""
    file.seek(0, 2)
    size = file.tell()
    file.seek(0)
    fixed = file.read(HEADER_BYTES[4])
    if fixed[:4] != b"LASF":
        raise MeshError("not a LAS file: it does not begin with LASF")
    if len(fixed) < HEADER_BYTES[0]:
        raise MeshError(f"the file is cut off: it ends after {size} bytes, within the header")
    major, minor = fixed[24], fixed[_MINOR_VERSION]
    if major != 1 or minor not in HEADER_BYTES:
        raise MeshError(f"LAS version {major}.{minor} is not known: 1.0 to 1.4 are")
    header_size, points_start, n_vlrs, packed, record_bytes, count = struct.unpack_from("<HIIBHI", fixed, _HEADER_SIZE)
    point_format = packed & ~_COMPRESSED
    if point_format >= len(POINT_BYTES):
        raise MeshError(f"point format {point_format} is not known: 0 to {len(POINT_BYTES) - 1} are")
    if record_bytes < POINT_BYTES[point_format]:
        raise MeshError(
            f"a point of format {point_format} takes {POINT_BYTES[point_format]} bytes, the header says {record_bytes}"
        )
    if header_size < HEADER_BYTES[minor]:
        raise MeshError(f"a header of LAS 1.{minor} takes {HEADER_BYTES[minor]} bytes, it says {header_size}")
    if not header_size <= points_start <= size:
        raise MeshError(f"the header says that points begin at byte {points_start:,} of {size:,}")
    waveform_start = evlrs_start = n_evlrs = 0
    if minor >= 3:
        (waveform_start,) = struct.unpack_from("<Q", fixed, _WAVEFORM_START)
    if minor >= 4:
        evlrs_start, n_evlrs, count = struct.unpack_from("<QIQ", fixed, _EVLRS_START)
    numbers = np.array(struct.unpack_from("<12d", fixed, _SCALES))
    scales, offsets, high, low = numbers[:3], numbers[3:6], numbers[6::2].copy(), numbers[7::2].copy()
    if not (np.isfinite(numbers[:6]).all() and (scales > 0).all()):
        raise MeshError(f"scales must be positive and offsets finite, got {scales}, {offsets}")
    file.seek(0)
    head = bytearray(file.read(points_start))
    vlrs, end = _read_vlrs(head, header_size, n_vlrs)
    header = LasHeader(
        head=head,
        version=minor,
        point_format=point_format,
        is_compressed=bool(packed & _COMPRESSED),
        record_bytes=record_bytes,
        n_points=count,
        scales=scales,
        offsets=offsets,
        low=low,
        high=high,
        vlrs=vlrs,
        padding=bytes(head[end:]),
        points_start=points_start,
        file_bytes=size,
    )
    if minor >= 4 and n_evlrs:
        header.evlrs = list(_list_evlrs(file, evlrs_start, n_evlrs, points_start, size))
    if waveform_start and not points_start <= waveform_start <= size:
        raise MeshError(f"the header says that waveforms begin at byte {waveform_start:,} of {size:,}")
    header.waveform_start = waveform_start
    if not header.is_compressed and points_start + count * record_bytes > header.tail_start:
        held = max(header.tail_start - points_start, 0) // record_bytes
        raise MeshError(f"the header says {count:,} points of {record_bytes} bytes, there is room for {held:,}")
    if not header.is_compressed and not is_padding(file, points_start + count * record_bytes, record_bytes):
        header.n_behind = (header.tail_start - points_start) // record_bytes - count
    return header


def require_points_counted(header: LasHeader) -> None:
    """Raise MeshError if a header counts no points, and there are some: an empty result would hide them."""
    if header.n_points == 0 and header.n_behind:
        raise MeshError(f"the header counts 0 points, and there are {header.n_behind:,} records: {UNCLOSED_WORDS}")


def is_padding(file: BinaryIO, place: int, n_bytes: int) -> bool:
    """Return whether nothing but zeros is at a place, as in space that was only reserved, or too little is there."""
    file.seek(place)
    data = file.read(n_bytes)
    return len(data) < n_bytes or not any(data)


def _read_vlrs(head: bytearray, start: int, count: int) -> tuple[list[Vlr], int]:
    vlrs = []
    for i in range(count):
        if start + _VLR_BYTES > len(head):
            raise MeshError(f"record {i} of {count} before the points does not fit there")
        user, number, length = struct.unpack_from("<16sHH", head, start + 2)
        end = start + _VLR_BYTES + length
        if end > len(head):
            raise MeshError(f"record {i} of {count} before the points does not fit there: {length:,} bytes")
        vlrs.append(Vlr(_as_text(user), number, bytes(head[start:end]), _VLR_BYTES))
        start = end
    return vlrs, start


def _list_evlrs(file: BinaryIO, start: int, count: int, first: int, size: int) -> Iterator[tuple[str, int, int, int]]:
    for i in range(count):
        if not first <= start <= size - EVLR_BYTES:
            raise MeshError(f"record {i} of {count} behind the points begins at byte {start:,} of {size:,}")
        file.seek(start)
        user, number, length = struct.unpack_from("<16sHQ", file.read(EVLR_BYTES), 2)
        if start + EVLR_BYTES + length > size:
            raise MeshError(f"record {i} of {count} behind the points takes {length:,} bytes, more than the file has")
        yield _as_text(user), number, start, EVLR_BYTES + length
        start += EVLR_BYTES + length


def _as_text(field: bytes) -> str:
    return field.partition(b"\0")[0].decode("latin-1")


def make_laz_vlr(record_data: bytes) -> Vlr:
    """Return the record that tells how points are compressed."""
    user, number = LAZ_VLR
    head = struct.pack("<H16sHH32s", 0, user.encode(), number, len(record_data), b"by gpu_xform")
    return Vlr(user, number, head + record_data, _VLR_BYTES)


def build_head(header: LasHeader, scales: Any, offsets: Any, laz_record: bytes | None) -> bytes:
    """Return the bytes before the points of a file with other scales and offsets, compressed or not.

    What tells of a compression and of an index of the source is left out; bounds and places of later records are
    those of the source until `patch_head` sets them.
    """
    kept = [vlr for vlr in header.vlrs if (vlr.user, vlr.number) != LAZ_VLR and vlr.user != COPC_USER]
    if laz_record is not None:
        kept.append(make_laz_vlr(laz_record))
    (header_size,) = struct.unpack_from("<H", header.head, _HEADER_SIZE)
    fixed = header.head[:header_size]
    start = header_size + sum(len(vlr.data) for vlr in kept) + len(header.padding)
    compressed = 0x80 if laz_record is not None else 0
    struct.pack_into("<IIB", fixed, _POINTS_START, start, len(kept), header.point_format | compressed)
    struct.pack_into("<6d", fixed, _SCALES, *scales, *offsets)
    return bytes(fixed) + b"".join(vlr.data for vlr in kept) + header.padding


def patch_head(
    header: LasHeader, file: BinaryIO, low: Any, high: Any, shift: int, evlrs: tuple[int, int] | None
) -> None:
    """Write bounds and the places of records behind the points into the head of a file.

    shift : by how many bytes the records behind the points have moved
    evlrs : where the first of them is now, and how many there are
    """
    file.seek(_BOUNDS)
    file.write(struct.pack("<6d", *np.stack([high, low], axis=1).ravel()))
    if header.version >= 3 and header.waveform_start:
        file.seek(_WAVEFORM_START)
        file.write(struct.pack("<Q", header.waveform_start + shift))
    if header.version >= 4 and evlrs is not None:
        file.seek(_EVLRS_START)
        file.write(struct.pack("<QI", *evlrs))


def choose_grid(
    low: Float64Array, high: Float64Array, scales: Any, fixed_scale: bool, offset: Any
) -> tuple[Float64Array, Float64Array]:
    """Return scales and offsets that hold a box: the offset at its centre, the scale ten times wider until it fits.

    fixed_scale : raise MeshError instead of another scale
    """
    scales = np.array(scales, np.float64)
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise MeshError("the matrix moves the points beyond the largest numbers")
    centre = low / 2 + high / 2
    with np.errstate(over="ignore"):  # of a scale such as 1e-310
        steps = np.round(centre / scales)
    near = np.where(np.isfinite(steps), steps * scales, centre)
    offsets = near if offset is None else np.array(offset, np.float64)
    reach = np.maximum(np.abs(low - offsets), np.abs(high - offsets))
    for axis in range(3):
        while reach[axis] / _MAX_CELL > scales[axis]:
            if fixed_scale:
                raise MeshError(
                    f"a scale of {scales[axis]:g} cannot hold coordinates {reach[axis]:g} from the offset: 32-bit "
                    f"integers need at least {reach[axis] / _MAX_CELL:.3g}"
                )
            scales[axis] = float(f"{float(scales[axis]) * 10:.12g}")
            if not math.isfinite(scales[axis]):
                raise MeshError("the matrix moves the points beyond the largest numbers")
    return scales, offsets


_MAX_CELL = 2**31 - 2  # one cell less than int32 holds, for what the folded matrix rounds
