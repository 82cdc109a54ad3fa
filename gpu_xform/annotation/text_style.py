"""Text style: the font, the size and the colours of all texts of a picture."""

from dataclasses import dataclass

from .._core.arguments import as_float
from .._core.types import StrPath
from ..errors import ArgumentError
from ..imaging.colors import Rgba
from .fonts import Font, choose_font, find_font
from .items import Box, Text

MIN_FONT_SIZE_PX, MAX_FONT_SIZE_PX = 1.0, 2000.0
# By default 10 pixels in a picture of 256, and 20 in one of 1024.
_DEFAULT_BASE_PX, _DEFAULT_SHARE = 6.5, 0.0135
HALO_WIDTH = 0.14  # of the font's size, on each side of a stroke
HALO_ALPHA = 0.85
DARK_TEXT: Rgba = (0.13, 0.13, 0.13, 1.0)
LIGHT_TEXT: Rgba = (0.93, 0.93, 0.93, 1.0)


@dataclass(frozen=True)
class TextStyle:
    """How texts look, and how large they are.

    color : of texts that have none of their own
    halo : around all texts
    """

    font: Font
    color: Rgba
    halo: Rgba

    @property
    def size(self) -> float:
        """The size of the font in pixels."""
        return self.font.size

    @property
    def is_dark(self) -> bool:
        """Whether texts are dark, on a light background."""
        return self.color == DARK_TEXT

    def text(self, text: str, name: str, *, color: Rgba | None = None) -> Text:
        """Return a text whose box begins at (0, 0); errors call it `name`."""
        line = " ".join(text.split())
        font = choose_font(line, self.font, name)
        width, above, below = font.measure(line)
        return Text(line, font, 0.0, above, width, Box(0.0, 0.0, width, above + below), color or self.color, self.halo)


def move_text(text: Text, left: float, top: float) -> Text:
    """Return the text with the upper left corner of its box at a point."""
    return text.moved(left - text.box.left, top - text.box.top)


def make_text_style(
    font: StrPath | None, font_size: float | None, size: tuple[int, int], background: Rgba
) -> TextStyle:
    """Return the style of the texts in a picture of `size`, whose colours stand out from the background.

    Raises `ArgumentError` for an unknown font, and for a size that is not positive.
    """
    if font_size is None:
        font_size = round(_DEFAULT_BASE_PX + _DEFAULT_SHARE * min(size))
    elif not MIN_FONT_SIZE_PX <= as_float(font_size, "font_size") <= MAX_FONT_SIZE_PX:
        expected = f"lie in [{MIN_FONT_SIZE_PX:g}, {MAX_FONT_SIZE_PX:g}] pixels"
        raise ArgumentError.expecting("font_size", expected, f"{font_size:g}")
    red, green, blue, alpha = background
    if alpha == 0.0:
        red = green = blue = 1.0
    is_light = 0.299 * red + 0.587 * green + 0.114 * blue > 0.5
    found = find_font(font, min(float(font_size), MAX_FONT_SIZE_PX))
    return TextStyle(found, DARK_TEXT if is_light else LIGHT_TEXT, (red, green, blue, HALO_ALPHA))
