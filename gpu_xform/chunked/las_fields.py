"""The fields of a LAS point that a transform changes, and extra bytes."""

import struct
from typing import Any

import numpy as np

from ..formats.las import find_normal
from ..formats.las_header import EXTRA_BYTES_VLR, POINT_BYTES, WAVE_PACKET_OFFSETS, LasHeader
from .protocol import Directions

_EXTRA_TYPES = {1: "u1", 2: "i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<u8", 8: "<i8", 9: "<f4", 10: "<f8"}
_EXTRA_RECORD_BYTES = 192
_WAVE_VECTOR_OFFSET = 17
_WAVE_VECTOR = ("wave x", "wave y", "wave z")
_FLOATS = ("<f4", "<f8")


def describe_record(header: LasHeader) -> tuple[np.dtype[Any], list[Directions]]:
    """Return the type of a whole point, with the fields alone that a transform may change, and its directions."""
    fields: dict[str, tuple[str, int]] = {"X": ("<i4", 0), "Y": ("<i4", 4), "Z": ("<i4", 8)}
    directions = []
    packet = WAVE_PACKET_OFFSETS.get(header.point_format)
    if packet is not None:
        for i, name in enumerate(_WAVE_VECTOR):
            fields[name] = ("<f4", packet + _WAVE_VECTOR_OFFSET + 4 * i)
        directions.append(Directions(_WAVE_VECTOR, False))
    extra = list_extra_fields(header)
    normal = find_normal([name for name, (kind, _) in extra.items() if kind in _FLOATS])
    if normal is not None:
        fields |= {name: extra[name] for name in normal}
        directions.append(Directions(normal, True))
    names = list(fields)
    dtype = np.dtype(
        {
            "names": names,
            "formats": [fields[name][0] for name in names],
            "offsets": [fields[name][1] for name in names],
            "itemsize": header.record_bytes,
        }
    )
    return dtype, directions


def list_fixed_normals(header: LasHeader) -> tuple[str, ...]:
    """Return the names of normals that are stored as integers, which nothing turns."""
    extra = list_extra_fields(header)
    names = find_normal(extra) or ()
    return () if all(extra[name][0] in _FLOATS for name in names) else names


def list_extra_fields(header: LasHeader) -> dict[str, tuple[str, int]]:
    """Return type and offset in a point of each described number of the extra bytes; those of a vector get letters."""
    vlr = header.find_vlr(EXTRA_BYTES_VLR)
    start, found = POINT_BYTES[header.point_format], {}
    body = vlr.body if vlr is not None else b""
    for at in range(0, len(body) - _EXTRA_RECORD_BYTES + 1, _EXTRA_RECORD_BYTES):
        kind, options, name = struct.unpack_from("<BB32s", body, at + 2)
        if kind == 0:
            start += options
            continue
        n_columns, scalar = 1 + (kind - 1) // 10, _EXTRA_TYPES[1 + (kind - 1) % 10]
        if n_columns > 3:
            break
        text, size = name.partition(b"\0")[0].decode("latin-1"), np.dtype(scalar).itemsize
        for i in range(n_columns):
            found[text if n_columns == 1 else f"{text} {'xyz'[i]}"] = (scalar, start + i * size)
        start += n_columns * size
    return {
        name: (kind, at) for name, (kind, at) in found.items() if at + np.dtype(kind).itemsize <= header.record_bytes
    }
