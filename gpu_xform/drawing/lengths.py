"""Lengths on screen and paper: numbers of pixels, or numbers with a unit, such as "0.35mm"."""

import re

from .._core.arguments import as_float
from ..errors import ArgumentError, ArgumentTypeError

PX_PER_INCH = 96.0  # of CSS, SVG, and of our PDF
MM_PER_INCH = 25.4
MAX_DPI = 1e5
INCHES = {"mm": 1.0 / MM_PER_INCH, "cm": 10.0 / MM_PER_INCH, "in": 1.0, "pt": 1.0 / 72.0}
_UNITS = ", ".join(("px", *INCHES))
_WITH_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*([a-z]*)\s*", re.ASCII | re.IGNORECASE)


def to_pixels(value: float | str, name: str, px_per_inch: float = PX_PER_INCH, *, also: str = "") -> float:
    """Return a length in pixels: a number is one; a string has a unit, px, mm, cm, in or pt (1/72 inch).

    also : a word that errors name as possible too

    Raises `ArgumentError` for a unit that is none of these, `ArgumentTypeError` for what is no length.
    """
    if not isinstance(value, str):
        return as_float(value, name)
    match = _WITH_UNIT.fullmatch(value)
    if match is None:
        expected = f"be {also}a number of pixels, or one with a unit, {_UNITS}"
        raise ArgumentTypeError.expecting(name, expected, repr(value))
    number, unit = float(match[1]), match[2].lower()
    if unit in ("", "px"):
        return number
    if unit not in INCHES:
        raise ArgumentError.expecting(name, f"have one of the units {_UNITS}", repr(value))
    return number * INCHES[unit] * px_per_inch


def as_dpi(value: float) -> float:
    """Return a number of pixels per inch."""
    dpi = as_float(value, "dpi")
    if not 1.0 <= dpi <= MAX_DPI:
        raise ArgumentError.expecting("dpi", f"lie in [1, {MAX_DPI:g}]", f"{dpi:g}")
    return dpi


def to_millimetres(value: float | str, name: str) -> float:
    """Return a length on paper in millimetres, which a number is in already; a string has a unit."""
    if not isinstance(value, str):
        return as_float(value, name)
    match = _WITH_UNIT.fullmatch(value)
    if match is not None and not match[2]:
        return float(match[1])
    return to_pixels(value, name) * MM_PER_INCH / PX_PER_INCH
