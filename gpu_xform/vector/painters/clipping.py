"""Clipping of convex polygons by planes, and their split into bands of a value that changes across them."""

from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from ..._core.types import Float64Array
from .polygons import RaggedPolygons, concatenate, min_max, next_corner, select
from .ragged import to_offsets

HalfSpace: TypeAlias = Callable[[Float64Array], Float64Array]


def clip(polygons: RaggedPolygons, half_space: HalfSpace) -> RaggedPolygons:
    """Return the parts of convex polygons that lie in a half-space.

    half_space : (c, d) to (c,), linear in the corners; not negative inside
    """
    distances = half_space(polygons.corners)
    low, high = min_max(polygons, distances)
    polygons = select(polygons, high > 0.0)
    if not (low < 0.0).any():
        return polygons
    corners, distances, after = polygons.corners, half_space(polygons.corners), next_corner(polygons)
    is_in = distances >= 0.0
    is_crossing = is_in != is_in[after]
    share = np.zeros(len(corners))
    share[is_crossing] = (distances / np.where(is_crossing, distances - distances[after], 1.0))[is_crossing]
    crossings = corners + share[:, np.newaxis] * (corners[after] - corners)
    is_kept = np.stack([is_in, is_crossing], axis=1)
    sizes = np.add.reduceat(is_kept.sum(axis=1), polygons.offsets[:-1]) if len(corners) else np.empty(0, np.int64)
    clipped = RaggedPolygons(to_offsets(sizes), np.stack([corners, crossings], axis=1)[is_kept], polygons.owners)
    return select(clipped, sizes > 2)


def split_bands(polygons: RaggedPolygons, value: HalfSpace, levels: Float64Array) -> RaggedPolygons:
    """Split convex polygons at the isolines of a value (isobands).

    value : (c, d) to (c,), linear in the corners
    levels : (l,) the values to split at, ascending
    """
    low, high = min_max(polygons, value(polygons.corners))
    bounds = np.concatenate([[-np.inf], levels, [np.inf]])
    is_split = np.searchsorted(levels, low, "right") < np.searchsorted(levels, high, "left")
    parts = [select(polygons, ~is_split)]
    for first, last in pairwise(bounds.tolist()):
        touching = select(polygons, is_split & (low < last) & (high > first))
        above = touching if first == -np.inf else clip(touching, _above(value, first))
        parts.append(above if last == np.inf else clip(above, _below(value, last)))
    return concatenate(parts)


def _above(value: HalfSpace, lower: float) -> HalfSpace:
    return lambda corners: value(corners) - lower


def _below(value: HalfSpace, upper: float) -> HalfSpace:
    return lambda corners: upper - value(corners)
