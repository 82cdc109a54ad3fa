"""Paths on the command line: file types, patterns, and `-` for standard input and output."""

import errno
import os
import stat
from collections.abc import Collection, Sequence
from pathlib import Path

from .._core.suggestions import MIN_FILE_TYPE_SIMILARITY, did_you_mean
from .._core.targets import describe_refusal, find_target, is_zarr_path
from ..errors import ArgumentError

STDIO = "-"


def file_type(path: str, declared: str | None = None) -> str:
    """Return the lower-case type of a file, such as "obj": `declared` if given, else the end of its name."""
    if declared is None and path == STDIO:
        raise ArgumentError("--file-type must give the type of standard input")
    if declared is None and is_zarr_path(path):
        return "zarr"
    return (Path(path).suffix if declared is None else declared).lower().lstrip(".")


def require_type(path: str, known: Collection[str], declared: str | None = None) -> None:
    """Raise `ArgumentError` if the type of `path`, or `declared`, is not among `known`."""
    found = file_type(path, declared)
    if found not in known:
        hint = did_you_mean(found, known, MIN_FILE_TYPE_SIMILARITY)
        raise ArgumentError(f"{path}: the type must be one of {', '.join(known)}, got {found or 'none'}{hint}")


def require_path(path: str) -> None:
    """Raise `ArgumentError` if `path` cannot be a file's: a final slash, which `Path` drops, means a folder."""
    if os.path.split(path)[1] in ("", "."):
        raise ArgumentError(f"expected the path of a file, got {path!r}")


def require_target(path: str) -> None:
    """Raise `OSError` if nothing can be written to `path`, before there is work; `-` is standard output."""
    if path != STDIO:
        find_target(path)


def require_room(path: str) -> None:
    """Raise `OSError` if no file can be made at `path`, whose missing folders are made, before there is work."""
    target = find_target(path).path
    folder = target.parent
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    if not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), path)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise describe_refusal(folder, path)


def expand_globs(patterns: Sequence[str]) -> list[str]:
    """Return the files that patterns match; an existing file, and a pattern without a match, stand for themselves.

    Shells expand patterns themselves, except that of Windows, and others if there are too many files.
    """
    return [path for pattern in patterns for path in _expand_glob(pattern)]


def is_stream(path: str) -> bool:
    """Return whether a path is read once, from its begin to its end: standard input, a FIFO, `<(zcat scan.ply.gz)`."""
    if path == STDIO:
        return True
    try:
        return stat.S_ISFIFO(os.stat(path).st_mode)  # noqa: PTH116 - Path.is_fifo hides errors of the system
    except OSError:  # which reading will tell
        return False


def describe_files(paths: Sequence[str]) -> str:
    """Return how messages name several files: the first, and the number of the others."""
    first, *others = paths
    return f"{first} and {len(others)} more" if others else first


def _expand_glob(pattern: str) -> list[str]:
    if pattern == STDIO or os.path.lexists(pattern):
        return [pattern]
    import glob

    return sorted(glob.glob(pattern, recursive=True)) or [pattern]  # noqa: PTH207 - Path.glob takes no absolute pattern
