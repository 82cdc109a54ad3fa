"""A `.npy` file of points to another, of any size, a chunk at a time."""

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrix
from .._core.npy import read_header
from .._core.public import public
from .._core.types import MatrixLike, Progress, StrPath
from ..errors import ArgumentError, ArgumentTypeError
from ..gpu.device import Device
from ._precision import Precision
from .transform import project_points, transform_points

CHUNK_BYTES = 32 << 20


@public
def transform_file(
    source: StrPath,
    destination: StrPath,
    matrix: MatrixLike,
    *,
    project: bool = False,
    precision: Precision = "auto",
    resume: bool = False,
    progress: Progress | None = None,
    device: Device | None = None,
) -> None:
    """Transform the points of one `.npy` file into another, holding two chunks of 32 MiB in memory.

    The result grows in `<destination>.partial` and takes its name when it is complete; what an interrupted run leaves
    there is taken up again with `resume`.

    source : an (n, 3) or (n, 2) array, float32 or float64, C-ordered
    matrix : (4, 4) or (3, 3); affine, unless `project`
    project : divide by w, as `project_points` does
    resume : go on after the last whole chunk of an interrupted run of the same work
    progress : called with the points done and the points in all, after each chunk

    Raises `ArgumentError` for a file that is not such an array, or that belongs to other work; otherwise as
    `transform_points`; what the system refuses (a full disk) as `OSError`.
    """
    with Path(source).open("rb") as reader:
        shape, dtype = _read_header(reader, source)
        _require_rows(reader, source, shape, dtype)
        checked = as_square_matrix(matrix, "matrix", shape[1] + 1)
        apply = project_points if project else transform_points
        apply(np.empty((0, shape[1]), dtype), checked, precision=precision, device=device)  # raises before any work
        partial = _Partial(destination, shape, dtype, _fingerprint(reader, shape, dtype, checked, project, precision))
        n_points, point_bytes = shape[0], shape[1] * dtype.itemsize
        chunk = max(1, CHUNK_BYTES // point_bytes)
        points = np.empty((min(chunk, n_points), shape[1]), dtype)
        result = np.empty(points.shape, dtype.newbyteorder("="))
        with partial.opened(resume, chunk) as done:
            reader.seek(done * point_bytes, os.SEEK_CUR)
            while done < n_points:
                count = min(chunk, n_points - done)
                if reader.readinto(points[:count].view(np.uint8).data) != count * point_bytes:
                    raise ArgumentError.expecting("source", "not shrink meanwhile", repr(os.fspath(source)))
                apply(points[:count], checked, precision=precision, out=result[:count], device=device)
                partial.append(result[:count])
                done += count
                if progress is not None:
                    progress(done, n_points)


def n_columns(source: StrPath) -> int | None:
    """Return 2 or 3 where `source` is a file that `transform_file` takes, as far as its header says; else None."""
    with Path(source).open("rb") as reader:
        try:
            shape, _ = _read_header(reader, source)
        except (ArgumentError, ArgumentTypeError):
            return None
    return shape[1]


def _read_header(reader: BufferedReader, source: StrPath) -> tuple[tuple[int, ...], np.dtype[Any]]:
    try:
        shape, is_fortran, dtype = read_header(reader)
    except ValueError as error:
        raise ArgumentError.expecting("source", "be a .npy file", repr(os.fspath(source)), reason=error) from None
    if dtype.kind != "f" or dtype.itemsize not in {4, 8}:
        raise ArgumentTypeError.expecting("source", "hold float32 or float64", f"{dtype} in {os.fspath(source)!r}")
    if len(shape) != 2 or shape[1] not in {2, 3}:
        raise ArgumentError.expecting("source", "have shape (n, 3) or (n, 2)", f"{shape} in {os.fspath(source)!r}")
    if is_fortran and min(shape) > 1:
        raise ArgumentError.expecting("source", "be C-ordered", f"a Fortran-ordered array in {os.fspath(source)!r}")
    return shape, dtype


def _require_rows(reader: BufferedReader, source: StrPath, shape: tuple[int, ...], dtype: np.dtype[Any]) -> None:
    expected = shape[0] * shape[1] * dtype.itemsize
    held = os.fstat(reader.fileno()).st_size - reader.tell()
    if held != expected:
        raise ArgumentError.expecting(
            "source", f"hold {expected:,} bytes of points", f"{held:,} in {os.fspath(source)!r}"
        )


def _fingerprint(
    reader: BufferedReader,
    shape: tuple[int, ...],
    dtype: np.dtype[Any],
    matrix: npt.NDArray[np.float64],
    project: bool,
    precision: str,
) -> str:
    """Return what tells one piece of work from another: the source as it stands, and what is done to it."""
    status = os.fstat(reader.fileno())
    facts = [status.st_size, status.st_mtime_ns, shape, dtype.str, matrix.tolist(), project, precision, CHUNK_BYTES]
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()


class _Partial:
    """The unfinished result beside its destination, and the note of whose work it is."""

    def __init__(self, destination: StrPath, shape: tuple[int, ...], dtype: np.dtype[Any], work: str) -> None:
        self._destination = Path(destination)
        self._path = self._destination.with_name(self._destination.name + ".partial")
        self._note = self._destination.with_name(self._destination.name + ".partial.work")
        self._header = {"descr": dtype.newbyteorder("=").str, "fortran_order": False, "shape": shape}
        self._point_bytes = shape[1] * dtype.itemsize
        self._work = work
        self._n_points = 0

    @contextmanager
    def opened(self, resume: bool, chunk: int) -> Iterator[int]:
        """Open the file, give how many points its whole chunks hold; where the block ends, give it its name.

        Where the block raises, the file stays if it holds a chunk at least.
        """
        resumed = resume and self._path.exists()
        if resumed and not (self._note.exists() and self._note.read_text() == self._work):
            raise ArgumentError(f"resume: {str(self._path)!r} belongs to other work; run without resume to replace it")
        with self._naming():
            if not resumed:
                self._note.write_text(self._work)
            self._file = self._path.open("r+b" if resumed else "w+b")
        try:
            with self._file:
                self._n_points = self._begin(chunk)
                yield self._n_points
                with self._naming():
                    os.fsync(self._file.fileno())
        except BaseException:
            if self._n_points == 0:
                self._path.unlink(missing_ok=True)
                self._note.unlink(missing_ok=True)
            raise
        with self._naming():
            self._path.replace(self._destination)
            self._note.unlink()

    def append(self, points: npt.NDArray[Any]) -> None:
        """Write a chunk, down to the system."""
        with self._naming():
            self._file.write(points.data)
            self._file.flush()
        self._n_points += len(points)

    def _begin(self, chunk: int) -> int:
        """Write the header, cut off what is not a whole chunk, and return how many points stay."""
        with self._naming():
            np.lib.format.write_array_header_2_0(self._file, self._header)
            self._file.flush()
            start = self._file.tell()
            held = (os.fstat(self._file.fileno()).st_size - start) // self._point_bytes
            whole = held - held % chunk
            self._file.seek(start + whole * self._point_bytes)
            self._file.truncate()
        return whole

    @contextmanager
    def _naming(self) -> Iterator[None]:
        """Let what the system refuses name the destination: Python does not say which file a disk had no room for."""
        try:
            yield
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self._destination)) from None
