"""What a picture of one model consists of, in two dimensions: computed before, written after.

Coordinates are pixels, x to the right and y down, from the picture's top left corner. Colours are straight red, green,
blue and alpha from 0 to 1; alpha is final, whatever paled a line is in it.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .._core.arguments import first_non_finite
from ..errors import ArgumentError

FloatArray = npt.NDArray[np.floating[Any]]

DASH_ON, DASH_OFF = 4.0, 3.0  # line widths
NARROWEST_DASHED = 1.5  # pixels: dashes of narrower lines would no longer look like lines
FARTHEST = 1e7  # pixels: hundredths of them still fit an int32


def dash_pattern(line_width: float) -> tuple[float, float]:
    """Return how many pixels along a dashed line are drawn, and how many then left out; dashes end flat."""
    width = max(line_width, NARROWEST_DASHED)
    return DASH_ON * width, DASH_OFF * width


@dataclass(frozen=True, eq=False)
class Polygons:
    """Filled polygons, those behind first: of one alpha, only the nearest shows.

    offsets : (k + 1,) int; polygon i has the points from offsets[i] to offsets[i + 1]
    points : (p, 2)
    colors : (1, 4) or (k, 4)
    """

    offsets: npt.NDArray[np.integer[Any]]
    points: FloatArray
    colors: FloatArray

    def __post_init__(self) -> None:
        _require_coordinates(self.points, "points", 2)
        _require_colors(self.colors, len(self.offsets) - 1)


@dataclass(frozen=True, eq=False)
class Dots:
    """Round dots, each over those before it.

    circles : (d, 3) the middle's x and y, and the diameter
    colors : (1, 4) or (d, 4)
    """

    circles: FloatArray
    colors: FloatArray

    def __post_init__(self) -> None:
        _require_coordinates(self.circles, "circles", 3)
        _require_colors(self.colors, len(self.circles))


@dataclass(frozen=True, eq=False)
class Strokes:
    """One model's picture: its polygons, the hidden parts of its edges over them, the visible ones, its dots.

    name : of the model: any text, and several may have the same
    segments : (s, 4) x0, y0, x1, y1: a visible or a hidden part of an edge, painted over those before it
    hidden : (s,) bool
    dash_start : (s,) pixels from where the edge starts to where the segment does
    colors : (1, 4) or (s, 4)
    line_width : pixels
    hidden_style : "dash" draws hidden segments by `dash_pattern`, which starts where the edge does; "fade" like others

    Raises `ArgumentError` where shapes don't fit, or a coordinate is no number or farther out than 1e7.
    """

    name: str
    segments: FloatArray
    hidden: npt.NDArray[np.bool_]
    dash_start: FloatArray
    colors: FloatArray
    line_width: float
    hidden_style: Literal["dash", "fade"] = "dash"
    polygons: Polygons | None = None
    dots: Dots | None = None

    def __post_init__(self) -> None:
        _require_coordinates(self.segments, "segments", 4)
        n = len(self.segments)
        for values, name in ((self.hidden, "hidden"), (self.dash_start, "dash_start")):
            if values.shape != (n,):
                raise ArgumentError(f"{name} must have shape ({n},), got {values.shape}")
        _require_reach(self.dash_start, "dash_start")
        _require_colors(self.colors, n)


def _require_coordinates(values: FloatArray, name: str, columns: int) -> None:
    if values.ndim != 2 or values.shape[1] != columns:
        raise ArgumentError(f"{name} must have shape (n, {columns}), got {values.shape}")
    _require_reach(values, name)


def _require_reach(values: FloatArray, name: str) -> None:
    if not np.isfinite(values).all():
        raise ArgumentError(f"{name} must be finite, got {first_non_finite(values)}")
    if np.abs(values).max(initial=0.0) > FARTHEST:
        raise ArgumentError(f"{name} must lie within {FARTHEST:g} pixels, got {np.abs(values).max():g}")


def _require_colors(colors: FloatArray, n: int) -> None:
    if colors.shape not in {(1, 4), (n, 4)}:
        raise ArgumentError(f"colors must have shape (1, 4) or ({n}, 4), got {colors.shape}")
