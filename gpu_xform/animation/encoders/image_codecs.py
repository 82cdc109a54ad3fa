"""Codecs of single pictures, by Pillow: lossless ones, fast rather than small, and lossy ones for previews."""

import functools
import io
from collections.abc import Callable
from typing import Any, NamedTuple

from ...imaging.image import Pixels, to_pillow

# AVIF keeps colours at full resolution, which thin coloured lines need; from WebP they come out grey. Encoders of AVIF
# are slow: at speed 8 of 10 a frame takes as long as a lossless WebP.
AVIF_QUALITIES = (80, 65, 50, 40, 30, 20, 10)
WEBP_QUALITIES = (90, 75, 50, 30, 10)


class Codec(NamedTuple):
    """A format, as it follows "image/" in a MIME type, and what encodes a frame in it."""

    format: str
    encode: Callable[[Pixels], bytes]


def lossy_codecs(is_opaque: bool) -> list[Codec]:
    """Return codecs from the best to the smallest: AVIF, or WebP where Pillow lacks that."""
    from PIL import features

    if features.check("avif"):
        options: Any = {"subsampling": "4:4:4", "speed": 8, "max_threads": 1}
        return [Codec("avif", _encoder("AVIF", is_opaque, quality=q, **options)) for q in AVIF_QUALITIES]
    return [Codec("webp", _encoder("WEBP", is_opaque, quality=q, method=4)) for q in WEBP_QUALITIES]


def _encoder(format_name: str, is_opaque: bool, **options: Any) -> Callable[[Pixels], bytes]:
    return functools.partial(_encode, format_name=format_name, mode="RGB" if is_opaque else "RGBA", **options)


def encode_png(pixels: Pixels) -> bytes:
    """Return a PNG file."""
    # Of zlib's levels, 3 is the second fastest here, and on thin lines no larger than 6, which takes twice as long.
    return _encode(pixels, "PNG", compress_level=3)


def encode_webp(pixels: Pixels) -> bytes:
    """Return a WebP file, lossless even in the colours of transparent pixels."""
    return _encode(pixels, "WEBP", lossless=True, exact=True, quality=20, method=1)


def _encode(pixels: Pixels, format_name: str, mode: str = "RGBA", **options: object) -> bytes:
    file = io.BytesIO()
    to_pillow(pixels).convert(mode).save(file, format_name, **options)
    return file.getvalue()
