"""Registry of encoders: from the name of a file to the function that writes it."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, TypeAlias

from ..._core.atomic_files import atomic_seekable_write, atomic_write
from ..._core.targets import find_target, require_path
from ..._core.types import StrPath
from ...errors import ArgumentError
from . import apng, gif, html, image_sequence, video, webp
from .frames import FrameSequence

Encoder: TypeAlias = Callable[[BinaryIO, FrameSequence], None]
Writer: TypeAlias = Callable[[FrameSequence], None]

ENCODERS: dict[str, Encoder] = {
    "apng": apng.write,
    "gif": gif.write,
    "html": html.write,
    "mp4": video.write_mp4,
    "png": apng.write,
    "webm": video.write_webm,
    "webp": webp.write,
}
NEEDS_SEEK = {"mp4", "webm", "webp"}  # to write the length of what follows


def make_writer(path: StrPath) -> Writer:
    """Return a function that saves a sequence as the file `path`, or as one file per frame if its name holds "{frame}".

    Raises at once what can be known of the name: `ArgumentError`, `MissingExtraError`.
    """
    require_path(path, "path")
    write = _find_writer(Path(path))

    def write_and_name_errors(sequence: FrameSequence) -> None:
        try:
            write(sequence)
        except OSError as error:
            if error.filename is None:  # as of a full disk
                error.filename = os.fspath(path)
            raise

    return write_and_name_errors


def _find_writer(path: Path) -> Writer:
    if image_sequence.is_template(path):
        image_sequence.parse_template(path.name)
        return lambda sequence: image_sequence.write(path, sequence)
    file_type = path.suffix.lower().lstrip(".")
    if file_type not in ENCODERS:
        known = ", ".join(f".{name}" for name in ENCODERS)
        raise ArgumentError.expecting("path", f"end in one of {known}, or hold {{frame}}", repr(str(path)))
    if file_type in ("mp4", "webm"):
        video.require_av()

    find_target(path)  # raises for a folder

    def write(sequence: FrameSequence) -> None:
        with (atomic_seekable_write if file_type in NEEDS_SEEK else atomic_write)(path) as file:
            ENCODERS[file_type](file, sequence)

    return write
