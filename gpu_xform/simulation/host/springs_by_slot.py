"""The springs of all points by slots, as the host's loops take them."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..._core.types import IndexArray
from ..incidence import SLOTS_PER_PACKET, Slots, SpringSlots

LISTED_POINTS_PER_BLOCK = 256  # whose springs are gathered into a processor's cache, and then computed many at a time
MAX_POINTS_ALONE = 2048  # that one thread steps sooner than others wake
MAX_SHIFTED_POINTS_PER_BLOCK, MIN_SHIFTED_POINTS_PER_BLOCK = 4096, 512
N_SHIFTED_BLOCKS = 16  # of smaller systems: shared evenly by up to as many threads
POINTS_ALIGNMENT = 16

Floats = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ShiftedSprings:
    """Slots that are alike for all points: each joins points to those a number of points ahead.

    pad : how many empty points lie before the first and after the last
    shifts, stiffness, rest : (s,)
    is_used : (s, n + 2 pad), whether a point has the spring
    """

    starts: IndexArray
    pad: int
    shifts: IndexArray
    stiffness: Floats
    rest: Floats
    is_used: npt.NDArray[np.bool_]

    @property
    def arguments(self) -> tuple[object, ...]:
        """What `step_shifted` takes of them."""
        return self.starts, self.pad, self.shifts, self.stiffness, self.rest, self.is_used

    def allocate(self, n_points: int) -> Floats:
        """Return an empty state, in which the same number of all points lies together."""
        return np.zeros((6, n_points + 2 * self.pad), np.float32)


@dataclass(frozen=True, eq=False)
class ListedSprings:
    """Slots in lists: each holds an end, a stiffness and a rest length for each point, (s, n); both ends have a slot.

    n_slots : how many of them the points of each block use
    """

    starts: IndexArray
    n_slots: IndexArray
    ends: npt.NDArray[np.uint32]
    stiffness: Floats
    rest: Floats

    pad = 0

    @property
    def arguments(self) -> tuple[object, ...]:
        """What `step_listed` takes of them."""
        return self.starts, self.n_slots, self.ends, self.stiffness, self.rest

    def allocate(self, n_points: int) -> Floats:
        """Return an empty state, in which all numbers of a point lie together."""
        return np.zeros((n_points, 8), np.float32).T


def arrange_springs(slots: SpringSlots, n_points: int) -> ShiftedSprings | ListedSprings:
    """Return the springs of slots that a point has, as they are found."""
    if slots.kind is Slots.SHIFTED:
        return _arrange_shifted(slots, n_points)
    return _arrange_listed(slots, n_points)


def _arrange_shifted(slots: SpringSlots, n_points: int) -> ShiftedSprings:
    """Of the two slots of a spring, take that of the first of its points."""
    shifts = slots.packets["shift"].ravel().astype(np.int64)
    ahead = np.flatnonzero(shifts > 0)
    pad = _align(int(shifts.max(initial=0)))
    is_used = np.zeros((len(ahead), n_points + 2 * pad), np.bool_)
    for row, slot in zip(is_used, ahead, strict=True):
        row[pad : pad + n_points] = (slots.masks >> np.uint32(slot)) & np.uint32(1)
    size = min(max(_align(n_points // N_SHIFTED_BLOCKS), MIN_SHIFTED_POINTS_PER_BLOCK), MAX_SHIFTED_POINTS_PER_BLOCK)
    return ShiftedSprings(
        _list_starts(n_points, size),
        pad,
        shifts[ahead],
        slots.packets["stiffness"].ravel()[ahead],
        slots.packets["rest"].ravel()[ahead],
        is_used,
    )


def _arrange_listed(slots: SpringSlots, n_points: int) -> ListedSprings:
    n_slots = SLOTS_PER_PACKET * slots.n_packets
    if slots.kind is Slots.LISTED:
        columns = np.ascontiguousarray(slots.springs.transpose(2, 0, 3, 1)).reshape(3, n_slots, n_points)
        ends, rest, stiffness = columns[0], columns[1].view(np.float32), columns[2].view(np.float32)
    else:
        ends = np.ascontiguousarray(slots.springs.transpose(0, 2, 1)).reshape(n_slots, n_points)
        rest = np.repeat(slots.packets["rest"].reshape(-1, 1), n_points, axis=1)
        stiffness = np.repeat(slots.packets["stiffness"].reshape(-1, 1), n_points, axis=1)
    starts = _list_starts(n_points, LISTED_POINTS_PER_BLOCK)
    last = np.zeros(n_points, np.int64)
    for slot, end in enumerate(ends):
        last[end != np.arange(n_points)] = slot + 1
    return ListedSprings(starts, np.maximum.reduceat(last, starts[:-1]), ends, stiffness, rest)


def _list_starts(n_points: int, size: int) -> IndexArray:
    """Return where each block of points begins, and where the last ends."""
    if n_points <= MAX_POINTS_ALONE:
        return np.array([0, n_points])
    return np.append(np.arange(0, n_points, size), n_points)


def _align(n_points: int) -> int:
    return -(-n_points // POINTS_ALIGNMENT) * POINTS_ALIGNMENT
