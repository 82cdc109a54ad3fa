"""Chains: edges that follow one another without a corner, along which dashes run on from edge to edge."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from .edges import merge_coincident_points

MAX_TURN_DEGREES = 50.0  # of a curve from one edge to the next: an octagon is round, the corners of a hexagon are sharp
MAX_CHAIN_EDGES = 1 << 20  # of a longer chain, the next begins
_MAX_EDGES_AT_POINT = 64  # where more meet, as at the tip of a cone, none of them goes on
_MAX_COMPARISONS = 1 << 20  # of directions at once


class Chains(NamedTuple):
    """Edges in the order in which chains pass them.

    edges : (m,) int64, rows of the edges, those of a chain one after the other
    is_first : (m,) bool, a chain begins with the edge
    is_reversed : (m,) bool, the chain passes the edge from its second point to its first
    """

    edges: IndexArray
    is_first: npt.NDArray[np.bool_]
    is_reversed: npt.NDArray[np.bool_]


def find_chains(
    edges: IndexArray, positions: Float64Array | None, max_turn_degrees: float = MAX_TURN_DEGREES
) -> Chains:
    """Join edges (m, 2) into chains.

    positions : (n, 3); points at one place count as one point, as files of separate triangles have them. None if they
        are not known: then chains end where more than two edges meet, and turn by any angle

    max_turn_degrees : from one edge to the next

    A chain goes straight on: where edges meet, two that are each other's most opposite are joined. It does not depend
    on a view, so dashes do not jump from frame to frame. Each begins at the end towards which the first point of its
    first edge lies, a closed one at that point.
    """
    if len(edges) == 0:
        return Chains(np.empty(0, np.int64), np.empty(0, np.bool_), np.empty(0, np.bool_))
    return _walk(_join_ends(edges, positions, -math.cos(math.radians(max_turn_degrees))))


def _join_ends(edges: IndexArray, positions: Float64Array | None, max_cosine: float) -> npt.NDArray[np.int64]:
    """Return, for each end of an edge, the end of another with which the chain goes on, or -1: (2m,).

    max_cosine : of the angle between the directions from a point along two edges that are joined

    Ends 2i and 2i + 1 are those of edge i.
    """
    points = (edges if positions is None else merge_coincident_points(positions, edges)).ravel()
    partner = np.full(len(points), -1)
    order = np.argsort(points, kind="stable")
    starts = np.flatnonzero(np.diff(points[order], prepend=-1))
    directions = None if positions is None else _directions(edges, positions)
    n_ends = np.diff(starts, append=len(order))
    for k in np.unique(n_ends[(n_ends > 1) & (n_ends <= _MAX_EDGES_AT_POINT)]).tolist():
        ends = order[starts[n_ends == k][:, np.newaxis] + np.arange(k)]
        if directions is None:
            partner[ends] = ends[:, ::-1] if k == 2 else -1
            continue
        rows = max(_MAX_COMPARISONS // k**2, 1)
        for first in range(0, len(ends), rows):
            _join_most_opposite(ends[first : first + rows], directions, max_cosine, partner)
    is_loop = partner == np.arange(len(partner)) ^ 1  # an edge from a point to itself
    partner[is_loop] = -1
    return partner


def _directions(edges: IndexArray, positions: Float64Array) -> npt.NDArray[np.float32]:
    """Return the unit vector from each end of an edge towards the other, (2m, 3); zero for an edge without length."""
    along = 0.5 * positions[edges[:, 1]] - 0.5 * positions[edges[:, 0]]  # halves, whose difference cannot overflow
    largest = np.abs(along).max(axis=1, keepdims=True)
    along /= np.where(largest > 0.0, largest, 1.0)
    lengths = np.sqrt(np.einsum("ij,ij->i", along, along))[:, np.newaxis]
    along /= np.where(lengths > 0.0, lengths, 1.0)
    return np.stack([along, -along], axis=1).reshape(-1, 3).astype(np.float32)


def _join_most_opposite(
    ends: IndexArray, directions: npt.NDArray[np.float32], max_cosine: float, partner: npt.NDArray[np.int64]
) -> None:
    """Join, of the ends (g, d) that meet in g points, those that are each other's most opposite."""
    towards = directions[ends]
    cosines = towards @ towards.swapaxes(1, 2)
    diagonal = np.arange(ends.shape[1])
    cosines[:, diagonal, diagonal] = np.inf
    best = cosines.argmin(axis=2)
    is_straight = np.take_along_axis(cosines, best[..., np.newaxis], axis=2)[..., 0] <= max_cosine
    is_mutual = np.take_along_axis(best, best, axis=1) == diagonal
    joined = is_straight & is_mutual
    partner[ends[joined]] = np.take_along_axis(ends, best, axis=1)[joined]


def _walk(partners: npt.NDArray[np.int64]) -> Chains:
    """Follow the joined ends (2m,) through all edges."""
    n = len(partners) // 2
    order = np.empty(n, np.int64)
    is_first, is_reversed = np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    # Views of memory are as quick to step through as lists, which would take eight times as many bytes.
    partner, ordered, first, reverse = partners.data, order.data, is_first.data, is_reversed.data
    is_done = bytearray(n)
    place = 0
    for edge in range(n):
        if is_done[edge]:
            continue
        end = 2 * edge
        while (before := partner[end]) >= 0 and before ^ 1 != 2 * edge:
            end = before ^ 1
        if before >= 0:
            end = 2 * edge  # the chain is closed
        begin = place
        while end >= 0 and not is_done[end >> 1]:
            is_done[end >> 1] = 1
            ordered[place] = end >> 1
            first[place] = (place - begin) % MAX_CHAIN_EDGES == 0
            reverse[place] = end & 1
            place += 1
            end = partner[end ^ 1]
    return Chains(order, is_first, is_reversed)
