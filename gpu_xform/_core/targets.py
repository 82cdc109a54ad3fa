"""Targets: what stands at a path that will be written, and so how it is written."""

import errno
import os
import stat
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, NamedTuple

from ..errors import ArgumentError, ArgumentTypeError

if TYPE_CHECKING:  # it imports NumPy, which help needs not
    from .types import StrPath


_PERMISSIONS = stat.S_IRWXU | stat.S_IRWXG | stat.S_IRWXO


class WriteTarget(NamedTuple):
    """Where the bytes go: beside a regular file that is replaced when they are whole, or into a stream.

    path : of the file itself, where what was given is a symbolic link, even to a file that does not exist yet
    is_stream : whether it is a FIFO, a device or a socket, which a file put in its place would destroy
    """

    path: Path
    is_stream: bool


def find_target(path: "StrPath", name: str = "path") -> WriteTarget:
    """Return the target at a path, for every writer.

    Raises `OSError` for a folder, for a file that may not be written, and as `os.stat` does.

    name : of the argument that gives the path
    """
    require_path(path, name)
    try:
        mode = os.stat(path).st_mode  # noqa: PTH116 - Path has no other names for it
    except FileNotFoundError:
        return WriteTarget(Path(os.path.realpath(path)), False)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
    if not stat.S_ISREG(mode):
        return WriteTarget(Path(path), True)
    if not os.access(path, os.W_OK):  # a rename would replace it all the same
        raise describe_refusal(path, path)
    return WriteTarget(Path(os.path.realpath(path)), False)


def describe_refusal(place: "StrPath", named: "StrPath") -> OSError:
    """Return the error of a place where the system lets nothing be written, which names another path."""
    is_read_only = hasattr(os, "statvfs") and bool(os.statvfs(place).f_flag & os.ST_RDONLY)
    reason = errno.EROFS if is_read_only else errno.EACCES
    return OSError(reason, os.strerror(reason), os.fspath(named))


def put_in_place(whole: Path, target: Path) -> None:
    """Rename a file onto its target, with the permissions of the one that it replaces."""
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        pass
    else:
        whole.chmod(mode & _PERMISSIONS)
    whole.replace(target)


def is_zarr_path(path: "StrPath") -> bool:
    """Return whether a path names a Zarr array: `scan.zarr`, or one within a group, `scan.zarr/points`."""
    parts = [part.lower() for part in PurePath(os.fsdecode(path)).parts]
    return bool(parts) and (
        parts[-1].endswith(".zarr") or ("." not in parts[-1] and any(part.endswith(".zarr") for part in parts))
    )


def require_path(path: object, name: str) -> None:
    """Raise an error for what is no path, or a path that no system has."""
    if not isinstance(path, str | os.PathLike):
        raise ArgumentTypeError.expecting(name, "be a path", type(path).__name__)
    text = os.fspath(path)
    if ("\0" if isinstance(text, str) else b"\0") in text:
        raise ArgumentError.expecting(name, "hold no NUL character", repr(text))
    try:
        os.fsencode(text)
    except UnicodeEncodeError:
        raise ArgumentError.expecting(name, "hold characters that the system can write", repr(text)) from None
