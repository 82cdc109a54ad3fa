"""Help overlay: the key bindings, drawn over a picture."""

from functools import cache

import numpy as np

from ..imaging.image import Pixels, to_pillow
from .key_bindings import HELP, SIMULATION

FONT_SIZE_PX = 14.0
MARGIN_PX, LINE_HEIGHT_PX = 12.0, 22.0
TEXT_RGBA, PANEL_RGBA = (255, 255, 255, 255), (20, 20, 20, 230)


def draw_help(picture: Pixels, pixel_ratio: float, *, has_simulation: bool = False) -> Pixels:
    """Return `picture` with the key bindings over its upper left corner, smaller if they do not fit."""
    below, panel = to_pillow(picture), to_pillow(_draw_panel(pixel_ratio, has_simulation))
    panel.thumbnail(below.size)
    below.alpha_composite(panel)
    return np.asarray(below)


@cache
def _draw_panel(pixel_ratio: float, has_simulation: bool) -> Pixels:
    from PIL import Image, ImageDraw, ImageFont

    rows = (SIMULATION if has_simulation else ()) + HELP
    font = ImageFont.load_default(FONT_SIZE_PX * pixel_ratio)
    margin, line_height = round(MARGIN_PX * pixel_ratio), round(LINE_HEIGHT_PX * pixel_ratio)
    keys_width, effects_width = (margin + max(round(font.getlength(row[side])) for row in rows) for side in (0, 1))
    size = keys_width + effects_width + 2 * margin, line_height * len(rows) + 2 * margin
    panel = Image.new("RGBA", size, PANEL_RGBA)
    draw = ImageDraw.Draw(panel)
    for i, (key, effect) in enumerate(rows):
        draw.text((margin, margin + line_height * i), key, TEXT_RGBA, font)
        draw.text((keys_width + margin, margin + line_height * i), effect, TEXT_RGBA, font)
    return np.asarray(panel)
