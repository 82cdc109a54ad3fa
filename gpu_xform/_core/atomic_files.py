"""Atomic writes: a file appears complete or not at all."""

import errno
import hashlib
import os
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import BinaryIO

from .file_locks import hold_lock_file, refuse_second_run
from .interrupts import defer_interrupts
from .targets import find_target, put_in_place
from .types import StrPath

_LOCK = ".lock"


@contextmanager
def atomic_write(path: StrPath) -> Iterator[BinaryIO]:
    """Yield a binary file that replaces `path` at the end of the block, and is deleted if the block raises.

    The permissions are those of the file that it replaces, or of any new one. What is no regular file is treated as
    `find_target` says. Errors of the system name `path`.
    """
    target, is_stream = find_target(path)
    if is_stream:
        try:
            with target.open("wb") as file:
                yield file
        except OSError as error:
            _name_path(error, path)
            raise
        return
    temporary = target.with_name(_make_temporary_name())
    try:
        with temporary.open("xb") as file:
            yield file
        put_in_place(temporary, target)
    except BaseException as error:
        with suppress(OSError):  # it may not have been created
            temporary.unlink()
        if isinstance(error, OSError) and error.filename == str(temporary):
            raise OSError(error.errno, error.strerror, os.fspath(path)) from None
        if isinstance(error, OSError):
            _name_path(error, path)
        raise


def _name_path(error: OSError, path: StrPath) -> None:
    """Let an error of the system know which file it is about: a full disk does not say it."""
    if error.errno is not None and error.filename is None:
        error.filename = os.fspath(path)


@contextmanager
def atomic_seekable_write(path: StrPath) -> Iterator[BinaryIO]:
    """Yield a regular file, which can be seeked in and opened by its name; otherwise as `atomic_write`.

    If `path` is a device or a pipe, the file is temporary, and is copied there at the end of the block.
    """
    with atomic_write(path) as file:
        if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            yield file
            return
        with tempfile.TemporaryDirectory() as folder:
            whole = Path(folder) / "whole"
            with whole.open("xb") as written:
                yield written
            with whole.open("rb") as read:
                shutil.copyfileobj(read, file)


@contextmanager
def atomic_folder(path: StrPath, names: Iterable[str], series: str) -> Iterator[Path]:
    """Yield an empty folder; its files move into the folder `path` at the end of the block, or none if one cannot.

    `path` is created if it does not exist, but not its parents; its other files stay. If the block raises, the new
    files are deleted. One run at a time writes files of a series there; another is refused by an `ArgumentError` that
    says who is at it. Errors of the system name `path`.

    names : the names of the files to come, none of which may be that of a folder
    series : what is common to names that could be the same
    """
    target = Path(path)
    if os.path.lexists(target) and not target.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), os.fspath(path))
    for name in names:
        _require_no_folder(target / name)
    is_new = False
    with suppress(FileExistsError):
        target.mkdir()
        is_new = True
    temporary = target / _make_temporary_name()
    try:
        with hold_lock_file(target / _make_lock_name(series), partial(refuse_second_run, "path", os.fspath(path))):
            temporary.mkdir()
            yield temporary
            with defer_interrupts():
                _move_all(temporary, target)
                temporary.rmdir()
    except BaseException as error:
        shutil.rmtree(temporary, ignore_errors=True)
        if is_new:
            with suppress(OSError):  # others may have put something there
                target.rmdir()
        if isinstance(error, OSError) and error.filename:
            failed = Path(error.filename)
            if failed.is_relative_to(temporary):
                raise OSError(error.errno, error.strerror, str(target / failed.relative_to(temporary))) from None
            if failed.suffix == _LOCK:
                raise OSError(error.errno, error.strerror, os.fspath(path)) from None
        raise


def _make_lock_name(series: str) -> str:
    """Return the name of the file that stands for a series; short enough for any system."""
    return f".{hashlib.sha256(series.encode('utf-8', 'surrogateescape')).hexdigest()[:16]}{_LOCK}"


def _move_all(source: Path, target: Path) -> None:
    """Move the files of one folder into another, or none of them if one cannot be moved."""
    replaced = target / _make_temporary_name()
    replaced.mkdir()
    files = sorted(source.iterdir())
    try:
        for file in files:
            destination = target / file.name
            _require_no_folder(destination)
            if os.path.lexists(destination):
                destination.rename(replaced / file.name)
            file.rename(destination)
    except BaseException:
        for file in files:
            if os.path.lexists(replaced / file.name):
                (replaced / file.name).replace(target / file.name)
            elif not file.exists():
                (target / file.name).unlink()
        replaced.rmdir()
        raise
    shutil.rmtree(replaced)


def _require_no_folder(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))


def _make_temporary_name() -> str:
    return f".{os.urandom(8).hex()}.tmp"  # short enough even if the final name has the maximal length
