"""What a file of chunked points holds, as JSON has it: of LAS by its header and records, of Zarr by its metadata."""

import contextlib
import datetime
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np

from .._core.types import StrPath
from ..errors import ArgumentError, MeshError
from ..formats._warn import warn
from ..formats.las import import_laspy, warn_of_points_behind
from ..formats.las_header import COPC_USER, CRS_USER, EVLR_BYTES, LasHeader, read_las_header
from ..formats.laz import ChunkTable
from .las import read_laspy_header
from .las_crs import name_crs
from .protocol import Bounds
from .zarr import ZarrSource, read_attributes

MAX_COUNTED_POINTS = 1 << 27  # of an array, whose bounds no header tells: a second or two
_SYSTEM, _SOFTWARE, _DAY, _LEGACY_RETURNS, _RETURNS = 26, 58, 90, 111, 255
_DESCRIPTION = 22  # of a record, behind its length, 16 bits before the points and 64 behind them


def summarize(path: StrPath, file_type: str) -> dict[str, Any]:
    """Return what a file of type "las", "laz" or "zarr" holds."""
    return summarize_zarr(path) if file_type == "zarr" else summarize_las(path)


def summarize_las(path: StrPath) -> dict[str, Any]:
    """Return what the header and the records of a LAS, LAZ or COPC file say; no point is read."""
    with Path(path).open("rb") as file:
        try:
            header = read_las_header(file)
        except MeshError as error:
            raise MeshError(f"{path}: {error}") from None
        systems = {vlr.number: vlr.body for vlr in header.vlrs if vlr.user == CRS_USER}
        records_behind = []
        for user, number, place, length in header.evlrs:
            file.seek(place)
            records_behind.append(_describe_record(user, number, file.read(EVLR_BYTES), length - EVLR_BYTES))
            if user == CRS_USER:
                systems[number] = file.read(length - EVLR_BYTES)
        chunk_points: int | str | None = None
        table = None
        if header.is_compressed:
            try:
                table = ChunkTable(file, header)
                chunk_points = table.chunk_points or "varies"
            except MeshError as error:
                warn(f"{path}: {error}")
        warn_of_points_behind(header, table, str(path))
    is_copc = header.find_vlr((COPC_USER, 1)) is not None
    return {
        "points": header.n_points,
        "bounds": _as_corners((header.low, header.high)) if header.has_bounds else None,
        "version": f"1.{header.version}",
        "point_format": header.point_format,
        "point_bytes": header.record_bytes,
        "compression": ("COPC" if is_copc else "LAZ") if header.is_compressed else None,
        "chunk_points": chunk_points,
        "scale": header.scales.tolist(),
        "offset": header.offsets.tolist(),
        "crs": name_crs(systems),
        "returns": _count_returns(header),
        "dimensions": _list_dimensions(path, header.point_format),
        "vlrs": [_describe_record(vlr.user, vlr.number, vlr.data, len(vlr.body)) for vlr in header.vlrs],
        "evlrs": records_behind,
        "waveforms": bool(header.waveform_start),
        **_describe_origin(header),
    }


def _list_dimensions(path: StrPath, number: int) -> dict[str, str]:
    """Return the type of each dimension, such as "3 bits" or "uint16"."""
    try:
        point_format = read_laspy_header(path).point_format
    except MeshError as error:
        warn(str(error))
        point_format = import_laspy().PointFormat(number)
    return {each.name: _name_type(each) for each in point_format.dimensions}


def _name_type(dimension: Any) -> str:
    if dimension.dtype is None:
        return f"{dimension.num_bits} bit{'s' if dimension.num_bits > 1 else ''}"
    dtype = np.dtype(dimension.dtype)
    return " x ".join([*map(str, dtype.shape), dtype.base.name])


def _describe_record(user: str, number: int, head: bytes, length: int) -> dict[str, Any]:
    start = _DESCRIPTION if len(head) != EVLR_BYTES else _DESCRIPTION + 6
    return {"user": user, "id": number, "description": _as_text(head[start : start + 32]), "bytes": length}


def _as_text(field: bytes) -> str:
    return field.partition(b"\0")[0].decode("latin-1").strip()


def _count_returns(header: LasHeader) -> list[int]:
    """Return how many points are first returns, second ones and so on, up to the last that there are."""
    is_new = header.version >= 4
    counts = struct.unpack_from("<15Q" if is_new else "<5I", header.head, _RETURNS if is_new else _LEGACY_RETURNS)
    return list(counts[: max((i + 1 for i, count in enumerate(counts) if count), default=0)])


def _describe_origin(header: LasHeader) -> dict[str, Any]:
    """Return what made the file and when, as far as the header says."""
    day, year = struct.unpack_from("<HH", header.head, _DAY)
    created = None
    if year and day:
        with contextlib.suppress(ValueError, OverflowError):
            created = (datetime.date(year, 1, 1) + datetime.timedelta(days=day - 1)).isoformat()
    system, software = (_as_text(bytes(header.head[at : at + 32])) for at in (_SYSTEM, _SOFTWARE))
    return {"system": system or None, "software": software or None, "created": created}


def summarize_zarr(path: StrPath) -> dict[str, Any]:
    """Return shape, type, layout and bounds of a Zarr array; the points of a large one are not read for its bounds."""
    source = ZarrSource(path)
    array = source.array
    bounds = None
    if source.n_points == 0:
        pass
    elif source.n_points > MAX_COUNTED_POINTS:
        warn(f"{path}: bounds are not counted for more than {MAX_COUNTED_POINTS:,} points")
    else:
        try:
            bounds = source.read_bounds()
        except ArgumentError as error:  # a chunk that cannot be read
            warn(str(error))
        else:
            if not all(np.isfinite(corner).all() for corner in bounds):
                warn(f"{path}: some coordinates are not finite")
    return {
        "points": source.n_points,
        "bounds": None if bounds is None else _as_corners(bounds),
        "columns": source.n_columns,
        "dtype": source.dtype.name,
        "format": array.metadata.zarr_format,
        "chunks": list(array.chunks),
        "shards": None if array.shards is None else list(array.shards),
        "compressors": [type(codec).__name__ for codec in array.compressors],
        "attributes": sorted(map(str, read_attributes(array))),
    }


def _as_corners(bounds: Bounds) -> list[list[float | None]]:
    """Return both corners; None for a number that JSON cannot hold."""
    return [[float(x) if math.isfinite(x) else None for x in corner] for corner in bounds]
