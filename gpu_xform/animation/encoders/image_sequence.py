"""Image sequence: a folder with one PNG file per frame."""

import re
from collections.abc import Callable
from pathlib import Path

from ..._core.atomic_files import atomic_folder
from ...errors import ArgumentError
from .frames import FrameSequence
from .image_codecs import encode_png
from .parallel import encode_parallel

PLACEHOLDER = re.compile(r"\{frame(?::(0?\d{0,2}))?\}")


def is_template(path: Path) -> bool:
    """Tell whether `path` is meant for one file per frame."""
    return "{" in path.name


def parse_template(template: str) -> Callable[[int], str]:
    """Return a function that puts the number of a frame into a file name such as "{frame:04}.png"."""
    if len(PLACEHOLDER.findall(template)) != 1 or re.search("[{}]", PLACEHOLDER.sub("", template)):
        raise ArgumentError.expecting("path", "hold {frame}, or {frame:04} for four digits, once", repr(template))
    if not template.lower().endswith(".png"):
        raise ArgumentError.expecting("path", "end in .png if it holds {frame}", repr(template))
    return lambda k: PLACEHOLDER.sub(lambda found: format(k, f"{found[1] or ''}d"), template)


def write(template: Path, sequence: FrameSequence) -> None:
    """Write a PNG for each frame, numbered from 0; all of them, or none."""
    name = parse_template(template.name)
    names = map(name, range(sequence.n_frames))
    series = PLACEHOLDER.sub("{frame}", template.name)  # of any number of digits
    with (
        atomic_folder(template.parent, names, series) as folder,
        encode_parallel(sequence.frames, encode_png) as images,
    ):
        for k, encoded in enumerate(images):
            (folder / name(k)).write_bytes(encoded)
