"""LAS and LAZ read whole, as a cloud of points with their attributes; `chunked` reads and writes them in parts."""

import struct
from collections.abc import Iterable
from io import BytesIO
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._core.interrupts import defer_interrupts
from .._core.types import Float64Array
from ..errors import MeshError, MissingExtraError
from ..geometry.attributes import Attributes
from ..geometry.mesh import Mesh, take_over
from ._warn import warn
from .las_header import LasHeader, read_las_header, require_points_counted
from .laz import ChunkTable, LazError
from .limits import budget

_COLOR = ("red", "green", "blue")
_COORDINATES = ("X", "Y", "Z")
_WAVE_VECTOR = ("x_t", "y_t", "z_t")
_NORMALS = tuple({f"n{axis}", f"normal{axis}"} for axis in "xyz")
# Points of real scans shrink to a fifth or less; those of files made to be small to a ten-thousandth.
_MAX_RATIO = 64
_FREE_BYTES = 1 << 26


def import_laspy() -> Any:
    """Return laspy; raise MissingExtraError without it."""
    try:
        with defer_interrupts():
            import laspy
    except ImportError:
        raise MissingExtraError("LAS needs laspy: pip install 'gpu_xform[las]'") from None
    return laspy


def parse_laspy_header(file: BinaryIO) -> Any:
    """Return the header as laspy reads it; raise MeshError where it does not, as for names that are no UTF-8."""
    laspy = import_laspy()
    try:
        return laspy.LasHeader.read_from(file)
    except (ArithmeticError, LookupError, ValueError, TypeError, struct.error, laspy.LaspyException) as error:
        raise MeshError(f"laspy does not read its header: {error}") from None


def read(data: bytes) -> Mesh:
    """Return the points in the unit of the file, with every other dimension, by the name that laspy gives it.

    Red, green and blue are `color` (n, 3); those that are 8 bits in fields of 16 are uint8. Extra bytes such as
    NormalX, NormalY and NormalZ are `normal` (n, 3).
    Raises MeshError for a damaged file, MissingExtraError if the extra `las` is not installed.
    """
    header = read_las_header(BytesIO(data))
    require_points_counted(header)
    laspy_header = parse_laspy_header(BytesIO(data))
    scaled = [each for each in laspy_header.point_format.dimensions if each.is_scaled]  # which become float64
    n_bytes = header.record_bytes + sum(8 * each.num_elements for each in scaled)
    budget().take_bytes(header.n_points * n_bytes, max(_MAX_RATIO, _FREE_BYTES // max(len(data), 1)), "the points")
    positions, columns = _split_records(_read_records(data, header), laspy_header, header)
    if all(name in columns for name in _WAVE_VECTOR):  # which no model's matrix would turn
        warn(f"the vectors of waveforms are left out: {', '.join(_WAVE_VECTOR)}")
        for name in _WAVE_VECTOR:
            del columns[name]
    columns = _join_normals(_join_colors(columns))
    for column in columns.values():
        column.flags.writeable = False  # else it would be copied
    return take_over(positions, np.empty((0, 3), np.uint32), attributes=Attributes(point=columns))


def _split_records(
    records: Any, laspy_header: Any, header: LasHeader
) -> tuple[Float64Array, dict[str, npt.NDArray[Any]]]:
    """Return positions in the unit of the file, and all other dimensions as arrays of their own."""
    laspy = import_laspy()
    point_format = laspy_header.point_format
    try:
        points = laspy.PackedPointRecord(np.frombuffer(records, point_format.dtype()), point_format)
        positions = np.empty((len(points), 3))
        with np.errstate(over="ignore", invalid="ignore"):
            for i, axis in enumerate(_COORDINATES):
                np.multiply(points[axis], header.scales[i], out=positions[:, i])
                positions[:, i] += header.offsets[i]
        names = [name for name in point_format.dimension_names if name not in _COORDINATES]
        columns = {name: np.array(points[name]) for name in names}
    except (laspy.LaspyException, ArithmeticError, ValueError, TypeError, LookupError) as error:
        raise MeshError(f"the dimensions of a point cannot be read: {error}") from None
    if len(points) != header.n_points:
        raise MeshError(f"the dimensions of a point do not take the {header.record_bytes} bytes that the header says")
    if not np.isfinite(positions).all():
        raise MeshError("the scales and offsets of the header are too large for float64")
    return positions, columns


def warn_of_points_behind(header: LasHeader, table: ChunkTable | None = None, path: str = "") -> None:
    """Warn if more points are in a file than its header counts, which are those that every reader takes."""
    n_behind = header.n_behind if table is None else table.n_behind
    if n_behind:
        warn(
            f"{path}{': ' if path else ''}the header counts {header.n_points:,} points, and {n_behind:,} more whole "
            "records lie behind them, which are left out"
        )


def find_normal(names: Iterable[str]) -> tuple[str, str, str] | None:
    """Return which of the names of floats stand for x, y and z of a normal; None if one of the three is missing."""
    spelled = {name.lower().replace("_", "").replace(" ", ""): name for name in reversed([*names])}
    found = [next((name for short, name in spelled.items() if short in axis), None) for axis in _NORMALS]
    x, y, z = found
    return None if x is None or y is None or z is None else (x, y, z)


def _read_records(data: bytes, header: LasHeader) -> Any:
    """Return the bytes of all points."""
    if not header.is_compressed:
        warn_of_points_behind(header)
        return memoryview(data)[header.points_start :][: header.n_points * header.record_bytes]
    file = BytesIO(data)
    table = ChunkTable(file, header)
    budget().require_chunks(table.n_chunks)
    warn_of_points_behind(header, table)
    try:
        return table.decompress(file, 0, table.n_chunks)
    except LazError as error:
        raise MeshError(f"a chunk does not decompress: {error}") from None


def _join_colors(columns: dict[str, npt.NDArray[Any]]) -> dict[str, npt.NDArray[Any]]:
    """Return the columns with red, green and blue as one."""
    if not all(name in columns for name in _COLOR):
        return columns
    color = np.stack([columns.pop(name) for name in _COLOR], axis=1)
    # The specification asks for 16 bits, and many writers put 8 into them (ASPRS, LAS 1.4 R15, table 9).
    columns["color"] = color.astype(np.uint8) if color.max(initial=0) <= np.iinfo(np.uint8).max else color
    return columns


def _join_normals(columns: dict[str, npt.NDArray[Any]]) -> dict[str, npt.NDArray[Any]]:
    """Return the columns with those of a normal as one."""
    normal = find_normal(name for name, column in columns.items() if column.dtype.kind == "f")
    if normal is not None:
        parts = [columns.pop(name) for name in normal]
        with np.errstate(invalid="ignore"):  # of signalling NaNs, where one part is wider than another
            columns["normal"] = np.stack(parts, axis=1)
    return columns
