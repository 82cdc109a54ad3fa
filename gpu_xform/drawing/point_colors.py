"""Colours of the points of a cloud: one for all, or one per point, which may come from a scalar through a colormap."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.masked import require_whole
from ..errors import ArgumentError
from ..imaging.colormaps import apply_colormap, find_limits, normalize_scalars, tabulate_colormap
from ..imaging.colors import Rgba, pack_rgba8, to_rgba, to_rgba_array
from .layer import Layer
from .layer_colors import BLACK, OPAQUE, PackedColors


class Coloring(IntEnum):
    """What the colour of a point comes from; the numbers are the WGSL constants `COLORING_*`."""

    UNIFORM = 0
    COORDINATE = 1
    SCALAR = 2
    PACKED = 3


@dataclass(frozen=True)
class PointColors:
    """The colours of points.

    uniform : straight alpha, if the coloring is that
    colormap : packed, straight alpha
    axis : the coordinate that goes through the colormap, if the coloring is that
    limits : the scalars at both ends of the colormap; None for the extremes of the coordinate
    values : returns the numbers or packed colours of a slice of the points, 32 bits each, if they have such
    """

    coloring: Coloring
    uniform: Rgba = BLACK
    colormap: PackedColors = field(default_factory=lambda: np.zeros(1, np.uint32))
    axis: int = 0
    limits: tuple[float, float] | None = None
    values: Callable[[slice], npt.NDArray[np.uint32]] | None = None

    @property
    def has_transparency(self) -> bool:
        """Whether some colours may be transparent."""
        is_mapped = self.coloring is Coloring.COORDINATE
        return bool((self.colormap < OPAQUE).any()) if is_mapped else self.coloring is not Coloring.UNIFORM


def point_colors(layer: Layer, positions: npt.NDArray[Any]) -> PointColors:
    """Return the colours that `layer` asks for, for points at `positions` (n, 3). Raises as `line_colors` does."""
    n_points = len(positions)
    if layer.vertex_colors is not None:
        return _pack_colors(layer.vertex_colors, n_points)
    if layer.scalars is None:
        return PointColors(Coloring.UNIFORM, uniform=to_rgba(layer.color, "color"))
    scalars: Any = layer.scalars
    colormap = tabulate_colormap(layer.cmap)
    if colormap is None:  # a function that only knows what it makes of numbers
        return _pack_colors(apply_colormap(scalars, layer.cmap, layer.clim, n_points), n_points)
    table = pack_rgba8(colormap)
    axis = find_axis(scalars, positions)
    if axis is not None:
        limits = None if layer.clim is None else find_limits(np.empty(0), layer.clim)
        return PointColors(Coloring.COORDINATE, colormap=table, axis=axis, limits=limits)
    numbers = _require_scalars(scalars, n_points)
    limits = find_limits(numbers, layer.clim)

    def values(part: slice) -> npt.NDArray[np.uint32]:
        return normalize_scalars(np.asarray(numbers[part], np.float64), limits).astype(np.float32).view(np.uint32)

    return PointColors(Coloring.SCALAR, colormap=table, limits=limits, values=values)


def find_axis(scalars: object, positions: npt.NDArray[Any]) -> int | None:
    """Return which coordinate of `positions` (n, 3) the scalars are, if they are a view of one; else None."""
    if not isinstance(scalars, np.ndarray) or scalars.dtype != positions.dtype or scalars.shape != positions.shape[:1]:
        return None
    if scalars.strides != positions.strides[:1]:
        return None
    start = scalars.__array_interface__["data"][0]
    axes = [i for i in range(3) if positions[:1, i].__array_interface__["data"][0] == start]
    return axes[0] if axes else None


def _pack_colors(colors: Any, n_points: int) -> PointColors:
    if isinstance(colors, np.ndarray) and colors.ndim == 2 and len(colors) == n_points:

        def values(part: slice) -> npt.NDArray[np.uint32]:
            rows = colors[part]
            return pack_rgba8(to_rgba_array(rows, "vertex_colors", len(rows), "points"))

        return PointColors(Coloring.PACKED, values=values)
    packed = pack_rgba8(to_rgba_array(colors, "vertex_colors", n_points, "points"))
    return PointColors(Coloring.PACKED, values=packed.__getitem__)


def _require_scalars(scalars: Any, n_points: int) -> npt.NDArray[Any]:
    """Return scalars (n_points,), finite or NaN."""
    if isinstance(scalars, np.ma.MaskedArray):
        scalars = np.where(np.ma.getmaskarray(scalars), np.nan, scalars.data)
    else:
        require_whole(scalars, "scalars")
    numbers = np.asarray(scalars)
    if numbers.dtype.kind not in "fiu" or numbers.shape != (n_points,):
        apply_colormap(scalars, "viridis", None, n_points)  # raises
        raise ArgumentError.expecting("scalars", f"have shape ({n_points},)", numbers.shape)
    return numbers
