"""Vector layer: what one model contributes to a vector picture, in two dimensions.

Coordinates are pixels from the top left corner of the picture, x to the right and y down. Colours are straight red,
green, blue and alpha from 0 to 1; alpha is final and includes all fades.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._core.arguments import describe_first_non_finite
from ..drawing.dash_patterns import DashPattern
from ..errors import ArgumentError

FloatArray = npt.NDArray[np.floating[Any]]

MAX_COORDINATE_PX = 1e7  # hundredths of pixels still fit an int32


class Stroke(NamedTuple):
    """The width of lines, and the lengths of their dashes, which end flat, and gaps, in pixels; none if continuous."""

    line_width: float
    dash: DashPattern


class Gradients(NamedTuple):
    """Colours that change linearly along axes.

    axes : (k, 4) from x0, y0 to x1, y1
    ends : (k, 2, 4) the colours at both ends of each, of one alpha; the same twice for one colour
    """

    axes: FloatArray
    ends: FloatArray


@dataclass(frozen=True, eq=False)
class Polygons:
    """Filled polygons from back to front; of polygons of one alpha, only the nearest shows.

    offsets : (k + 1,) int; polygon i has the points from offsets[i] to offsets[i + 1]
    points : (p, 2)
    colors : (1, 4) or (k, 4)
    gradients : over the polygons, convex then; None if each has one colour
    """

    offsets: npt.NDArray[np.integer[Any]]
    points: FloatArray
    colors: FloatArray
    gradients: Gradients | None = None

    def __post_init__(self) -> None:
        _require_coordinates(self.points, "points", 2)
        _require_colors(self.colors, len(self.offsets) - 1)


@dataclass(frozen=True, eq=False)
class Points:
    """Round points, each drawn over those before it.

    circles : (d, 3) the centre's x and y, and the diameter
    colors : (1, 4) or (d, 4)
    """

    circles: FloatArray
    colors: FloatArray

    def __post_init__(self) -> None:
        _require_coordinates(self.circles, "circles", 3)
        _require_colors(self.colors, len(self.circles))


@dataclass(frozen=True, eq=False)
class VectorLayer:
    """One model in a picture: its polygons, over them the hidden and the visible parts of its edges, and its points.

    name : of the model: any text, not necessarily unique
    segments : (s, 4) x0, y0, x1, y1: a visible or a hidden part of an edge, drawn over those before it
    hidden : (s,) bool
    dash_start : (s,) distance in pixels along the dash pattern at which the segment begins; a segment that begins where
        another ends, and as far along the pattern, carries on its dashes
    colors : (1, 4) or (s, 4)
    visible_stroke, hidden_stroke : how either kind of segments is drawn

    Raises `ArgumentError` if shapes don't fit, or a coordinate is not finite or beyond 1e7.
    """

    name: str
    segments: FloatArray
    hidden: npt.NDArray[np.bool_]
    dash_start: FloatArray
    colors: FloatArray
    visible_stroke: Stroke
    hidden_stroke: Stroke
    polygons: Polygons | None = None
    points: Points | None = None

    def moved(self, x: float, y: float) -> "VectorLayer":
        """Return the layer, moved by pixels."""
        polygons, points = self.polygons, self.points
        if polygons is not None:
            gradients = polygons.gradients
            if gradients is not None:
                gradients = gradients._replace(axes=gradients.axes + np.array([x, y, x, y]))
            polygons = replace(polygons, points=polygons.points + np.array([x, y]), gradients=gradients)
        if points is not None:
            points = replace(points, circles=points.circles + np.array([x, y, 0.0]))
        return replace(self, segments=self.segments + np.array([x, y, x, y]), polygons=polygons, points=points)

    def stroke(self, *, hidden: bool) -> Stroke:
        """Return how hidden or visible segments are drawn."""
        return self.hidden_stroke if hidden else self.visible_stroke

    def __post_init__(self) -> None:
        _require_coordinates(self.segments, "segments", 4)
        n = len(self.segments)
        for values, name in ((self.hidden, "hidden"), (self.dash_start, "dash_start")):
            if values.shape != (n,):
                raise ArgumentError.expecting(name, f"have shape ({n},)", values.shape)
        _require_in_range(self.dash_start, "dash_start")
        _require_colors(self.colors, n)


def _require_coordinates(values: FloatArray, name: str, columns: int) -> None:
    if values.ndim != 2 or values.shape[1] != columns:
        raise ArgumentError.expecting(name, f"have shape (n, {columns})", values.shape)
    _require_in_range(values, name)


def _require_in_range(values: FloatArray, name: str) -> None:
    if not np.isfinite(values).all():
        raise ArgumentError.expecting(name, "be finite", describe_first_non_finite(values))
    if np.abs(values).max(initial=0.0) > MAX_COORDINATE_PX:
        raise ArgumentError.expecting(name, f"lie within {MAX_COORDINATE_PX:g} pixels", f"{np.abs(values).max():g}")


def _require_colors(colors: FloatArray, n: int) -> None:
    if colors.shape not in {(1, 4), (n, 4)}:
        raise ArgumentError.expecting("colors", f"have shape (1, 4) or ({n}, 4)", colors.shape)
