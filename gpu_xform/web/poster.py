"""The poster of a page: a picture of its models that is small in bytes, for browsers that run no scripts."""

import io
from base64 import b64encode
from bisect import bisect_left
from typing import TYPE_CHECKING

from ..imaging.image import Pixels, to_pillow

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_BYTES = 2500  # with the program, just under 40,000 bytes of page
# Of the longer side; the largest that is small enough is taken.
SIDES_PX = (*(800, 640, 512, 400, 320), *(256, 192, 128, 96, 64))
QUALITY, BEST_QUALITY = 35, 60
_ALPHA_QUALITY = 20  # as much as that of colours: without, a transparent picture takes four times the bytes


def encode_poster(picture: Pixels) -> str:
    """Return a data URL of a picture, as large as fits in `MAX_BYTES`."""
    from PIL import Image, features

    image = to_pillow(picture)
    has_webp = bool(features.check("webp"))

    def encode(side: int, quality: int) -> bytes:
        smaller = image.copy()
        smaller.thumbnail((side, side), Image.Resampling.LANCZOS)
        return _encode(smaller, quality, has_webp=has_webp)

    def fits(side: int) -> bool:
        return len(encode(side, QUALITY)) <= MAX_BYTES

    sides = [side for side in SIDES_PX if side <= max(image.size)] or SIDES_PX[-1:]
    side = sides[min(bisect_left(sides, True, key=fits), len(sides) - 1)]
    best = encode(side, BEST_QUALITY)
    return _as_url(best if len(best) <= MAX_BYTES else encode(side, QUALITY), has_webp=has_webp)


def _encode(image: "Image", quality: int, *, has_webp: bool) -> bytes:
    file = io.BytesIO()
    if has_webp:
        image.save(file, "WEBP", quality=quality, alpha_quality=_ALPHA_QUALITY, method=6)
    else:
        image.quantize(16).save(file, "PNG", optimize=True)
    return file.getvalue()


def _as_url(data: bytes, *, has_webp: bool) -> str:
    return f"data:image/{'webp' if has_webp else 'png'};base64,{b64encode(data).decode()}"
