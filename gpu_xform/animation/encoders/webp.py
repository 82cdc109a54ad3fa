"""Animated WebP: lossless, with transparency, smaller than PNG. One WebP per frame, by Pillow, in one container.

Pillow writes animations itself, but needs the list of all frames first.
"""

import struct
from typing import BinaryIO

from .frames import MAX_BROWSER_FPS as MAX_FPS
from .frames import FrameSequence
from .image_codecs import encode_webp
from .parallel import encode_parallel

MAX_SIDE_PX = 16383
TIME_UNIT_S = 1e-3
HAS_ANIMATION, HAS_ALPHA = 0x02, 0x10
FOREVER = 0
TRANSPARENT = b"\0\0\0\0"
REPLACE_BELOW = 0x02


def write(file: BinaryIO, sequence: FrameSequence) -> None:
    """Write an animated WebP; frames begin within half a millisecond of their times."""
    sequence.require_size_within(MAX_SIDE_PX, "a WebP")
    sequence.require_rate_within(MAX_FPS, "a WebP")
    sides = b"".join((side - 1).to_bytes(3, "little") for side in sequence.size)
    start = file.tell()
    file.write(b"RIFF\0\0\0\0WEBP")
    file.write(_chunk(b"VP8X", bytes([HAS_ANIMATION | HAS_ALPHA, 0, 0, 0]) + sides))
    file.write(_chunk(b"ANIM", TRANSPARENT + struct.pack("<H", FOREVER)))
    with encode_parallel(sequence.frames, encode_webp) as images:
        for duration, encoded in zip(sequence.durations(TIME_UNIT_S), images, strict=True):
            header = bytes(6) + sides + duration.to_bytes(3, "little") + bytes([REPLACE_BELOW])
            file.write(_chunk(b"ANMF", header + _bitstream(encoded)))
    n_bytes = file.tell() - start
    file.seek(start + 4)
    file.write(struct.pack("<I", n_bytes - 8))


def _bitstream(encoded: bytes) -> bytes:
    """Return the chunk of a lossless WebP file that holds the picture, whole."""
    offset = 12
    while encoded[offset : offset + 4] != b"VP8L":
        offset += 8 + _round_up_even(int.from_bytes(encoded[offset + 4 : offset + 8], "little"))
    return encoded[offset:]


def _chunk(name: bytes, body: bytes) -> bytes:
    return name + struct.pack("<I", len(body)) + body + bytes(_round_up_even(len(body)) - len(body))


def _round_up_even(n: int) -> int:
    return n + n % 2
