"""Which of many boxes overlap: a tree of boxes, gone down in pairs."""

from typing import NamedTuple

import numpy as np

from ..._core.types import Float64Array, IndexArray

BITS = 12  # of each measure that boxes are sorted by


class _Level(NamedTuple):
    """Boxes of the tree: (2^k, d) their low and high corners, (2^k,) the least and the largest kind in each."""

    low: Float64Array
    high: Float64Array
    least: IndexArray
    largest: IndexArray


def overlapping(low: Float64Array, high: Float64Array, kinds: IndexArray, most: int) -> tuple[IndexArray, IndexArray]:
    """Return all pairs i < j of boxes, of different kinds, that overlap or touch.

    low, high : (n, d), no more than four dimensions
    kinds : (n,)
    most : pairs that there is room for; raises `OverflowError` where there are more
    """
    order = np.argsort(_places(low, high))
    levels = [_leaves(low[order], high[order], kinds[order])]
    while len(levels[-1].low) > 1:
        levels.append(_parents(levels[-1]))
    a = b = np.zeros(1, np.int64)
    for level in reversed(levels[:-1]):
        is_pair = a != b
        a, b = 2 * a, 2 * b
        a, b = np.concatenate([a, a, a[is_pair] + 1, a + 1]), np.concatenate([b, b + 1, b[is_pair], b + 1])
        met = (level.least[a] != level.largest[b]) | (level.least[b] != level.largest[a])
        for axis_low, axis_high in zip(level.low.T, level.high.T, strict=True):
            a, b = a[met], b[met]
            met = (axis_low[a] <= axis_high[b]) & (axis_low[b] <= axis_high[a])
        a, b = a[met], b[met]
        if len(a) > most:
            raise OverflowError(f"more than {most:,} pairs of boxes overlap")
    is_pair = a != b
    i, j = order[a[is_pair]], order[b[is_pair]]
    return np.minimum(i, j), np.maximum(i, j)


def _places(low: Float64Array, high: Float64Array) -> IndexArray:
    """Return numbers (n,), close for boxes that are close and about as large: Morton's order of middles and sizes."""
    measures = np.column_stack([low + high, (high - low).max(axis=1)])
    measures -= measures.min(axis=0, initial=np.inf)
    largest = measures.max(axis=0, initial=0.0)
    whole = (measures * ((1 << BITS) - 1) / np.where(largest > 0.0, largest, 1.0)).astype(np.int64)
    places = np.zeros(len(low), np.int64)
    for bit in range(BITS):
        for number, values in enumerate(whole.T):
            places |= ((values >> bit) & 1) << (bit * whole.shape[1] + number)
    return places


def _leaves(low: Float64Array, high: Float64Array, kinds: IndexArray) -> _Level:
    """Return the boxes, and as many more that nothing meets as make a power of two."""
    more = (0, (1 << max(len(low) - 1, 0).bit_length()) - len(low))
    numbers = np.iinfo(np.int64)
    return _Level(
        np.pad(low, (more, (0, 0)), constant_values=np.inf),
        np.pad(high, (more, (0, 0)), constant_values=-np.inf),
        np.pad(kinds, more, constant_values=numbers.max),
        np.pad(kinds, more, constant_values=numbers.min),
    )


def _parents(level: _Level) -> _Level:
    """Return what holds two neighbours each."""
    return _Level(
        np.minimum(level.low[::2], level.low[1::2]),
        np.maximum(level.high[::2], level.high[1::2]),
        np.minimum(level.least[::2], level.least[1::2]),
        np.maximum(level.largest[::2], level.largest[1::2]),
    )
