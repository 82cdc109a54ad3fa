"""The coordinate system that a LAS file names, in words: of OGC WKT, or of GeoTIFF's keys."""

import re
import struct
from collections.abc import Mapping

WKT_RECORD, GEO_KEYS_RECORD, GEO_TEXTS_RECORD = 2112, 34735, 34737
_EPSG_KEYS = {3072: "projected", 2048: "geographic", 4096: "vertical"}
_CITATION_KEYS = (3073, 1026, 2049)
_USER_DEFINED = 32767
_MAX_NAME_CHARACTERS = 200


def name_crs(records: Mapping[int, bytes]) -> str | None:
    """Return such as "WGS 84 / UTM zone 33N (EPSG:32633)" of records of LASF_Projection by number; None if unknown."""
    return _name_wkt(records.get(WKT_RECORD, b"")) or _name_geo_keys(
        records.get(GEO_KEYS_RECORD, b""), records.get(GEO_TEXTS_RECORD, b"")
    )


def _name_wkt(body: bytes) -> str | None:
    text = body.partition(b"\0")[0].decode("utf-8", "replace").strip()
    name = re.match(r"\w+\s*\[\s*\"([^\"]*)\"", text)
    if name is None:
        return None
    code = re.search(r"(?:AUTHORITY|ID)\s*\[\s*\"(\w+)\"\s*,\s*\"?(\w+)\"?\s*\]\s*\]\s*$", text)
    shown = name[1][:_MAX_NAME_CHARACTERS]
    return f"{shown} ({code[1]}:{code[2]})" if code is not None else shown


def _name_geo_keys(body: bytes, texts: bytes) -> str | None:
    keys: dict[int, tuple[int, int, int]] = {}
    for at in range(8, len(body) - 7, 8):
        key, place, count, value = struct.unpack_from("<4H", body, at)
        keys[key] = place, count, value
    found: list[str] = []
    for key, what in _EPSG_KEYS.items():
        place, _, value = keys.get(key, (0, 0, 0))
        if place == 0 and 0 < value < _USER_DEFINED and not (what == "geographic" and found):
            found.append(f"EPSG:{value}")
    cited = next((keys[key] for key in _CITATION_KEYS if key in keys and keys[key][0] == GEO_TEXTS_RECORD), None)
    name = ""
    if cited is not None:
        _, count, start = cited
        name = texts[start : start + count].decode("latin-1").strip("|\0 ")[:_MAX_NAME_CHARACTERS]
    codes = " + ".join(found)
    if name and codes:
        return f"{name} ({codes})"
    return name or codes or None
