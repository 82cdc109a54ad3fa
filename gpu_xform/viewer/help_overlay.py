"""The keys, written over a picture."""

from functools import cache

import numpy as np

from ..imaging.image import Pixels, image
from .key_bindings import HELP

FONT_SIZE = 14.0
MARGIN, GAP = 12.0, 22.0
INK, GROUND = (255, 255, 255, 255), (20, 20, 20, 230)


def with_help(picture: Pixels, pixel_ratio: float) -> Pixels:
    """Return `picture` with the keys over its upper left corner, smaller where they do not fit."""
    below, panel = image(picture), image(_panel(pixel_ratio))
    panel.thumbnail(below.size)
    below.alpha_composite(panel)
    return np.asarray(below)


@cache
def _panel(pixel_ratio: float) -> Pixels:
    from PIL import Image, ImageDraw, ImageFont

    font = ImageFont.load_default(FONT_SIZE * pixel_ratio)
    margin, gap = round(MARGIN * pixel_ratio), round(GAP * pixel_ratio)
    middle, right = (margin + max(round(font.getlength(row[side])) for row in HELP) for side in (0, 1))
    panel = Image.new("RGBA", (middle + right + 2 * margin, gap * len(HELP) + 2 * margin), GROUND)
    draw = ImageDraw.Draw(panel)
    for i, (key, what) in enumerate(HELP):
        draw.text((margin, margin + gap * i), key, INK, font)
        draw.text((middle + margin, margin + gap * i), what, INK, font)
    return np.asarray(panel)
