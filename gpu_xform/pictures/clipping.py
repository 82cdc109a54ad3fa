"""Polygons in clip space, cut by planes: at the sides of the view, and into strips of what changes across them."""

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._arguments import Float64Array

Height: TypeAlias = Callable[[Float64Array], Float64Array]


class Pieces(NamedTuple):
    """Polygons, and what each is a piece of.

    offsets : (k + 1,); polygon i has the corners from offsets[i] to offsets[i + 1], at least three
    corners : (c, 4), in clip space
    owners : (k,)
    """

    offsets: npt.NDArray[np.int64]
    corners: Float64Array
    owners: npt.NDArray[np.int64]


def chosen(pieces: Pieces, which: npt.NDArray[np.bool_]) -> Pieces:
    """Return some of the polygons: which (k,)."""
    sizes = np.diff(pieces.offsets)
    offsets = np.concatenate([[0], np.cumsum(sizes[which])])
    return Pieces(offsets, pieces.corners[np.repeat(which, sizes)], pieces.owners[which])


def together(parts: list[Pieces]) -> Pieces:
    """Return all polygons of several, one after another."""
    sizes = np.concatenate([np.diff(part.offsets) for part in parts])
    return Pieces(
        np.concatenate([[0], np.cumsum(sizes)]),
        np.concatenate([part.corners for part in parts]),
        np.concatenate([part.owners for part in parts]),
    )


def extremes(pieces: Pieces, values: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the least and the largest of the values (c,) at the corners of each polygon."""
    starts = pieces.offsets[:-1]
    if len(starts) == 0:
        return np.empty(0), np.empty(0)
    return np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)


def clipped(pieces: Pieces, height: Height) -> Pieces:
    """Return what of convex polygons lies where `height`, linear in clip space, is not negative; (c, 4) to (c,)."""
    heights = height(pieces.corners)
    low, high = extremes(pieces, heights)
    pieces = chosen(pieces, high > 0.0)
    if not (low < 0.0).any():
        return pieces
    corners, heights = pieces.corners, height(pieces.corners)
    following = np.arange(1, len(corners) + 1)
    following[pieces.offsets[1:] - 1] = pieces.offsets[:-1]
    is_in = heights >= 0.0
    is_crossing = is_in != is_in[following]
    share = np.zeros(len(corners))
    share[is_crossing] = (heights / np.where(is_crossing, heights - heights[following], 1.0))[is_crossing]
    crossings = corners + share[:, np.newaxis] * (corners[following] - corners)
    is_left = np.stack([is_in, is_crossing], axis=1)
    sizes = np.add.reduceat(is_left.sum(axis=1), pieces.offsets[:-1]) if len(corners) else np.empty(0, np.int64)
    cut = Pieces(
        np.concatenate([[0], np.cumsum(sizes)]),
        np.stack([corners, crossings], axis=1)[is_left],
        pieces.owners,
    )
    return chosen(cut, sizes > 2)


def strips(pieces: Pieces, value: Height, levels: Float64Array) -> Pieces:
    """Return convex polygons cut wherever `value`, linear in clip space, is one of `levels`, which ascend.

    value : (c, 4) to (c,)
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
