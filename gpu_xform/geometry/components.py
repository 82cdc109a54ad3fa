"""Connected components of a graph whose edges are pairs of indices."""

import numpy as np

from .._core.types import IndexArray


def number_components(n: int, pairs: IndexArray) -> IndexArray:
    """Return the number of each node's component, from 0: nodes 0..n-1 that `pairs` (m, 2) join have one."""
    parent = np.arange(n)
    # Shiloach and Vishkin, "An O(log n) parallel connectivity algorithm", 1982: roots hook onto lower roots.
    while True:
        roots = parent[pairs]
        low, high = roots.min(axis=1), roots.max(axis=1)
        differs = low != high
        if not differs.any():
            return np.unique(parent, return_inverse=True)[1].astype(np.int64)
        np.minimum.at(parent, high[differs], low[differs])
        while ((grandparent := parent[parent]) != parent).any():
            parent = grandparent
