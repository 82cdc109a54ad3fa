"""Ragged arrays: groups of rows, one after another; group i has the rows from offsets[i] to offsets[i + 1]."""

import numpy as np

from ..._core.types import IndexArray


def to_offsets(sizes: IndexArray) -> IndexArray:
    """Return the offsets of groups of these sizes: (k + 1,)."""
    return np.concatenate([[0], np.cumsum(sizes)])


def rows_of(offsets: IndexArray, groups: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Return the rows of `groups` (k,), one group after another, and their offsets (k + 1,) in that list."""
    sizes = offsets[groups + 1] - offsets[groups]
    new_offsets = to_offsets(sizes)
    return np.repeat(offsets[groups] - new_offsets[:-1], sizes) + np.arange(new_offsets[-1]), new_offsets


def cross_join_groups(offsets: IndexArray, i: IndexArray, j: IndexArray) -> tuple[IndexArray, IndexArray, IndexArray]:
    """Pair each row of group i with each row of group j, for pairs of groups (p,).

    Returns the rows of the first groups, those of the second, and the index of the pair of groups, each (r,).
    """
    sizes = np.diff(offsets)
    counts = sizes[i] * sizes[j]
    pair = np.repeat(np.arange(len(i)), counts)
    first, second = np.divmod(np.arange(len(pair)) - to_offsets(counts)[pair], sizes[j][pair])
    return offsets[i][pair] + first, offsets[j][pair] + second, pair
