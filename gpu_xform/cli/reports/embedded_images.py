"""Pictures embedded in a page as data URIs, at the size that they are looked at in."""

import io
from base64 import b64encode
from collections.abc import Iterator
from typing import TYPE_CHECKING
from urllib.parse import quote

from ..outcome import Outcome

if TYPE_CHECKING:
    from PIL.Image import Image

THUMBNAIL_PX = 320  # of pictures that are as they should be: twice the width that they are shown in
COMPARED_PX = 1024  # of pictures that are to be compared
MAX_SVG_CHARACTERS = 2_000_000


def embed_images(outcome: Outcome) -> dict[str, str]:
    """Return the data URIs of the pictures of an outcome, by the names of its `images`."""
    size = THUMBNAIL_PX if outcome.status in ("matched", "drawn") else COMPARED_PX
    names = ("picture",) if outcome.status in ("matched", "drawn") else tuple(outcome.images)
    return dict(_embed_each(outcome, names, size))


def _embed_each(outcome: Outcome, names: tuple[str, ...], size: int) -> Iterator[tuple[str, str]]:
    for name in names:
        image = outcome.images.get(name)
        if isinstance(image, str):
            if len(image) <= MAX_SVG_CHARACTERS:
                yield name, f"data:image/svg+xml,{quote(image)}"
        elif image is not None:
            yield name, f"data:image/png;base64,{b64encode(_encode(image, size)).decode()}"


def _encode(image: "Image", max_px: int) -> bytes:
    """Return a PNG file of an image, no side of which is longer than `max_px`."""
    from PIL import Image

    side = max(image.size)
    if side > max_px:
        width, height = (max(1, round(length * max_px / side)) for length in image.size)
        image = image.resize((width, height), Image.Resampling.LANCZOS)
    file = io.BytesIO()
    image.save(file, "PNG", optimize=True)
    return file.getvalue()
