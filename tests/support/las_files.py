"""LAS and LAZ files to test with, made by laspy, and their points without rounding."""

from pathlib import Path
from typing import Any

import laspy
import numpy as np

from tests.support.types import Array

NORMALS = ("NormalX", "NormalY", "NormalZ")
WAVE_VECTOR = ("x_t", "y_t", "z_t")


def make_las(path: Path, n: int = 400, point_format: int = 7, *, normals: bool = True, **header: Any) -> Any:
    """Write a tile with every dimension filled with noise; return what laspy reads back."""
    random = np.random.default_rng(n + point_format)
    head = laspy.LasHeader(point_format=point_format, version="1.4")
    head.scales, head.offsets = header.get("scales", (0.001, 0.002, 0.005)), (431_000.0, 5_123_000.0, 211.0)
    if normals:
        head.add_extra_dims([laspy.ExtraBytesParams(name, "f4") for name in NORMALS])
        head.add_extra_dims([laspy.ExtraBytesParams("amplitude", "u2"), laspy.ExtraBytesParams("depth", "f8")])
    las = laspy.LasData(head)
    raw = random.integers(0, 256, (n, head.point_format.size), np.uint8)
    las.points = laspy.ScaleAwarePointRecord(
        *(raw.reshape(-1).view(head.point_format.dtype()), head.point_format, head.scales, head.offsets)
    )
    for axis in "XYZ":
        las[axis] = random.integers(-300_000, 500_000, n)
    if normals:
        for name, column in zip(NORMALS, random.normal(size=(3, n)), strict=True):
            las[name] = column
    if point_format in (4, 5, 9, 10):
        for name, column in zip(WAVE_VECTOR, random.normal(size=(3, n)), strict=True):
            las[name] = column
    for vlr in header.get("vlrs", ()):
        las.vlrs.append(vlr)
    if "evlrs" in header:
        las.evlrs = laspy.vlrs.vlrlist.VLRList(header["evlrs"])
    las.write(path)
    return laspy.read(path)


def world(las: Any) -> Array:
    """Return coordinates in extended precision: (n, 3)."""
    columns = [
        np.longdouble(las[axis]) * np.longdouble(las.header.scales[i]) + np.longdouble(las.header.offsets[i])
        for i, axis in enumerate("XYZ")
    ]
    return np.stack(columns, axis=1)


def stack(las: Any, names: tuple[str, ...]) -> Array:
    """Return three dimensions as rows."""
    return np.stack([np.float64(las[name]) for name in names], axis=1)
