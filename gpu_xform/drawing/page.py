"""Pages: pictures on paper of a given size, with margins, and true to scale where a scale is given."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from .._core.arguments import as_float
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError
from .lengths import MM_PER_INCH, to_millimetres

PaperLike: TypeAlias = str | Sequence[float]

# Width and height in millimetres, upright: ISO 216, and the sizes of North America.
PAPERS: Mapping[str, tuple[float, float]] = {
    "A0": (841.0, 1189.0),
    "A1": (594.0, 841.0),
    "A2": (420.0, 594.0),
    "A3": (297.0, 420.0),
    "A4": (210.0, 297.0),
    "A5": (148.0, 210.0),
    "A6": (105.0, 148.0),
    "letter": (215.9, 279.4),
    "legal": (215.9, 355.6),
    "tabloid": (279.4, 431.8),
}
A_SERIES = ("A0", "A1", "A2", "A3", "A4", "A5", "A6")
UNITS_MM: Mapping[str, float] = {"um": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
DEFAULT_MARGIN = "10mm"
LANDSCAPE, PORTRAIT = "landscape", "portrait"
MAX_SIDE_MM = 1e5
ROUNDING = 1e-9  # of the paper: what fills it to the last bit fits


@dataclass(frozen=True)
class Page:
    """Paper, and how models are drawn on it.

    paper : as errors name it
    width_mm, height_mm, margin_mm : of the paper
    paper_mm_per_unit : of the models; None if they fill the paper
    drawing_scale : as errors name it
    """

    paper: str
    width_mm: float
    height_mm: float
    margin_mm: float
    paper_mm_per_unit: float | None
    drawing_scale: str

    @property
    def inner_mm(self) -> tuple[float, float]:
        """The width and the height between the margins."""
        return self.width_mm - 2.0 * self.margin_mm, self.height_mm - 2.0 * self.margin_mm

    @property
    def aspect(self) -> float:
        """The width over the height between the margins."""
        return self.inner_mm[0] / self.inner_mm[1]

    def sides_px(self, px_per_inch: float) -> tuple[float, float]:
        """Return the width and the height of the paper in pixels, which need not be whole."""
        return self.width_mm * px_per_inch / MM_PER_INCH, self.height_mm * px_per_inch / MM_PER_INCH

    def size_px(self, px_per_inch: float) -> tuple[int, int]:
        """Return the size of a picture that holds the paper, whose top left corner is that of the picture."""
        width, height = (math.ceil(side * (1.0 - ROUNDING)) for side in self.sides_px(px_per_inch))
        return width, height

    def fit_options(self, options: dict[str, Any]) -> dict[str, Any]:
        """Return the keywords of `Camera.fit` for this page: between the margins nothing stays free."""
        options = {"margin": 0.0} | options
        if self.paper_mm_per_unit is None:
            return options
        if not options.get("orthographic", True):
            raise ArgumentError.expecting("drawing_scale", "go with an orthographic camera", "a perspective one")
        return options | {"orthographic": True}

    def place(self, clip_from_world: Float64Array, points: Float64Array, px_per_inch: float) -> Float64Array:
        """Return the matrix from the world to the clip space of a picture of `size_px`.

        clip_from_world : (4, 4), to the part of the paper between the margins, whose aspect it is for
        points : (n, 3), what the paper must hold if there is a scale

        Raises `ArgumentError` for a scale with a camera that is not orthographic, and for paper that is too small.
        """
        matrix = clip_from_world.copy()
        if self.paper_mm_per_unit is not None:
            if matrix[3, :3].any():
                raise ArgumentError.expecting("drawing_scale", "go with an orthographic camera", "a perspective one")
            matrix /= matrix[3, 3]
            for axis, side_mm in enumerate(self.inner_mm):
                matrix[axis] *= 2.0 * self.paper_mm_per_unit / side_mm / math.hypot(*matrix[axis, :3])
            self._require_room(matrix, points)
        size = self.size_px(px_per_inch)
        px_per_mm = px_per_inch / MM_PER_INCH
        place = np.eye(4)
        for axis, (side_mm, side_px, sign) in enumerate(zip(self.inner_mm, size, (1.0, -1.0), strict=True)):
            share = side_mm * px_per_mm / side_px
            place[axis, axis] = share
            place[axis, 3] = sign * (2.0 * self.margin_mm * px_per_mm / side_px + share - 1.0)
        return place @ matrix

    def _require_room(self, matrix: Float64Array, points: Float64Array) -> None:
        flat = points @ matrix[:2, :3].T + matrix[:2, 3]
        reach = np.abs(flat).max(axis=0, initial=0.0)
        if (reach <= 1.0 + ROUNDING).all():
            return
        needed = [float(r) * side + 2.0 * self.margin_mm for r, side in zip(reach, self.inner_mm, strict=True)]
        width, height = (math.ceil(side * 10.0 * (1.0 - ROUNDING)) / 10.0 for side in needed)
        expected = f"be at least {width:g} x {height:g} mm{_suggest_paper(width, height)}"
        expected += f", for the models at {self.drawing_scale}"
        margins = f" with margins of {self.margin_mm:g} mm" if self.margin_mm else ""
        got = f"{self.paper}, {self.width_mm:g} x {self.height_mm:g} mm"
        raise ArgumentError.expecting("paper", expected + margins, got)


def make_page(
    paper: PaperLike | None,
    drawing_scale: str | float | None,
    margin: float | str | None,
    units: str,
    size: Sequence[int],
    default_size: Sequence[int],
) -> Page | None:
    """Return the page that arguments of these names describe; None without paper. Raises as `render_svg` does."""
    if units not in UNITS_MM:
        raise ArgumentError.expecting("units", f"be one of {', '.join(UNITS_MM)}", repr(units))
    if paper is None:
        for name, value in (("drawing_scale", drawing_scale), ("margin", margin)):
            if value is not None:
                raise ArgumentError.expecting(name, "go with paper, such as paper='A4'")
        return None
    if size is not default_size and tuple(size) != tuple(default_size):
        raise ArgumentError.expecting("size", "not be given with paper, which has one", repr(size))
    name, width, height = _parse_paper(paper)
    margin_mm = to_millimetres(DEFAULT_MARGIN if margin is None else margin, "margin")
    if not 0.0 <= margin_mm < 0.5 * min(width, height):
        raise ArgumentError.expecting(
            "margin", f"leave room on paper of {width:g} x {height:g} mm", f"{margin_mm:g} mm"
        )
    scale, text = (None, "") if drawing_scale is None else _parse_scale(drawing_scale)
    return Page(name, width, height, margin_mm, None if scale is None else scale * UNITS_MM[units], text)


def _parse_paper(paper: PaperLike) -> tuple[str, float, float]:
    if isinstance(paper, str):
        words = re.split(r"[\s-]+", paper.strip())
        by_name = {name.lower(): sides for name, sides in PAPERS.items()}
        turned = words[1].lower() if len(words) == 2 else PORTRAIT
        match = re.fullmatch(r"([\d.]+)x([\d.]+)(mm|cm|in)?", words[0], re.IGNORECASE)
        is_known = words[0].lower() in by_name or match is not None
        if len(words) > 2 or not is_known or turned not in (LANDSCAPE, PORTRAIT):
            expected = f"be one of {', '.join(PAPERS)}, with or without {LANDSCAPE!r}, or a size such as '200x100mm'"
            raise ArgumentError.expecting("paper", expected, f"{paper!r}{did_you_mean(words[0], PAPERS)}")
        if match is None:
            width, height = by_name[words[0].lower()]
        else:
            unit = match[3] or "mm"
            width, height = (_parse_side(f"{number}{unit}") for number in (match[1], match[2]))
        if turned == LANDSCAPE:
            width, height = max(width, height), min(width, height)
        return paper.strip(), width, height
    sides: object = paper
    if not isinstance(sides, Sequence) or len(sides) != 2:
        raise ArgumentTypeError.expecting("paper", "be a name such as 'A4', or (width, height) in mm", repr(paper))
    width, height = (_parse_side(side) for side in sides)
    return "the paper", width, height


def _parse_side(side: float | str) -> float:
    length = to_millimetres(side, "paper")
    if not 0.0 < length <= MAX_SIDE_MM:
        raise ArgumentError.expecting("paper", f"have sides of at most {MAX_SIDE_MM:g} mm, and not of 0", f"{length:g}")
    return length


def _parse_scale(scale: str | float) -> tuple[float, str]:
    """Return how long a unit of length is on paper, and the scale as errors name it."""
    if isinstance(scale, str):
        match = re.fullmatch(r"\s*([\d.]+)\s*(?::\s*([\d.]+)\s*)?", scale)
        try:
            value = float(match[1]) / float(match[2] or 1) if match else math.nan
        except (ValueError, ZeroDivisionError):
            value = math.nan
    else:
        value = as_float(scale, "drawing_scale")
    if not 0.0 < value < math.inf:
        raise ArgumentError.expecting("drawing_scale", "be a ratio such as '1:10', or a positive number", repr(scale))
    return value, scale.strip() if isinstance(scale, str) and ":" in scale else f"{value:g}:1"


def _suggest_paper(width: float, height: float) -> str:
    """Return words on the smallest paper of the A series that holds a width and a height."""
    for name in reversed(A_SERIES):
        short, long = PAPERS[name]
        if short >= width and long >= height:
            return f", as {name} is"
        if long >= width and short >= height:
            return f", as {name} {LANDSCAPE} is"
    return ""
