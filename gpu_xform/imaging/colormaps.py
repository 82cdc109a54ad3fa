"""Colormaps: scalars to colours."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array, as_vector
from .._core.masked import is_masked_array
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError
from .colors import to_rgba_array

ColormapLike: TypeAlias = str | Callable[[Float64Array], npt.ArrayLike]


def apply_colormap(
    scalars: npt.ArrayLike, cmap: ColormapLike, clim: Sequence[float] | None, n_points: int
) -> Float64Array:
    """Return the colour of each point: (n_points, 4) float64 in [0, 1], straight.

    scalars : (n_points,) numbers; NaN and masked values are transparent
    cmap : a name as in matplotlib, "viridis", or reversed, "viridis_r"; or a callable from numbers in [0, 1] (k,) to
        colours (k, 4)
    clim : (low, high), the scalars at the ends of the colormap; the extremes of `scalars` by default. Scalars beyond
        the limits take the colours of the ends. If both limits are equal, all points take the first colour.

    A colormap of matplotlib or of the package cmap is such a callable, and keeps its own colours for NaN and for
    scalars beyond the limits.
    """
    if is_masked_array(scalars):
        scalars = np.where(np.ma.getmaskarray(scalars), np.nan, scalars.data)
    numbers = as_real_array(scalars, "scalars", finite=False)
    if numbers.ndim != 1:
        raise ArgumentError.expecting("scalars", f"have shape ({n_points},)", numbers.shape)
    if len(numbers) != n_points:
        raise ArgumentError.expecting("scalars", f"have one number for each of the {n_points} points", len(numbers))
    colormap = _resolve_colormap(cmap)
    normalized = normalize_scalars(numbers, find_limits(numbers, clim))
    if hasattr(colormap, "with_extremes"):
        return to_rgba_array(colormap(normalized), "the colours from cmap", n_points, "points")
    colors = np.zeros((n_points, 4))
    is_number = ~np.isnan(normalized)
    if is_number.any():
        inside = np.clip(normalized[is_number], 0.0, 1.0)
        colors[is_number] = to_rgba_array(colormap(inside), "the colours from cmap", len(inside), "points")
    return colors


def tabulate_colormap(cmap: ColormapLike) -> Float64Array | None:
    """Return the colours of a named colormap, from its first to its last: (k, 4), straight; None for a callable.

    Of k colours, a scalar s in [0, 1] has the one of index floor(s * k), or the last.
    """
    if not isinstance(cmap, str):
        _resolve_colormap(cmap)
        return None
    colormap: Any = _resolve_colormap(cmap)
    n_colors: int = colormap.keywords["N"]
    return to_rgba_array(colormap((np.arange(n_colors) + 0.5) / n_colors), "the colours from cmap", n_colors, "colours")


def find_limits(numbers: npt.NDArray[Any], clim: Sequence[float] | None) -> tuple[float, float]:
    """Return the scalars at both ends of a colormap: `clim`, or the extremes of `numbers` (n,), finite or NaN."""
    kind = numbers.dtype if numbers.dtype.kind == "f" else np.dtype(np.float64)  # no integer is infinite
    low = np.fmin.reduce(numbers, initial=np.inf, dtype=kind)
    high = np.fmax.reduce(numbers, initial=-np.inf, dtype=kind)
    if np.isinf(high) or np.isinf(low):
        infinite = np.flatnonzero(np.isinf(numbers))
        if len(infinite):
            index = int(infinite[0])
            raise ArgumentError.expecting("scalars", "be finite or NaN", f"{numbers[index]} at index {index}")
    if clim is None:
        return (float(low), float(high)) if low <= high else (0.0, 0.0)
    low, high = as_vector(clim, "clim", 2).tolist()
    if low > high:
        raise ArgumentError.expecting(
            "clim", "be (low, high)", f"({low:g}, {high:g}); a cmap ending in '_r' is reversed"
        )
    return low, high


def normalize_scalars(numbers: Float64Array, limits: tuple[float, float]) -> Float64Array:
    """Return the numbers scaled so that the limits become 0 and 1."""
    low, high = (0.5 * limit for limit in limits)  # halves, because the whole range may overflow
    span = high - low
    if span == 0.0:
        return np.where(np.isnan(numbers), np.nan, 0.0)
    with np.errstate(over="ignore"):  # far beyond narrow limits a number becomes infinite, which is beyond them still
        return np.asarray((0.5 * numbers - low) / span)


def _resolve_colormap(cmap: ColormapLike) -> Callable[..., Any]:
    if not isinstance(cmap, str):
        if not callable(cmap):
            raise ArgumentTypeError.expecting("cmap", "be a colormap's name or a callable", type(cmap).__name__)
        return cmap
    from cmap import Colormap

    name = cmap.removesuffix("_r")
    try:
        full_name = Colormap.catalog().resolve(name)  # `Colormap` would log a warning for an ambiguous name
    except KeyError:
        hint = did_you_mean(name, Colormap.catalog().short_keys())
        raise ArgumentError.expecting("cmap", "be a colormap's name, such as 'viridis'", f"{cmap!r}{hint}") from None
    colormap = Colormap(full_name + cmap[len(name) :])
    return partial(colormap, N=max(256, len(colormap.color_stops)))
