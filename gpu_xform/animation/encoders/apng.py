"""Animated PNG: exact, with transparency. Each frame is a PNG of Pillow's, its chunks put into one file.

Pillow writes animations itself, but holds every frame of them until the last.
"""

import struct
import zlib
from collections.abc import Iterator
from fractions import Fraction
from itertools import count
from typing import BinaryIO

from .frames import Clip
from .image_codecs import png
from .parallel import encoded

SIGNATURE = b"\x89PNG\r\n\x1a\n"
MOST_OF_A_DELAY = 65535
FOREVER = 0


def write(file: BinaryIO, clip: Clip) -> None:
    """Write an animated PNG, with the delays as exact fractions."""
    clip.require_size_within(2**31 - 1, "a PNG")
    width, height = clip.size
    delay = Fraction(1 / clip.fps).limit_denominator(MOST_OF_A_DELAY)
    number = count()  # of the chunks that are about the animation
    with encoded(clip.frames, png) as stills:
        for k, still in enumerate(stills):
            chunks = dict(_chunks(still))
            if k == 0:
                file.write(SIGNATURE + _chunk(b"IHDR", chunks[b"IHDR"]))
                file.write(_chunk(b"acTL", struct.pack(">II", clip.n_frames, FOREVER)))
            timing = (*delay.as_integer_ratio(), 0, 0)
            file.write(_chunk(b"fcTL", struct.pack(">IIIIIHHBB", next(number), width, height, 0, 0, *timing)))
            if k == 0:
                file.write(_chunk(b"IDAT", chunks[b"IDAT"]))
            else:
                file.write(_chunk(b"fdAT", struct.pack(">I", next(number)) + chunks[b"IDAT"]))
    file.write(_chunk(b"IEND", b""))


def _chunks(still: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the name and the body of each chunk of a PNG file, the parts of the picture as one."""
    picture = []
    place = len(SIGNATURE)
    while place < len(still):
        length, name = struct.unpack_from(">I4s", still, place)
        body = still[place + 8 : place + 8 + length]
        place += length + 12
        if name == b"IDAT":
            picture.append(body)
        else:
            yield name, body
    yield b"IDAT", b"".join(picture)


def _chunk(name: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
