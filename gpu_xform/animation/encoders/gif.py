"""GIF: for every program that shows pictures. 255 colours at a time, and pixels either opaque or not.

Pillow writes animations itself, but holds every frame of them until the last, and gives each its own colours.
"""

import os
import struct
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from ...errors import ArgumentError
from ...imaging.image import Pixels
from .frames import Clip
from .palettes import TRANSPARENT, Indices, Palettes, is_opaque, words
from .parallel import encoded

LARGEST_SIDE = 65535
# Browsers take a delay of less than two hundredths of a second for a mistake, and make it ten.
MOST_FPS = 50
N_SAMPLES = 8
FOREVER = 0
NOTHING = np.full((1, 1), TRANSPARENT, np.uint8)
BITS = 8  # of an index
HAS_FULL_TABLE, HAS_TABLE_OF_ITS_OWN, NO_TABLE = 0xF7, 0x87, 0
LEAVE, CLEAR = 1 << 2, 2 << 2  # what becomes of a frame before the next
HAS_TRANSPARENT = 1


def write(file: BinaryIO, clip: Clip) -> None:
    """Write a GIF; frames begin within half a hundredth of a second, its unit, of their times.

    The colours are chosen from eight frames: those that cover most are kept exactly, the rest share the palette, and
    no pixel is dithered. A frame that shows much of a colour which is not near one of these has a palette of its own,
    as have those after it that it suits better. Of each frame only the part is written that differs from what is below.
    """
    clip.require_size_within(LARGEST_SIDE, "a GIF")
    if clip.fps > MOST_FPS:
        raise ArgumentError.expecting("fps", f"be at most {MOST_FPS} in a GIF", f"{clip.fps:g}")
    spread = np.unique(np.linspace(0, clip.n_frames - 1, N_SAMPLES).round().astype(int))
    palettes = Palettes(clip.samples(spread.tolist()))

    below: Pixels | None = None

    def compressed(pixels: Pixels) -> bytes:
        nonlocal below
        shown = is_opaque(pixels) if below is None else words(pixels) != words(below)
        rows, columns = _box(shown)
        below = pixels if clip.is_opaque else None
        if not shown[rows, columns].any():
            return _image_block(NOTHING, 0, 0)
        palette, indices = palettes.indexed(pixels[rows, columns])
        table = b"" if palette is palettes.common else palette.table()
        return _image_block(indices, rows.start, columns.start, table)

    file.write(b"GIF89a" + struct.pack("<HHBBB", *clip.size, HAS_FULL_TABLE, TRANSPARENT, 0))
    file.write(palettes.common.table())
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


def _image_block(indices: Indices, top: int, left: int, table: bytes = b"") -> bytes:
    """Return the block of a GIF that shows `indices` (height, width), by the file's colours or a `table` of its own."""
    from PIL import Image

    height, width = indices.shape
    flags = HAS_TABLE_OF_ITS_OWN if table else NO_TABLE
    place = struct.pack("<HHHHB", left, top, width, height, flags)
    return b"," + place + table + bytes([BITS]) + Image.fromarray(indices, "L").tobytes("gif", "L") + b"\0"
