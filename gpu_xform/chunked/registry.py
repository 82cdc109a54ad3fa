"""Sources and sinks by the type of a file."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from .._core.git_lfs import MAX_POINTER_BYTES, POINTER_WORDS, is_lfs_pointer
from .._core.targets import find_target, is_zarr_path
from .._core.types import Float64Array, StrPath
from ..errors import ArgumentError, MeshError
from ..formats._warn import warn
from ..formats.ply_header import list_new_names
from .las import (
    DEFAULT_SCALE,
    LasSink,
    LasSource,
    NewLasSink,
    choose_las_grid,
    list_las_losses,
    move_bounds,
)
from .losses import warn_of_losses
from .npy import SCAN_POINTS, NpySink, NpySource
from .ply import PlySink, PlySource, SamePlySink, name_properties
from .protocol import Bounds, PointSink, PointSource
from .zarr import ZarrSink, ZarrSource

SOURCES: dict[str, Any] = {"las": LasSource, "laz": LasSource, "npy": NpySource, "ply": PlySource, "zarr": ZarrSource}
CHUNKED_TYPES = tuple(SOURCES)


def find_type(path: StrPath) -> str:
    """Return the type of a file by the end of its name; "npy" for all that are not known, as streams are."""
    if is_zarr_path(path):
        return "zarr"
    suffix = Path(os.fsdecode(path)).suffix.lower().lstrip(".")
    return suffix if suffix in SOURCES else "npy"


def open_source(path: StrPath) -> PointSource:
    """Open a file of points by the end of its name."""
    if Path(path).is_file():
        with Path(path).open("rb") as file:
            if is_lfs_pointer(file.read(MAX_POINTER_BYTES)):
                raise ArgumentError.expecting("source", "hold points", f"{POINTER_WORDS}, at {os.fspath(path)!r}")
    if find_type(path) in ("las", "laz", "ply") and Path(path).exists() and not Path(path).is_file():
        raise ArgumentError.expecting("source", "be a file for this type", repr(os.fspath(path)))
    return SOURCES[find_type(path)](path)  # type: ignore[no-any-return]


def make_sink(
    source: PointSource,
    destination: StrPath,
    matrix: Float64Array,
    *,
    project: bool,
    scale: Any,
    offset: Any,
) -> PointSink:
    """Return the sink for a destination, and warn of what it cannot hold; nothing is written yet."""
    file_type = find_type(destination)
    if isinstance(source, LasSource):
        source.warn_of_points_behind()
    elif isinstance(source, PlySource):
        source.warn_of_bytes_behind()
    records = _list_records(source)
    if file_type in ("las", "laz"):
        return _make_las_sink(source, destination, matrix, file_type, project, scale, offset)
    if scale is not None or offset is not None:
        name = "scale" if scale is not None else "offset"
        raise ArgumentError(f"{name} is for .las and .laz files, got {os.fspath(destination)!r}", argument=name)
    shape = (source.n_points, source.n_columns)
    if file_type == "zarr":
        warn_of_losses(os.fspath(destination), file_type, source.attributes, records)
        return ZarrSink(destination, shape, source.dtype, getattr(source, "array", None))
    target = find_target(destination, "destination")
    if file_type == "npy":
        suffix = Path(os.fsdecode(destination)).suffix
        if source.file_type != "npy" and suffix not in ("", ".npy") and not target.is_stream:
            known = ", ".join(f".{name}" for name in SOURCES)
            raise ArgumentError.expecting("destination", f"end in {known}", repr(os.fspath(destination)))
        warn_of_losses(os.fspath(destination), file_type, source.attributes, records)
        return NpySink(destination, *target, shape, source.dtype)
    _require_space(source, destination)
    if isinstance(source, PlySource):
        return SamePlySink(destination, *target, source)
    columns = _describe_columns(source)
    held = name_properties(columns)
    lost = [name for name in columns if name not in held]
    warn_of_losses(os.fspath(destination), file_type, lost, records + list_new_names(held, "point"))
    return PlySink(destination, *target, source.n_points, source.dtype, columns)


def _make_las_sink(
    source: PointSource,
    destination: StrPath,
    matrix: Float64Array,
    file_type: str,
    project: bool,
    scale: Any,
    offset: Any,
) -> PointSink:
    _require_space(source, destination)
    if os.fsdecode(destination).lower().endswith(".copc.laz"):
        raise ArgumentError.expecting(
            "destination", "end in .laz alone", repr(os.fspath(destination)), reason="COPC is read, not written"
        )
    target = find_target(destination, "destination")
    if target.is_stream:
        raise ArgumentError.expecting("destination", "be a file for this type", repr(os.fspath(destination)))
    if isinstance(source, LasSource) and scale is None and offset is None and np.array_equal(matrix, np.identity(4)):
        grid = source.header.scales, source.header.offsets
    else:
        grid = _choose_grid(source, matrix, project, scale, offset)
    is_compressed = file_type == "laz"
    if not isinstance(source, LasSource):
        columns = _describe_columns(source)
        lost = list_las_losses(columns)
        warn_of_losses(os.fspath(destination), file_type, lost)
        kept = {name: kind for name, kind in columns.items() if name not in lost}
        return NewLasSink(destination, *target, source.n_points, kept, grid, is_compressed)
    if source.is_copc:
        warn(f"{source.path}: its COPC index is left out: {file_type.upper()} with points in their order is written")
    if source.header.has_crs:
        _warn_of_crs(source, matrix, project)
    sink = LasSink(destination, *target, source.header, grid, is_compressed)
    sink.keep_tail_of(source)
    return sink


def _list_records(source: PointSource | LasSource) -> list[str]:
    return source.list_records() if isinstance(source, LasSource) else []


def _choose_grid(
    source: PointSource | LasSource, matrix: Float64Array, project: bool, scale: Any, offset: Any
) -> tuple[Float64Array, Float64Array]:
    """Return scales and offsets; where the bounds of a LAS header leave no good ones, those of the points decide."""
    scales = source.header.scales if isinstance(source, LasSource) else [DEFAULT_SCALE] * 3
    try:
        bounds = source.read_bounds()
        _require_finite(source, bounds)
        grid = choose_las_grid(bounds, matrix, scales, scale, offset, project)
        is_widened = scale is None and not np.array_equal(grid[0], scales)
        if not (is_widened and isinstance(source, LasSource) and source.count_bounds()):
            if is_widened:
                told = [f"{old:g} becomes {new:g}" for old, new in zip(scales, grid[0], strict=True) if old != new]
                warn(f"{source.path}: 32-bit integers need a wider scale for the result: {', '.join(told)}")
            else:
                _warn_of_coarse_grid(source, bounds, matrix, project, grid, scale is not None)
            return grid
    except MeshError as error:
        if not (isinstance(source, LasSource) and source.count_bounds()):
            raise MeshError(f"{source.path}: {error}") from None
    return _choose_grid(source, matrix, project, scale, offset)


def _warn_of_coarse_grid(
    source: PointSource | LasSource, bounds: Bounds, matrix: Float64Array, project: bool, grid: Bounds, is_given: bool
) -> None:
    """Warn if a grid rounds away the steps of the source's grid, or the whole cloud to one point."""
    advice = "the option `scale` (--las-scale) sets a finer one"
    scales, offsets = grid
    if isinstance(source, LasSource) and source.n_points and not (project or is_given):
        steps = np.linalg.norm(matrix[:3, :3], axis=0) * source.header.scales
        if steps.min() < scales.min() / 2:
            source.warn_once(
                f"steps of its grid become {steps.min():.3g}, and the result keeps a scale of {scales.min():.3g}, "
                f"which rounds them away: {advice}"
            )
            return
    with np.errstate(over="ignore", invalid="ignore"):
        low, high = move_bounds(bounds, matrix, project)
        cells = np.rint((np.stack([low, high]) - offsets) / scales)
    if source.n_points and (low < high).any() and np.array_equal(cells[0], cells[1]):
        warn(f"{source.path}: a scale of {scales.min():.3g} rounds all points of the result to one: {advice}")


def _require_finite(source: PointSource | LasSource, bounds: Bounds) -> None:
    """Raise MeshError that names the first point of a source whose coordinates no integers can hold."""
    if np.isfinite(bounds).all():
        return
    for start in range(0, source.n_points, SCAN_POINTS):
        points = source.read(start, min(start + SCAN_POINTS, source.n_points)).positions
        is_finite = np.isfinite(points).all(axis=1)
        if not is_finite.all():
            row = int(np.argmin(is_finite))
            raise MeshError(f"point {start + row}: coordinates must be finite for LAS, got {points[row].tolist()}")


def _warn_of_crs(source: LasSource, matrix: Float64Array, project: bool) -> None:
    """Warn if the matrix moves points by more than a unit, after which the named coordinate system is hardly theirs."""
    low, high = source.read_bounds()
    corners = np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T
    moved = float(np.abs(corners @ matrix[:3, :3].T + matrix[:3, 3] - corners).max())
    if project or not moved <= 1.0:
        source.warn_once(
            "the coordinate system that it names is kept, and the matrix moves points by more than a unit: "
            "is it still true?"
        )


def _require_space(source: PointSource, destination: StrPath) -> None:
    if source.n_columns != 3:
        raise ArgumentError.expecting(
            "source", f"have shape (n, 3) for {os.fspath(destination)!r}", f"(n, 2) of {source.path!r}"
        )


def _describe_columns(source: PointSource) -> dict[str, np.dtype[Any]]:
    """Return the type of each attribute, one with a shape for vectors per point."""
    if not source.attributes:
        return {}
    columns = source.read_columns(source.read(0, 0))
    return {name: np.dtype((column.dtype, column.shape[1:])) for name, column in columns.items()}
