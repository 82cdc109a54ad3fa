"""Exclusive locks of open files, which the system takes away when a process ends, however it does."""

import os
import sys
from typing import BinaryIO

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


def is_at(file: BinaryIO, path: os.PathLike[str]) -> bool:
    """Return whether an open file is the one at a path still: it may have been renamed or deleted since."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))  # noqa: PTH116 - the same as in find_target
    except FileNotFoundError:
        return False
