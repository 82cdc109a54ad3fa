"""The column at the right of a picture: the legend, and below it the colour bars."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._core.types import Float64Array
from ..imaging.colors import Rgba
from .items import Annotation, Box, Disc, Line, Rectangle, Shape, Text
from .text_style import TextStyle, move_text
from .ticks import fit_ticks

MARGIN, ROW_GAP, SWATCH_WIDTH, SWATCH_GAP = 0.8, 0.55, 1.8, 0.6  # in sizes of the font
BAR_WIDTH, TICK_LENGTH, TICK_GAP = 1.0, 0.3, 0.3
MAX_BAR_SHARE, MAX_COLUMN_SHARE = 0.6, 0.45  # of the height, and of the width of the picture
MIN_BAR_HEIGHT = 3.0
ELLIPSIS = "..."


@dataclass(frozen=True)
class LegendEntry:
    """What a layer looks like, and its name. Colours are None for what the layer does not draw."""

    name: str
    fill: Rgba | None
    line: Rgba | None
    line_width: float
    dot: Rgba | None
    dot_size: float


@dataclass(frozen=True, eq=False)
class ColorBar:
    """The colours of numbers.

    limits : at the first and the last of the colours
    colors : (k, 4)
    """

    title: str
    limits: tuple[float, float]
    colors: Float64Array


@dataclass(frozen=True)
class Column:
    """The column: its width, and what is in it."""

    width: float
    annotation: Annotation


def lay_out_column(
    entries: Sequence[LegendEntry], bars: Sequence[ColorBar], size: tuple[int, int], style: TextStyle
) -> Column:
    """Return a legend and colour bars at the right of a picture of `size`, without overlap.

    Texts that are too long for the picture end in dots; what there is no height for is left out.
    """
    if not entries and not bars:
        return Column(0.0, Annotation())
    em = style.size
    most = MAX_COLUMN_SHARE * size[0] - 2.0 * MARGIN * em
    names = [_shorten(entry.name, "legend", most - (SWATCH_WIDTH + SWATCH_GAP) * em, style) for entry in entries]
    legend_width = max((_width(name) + (SWATCH_WIDTH + SWATCH_GAP) * em for name in names), default=0.0)
    row = max((text.box.bottom - text.box.top for text in names), default=0.0) + ROW_GAP * em
    legend_height = len(entries) * row
    below = legend_height + (MARGIN * em if entries else 0.0) + MARGIN * em
    bars_height = (size[1] - below - MARGIN * em) / max(1, len(bars))
    laid_out = [_lay_out_bar(bar, min(bars_height - em, MAX_BAR_SHARE * size[1]), most, style) for bar in bars]
    width = max([legend_width, *(_extent(part) for part in laid_out)])
    left = size[0] - width - MARGIN * em
    result = _lay_out_legend(entries, names, left, MARGIN * em, row, size[1] - MARGIN * em, style)
    for i, part in enumerate(laid_out):
        height = max((text.box.bottom for text in part.texts), default=0.0)
        top = below + i * bars_height + max(0.0, 0.5 * (bars_height - em - height))
        result += part.moved(left, top)
    return Column(width + 2.0 * MARGIN * em, result)


def _lay_out_legend(
    entries: Sequence[LegendEntry],
    names: Sequence[Text],
    left: float,
    top: float,
    row: float,
    bottom: float,
    style: TextStyle,
) -> Annotation:
    em = style.size
    shapes: list[Shape] = []
    texts: list[Text] = []
    for i, (entry, name) in enumerate(zip(entries, names, strict=True)):
        y = top + (i + 0.5) * row
        if y + 0.5 * row > bottom:
            break
        right = left + SWATCH_WIDTH * em
        if entry.fill is not None:
            shapes.append(Rectangle(Box(left, y - 0.35 * em, right, y + 0.35 * em), entry.fill))
        if entry.line is not None:
            shapes.append(Line(left, y, right, y, min(entry.line_width, 0.5 * em), entry.line))
        if entry.dot is not None:
            shapes.append(Disc(0.5 * (left + right), y, min(max(entry.dot_size, 3.0), 0.8 * em), entry.dot))
        height = name.box.bottom - name.box.top
        texts.append(move_text(name, right + SWATCH_GAP * em, y - 0.5 * height))
    return Annotation(shapes, texts)


def _lay_out_bar(bar: ColorBar, height: float, most: float, style: TextStyle) -> Annotation:
    """Return a colour bar whose upper left corner is at (0, 0): its title, its colours and its ticks."""
    em = style.size
    title = [_shorten(bar.title, "colorbar", most, style)] if bar.title.strip() else []
    top = (title[0].box.bottom + 0.6 * em) if title else 0.5 * em
    bottom = height - 0.5 * em
    if bottom - top < MIN_BAR_HEIGHT * em:
        return Annotation()
    width = BAR_WIDTH * em
    rows = min(len(bar.colors), max(2, round(bottom - top)))
    shown = bar.colors[np.rint(np.linspace(0, len(bar.colors) - 1, rows)).astype(int)]
    is_new = np.append(True, (shown[1:] != shown[:-1]).any(axis=1))
    # From the highest down, each to the bottom of the bar: no seam between two, and none lets another through.
    levels = bottom - (bottom - top) * np.arange(rows + 1) / rows
    last = [*np.flatnonzero(is_new)[1:].tolist(), rows]
    shapes: list[Shape] = []
    for first, after in reversed(list(zip(np.flatnonzero(is_new).tolist(), last, strict=True))):
        red, green, blue, _ = shown[first].tolist()
        shapes.append(Rectangle(Box(0.0, float(levels[after]), width, bottom), (red, green, blue, 1.0)))
    low, high = bar.limits

    def to_pixels(value: float) -> tuple[float, float]:
        return width, bottom - (bottom - top) * (value - low) / (high - low)

    everywhere = Box(-np.inf, -np.inf, np.inf, np.inf)
    outward = np.array((1.0, 0.0))
    ticks = fit_ticks(bar.limits, to_pixels, outward, (TICK_LENGTH + TICK_GAP) * em, everywhere, style)
    texts = [_align(tick.text, width + (TICK_LENGTH + TICK_GAP) * em) for tick in ticks]
    if not ticks:  # all numbers are the same
        text = style.text(f"{low:.6g}", "colorbar")
        texts = [move_text(text, width + (TICK_LENGTH + TICK_GAP) * em, 0.5 * (top + bottom - text.box.bottom))]
    thin = max(1.0, 0.06 * em)
    shapes += [Line(width, tick.y, width + TICK_LENGTH * em, tick.y, thin, style.color) for tick in ticks]
    return Annotation(shapes, [*title, *texts])


def _align(text: Text, left: float) -> Text:
    return move_text(text, left, text.box.top)


def _shorten(text: str, name: str, most: float, style: TextStyle) -> Text:
    """Return a text that is at most so wide, if need be with dots at its end."""
    whole = style.text(text, name)
    for length in range(len(text) - 1, 0, -1):
        if _width(whole) <= most:
            break
        whole = style.text(text[:length].rstrip() + ELLIPSIS, name)
    return whole


def _width(text: Text) -> float:
    return text.box.right - text.box.left


def _extent(annotation: Annotation) -> float:
    return max((text.box.right for text in annotation.texts), default=0.0)
