"""Chains of edges for the device, which measures how far along them each edge begins, so that dashes run on."""

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..geometry.chains import MAX_TURN_DEGREES, find_chains
from ..gpu.layouts import CHAIN_EDGE
from .draw_list import NO_POINT

# Beside the number of an edge.
CHAIN_IS_FIRST = np.uint32(1 << 31)  # of its chain
CHAIN_IS_REVERSED = np.uint32(1 << 30)  # the chain passes the edge from its second point to its first


def pack_chains(
    edges: IndexArray, positions: Float64Array | None, batch_size: int, max_turn_degrees: float = MAX_TURN_DEGREES
) -> npt.NDArray[np.void]:
    """Return the edges of each batch in the order of their chains: `layouts.CHAIN_EDGE` (m,).

    edges : (m, 2) indices of points, or two `NO_POINT` for an edge that is not there, which is a chain of its own
    positions : (n, 3) of the points; None if they are not known
    batch_size : edges that are drawn together; chains end where a batch does
    max_turn_degrees : from one edge of a chain to the next
    """
    packed = np.empty(len(edges), CHAIN_EDGE)
    for start in range(0, len(edges), batch_size):
        batch = edges[start : start + batch_size]
        is_there = batch[:, 0] != NO_POINT
        rows = np.flatnonzero(is_there)
        chains = find_chains(batch[rows], positions, max_turn_degrees)
        part = packed[start : start + len(batch)]
        there, rest = np.split(part, [len(rows)])
        there["edge"] = rows[chains.edges]
        points = batch[rows[chains.edges]]
        points[chains.is_reversed] = points[chains.is_reversed, ::-1]
        there["start"], there["end"] = points.T
        there["edge"][chains.is_first] |= CHAIN_IS_FIRST
        there["edge"][chains.is_reversed] |= CHAIN_IS_REVERSED
        rest["edge"] = np.flatnonzero(~is_there) | CHAIN_IS_FIRST
        rest["start"] = rest["end"] = NO_POINT
    return packed
