"""Animated PNG: lossless, with transparency. The chunks of one PNG per frame, by Pillow, are put into one file.

Pillow writes animations itself, but holds all frames until the last.
"""

import struct
import zlib
from collections.abc import Iterator
from fractions import Fraction
from itertools import count
from typing import BinaryIO

from .frames import MAX_BROWSER_FPS as MAX_FPS
from .frames import FrameSequence
from .image_codecs import encode_png
from .parallel import encode_parallel

SIGNATURE = b"\x89PNG\r\n\x1a\n"
MAX_SIDE_PX = 2**31 - 1
MAX_DELAY_DENOMINATOR = 65535
FOREVER = 0


def write(file: BinaryIO, sequence: FrameSequence) -> None:
    """Write an animated PNG, with the delays as exact fractions."""
    sequence.require_size_within(MAX_SIDE_PX, "a PNG")
    sequence.require_rate_within(MAX_FPS, "an animated PNG")
    width, height = sequence.size
    delay = Fraction(1 / sequence.fps).limit_denominator(MAX_DELAY_DENOMINATOR)
    sequence_number = count()  # of the animation's own chunks
    with encode_parallel(sequence.frames, encode_png) as images:
        for k, encoded in enumerate(images):
            chunks = dict(_chunks(encoded))
            if k == 0:
                file.write(SIGNATURE + _chunk(b"IHDR", chunks[b"IHDR"]))
                file.write(_chunk(b"acTL", struct.pack(">II", sequence.n_frames, FOREVER)))
            timing = (*delay.as_integer_ratio(), 0, 0)
            control = struct.pack(">IIIIIHHBB", next(sequence_number), width, height, 0, 0, *timing)
            file.write(_chunk(b"fcTL", control))
            if k == 0:
                file.write(_chunk(b"IDAT", chunks[b"IDAT"]))
            else:
                file.write(_chunk(b"fdAT", struct.pack(">I", next(sequence_number)) + chunks[b"IDAT"]))
    file.write(_chunk(b"IEND", b""))


def _chunks(encoded: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the name and the body of each chunk of a PNG file, all image data as one chunk."""
    image_data = []
    offset = len(SIGNATURE)
    while offset < len(encoded):
        length, name = struct.unpack_from(">I4s", encoded, offset)
        body = encoded[offset + 8 : offset + 8 + length]
        offset += length + 12
        if name == b"IDAT":
            image_data.append(body)
        else:
            yield name, body
    yield b"IDAT", b"".join(image_data)


def _chunk(name: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
