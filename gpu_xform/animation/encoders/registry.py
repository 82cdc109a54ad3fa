"""From a file's name to what writes it."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, TypeAlias

from ..._core.atomic_files import atomic_seekable_write, atomic_write
from ..._core.types import StrPath
from ...errors import ArgumentError, ArgumentTypeError
from . import apng, gif, html, video, webp
from . import image_sequence as folder
from .frames import Clip

Writer: TypeAlias = Callable[[BinaryIO, Clip], None]

WRITERS: dict[str, Writer] = {
    "apng": apng.write,
    "gif": gif.write,
    "html": html.write,
    "mp4": video.write_mp4,
    "png": apng.write,
    "webm": video.write_webm,
    "webp": webp.write,
}
GO_BACK = {"mp4", "webm", "webp"}  # to write the length of what comes after


def saver(path: StrPath) -> Callable[[Clip], None]:
    """Return what saves a clip as the file `path`, or as one file a frame where its name holds "{frame}".

    Raises at once what can be known of the name: `ArgumentError`, `MissingExtraError`.
    """
    if not isinstance(path, str | os.PathLike):
        raise ArgumentTypeError.expecting("path", "be a path", type(path).__name__)
    write = _writer(Path(path))

    def save(clip: Clip) -> None:
        try:
            write(clip)
        except OSError as error:
            if error.filename is None:  # as of a full disk
                error.filename = os.fspath(path)
            raise

    return save


def _writer(path: Path) -> Callable[[Clip], None]:
    if folder.is_template(path):
        folder.frame_name(path.name)
        return lambda clip: folder.write(path, clip)
    kind = path.suffix.lower().lstrip(".")
    if kind not in WRITERS:
        known = ", ".join(f".{name}" for name in WRITERS)
        raise ArgumentError.expecting("path", f"end in one of {known}, or hold {{frame}}", repr(str(path)))
    if kind in ("mp4", "webm"):
        video.require_av()

    def write(clip: Clip) -> None:
        with (atomic_seekable_write if kind in GO_BACK else atomic_write)(path) as file:
            WRITERS[kind](file, clip)

    return write
