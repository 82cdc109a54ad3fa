"""Ticks: round numbers along an axis, as few or as many as have room, and how they are written."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from .._core.types import Float64Array
from .items import Box, Text
from .text_style import TextStyle, move_text

STEPS = (1, 2, 5)  # times powers of ten
MAX_TICKS = 11
_MIN_SPACING = 1.6  # between ticks, in sizes of the font
_MIN_GAP = 0.4  # between their texts
_MAX_PLAIN, _MIN_PLAIN = 1e7, 1e-4  # of larger and smaller numbers the exponent is written
_ROUNDING = 1e-9  # of a step

MIN_EXTENT = 1e-300  # of an axis: numbers below have no reciprocal


@dataclass(frozen=True)
class Tick:
    """A number on an axis.

    x, y : on the axis, in pixels
    text : where it is written
    """

    value: float
    x: float
    y: float
    text: Text


def steps_from(least: float) -> Iterator[float]:
    """Yield 1, 2 and 5 times powers of ten, ascending, from the first that is not below `least`."""
    exponent = math.floor(math.log10(least))
    while True:
        for factor in STEPS:
            step = factor * 10.0**exponent if exponent >= 0 else factor / 10.0**-exponent
            if step >= least * (1.0 - _ROUNDING):
                yield step
        exponent += 1


def multiples_of(step: float, low: float, high: float) -> list[float]:
    """Return the multiples of a step in [low, high]."""
    first = math.ceil(low / step - _ROUNDING)
    last = math.floor(high / step + _ROUNDING)
    inverse = round(1.0 / step) if step < 1.0 else 0  # 3 / 10 is nearer to 0.3 than 3 * 0.1
    return [i / inverse if inverse else i * step for i in range(first, last + 1)]


def format_values(values: Sequence[float], step: float) -> list[str]:
    """Return the texts of ticks, all with as many digits as the step needs."""
    largest = max(map(abs, values), default=0.0)
    digits = max(0, -math.floor(math.log10(step) + _ROUNDING))
    if largest and not _MIN_PLAIN <= largest < _MAX_PLAIN:
        exponent = math.floor(math.log10(largest))
        mantissa_digits = max(0, exponent - math.floor(math.log10(step) + _ROUNDING))
        return [_format_exponent(value, mantissa_digits) for value in values]
    return [f"{value + 0.0:.{digits}f}" for value in values]  # + 0.0: no -0


def _format_exponent(value: float, digits: int) -> str:
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{value:.{digits}e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def fit_ticks(
    limits: tuple[float, float],
    to_pixels: Callable[[float], tuple[float, float]],
    outward: Float64Array,
    offset: float,
    viewport: Box,
    style: TextStyle,
) -> list[Tick]:
    """Return ticks within the limits whose texts have room: of round steps the smallest for which no two overlap.

    to_pixels : the point of a value on the axis; those beyond the viewport are left out
    outward : (2,), the direction from the axis to the texts, of length 1
    offset : between the axis and the texts, in pixels
    """
    low, high = limits
    extent = high - low
    if not extent > MIN_EXTENT:
        return []
    (x0, y0), (x1, y1) = to_pixels(low), to_pixels(high)
    length = math.hypot(x1 - x0, y1 - y0)
    if length < 2.0 * style.size or not math.isfinite(length):
        return []
    ticks: list[Tick] = []
    for step in steps_from(extent * max(1.0 / (MAX_TICKS - 1), _MIN_SPACING * style.size / length)):
        values = multiples_of(step, low, high)
        if len(values) < 2 and ticks:
            break
        texts = format_values(values, step)
        ticks = [
            Tick(value, x, y, write_beside(style.text(text, "axes"), x, y, outward, offset))
            for value, text in zip(values, texts, strict=True)
            for x, y in [to_pixels(value)]
            if viewport.left <= x <= viewport.right and viewport.top <= y <= viewport.bottom
        ]
        boxes = [tick.text.box.widened(0.5 * _MIN_GAP * style.size) for tick in ticks]
        if len(values) < 2 or not any(_overlap(a, b) for a, b in pairwise(boxes)):
            return ticks
    return ticks[:1]


def write_beside(text: Text, x: float, y: float, outward: Float64Array, offset: float) -> Text:
    """Return a text that lies in a direction of length 1 from a point, `offset` away from it."""
    left, top, right, bottom = text.box
    half_width, half_height = 0.5 * (right - left), 0.5 * (bottom - top)
    support = half_width * abs(float(outward[0])) + half_height * abs(float(outward[1]))
    center = outward * (offset + support)
    return move_text(text, x + float(center[0]) - half_width, y + float(center[1]) - half_height)


def _overlap(a: Box, b: Box) -> bool:
    return a.left < b.right and b.left < a.right and a.top < b.bottom and b.top < a.bottom
