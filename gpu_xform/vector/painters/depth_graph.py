"""Occlusion graph: its topological levels, and the cycles that leave it without an order."""

import numpy as np

from ..._core.types import BoolArray, IndexArray
from .ragged import rows_of


def topological_levels(n: int, before: IndexArray, after: IndexArray) -> IndexArray:
    """Return a level for each of n nodes, lower for `before` (e,) than for `after` (e,) of each edge: (n,).

    It is -1 for the nodes of cycles, and for all that come after one.
    """
    levels = np.full(n, -1)
    waiting = np.bincount(after, minlength=n)
    order = np.argsort(before, kind="stable")
    successors = after[order]
    offsets = np.searchsorted(before[order], np.arange(n + 1))
    ready, level = np.flatnonzero(waiting == 0), 0
    while len(ready):
        levels[ready] = level
        reached = successors[rows_of(offsets, ready)[0]]
        np.subtract.at(waiting, reached, 1)
        ready, level = np.unique(reached[waiting[reached] == 0]), level + 1
    return levels


def in_cycle(n: int, before: IndexArray, after: IndexArray) -> BoolArray:
    """Tell which of n nodes are in a cycle, or come after one and before another: (n,)."""
    unordered = topological_levels(n, before, after) < 0
    both = unordered[before] & unordered[after]
    return unordered & (topological_levels(n, after[both], before[both]) < 0)


def find_cycles(before: IndexArray, after: IndexArray) -> list[list[int]]:
    """Return disjoint cycles, enough that the nodes outside them form no other; by depth-first search."""
    successors: dict[int, list[int]] = {}
    for node, successor in zip(before.tolist(), after.tolist(), strict=True):
        successors.setdefault(node, []).append(successor)
    cycles: list[list[int]] = []
    done = set[int]()
    for start in successors:
        path = [] if start in done else [start]
        position = {start: 0}
        while path:
            waiting = successors.get(path[-1], [])
            while waiting and waiting[-1] in done:
                waiting.pop()
            if waiting and waiting[-1] not in position:
                position[waiting[-1]] = len(path)
                path.append(waiting[-1])
                continue
            first = position[waiting[-1]] if waiting else len(path) - 1
            if waiting:
                cycles.append(path[first:])
            for node in path[first:]:
                del position[node]
            done.update(path[first:])
            del path[first:]
    return cycles
