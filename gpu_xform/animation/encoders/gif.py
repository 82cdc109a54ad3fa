"""GIF, which every program shows: 255 colours at a time, and pixels either opaque or transparent.

Pillow writes animations itself, but holds all frames until the last, and gives each its own colours.
"""

import os
import struct
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from ...imaging.image import Pixels
from .frames import FrameSequence
from .palettes import TRANSPARENT, PaletteIndices, Palettes, is_opaque, pack_pixels
from .parallel import encode_parallel

MAX_SIDE_PX = 65535
# Browsers take a delay of less than two hundredths of a second for a mistake, and make it ten.
MAX_FPS = 50
TIME_UNIT_S = 1e-2
N_SAMPLES = 8  # frames that the common palette is chosen from
FOREVER = 0
TRANSPARENT_PIXEL = np.full((1, 1), TRANSPARENT, np.uint8)
INDEX_BITS = 8
HAS_FULL_TABLE, HAS_LOCAL_TABLE, NO_TABLE = 0xF7, 0x87, 0
KEEP, CLEAR = 1 << 2, 2 << 2  # how a frame is disposed of before the next
HAS_TRANSPARENT = 1


def write(file: BinaryIO, sequence: FrameSequence) -> None:
    """Write a GIF; frames begin within half a hundredth of a second, its unit, of their times.

    The colours are chosen from eight frames: those that cover most are kept exactly, the rest share the palette, and
    no pixel is dithered. A frame with many pixels whose colour is not near one of these has a palette of its own, which
    later frames use if it suits them better. Of each frame only the part is written that differs from what is below.
    """
    sequence.require_size_within(MAX_SIDE_PX, "a GIF")
    sequence.require_rate_within(MAX_FPS, "a GIF")
    sampled = np.unique(np.linspace(0, sequence.n_frames - 1, N_SAMPLES).round().astype(int))
    palettes = Palettes(sequence.sample(sampled.tolist()))

    below: Pixels | None = None

    def encode(pixels: Pixels) -> bytes:
        nonlocal below
        differs = is_opaque(pixels) if below is None else pack_pixels(pixels) != pack_pixels(below)
        rows, columns = _bounding_box(differs)
        below = pixels if sequence.is_opaque else None
        if not differs[rows, columns].any():
            return _image_block(TRANSPARENT_PIXEL, 0, 0)
        palette, indices = palettes.quantize(pixels[rows, columns])
        table = b"" if palette is palettes.common else palette.table()
        return _image_block(indices, rows.start, columns.start, table)

    file.write(b"GIF89a" + struct.pack("<HHBBB", *sequence.size, HAS_FULL_TABLE, TRANSPARENT, 0))
    file.write(palettes.common.table())
    file.write(b"!\xff\x0bNETSCAPE2.0\x03\x01" + struct.pack("<HB", FOREVER, 0))
    flags = HAS_TRANSPARENT | (KEEP if sequence.is_opaque else CLEAR)
    with encode_parallel(sequence.frames, encode, n_workers=_choose_n_workers()) as blocks:
        for duration, block in zip(sequence.durations(TIME_UNIT_S), blocks, strict=True):
            file.write(b"!\xf9\x04" + struct.pack("<BHBB", flags, duration, TRANSPARENT, 0) + block)
    file.write(b";")


def _choose_n_workers() -> int:
    # Pillow's compressor holds the interpreter: on two processors, which may be drawing as well, a thread of its own
    # only makes the next frame wait.
    return 1 if (os.cpu_count() or 1) > 2 else 0


def _bounding_box(mask: npt.NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the rows and the columns around all that is true, or one pixel if nothing is."""
    rows = _bounding_slice(np.asarray(mask.any(axis=1)))
    return rows, _bounding_slice(np.asarray(mask[rows].any(axis=0)))


def _bounding_slice(mask: npt.NDArray[np.bool_]) -> slice:
    (indices,) = mask.nonzero()
    return slice(indices[0], indices[-1] + 1) if len(indices) else slice(0, 1)


def _image_block(indices: PaletteIndices, top: int, left: int, table: bytes = b"") -> bytes:
    """Return the block of a GIF that shows `indices` (height, width), by the file's colours or a local `table`."""
    from PIL import Image

    height, width = indices.shape
    flags = HAS_LOCAL_TABLE if table else NO_TABLE
    descriptor = struct.pack("<HHHHB", left, top, width, height, flags)
    data = Image.fromarray(indices, "L").tobytes("gif", "L")
    return b"," + descriptor + table + bytes([INDEX_BITS]) + data + b"\0"
