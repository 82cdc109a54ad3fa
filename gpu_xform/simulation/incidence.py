"""Incidence lists: the springs and the triangles of each point, packed as the step's shader gathers them."""

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray
from .spring_system import SpringSystem

SPRINGS_PER_PACKET = 4
WORDS_PER_PACKET = 3 * SPRINGS_PER_PACKET


def count_packets(system: SpringSystem) -> int:
    """Return how many packets hold the springs of the point that has most."""
    return -(-_max_count(system.pairs, system.n_points) // SPRINGS_PER_PACKET)


def pack_springs(system: SpringSystem) -> npt.NDArray[np.uint32]:
    """Return the springs of all points, packet by packet (p, n, 3, 4): other ends, then rest lengths and stiffnesses.

    The last two are float32 in the bits of uint32. An unused slot joins a point to itself, with stiffness 0.
    """
    n_points, n_slots = system.n_points, SPRINGS_PER_PACKET * count_packets(system)
    slots = np.zeros((n_points, 3, n_slots), np.uint32)
    slots[:, 0] = np.arange(n_points, dtype=np.uint32)[:, np.newaxis]
    points, others = system.pairs.T.ravel(), system.pairs[:, ::-1].T.ravel()
    order = np.lexsort((others, points))
    points, others, spring = points[order], others[order], np.tile(np.arange(len(system.pairs)), 2)[order]
    slot = _number_within(points, n_points)
    slots[points, 0, slot] = others
    slots[points, 1, slot] = system.rest.astype(np.float32).view(np.uint32)[spring]
    slots[points, 2, slot] = system.stiffness.astype(np.float32).view(np.uint32)[spring]
    packets = slots.reshape(n_points, 3, -1, SPRINGS_PER_PACKET).transpose(2, 0, 1, 3)
    return np.ascontiguousarray(packets)


def pack_fans(triangles: IndexArray, n_points: int) -> npt.NDArray[np.uint32]:
    """Return the other corners of the triangles around each point (f, n, 2); an unused slot names the point twice."""
    corners = np.concatenate([np.roll(triangles, -turn, axis=1) for turn in range(3)])
    order = np.lexsort((corners[:, 2], corners[:, 1], corners[:, 0]))
    corners = corners[order]
    fans = np.empty((_max_count(triangles, n_points), n_points, 2), np.uint32)
    fans[:] = np.arange(n_points, dtype=np.uint32)[:, np.newaxis]
    fans[_number_within(corners[:, 0], n_points), corners[:, 0]] = corners[:, 1:]
    return fans


def _max_count(indices: IndexArray, n_points: int) -> int:
    return int(np.bincount(indices.ravel(), minlength=n_points).max(initial=0))


def _number_within(points: IndexArray, n_points: int) -> IndexArray:
    """Return for each of sorted indices how many equal ones come before it."""
    counts = np.bincount(points, minlength=n_points)
    return np.arange(len(points)) - np.repeat(np.cumsum(counts) - counts, counts)
