"""GIF: for every program that shows pictures. 255 colours for the whole file, and pixels either opaque or not.

Pillow writes animations itself, but holds every frame of them until the last, and gives each its own colours.
"""

import os
import struct
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from ...errors import ArgumentError
from ...images import Pixels
from .clip import Clip
from .overlap import encoded
from .palettes import TRANSPARENT, Indices, Palette, is_opaque, words

LARGEST_SIDE = 65535
# Browsers take a delay of less than two hundredths of a second for a mistake, and make it ten.
MOST_FPS = 50
N_SAMPLES = 8
FOREVER = 0
BITS = 8  # of an index
HAS_FULL_TABLE, NO_TABLE = 0xF7, 0
LEAVE, CLEAR = 1 << 2, 2 << 2  # what becomes of a frame before the next
HAS_TRANSPARENT = 1


def write(file: BinaryIO, clip: Clip) -> None:
    """Write a GIF; frames begin within half a hundredth of a second, its unit, of their times.

    The colours are chosen from eight frames: those that cover most are kept exactly, the rest share the palette, and
    no pixel is dithered. Of each frame only the part is written that differs from what is below it.
    """
    clip.require_size_within(LARGEST_SIDE, "a GIF")
    if clip.fps > MOST_FPS:
        raise ArgumentError(f"fps must be at most {MOST_FPS} in a GIF, got {clip.fps:g}")
    spread = np.unique(np.linspace(0, clip.n_frames - 1, N_SAMPLES).round().astype(int))
    palette = Palette(clip.samples(spread.tolist()))

    below: Pixels | None = None

    def compressed(pixels: Pixels) -> bytes:
        nonlocal below
        rows, columns = _box(is_opaque(pixels) if below is None else words(pixels) != words(below))
        below = pixels if clip.is_opaque else None
        return _image_block(palette.indices(pixels[rows, columns]), rows.start, columns.start)

    file.write(b"GIF89a" + struct.pack("<HHBBB", *clip.size, HAS_FULL_TABLE, TRANSPARENT, 0) + palette.table())
    file.write(b"!\xff\x0bNETSCAPE2.0\x03\x01" + struct.pack("<HB", FOREVER, 0))
    flags = HAS_TRANSPARENT | (LEAVE if clip.is_opaque else CLEAR)
    with encoded(clip.frames, compressed, n_workers=_n_workers()) as blocks:
        for duration, block in zip(clip.durations(1e-2), blocks, strict=True):
            file.write(b"!\xf9\x04" + struct.pack("<BHBB", flags, duration, TRANSPARENT, 0) + block)
    file.write(b";")


def _n_workers() -> int:
    # Pillow's compressor holds the interpreter: on two processors, which may be drawing as well, a thread of its own
    # only makes the next frame wait.
    return 1 if (os.cpu_count() or 1) > 2 else 0


def _box(shown: npt.NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the rows and the columns around all that is true, or one pixel where nothing is."""
    rows = _span(np.asarray(shown.any(axis=1)))
    return rows, _span(np.asarray(shown[rows].any(axis=0)))


def _span(line: npt.NDArray[np.bool_]) -> slice:
    (places,) = line.nonzero()
    return slice(places[0], places[-1] + 1) if len(places) else slice(0, 1)


def _image_block(indices: Indices, top: int, left: int) -> bytes:
    """Return the block of a GIF that shows `indices` (height, width) by the file's own 256 colours."""
    from PIL import Image

    height, width = indices.shape
    place = struct.pack("<HHHHB", left, top, width, height, NO_TABLE)
    return b"," + place + bytes([BITS]) + Image.fromarray(indices, "L").tobytes("gif", "L") + b"\0"
