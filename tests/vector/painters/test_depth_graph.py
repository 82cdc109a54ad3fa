"""Topological levels and cycles, beside what the standard library and closures of relations say of them."""

from graphlib import CycleError, TopologicalSorter
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.vector.painters.depth_graph import find_cycles, in_cycle, topological_levels

Relation = npt.NDArray[np.int64]

N = 12
RELATIONS = st.lists(st.tuples(st.integers(0, N - 1), st.integers(0, N - 1)), max_size=40).map(
    lambda pairs: np.array(pairs, np.int64).reshape(-1, 2)
)


def reached(relation: Relation) -> npt.NDArray[np.bool_]:
    """Return what is reached from what by one step or more: (N, N)."""
    found = np.zeros((N, N), np.bool_)
    found[relation[:, 0], relation[:, 1]] = True
    for middle in range(N):
        found |= found[:, middle, None] & found[middle]
    return found


@given(RELATIONS)
def test_levels_rise_and_what_follows_a_cycle_has_none(relation: Relation) -> None:
    found = topological_levels(N, *relation.T)
    reach = reached(relation)
    is_in_cycle = reach.diagonal()
    assert ((found < 0) == (is_in_cycle | reach[is_in_cycle].any(axis=0))).all()
    settled = relation[(found[relation] >= 0).all(axis=1)]
    assert (found[settled[:, 0]] < found[settled[:, 1]]).all()


@given(RELATIONS)
def test_in_cycle_holds_for_cycles_and_what_is_between_them(relation: Relation) -> None:
    reach = reached(relation)
    is_in_cycle = reach.diagonal()
    after, before = is_in_cycle | reach[is_in_cycle].any(axis=0), is_in_cycle | reach[:, is_in_cycle].any(axis=1)
    assert (in_cycle(N, *relation.T) == (after & before)).all()


@given(RELATIONS)
def test_cycles_are_disjoint_and_leave_no_other(relation: Relation) -> None:
    found = find_cycles(*relation.T)
    steps = set(map(tuple, relation.tolist()))
    for cycle in found:
        assert all(step in steps for step in pairwise([*cycle, cycle[0]]))
    nodes = [node for cycle in found for node in cycle]
    assert len(nodes) == len(set(nodes))
    graph: dict[int, set[int]] = {}
    for before, after in steps:
        if before not in nodes and after not in nodes:
            graph.setdefault(after, set()).add(before)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        raise AssertionError("a cycle is left") from error


def test_nothing_has_no_order() -> None:
    nothing = np.empty(0, np.int64)
    assert topological_levels(0, nothing, nothing).shape == (0,)
    assert topological_levels(3, nothing, nothing).tolist() == [0, 0, 0]
    assert not in_cycle(3, nothing, nothing).any()
    assert find_cycles(nothing, nothing) == []
