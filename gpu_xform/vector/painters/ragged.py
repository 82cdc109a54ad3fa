"""Groups of rows, one after another: group i has the rows from offsets[i] to offsets[i + 1]."""

import numpy as np

from ..._core.types import IndexArray


def starts(sizes: IndexArray) -> IndexArray:
    """Return the offsets of groups of these sizes: (k + 1,)."""
    return np.concatenate([[0], np.cumsum(sizes)])


def members(offsets: IndexArray, which: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Return the rows of the groups `which` (k,), one group after the other, and the offsets (k + 1,) among them."""
    sizes = offsets[which + 1] - offsets[which]
    found = starts(sizes)
    return np.repeat(offsets[which] - found[:-1], sizes) + np.arange(found[-1]), found


def products(offsets: IndexArray, i: IndexArray, j: IndexArray) -> tuple[IndexArray, IndexArray, IndexArray]:
    """Return each row of group i with each row of group j, for pairs of groups (p,), and the pair that each is of."""
    sizes = np.diff(offsets)
    counts = sizes[i] * sizes[j]
    pair = np.repeat(np.arange(len(i)), counts)
    first, second = np.divmod(np.arange(len(pair)) - starts(counts)[pair], sizes[j][pair])
    return offsets[i][pair] + first, offsets[j][pair] + second, pair
