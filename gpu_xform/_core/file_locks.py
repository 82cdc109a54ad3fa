"""Exclusive locks of open files, which the system takes away when a process ends, however it does."""

import os
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from ..errors import ArgumentError

if sys.platform == "win32":
    import msvcrt

    LOCKED_OFFSET = 1 << 62  # of the one byte that stands for the file; locks there are mandatory

    def _lock(file: BinaryIO) -> None:
        position = file.tell()
        file.seek(LOCKED_OFFSET)
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            raise BlockingIOError from None
        finally:
            file.seek(position)

else:
    import fcntl

    def _lock(file: BinaryIO) -> None:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)


def try_lock(file: BinaryIO) -> bool:
    """Lock an open file until it is closed; return False if another holds it, in this process or in any other.

    A file system without locks locks nothing.
    """
    try:
        _lock(file)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def describe_process() -> str:
    """Return what a lock's holder is told by: this process and its machine."""
    return f"process {os.getpid()} on {socket.gethostname()}"


def refuse_second_run(name: str, path: str, holder: str) -> ArgumentError:
    """Return the error about a path that another run writes.

    name : of the argument that gives the path
    holder : as `describe_process` tells; "" where nothing tells who it is
    """
    got = f"{path!r}, which {holder or 'another run'} is at"
    return ArgumentError.expecting(name, "be written by one run at a time", got)


@contextmanager
def hold_lock_file(path: Path, refuse: Callable[[str], Exception]) -> Iterator[None]:
    """Hold a file at a path that stands for something else, which one run at a time may write, and delete it then.

    refuse : makes the error, of who else holds it
    """
    file = _open_locked(path, refuse)
    with file:
        try:
            file.truncate(0)
            file.write(describe_process().encode())
            file.flush()
            yield
        finally:
            if sys.platform == "win32":  # where no open file is deleted
                file.close()
            path.unlink(missing_ok=True)


def _open_locked(path: Path, refuse: Callable[[str], Exception]) -> BinaryIO:
    while True:
        file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "r+b")
        if not try_lock(file):
            with file:
                holder = file.read().decode("utf-8", "replace")
            raise refuse(holder)
        if is_at(file, path):
            return file
        file.close()  # the run that held it has deleted it meanwhile


def is_at(file: BinaryIO, path: os.PathLike[str]) -> bool:
    """Return whether an open file is the one at a path still: it may have been renamed or deleted since."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))  # noqa: PTH116 - the same as in find_target
    except FileNotFoundError:
        return False
