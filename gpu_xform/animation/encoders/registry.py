"""From a file's name to what writes it."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, TypeAlias

from ..._files import atomic_write
from ...errors import ArgumentError, ArgumentTypeError
from . import apng, folder, gif, html, video, webp
from .clip import Clip

Writer: TypeAlias = Callable[[BinaryIO, Clip], None]
StrPath: TypeAlias = str | os.PathLike[str]

WRITERS: dict[str, Writer] = {
    "apng": apng.write,
    "gif": gif.write,
    "html": html.write,
    "mp4": video.write_mp4,
    "png": apng.write,
    "webm": video.write_webm,
    "webp": webp.write,
}


def saver(path: StrPath) -> Callable[[Clip], None]:
    """Return what saves a clip as the file `path`, or as one file a frame where its name holds "{frame}".

    Raises at once what can be known of the name: `ArgumentError`, `MissingExtraError`.
    """
    if not isinstance(path, str | os.PathLike):
        raise ArgumentTypeError(f"path must be a path, got {type(path).__name__}")
    target = Path(path)
    if folder.is_template(target):
        folder.frame_name(target.name)
        return lambda clip: folder.write(target, clip)
    kind = target.suffix.lower().lstrip(".")
    if kind not in WRITERS:
        known = ", ".join(f".{name}" for name in WRITERS)
        raise ArgumentError(f"path must end in one of {known}, or hold {{frame}}, got {os.fspath(path)!r}")
    write = WRITERS[kind]
    if kind in ("mp4", "webm"):
        video.require_av()

    def save(clip: Clip) -> None:
        try:
            with atomic_write(target) as file:
                write(file, clip)
        except OSError as error:
            if error.filename is None:  # as of a full disk
                error.filename = os.fspath(path)
            raise

    return save
