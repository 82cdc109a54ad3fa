"""Streaming: a `.npy` file of points of any size to another, one chunk at a time."""

import hashlib
import json
import os
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from io import BufferedReader
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrix, require_callable, require_flag
from .._core.file_locks import describe_process, is_at, try_lock
from .._core.npy import read_header
from .._core.public import public
from .._core.targets import find_target, require_path
from .._core.types import MatrixLike, Progress, StrPath
from ..device import Device
from ..errors import ArgumentError, ArgumentTypeError
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

    The result grows in `<destination>.partial` and is renamed when it is complete. An interrupted run leaves that file,
    and `resume` goes on with it. Only one run at a time writes it. If the destination is a symbolic link, all that is
    beside its target; into a FIFO or a device the result is written as it comes, and nothing is resumed.

    Parameters
    ----------
    source : path
        A `.npy` file of an array (n, 3) or (n, 2), float32 or float64, C-ordered.
    destination : path
        The `.npy` file to write: same shape, same type, in the machine's byte order.
    matrix : (4, 4) for points of space, (3, 3) for points of the plane, or an object with `as_matrix()`
        Affine, unless `project` is set.
    project : bool
        Apply any matrix and divide by w, as `project_points` does.
    precision : {"auto", "float32", "float64", "rebased"}
        The number type on the device, as in `transform_points`.
    resume : bool
        Go on after the last whole chunk of an interrupted run of the same work.
    progress : callable, optional
        Called with the points done and the points in all, after each chunk.
    device : Device, optional
        By default the process's own.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        If the source is not such an array, if a file to resume belongs to other work, or if another run is writing the
        destination; otherwise as `transform_points` does.
    PrecisionError
        As `transform_points` does.
    OSError
        What the system refuses, such as a full disk.
    """
    require_path(source, "source")
    target = find_target(destination, "destination")
    require_callable(progress, "progress")
    project, resume = require_flag(project, "project"), require_flag(resume, "resume")
    if target.is_stream and resume:
        raise ArgumentError.expecting("resume", "not be set for a stream", repr(os.fspath(destination)))
    with Path(source).open("rb") as reader:
        shape, dtype = _read_header(reader, source)
        _require_rows(reader, source, shape, dtype)
        checked = as_square_matrix(matrix, "matrix", shape[1] + 1)
        run = project_points if project else transform_points
        run(np.empty((0, shape[1]), dtype), checked, precision=precision, device=device)  # raises before any work
        work = _fingerprint(reader, shape, dtype, checked, project, precision)
        kind = _Stream if target.is_stream else _PartialFile
        partial = kind(destination, target.path, shape, dtype, work)
        n_points, point_bytes = shape[0], shape[1] * dtype.itemsize
        chunk = max(1, CHUNK_BYTES // point_bytes)
        points = np.empty((min(chunk, n_points), shape[1]), dtype)
        result = np.empty(points.shape, dtype.newbyteorder("="))
        with partial.open(resume, chunk) as done:
            reader.seek(done * point_bytes, os.SEEK_CUR)
            while done < n_points:
                count = min(chunk, n_points - done)
                if reader.readinto(points[:count].view(np.uint8).data) != count * point_bytes:
                    raise ArgumentError.expecting("source", "not shrink meanwhile", repr(os.fspath(source)))
                run(points[:count], checked, precision=precision, out=result[:count], device=device)
                partial.append(result[:count])
                done += count
                if progress is not None:
                    progress(done, n_points)


def count_columns(source: StrPath) -> int | None:
    """Return 2 or 3 if `source` is a file that `transform_file` takes, as far as its header says; else None."""
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
    """Return what tells one piece of work from another: the state of the source, and what is done to it."""
    status = os.fstat(reader.fileno())
    facts = [status.st_size, status.st_mtime_ns, shape, dtype.str, matrix.tolist(), project, precision, CHUNK_BYTES]
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()


class _Output:
    """The result, as it is written: chunk by chunk, and named as `destination` in what the system refuses."""

    def __init__(
        self, destination: StrPath, path: Path, shape: tuple[int, ...], dtype: np.dtype[Any], work: str
    ) -> None:
        self._destination = os.fspath(destination)
        self._path = path
        self._header = {"descr": dtype.newbyteorder("=").str, "fortran_order": False, "shape": shape}
        self._point_bytes = shape[1] * dtype.itemsize
        self._work = work
        self._n_points = 0
        self._file: BinaryIO

    def open(self, resume: bool, chunk: int) -> AbstractContextManager[int]:
        """Open the file, lend how many points its whole chunks hold, and finish it at the end of the block."""
        raise NotImplementedError

    def append(self, points: npt.NDArray[Any]) -> None:
        """Write a chunk, and hand it to the system."""
        with self._name_destination():
            self._file.write(points.data)
            self._file.flush()
        self._n_points += len(points)

    def _write_header(self) -> None:
        np.lib.format.write_array_header_2_0(self._file, self._header)
        self._file.flush()

    @contextmanager
    def _name_destination(self) -> Iterator[None]:
        """Name the destination in what the system refuses: Python does not say which file a full disk is about."""
        try:
            yield
        except OSError as error:
            raise OSError(error.errno, error.strerror, self._destination) from None


class _Stream(_Output):
    """A FIFO or a device, which takes the result as it comes."""

    @contextmanager
    def open(self, resume: bool, chunk: int) -> Iterator[int]:  # noqa: ARG002
        """Open the stream, and lend 0."""
        with self._path.open("wb") as self._file:
            with self._name_destination():
                self._write_header()
            yield 0


class _PartialFile(_Output):
    """The unfinished result beside its destination, and a note of which work it belongs to, and who is at it."""

    @property
    def _partial(self) -> Path:
        return self._path.with_name(self._path.name + ".partial")

    @property
    def _note(self) -> Path:
        return self._path.with_name(self._path.name + ".partial.work")

    @contextmanager
    def open(self, resume: bool, chunk: int) -> Iterator[int]:
        """Open and lock the file, lend how many points its whole chunks hold, and rename it at the end of the block.

        If the block raises, the file stays if it holds at least one chunk.
        """
        with self._name_destination():
            self._file = self._open_locked()
        with self._file:
            held = os.fstat(self._file.fileno()).st_size
            if resume and held and self._read_note()[0] != self._work:
                raise ArgumentError(
                    f"resume: {str(self._partial)!r} belongs to other work; run without resume to replace it"
                )
            try:
                with self._name_destination():
                    if not resume:
                        self._file.truncate(0)
                    self._note.write_text(f"{self._work}\n{describe_process()}\n", "utf-8")
                    self._n_points = self._keep_whole_chunks(chunk)
                yield self._n_points
                with self._name_destination():
                    os.fsync(self._file.fileno())
                    if sys.platform == "win32":  # where no open file is renamed
                        self._file.close()
                    self._partial.replace(self._path)
                    self._note.unlink(missing_ok=True)
            except BaseException:
                if self._n_points == 0:
                    self._partial.unlink(missing_ok=True)
                    self._note.unlink(missing_ok=True)
                raise

    def _open_locked(self) -> BinaryIO:
        """Open the unfinished file, or make it; raise `ArgumentError` if another run holds it."""
        while True:
            file = os.fdopen(os.open(self._partial, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "r+b")
            if not try_lock(file):
                file.close()
                holder = self._read_note()[1] or "another run"
                raise ArgumentError.expecting("destination", "be written by one run at a time", f"{holder} is at it")
            if is_at(file, self._partial):
                return file
            file.close()  # another run has finished meanwhile

    def _read_note(self) -> tuple[str, str]:
        """Return which work the file belongs to, and who is at it or was."""
        try:
            work, _, holder = self._note.read_text("utf-8").partition("\n")
        except (OSError, ValueError):
            return "", ""
        return work, holder.strip()

    def _keep_whole_chunks(self, chunk: int) -> int:
        """Write the header, cut off what is not a whole chunk, and return how many points are kept."""
        self._write_header()
        start = self._file.tell()
        held = max(os.fstat(self._file.fileno()).st_size - start, 0) // self._point_bytes
        whole = held - held % chunk
        self._file.seek(start + whole * self._point_bytes)
        self._file.truncate()
        return whole
