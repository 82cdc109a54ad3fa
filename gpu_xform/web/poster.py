"""The poster of a page: a picture of its models that is small in bytes, for browsers that run no scripts."""

import io
from base64 import b64encode
from typing import TYPE_CHECKING

from ..imaging.image import Pixels, to_pillow

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_BYTES = 1800
SIDES_PX = (800, 640, 512, 400, 320, 256, 192, 128)  # of the longer side; the largest that is small enough is taken
QUALITIES = (60, 35)


def encode_poster(picture: Pixels) -> str:
    """Return a data URL of a picture, as large as fits in `MAX_BYTES`."""
    from PIL import Image, features

    image = to_pillow(picture)
    has_webp = bool(features.check("webp"))
    data = b""
    for side in SIDES_PX:
        if side > max(image.size) and side != SIDES_PX[-1]:
            continue
        smaller = image.copy()
        smaller.thumbnail((side, side), Image.Resampling.LANCZOS)
        for quality in QUALITIES:
            data = _encode(smaller, quality, has_webp=has_webp)
            if len(data) <= MAX_BYTES:
                return _as_url(data, has_webp=has_webp)
    return _as_url(data, has_webp=has_webp)


def _encode(image: "Image", quality: int, *, has_webp: bool) -> bytes:
    file = io.BytesIO()
    if has_webp:
        image.save(file, "WEBP", quality=quality, method=4)
    else:
        image.quantize(16).save(file, "PNG", optimize=True)
    return file.getvalue()


def _as_url(data: bytes, *, has_webp: bool) -> str:
    return f"data:image/{'webp' if has_webp else 'png'};base64,{b64encode(data).decode()}"
