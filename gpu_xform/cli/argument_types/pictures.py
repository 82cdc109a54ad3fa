"""Pictures: their size, page, texts, views and rasteriser."""

import re

from ..._core.suggestions import did_you_mean
from ...drawing.camera import MIN_MARGIN
from ...drawing.lengths import as_dpi, to_pixels
from ...drawing.sheet import PROJECTIONS, VIEW_NAMES
from ...raster.names import RASTERIZERS
from .styles import parse_width
from .texts import argument_type, parse_numbers, quote

MAX_ZOOM_FACTOR = 1.0 - 2.0 * MIN_MARGIN


@argument_type
def parse_resolution(text: str) -> tuple[int, int]:
    """Parse W,H or WxH."""
    sides = re.fullmatch(r"0*([1-9]\d{0,8})\s*[x,]\s*0*([1-9]\d{0,8})", text.strip(), re.ASCII | re.IGNORECASE)
    if sides is None:
        raise ValueError(f"expected a width and a height in pixels, W,H or WxH, got {quote(text)}")
    return int(sides[1]), int(sides[2])


@argument_type
def parse_dpi(text: str) -> float:
    """Parse pixels per inch."""
    return as_dpi(*parse_numbers(text, "pixels per inch", 1))


@argument_type
def parse_units(text: str) -> str:
    """Parse the unit of a model's lengths."""
    from ...drawing.page import UNITS_MM

    if text not in UNITS_MM:
        raise ValueError(f"expected {', '.join(UNITS_MM)}, got {quote(text)}")
    return text


@argument_type
def parse_font_size(text: str) -> float:
    """Parse a positive number of pixels."""
    return to_pixels(parse_width(text), "the size")


@argument_type
def parse_axis_titles(text: str) -> tuple[str, ...]:
    """Parse three titles, X,Y,Z, of which some may be empty."""
    titles = tuple(title.strip() for title in text.split(","))
    if len(titles) != 3:
        raise ValueError(f"expected three titles, X,Y,Z, got {quote(text)}")
    return titles


@argument_type
def parse_views(text: str) -> tuple[str, ...]:
    """Parse names of views, separated by commas."""
    names = tuple(name.strip() for name in text.split(","))
    unknown = next((name for name in names if name not in VIEW_NAMES), None)
    if unknown is not None:
        hint = did_you_mean(unknown, VIEW_NAMES)
        raise ValueError(f"expected names among {', '.join(VIEW_NAMES)}, got {quote(unknown)}{hint}")
    if len(set(names)) < len(names):
        raise ValueError(f"expected each view once, got {quote(text)}")
    return names


@argument_type
def parse_projection(text: str) -> str:
    """Parse the angle of a projection."""
    if text not in PROJECTIONS:
        raise ValueError(f"expected {' or '.join(PROJECTIONS)}, got {quote(text)}")
    return text


@argument_type
def parse_zoom_factor(text: str) -> float:
    """Parse the part of a picture that is filled, positive."""
    (factor,) = parse_numbers(text, "factor", 1)
    if not 0.0 < factor <= MAX_ZOOM_FACTOR:
        raise ValueError(f"expected a factor above 0 and at most {MAX_ZOOM_FACTOR:g}, got {quote(text)}")
    return factor


@argument_type
def parse_rasterizer(text: str) -> str:
    """Parse the name of a rasteriser."""
    if text not in RASTERIZERS:
        raise ValueError(f"expected {', '.join(RASTERIZERS)}, got {quote(text)}{did_you_mean(text, RASTERIZERS)}")
    return text
