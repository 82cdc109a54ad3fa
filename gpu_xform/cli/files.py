"""What the commands read and write: paths, and `-` for standard input and output."""

import contextlib
import errno
import glob
import io
import os
import sys
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._core import npy as _npy
from .._core.atomic_files import atomic_write
from ..errors import ArgumentError
from ..geometry.mesh import Mesh

if TYPE_CHECKING:
    from PIL.Image import Image

STANDARD = "-"


def kind(path: str, file_type: str | None = None) -> str:
    """Return the type of a file, from its name where `file_type` does not say: "obj", "npy", ..."""
    if file_type is None and path == STANDARD:
        raise ArgumentError("--file-type must say what standard input holds")
    return (Path(path).suffix if file_type is None else file_type).lower().lstrip(".")


def require_type(path: str, known: Collection[str], file_type: str | None = None) -> None:
    """Raise `ArgumentError` where the type of `path`, or `file_type`, is not among `known`."""
    found = kind(path, file_type)
    if found not in known:
        raise ArgumentError(f"{path}: the type must be one of {', '.join(known)}, got {found or 'none'}")


def require_path(path: str) -> None:
    """Raise `ArgumentError` where `path` cannot be a file's: a slash at its end, which `Path` drops, means a folder."""
    if os.path.split(path)[1] in ("", "."):
        raise ArgumentError(f"expected the path of a file, got {path!r}")


def matching(typed: Sequence[str]) -> list[str]:
    """Return the files that paths mean: each itself, or, where there is none of the name, what its pattern matches.

    Shells expand patterns before; the one of Windows does not, and others refuse to where there are too many files.
    """
    return [path for each in typed for path in _matching(each)]


def called(paths: Sequence[str]) -> str:
    """Return what messages call several files."""
    first, *others = paths
    return f"{first} and {len(others)} more" if others else first


def read_mesh(path: str, file_type: str | None) -> Mesh:
    """Return the mesh in `path`."""
    from ..formats import load_mesh

    return load_mesh(_standard("stdin") if path == STANDARD else path, file_type=kind(path, file_type))


def write_mesh(mesh: Mesh, path: str, file_type: str) -> None:
    """Write a mesh to `path`."""
    from ..formats import save_mesh

    with _naming(path):
        save_mesh(mesh, _standard("stdout") if path == STANDARD else path, file_type=file_type)


def read_stack(path: str, count: str) -> npt.NDArray[Any]:
    """Return the matrices in an .npy file, (k, 4, 4); errors call k `count`."""
    stack = read_array(path)
    if stack.ndim != 3 or stack.shape[1:] != (4, 4):
        raise ArgumentError(f"{path}: expected an array of shape ({count}, 4, 4), got {stack.shape}")
    return stack


def read_array(path: str) -> npt.NDArray[Any]:
    """Return the array in an .npy file."""
    try:
        return _npy.read_array(_standard("stdin").read() if path == STANDARD else Path(path).read_bytes())
    except ValueError as error:
        raise ArgumentError(f"{path}: not an .npy file of numbers: {error}") from None
    except MemoryError as error:
        raise ArgumentError(f"{path}: not enough memory: {error}") from None


def write_array(array: npt.NDArray[Any], path: str) -> None:
    """Write a C-ordered array to an .npy file."""
    with _output(path) as file:
        _npy.write_array(array, file)


def read_matrix(path: str) -> npt.NDArray[Any]:
    """Return the (4, 4) entries in an .npy file, or in a text of 16 numbers."""
    if kind(path) == "npy":
        return read_array(path)
    try:
        words = Path(path).read_text("utf-8").replace(",", " ").split()
        return np.array([float(word) for word in words]).reshape(4, 4)
    except ValueError:
        raise ArgumentError(f"{path}: expected a text of 16 numbers, row by row, or an .npy file") from None


def write_picture(picture: "Image | str | bytes", path: str, *, make_folders: bool) -> None:
    """Write an image as PNG, and documents as they are."""
    data = _encoded(picture)
    if make_folders:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    with _output(path) as file:
        # Not by Pillow, which calls every failure to write an encoder's error.
        file.write(data)


def _encoded(picture: "Image | str | bytes") -> bytes:
    if isinstance(picture, bytes):
        return picture
    if isinstance(picture, str):
        return picture.encode()
    png = io.BytesIO()
    picture.save(png, "PNG")
    return png.getvalue()


@contextlib.contextmanager
def _output(path: str) -> Iterator[BinaryIO]:
    with _naming(path):
        if path == STANDARD:
            yield _standard("stdout")
        else:
            with atomic_write(path) as file:
                yield file


@contextlib.contextmanager
def _naming(path: str) -> Iterator[None]:
    """Let a failure to write name the file that was asked for, not the one that stands in for it until it is whole."""
    try:
        yield
    except OSError as error:
        name = "standard output" if path == STANDARD else path
        raise OSError(error.errno, error.strerror or str(error), name) from None


def _matching(path: str) -> list[str]:
    if path == STANDARD or os.path.lexists(path):
        return [path]
    return sorted(glob.glob(path, recursive=True)) or [path]  # noqa: PTH207 - Path.glob takes no absolute pattern


def say(text: str) -> None:
    """Print to standard output; what its encoding lacks, in an adapter's name, is shown as an escape."""
    with _naming(STANDARD):
        _standard("stdout")
        encoding = sys.stdout.encoding or "utf-8"
        sys.stdout.write(text.encode(encoding, "backslashreplace").decode(encoding))
        sys.stdout.flush()


def flush() -> None:
    """Hand over what standard output still holds."""
    if sys.stdout is not None:
        with _naming(STANDARD):
            sys.stdout.flush()


def _standard(stream: str) -> BinaryIO:
    text = getattr(sys, stream)
    if text is None:
        raise OSError(errno.EBADF, os.strerror(errno.EBADF), stream)
    binary: BinaryIO = text.buffer
    return binary
