"""What comes before what, and what cannot be put in order because it goes round in a circle."""

import numpy as np

from ..._core.types import BoolArray, IndexArray
from .ragged import members


def levels(n: int, before: IndexArray, after: IndexArray) -> IndexArray:
    """Return a number for each of n things, less for each of `before` (e,) than for its `after` (e,): (n,).

    It is -1 for what is in a circle, and for all that comes after one.
    """
    found = np.full(n, -1)
    waiting = np.bincount(after, minlength=n)
    order = np.argsort(before, kind="stable")
    followers = after[order]
    offsets = np.searchsorted(before[order], np.arange(n + 1))
    ready, level = np.flatnonzero(waiting == 0), 0
    while len(ready):
        found[ready] = level
        following = followers[members(offsets, ready)[0]]
        np.subtract.at(waiting, following, 1)
        ready, level = np.unique(following[waiting[following] == 0]), level + 1
    return found


def knotted(n: int, before: IndexArray, after: IndexArray) -> BoolArray:
    """Tell which of n things are in a circle, or after one and before another: (n,)."""
    left = levels(n, before, after) < 0
    both = left[before] & left[after]
    return left & (levels(n, after[both], before[both]) < 0)


def circles(before: IndexArray, after: IndexArray) -> list[list[int]]:
    """Return circles that have nothing in common, so many that what is in none of them makes no other."""
    followers: dict[int, list[int]] = {}
    for thing, follower in zip(before.tolist(), after.tolist(), strict=True):
        followers.setdefault(thing, []).append(follower)
    found: list[list[int]] = []
    done = set[int]()
    for start in followers:
        way = [] if start in done else [start]
        place = {start: 0}
        while way:
            left = followers.get(way[-1], [])
            while left and left[-1] in done:
                left.pop()
            if left and left[-1] not in place:
                place[left[-1]] = len(way)
                way.append(left[-1])
                continue
            first = place[left[-1]] if left else len(way) - 1
            if left:
                found.append(way[first:])
            for thing in way[first:]:
                del place[thing]
            done.update(way[first:])
            del way[first:]
    return found
