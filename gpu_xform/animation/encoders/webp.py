"""Animated WebP: exact, with transparency, smaller than PNG. Each frame is a WebP of Pillow's, put into one container.

Pillow writes animations itself, but wants the list of all frames first.
"""

import struct
from typing import BinaryIO

from .frames import Clip
from .image_codecs import webp
from .parallel import encoded

LARGEST_SIDE = 16383
HAS_ANIMATION, HAS_ALPHA = 0x02, 0x10
FOREVER = 0
TRANSPARENT = b"\0\0\0\0"
REPLACE_WHAT_IS_BELOW = 0x02


def write(file: BinaryIO, clip: Clip) -> None:
    """Write an animated WebP; frames begin within half a millisecond of their times."""
    clip.require_size_within(LARGEST_SIDE, "a WebP")
    sides = b"".join((side - 1).to_bytes(3, "little") for side in clip.size)
    start = file.tell()
    file.write(b"RIFF\0\0\0\0WEBP")
    file.write(_chunk(b"VP8X", bytes([HAS_ANIMATION | HAS_ALPHA, 0, 0, 0]) + sides))
    file.write(_chunk(b"ANIM", TRANSPARENT + struct.pack("<H", FOREVER)))
    with encoded(clip.frames, webp) as stills:
        for duration, still in zip(clip.durations(1e-3), stills, strict=True):
            placed = bytes(6) + sides + duration.to_bytes(3, "little") + bytes([REPLACE_WHAT_IS_BELOW])
            file.write(_chunk(b"ANMF", placed + _bitstream(still)))
    n_bytes = file.tell() - start
    file.seek(start + 4)
    file.write(struct.pack("<I", n_bytes - 8))


def _bitstream(still: bytes) -> bytes:
    """Return the chunk of a lossless WebP file that holds the picture, whole."""
    place = 12
    while still[place : place + 4] != b"VP8L":
        place += 8 + _even(int.from_bytes(still[place + 4 : place + 8], "little"))
    return still[place:]


def _chunk(name: bytes, body: bytes) -> bytes:
    return name + struct.pack("<I", len(body)) + body + bytes(_even(len(body)) - len(body))


def _even(n: int) -> int:
    return n + n % 2
