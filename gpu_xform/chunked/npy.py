"""`.npy` files as chunked points."""

import os
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.npy import read_header
from .._core.types import StrPath
from ..errors import ArgumentError, ArgumentTypeError
from .partial_files import FileSink
from .protocol import Block, Bounds, ChunkError, Directions, Encoded, PointSource


class NpySource:
    """A `.npy` file of an array (n, 3) or (n, 2), float32 or float64, C-ordered."""

    file_type = "npy"
    attributes: Sequence[str] = ()
    directions: Sequence[Directions] = ()
    chunk_points = 1

    def __init__(self, path: StrPath, *, is_checked: bool = True) -> None:
        self.path = os.fspath(path)
        self._file = Path(path).open("rb")  # noqa: SIM115 - closed by `close`
        try:
            shape, self.dtype = self._read_header()
            self._start = self._file.tell()
            self.n_points, self.n_columns = shape
            self.point_bytes = self.n_columns * self.dtype.itemsize
            if is_checked:
                self._require_rows()
        except BaseException:
            self._file.close()
            raise
        self.world_from_stored = np.identity(self.n_columns + 1)
        self._buffer: npt.NDArray[Any] = np.empty((0, self.n_columns), self.dtype)
        self._spare = self._buffer

    def _read_header(self) -> tuple[tuple[int, int], np.dtype[Any]]:
        try:
            shape, is_fortran, dtype = read_header(self._file)
        except ValueError as error:
            is_named = Path(os.fsdecode(self.path)).suffix.lower() in ("", ".npy")
            expected = "be a .npy file" if is_named else "end in .las, .laz, .ply or .zarr, or be a .npy file"
            raise ArgumentError.expecting("source", expected, repr(self.path), reason=error) from None
        if dtype.kind != "f" or dtype.itemsize not in {4, 8}:
            raise ArgumentTypeError.expecting("source", "hold float32 or float64", f"{dtype} in {self.path!r}")
        if len(shape) != 2 or shape[1] not in {2, 3}:
            raise ArgumentError.expecting("source", "have shape (n, 3) or (n, 2)", f"{shape} in {self.path!r}")
        if is_fortran and min(shape) > 1:
            raise ArgumentError.expecting("source", "be C-ordered", f"a Fortran-ordered array in {self.path!r}")
        return (shape[0], shape[1]), dtype

    def _require_rows(self) -> None:
        expected = self.n_points * self.point_bytes
        held = os.fstat(self._file.fileno()).st_size - self._start
        if held != expected:
            raise ArgumentError.expecting("source", f"hold {expected:,} bytes of points", f"{held:,} in {self.path!r}")

    def read(self, start: int, stop: int) -> Block:
        """Return the points from `start` up to `stop`, in memory that the call after the next one uses again."""
        n = stop - start
        self._buffer, self._spare = self._spare, self._buffer
        if len(self._buffer) < n:
            self._buffer = np.empty((n, self.n_columns), self.dtype)
        points = self._buffer[:n]
        self._file.seek(self._start + start * self.point_bytes)
        if self._file.readinto(points.view(np.uint8).data) != points.nbytes:
            raise ArgumentError.expecting("source", "not shrink meanwhile", repr(self.path))
        return Block(start, points)

    def read_raw(self, start: int, stop: int) -> Block:
        """Raise: nothing here is compressed."""
        raise ChunkError(f"{self.path}: not compressed", start, stop)

    def read_bounds(self) -> Bounds:
        """Return the corners of the box of all points, which are read for it."""
        return scan_bounds(self)

    def read_columns(self, block: Block) -> Mapping[str, npt.NDArray[Any]]:  # noqa: ARG002
        """Return nothing: there are positions alone."""
        return {}

    def describe_state(self) -> list[Any]:
        """Return size, time, shape and type."""
        status = os.fstat(self._file.fileno())
        return [status.st_size, status.st_mtime_ns, (self.n_points, self.n_columns), self.dtype.str]

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class NpySink(FileSink):
    """A `.npy` file that grows."""

    chunk_points = 1

    def __init__(
        self, destination: StrPath, path: Path, is_stream: bool, shape: tuple[int, int], dtype: np.dtype[Any]
    ) -> None:
        super().__init__(destination, path, is_stream)
        self._dtype = dtype.newbyteorder("=")
        self.point_bytes = shape[1] * dtype.itemsize
        self.world_from_stored = np.identity(shape[1] + 1)
        head = BytesIO()
        header = {"descr": self._dtype.str, "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_2_0(head, header)
        self.head = head.getvalue()

    def encode(self, block: Block, positions: npt.NDArray[Any], source: PointSource) -> Encoded:  # noqa: ARG002
        """Return the positions in the type of the file."""
        body = np.ascontiguousarray(positions, self._dtype)
        return Encoded(block.start, len(body), body.data)


SCAN_POINTS = 1 << 20
_ROWS_TOGETHER = 512


def scan_bounds(source: PointSource) -> Bounds:
    """Return the corners of the box of all points of a source, in world coordinates; NaN where a coordinate is NaN."""
    low, high = np.full(source.n_columns, np.inf), np.full(source.n_columns, -np.inf)
    step = max(SCAN_POINTS // source.chunk_points, 1) * source.chunk_points
    for start in range(0, source.n_points, step):
        positions = source.read(start, min(start + step, source.n_points)).positions
        low = np.minimum(low, positions.min(axis=0))
        high = np.maximum(high, positions.max(axis=0))
    if source.n_points == 0:
        low = high = np.zeros(source.n_columns)
    return low, high


def find_extremes(positions: npt.NDArray[Any]) -> Bounds:
    """Return the least and the greatest of each column; many rows at a time, as NumPy is slow along short ones."""
    whole = len(positions) - len(positions) % _ROWS_TOGETHER
    low, high = [positions[whole:]], [positions[whole:]]
    if whole:
        wide = positions[:whole].reshape(-1, 3 * _ROWS_TOGETHER)
        low.append(wide.min(axis=0).reshape(-1, 3))
        high.append(wide.max(axis=0).reshape(-1, 3))
    return np.concatenate(low).min(axis=0), np.concatenate(high).max(axis=0)
