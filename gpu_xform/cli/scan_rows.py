"""What `gpu-xform info` says of scans: rows of a name and a text, from what `chunked.summary` has found."""

from collections.abc import Mapping, Sequence
from typing import Any

MAX_RECORDS = 12


def describe_scan(found: Mapping[str, Any], bounds: str) -> list[tuple[str, str]]:
    """Return the rows of a LAS, LAZ, COPC or Zarr file; `bounds` is what is said of its box."""
    rows = _describe_array(found) if found["type"] == "zarr" else _describe_las(found)
    return [rows[0], ("points", f"{found['points']:,}"), ("bounds", bounds), *rows[1:]]


def _describe_las(found: Mapping[str, Any]) -> list[tuple[str, str]]:
    format_ = f"LAS {found['version']}, point format {found['point_format']}, {found['point_bytes']} bytes per point"
    if found["compression"]:
        chunks = found["chunk_points"]
        size = "of various sizes" if chunks == "varies" else f"of {chunks:,} points" if chunks else "not readable"
        format_ = f"{found['compression']}, chunks {size}; {format_}"
    rows = [
        ("type", format_),
        ("scale", _join(found["scale"])),
        ("offset", _join(found["offset"])),
        ("crs", found["crs"] or "none named"),
        ("returns", ", ".join(f"{count:,}" for count in found["returns"])),
        ("dimensions", ", ".join(f"{name} ({kind})" for name, kind in found["dimensions"].items())),
        ("records", _describe_records(found["vlrs"])),
        ("behind", _describe_records(found["evlrs"])),
        ("waveforms", "in the file" if found["waveforms"] else ""),
        ("made", ", ".join(found[key] for key in ("created", "software", "system") if found[key])),
    ]
    return [(name, text) for name, text in rows if text]


def _describe_records(records: Sequence[Mapping[str, Any]]) -> str:
    named = []
    for record in records[:MAX_RECORDS]:
        text = f", {record['description']}" if record["description"] else ""
        named.append(f"{record['user']} {record['id']} ({record['bytes']:,} bytes{text})")
    more = f", and {len(records) - MAX_RECORDS} more" if len(records) > MAX_RECORDS else ""
    return ", ".join(named) + more


def _describe_array(found: Mapping[str, Any]) -> list[tuple[str, str]]:
    shards = f"shards of {found['shards'][0]:,} rows, " if found["shards"] else ""
    layout = f"{shards}chunks of {' x '.join(f'{size:,}' for size in found['chunks'])}"
    rows = [
        ("type", f"zarr, format {found['format']}, {found['columns']} x {found['dtype']}"),
        ("layout", layout),
        ("compressed", ", ".join(found["compressors"]) or "no"),
        ("attributes", ", ".join(found["attributes"])),
    ]
    return [(name, text) for name, text in rows if text]


def _join(numbers: Sequence[float]) -> str:
    return ", ".join(f"{number + 0.0:.15g}" for number in numbers)
