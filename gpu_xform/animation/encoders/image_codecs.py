"""Lossless codecs of single pictures, by Pillow: fast rather than small."""

import io

from ...imaging.image import Pixels, to_pillow


def encode_png(pixels: Pixels) -> bytes:
    """Return a PNG file."""
    # Of zlib's levels, 3 is the second fastest here, and on thin lines no larger than 6, which takes twice as long.
    return _encode(pixels, "PNG", compress_level=3)


def encode_webp(pixels: Pixels) -> bytes:
    """Return a WebP file, lossless even in the colours of transparent pixels."""
    return _encode(pixels, "WEBP", lossless=True, exact=True, quality=20, method=1)


def _encode(pixels: Pixels, format_name: str, **options: object) -> bytes:
    file = io.BytesIO()
    to_pillow(pixels).save(file, format_name, **options)
    return file.getvalue()
