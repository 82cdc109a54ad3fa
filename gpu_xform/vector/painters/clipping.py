"""Polygons cut by planes: at the sides of the view, and into strips of what changes across them."""

from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from ..._core.types import Float64Array
from .polygons import Pieces, chosen, extremes, following, together
from .ragged import starts

Height: TypeAlias = Callable[[Float64Array], Float64Array]


def clipped(pieces: Pieces, height: Height) -> Pieces:
    """Return what of convex polygons lies where `height`, linear in the corners, is not negative; (c, d) to (c,)."""
    heights = height(pieces.corners)
    low, high = extremes(pieces, heights)
    pieces = chosen(pieces, high > 0.0)
    if not (low < 0.0).any():
        return pieces
    corners, heights, after = pieces.corners, height(pieces.corners), following(pieces)
    is_in = heights >= 0.0
    is_crossing = is_in != is_in[after]
    share = np.zeros(len(corners))
    share[is_crossing] = (heights / np.where(is_crossing, heights - heights[after], 1.0))[is_crossing]
    crossings = corners + share[:, np.newaxis] * (corners[after] - corners)
    is_left = np.stack([is_in, is_crossing], axis=1)
    sizes = np.add.reduceat(is_left.sum(axis=1), pieces.offsets[:-1]) if len(corners) else np.empty(0, np.int64)
    cut = Pieces(starts(sizes), np.stack([corners, crossings], axis=1)[is_left], pieces.owners)
    return chosen(cut, sizes > 2)


def strips(pieces: Pieces, value: Height, levels: Float64Array) -> Pieces:
    """Return convex polygons cut wherever `value`, linear in the corners, is one of `levels`, which ascend.

    value : (c, d) to (c,)
    """
    low, high = extremes(pieces, value(pieces.corners))
    bounds = np.concatenate([[-np.inf], levels, [np.inf]])
    is_cut = np.searchsorted(levels, low, "right") < np.searchsorted(levels, high, "left")
    parts = [chosen(pieces, ~is_cut)]
    for first, last in pairwise(bounds.tolist()):
        reaching = chosen(pieces, is_cut & (low < last) & (high > first))
        above = reaching if first == -np.inf else clipped(reaching, _above(value, first))
        parts.append(above if last == np.inf else clipped(above, _below(value, last)))
    return together(parts)


def _above(value: Height, least: float) -> Height:
    return lambda corners: value(corners) - least


def _below(value: Height, most: float) -> Height:
    return lambda corners: most - value(corners)
