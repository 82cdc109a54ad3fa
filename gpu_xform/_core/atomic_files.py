"""Writing a file so that it is there whole or not at all."""

import errno
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from .interrupts import defer_sigint
from .types import StrPath


@contextmanager
def atomic_write(path: StrPath) -> Iterator[BinaryIO]:
    """Give a binary file that takes the place of `path` when the block ends, and vanishes if the block raises.

    A symbolic link stays, and its target is replaced. The permissions are those of any new file.
    A device or a pipe is written to directly: replacing it would destroy it. What the system refuses names `path`.
    """
    if Path(path).exists() and not Path(path).is_file():
        with Path(path).open("wb") as file:
            yield file
        return
    target = Path(os.path.realpath(path))
    beside = target.with_name(_make_temporary_name())
    try:
        with beside.open("xb") as file:
            yield file
        beside.replace(target)
    except BaseException as error:
        with suppress(OSError):  # where it was never made, or its folder is none
            beside.unlink()
        if isinstance(error, OSError) and error.filename == str(beside):
            raise OSError(error.errno, error.strerror, os.fspath(path)) from None
        raise


@contextmanager
def atomic_seekable_write(path: StrPath) -> Iterator[BinaryIO]:
    """Give what `atomic_write` gives where it is a regular file, which can be opened by its name and gone back in.

    In place of another, it gives a temporary one, which is copied there when the block ends.
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
def atomic_folder(path: StrPath, names: Iterable[str]) -> Iterator[Path]:
    """Give an empty folder whose files move into the folder `path` when the block ends, and vanish if it raises.

    `path` is made where there is none, in a folder that there must be; what else it holds stays. The files that will
    be there have these `names`, none of which may be a folder's. Where one cannot be moved, none is. What the system
    refuses names `path`.
    """
    target = Path(path)
    if os.path.lexists(target) and not target.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), os.fspath(path))
    for name in names:
        _require_no_folder(target / name)
    beside = (target if target.is_dir() else target.parent) / _make_temporary_name()
    try:
        beside.mkdir()
        yield beside
        if target.is_dir():
            with defer_sigint():
                _move_all(beside, target)
                beside.rmdir()
        else:
            beside.rename(target)
    except BaseException as error:
        shutil.rmtree(beside, ignore_errors=True)
        if isinstance(error, OSError) and error.filename and Path(error.filename).is_relative_to(beside):
            named = target / Path(error.filename).relative_to(beside)
            raise OSError(error.errno, error.strerror, str(named)) from None
        raise


def _move_all(source: Path, target: Path) -> None:
    """Move the files of one folder into another; where one cannot be moved, the other is left as it was."""
    replaced = target / _make_temporary_name()
    replaced.mkdir()
    files = sorted(source.iterdir())
    try:
        for file in files:
            place = target / file.name
            _require_no_folder(place)
            if os.path.lexists(place):
                place.rename(replaced / file.name)
            file.rename(place)
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
    return f".{secrets.token_hex(8)}.tmp"  # short: what it stands for may have a name of full length
