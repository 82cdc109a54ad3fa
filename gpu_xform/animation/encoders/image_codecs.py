"""Single pictures as the bytes of a file, encoded by Pillow: lossless, and rather fast than small."""

import io

from ...imaging.image import Pixels, image


def png(pixels: Pixels) -> bytes:
    """Return a PNG file."""
    # Of zlib's levels, 3 is the fastest here but one, and on thin lines no larger than 6, which takes twice as long.
    return _encoded(pixels, "PNG", compress_level=3)


def webp(pixels: Pixels) -> bytes:
    """Return a WebP file, lossless to the colours of transparent pixels."""
    return _encoded(pixels, "WEBP", lossless=True, exact=True, quality=20, method=1)


def _encoded(pixels: Pixels, name: str, **options: object) -> bytes:
    file = io.BytesIO()
    image(pixels).save(file, name, **options)
    return file.getvalue()
