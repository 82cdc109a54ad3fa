"""Whole writes: files whose `write` may take a part of the data get all of it, or an error is raised."""

import errno
import os
from collections.abc import Iterator
from typing import Any, BinaryIO, cast


def write_all(file: BinaryIO, data: Any) -> int:
    """Write all of `data`, bytes or a contiguous array, and return how many bytes that is.

    Files without a buffer (`open(..., buffering=0)`, `sys.stdout.buffer` of `python -u`) write what the system takes
    at once, which is less on a full disk, in a pipe, and beyond 2 GiB.
    """
    rest = memoryview(data)
    n_bytes = rest.nbytes
    if n_bytes == 0:
        return 0
    rest = rest.cast("B")
    while len(rest):
        n_written = cast("int | None", file.write(rest))
        if n_written is None:
            if hasattr(file, "readinto") or hasattr(file, "fileno"):  # a raw file that would have to wait
                raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
            break  # an object of the caller's own that does not count
        if n_written <= 0:
            raise OSError(errno.EIO, "nothing could be written")
        rest = rest[n_written:]
    return n_bytes


class WholeWriter:
    """A binary file as `file`, whose `write` writes all."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def write(self, data: Any) -> int:
        """Write all of `data`."""
        return write_all(self._file, data)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def __iter__(self) -> Iterator[bytes]:
        return iter(self._file)


def as_whole_writer(file: BinaryIO) -> BinaryIO:
    """Return `file` as a file whose `write` writes all."""
    return cast("BinaryIO", WholeWriter(file))
