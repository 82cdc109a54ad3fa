"""Bounding volume hierarchy of boxes, which finds all pairs that overlap."""

from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array, IndexArray

BITS_PER_MEASURE = 12  # of the Morton codes


class _Level(NamedTuple):
    """One level of the tree: the boxes of its 2^k nodes.

    low, high : (2^k, d) the corners
    min_kind, max_kind : (2^k,) of the boxes below each node
    """

    low: Float64Array
    high: Float64Array
    min_kind: IndexArray
    max_kind: IndexArray


def find_overlapping_boxes(
    low: Float64Array, high: Float64Array, kinds: IndexArray, max_pairs: int
) -> tuple[IndexArray, IndexArray]:
    """Return all pairs i < j of boxes of different kinds that overlap or touch.

    low, high : (n, d) the corners, in at most four dimensions
    kinds : (n,)

    Raises `OverflowError` for more than `max_pairs` pairs.
    """
    order = np.argsort(_morton_codes(low, high))
    levels = [_leaves(low[order], high[order], kinds[order])]
    while len(levels[-1].low) > 1:
        levels.append(_parents(levels[-1]))
    a = b = np.zeros(1, np.int64)
    for level in reversed(levels[:-1]):
        is_pair = a != b
        a, b = 2 * a, 2 * b
        a, b = np.concatenate([a, a, a[is_pair] + 1, a + 1]), np.concatenate([b, b + 1, b[is_pair], b + 1])
        meets = (level.min_kind[a] != level.max_kind[b]) | (level.min_kind[b] != level.max_kind[a])
        for axis_low, axis_high in zip(level.low.T, level.high.T, strict=True):
            a, b = a[meets], b[meets]
            meets = (axis_low[a] <= axis_high[b]) & (axis_low[b] <= axis_high[a])
        a, b = a[meets], b[meets]
        if len(a) > max_pairs:
            raise OverflowError(f"more than {max_pairs:,} pairs of boxes overlap")
    is_pair = a != b
    i, j = order[a[is_pair]], order[b[is_pair]]
    return np.minimum(i, j), np.maximum(i, j)


def _morton_codes(low: Float64Array, high: Float64Array) -> IndexArray:
    """Return the Morton codes (n,) of the centres and sizes of boxes: close for boxes that are close and alike."""
    measures = np.column_stack([low + high, (high - low).max(axis=1)])
    measures -= measures.min(axis=0, initial=np.inf)
    largest = measures.max(axis=0, initial=0.0)
    quantized = (measures * ((1 << BITS_PER_MEASURE) - 1) / np.where(largest > 0.0, largest, 1.0)).astype(np.int64)
    codes = np.zeros(len(low), np.int64)
    for bit in range(BITS_PER_MEASURE):
        for column, values in enumerate(quantized.T):
            codes |= ((values >> bit) & 1) << (bit * quantized.shape[1] + column)
    return codes


def _leaves(low: Float64Array, high: Float64Array, kinds: IndexArray) -> _Level:
    """Return the boxes, padded to a power of two with boxes that overlap nothing."""
    padding = (0, (1 << max(len(low) - 1, 0).bit_length()) - len(low))
    limits = np.iinfo(np.int64)
    return _Level(
        np.pad(low, (padding, (0, 0)), constant_values=np.inf),
        np.pad(high, (padding, (0, 0)), constant_values=-np.inf),
        np.pad(kinds, padding, constant_values=limits.max),
        np.pad(kinds, padding, constant_values=limits.min),
    )


def _parents(level: _Level) -> _Level:
    """Return the boxes around each two neighbours."""
    return _Level(
        np.minimum(level.low[::2], level.low[1::2]),
        np.maximum(level.high[::2], level.high[1::2]),
        np.minimum(level.min_kind[::2], level.min_kind[1::2]),
        np.maximum(level.max_kind[::2], level.max_kind[1::2]),
    )
