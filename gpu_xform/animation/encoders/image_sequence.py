"""A folder of PNG files, one a frame."""

import re
from collections.abc import Callable
from pathlib import Path

from ..._core.atomic_files import atomic_folder
from ...errors import ArgumentError
from .frames import Clip
from .image_codecs import png
from .parallel import encoded

PLACE = re.compile(r"\{frame(?::(0?\d{0,2}))?\}")


def is_template(path: Path) -> bool:
    """Say whether `path` is meant for one file a frame."""
    return "{" in path.name


def frame_name(template: str) -> Callable[[int], str]:
    """Return what puts a frame's number into `template`, "{frame:04}.png"."""
    if len(PLACE.findall(template)) != 1 or re.search("[{}]", PLACE.sub("", template)):
        raise ArgumentError.expecting("path", "hold {frame}, or {frame:04} for four digits, once", repr(template))
    if not template.lower().endswith(".png"):
        raise ArgumentError.expecting("path", "end in .png where it holds {frame}", repr(template))
    return lambda k: PLACE.sub(lambda place: format(k, f"{place[1] or ''}d"), template)


def write(template: Path, clip: Clip) -> None:
    """Write a PNG for each frame, numbered from 0; all of them, or none."""
    name = frame_name(template.name)
    names = map(name, range(clip.n_frames))
    with atomic_folder(template.parent, names) as folder, encoded(clip.frames, png) as stills:
        for k, still in enumerate(stills):
            (folder / name(k)).write_bytes(still)
