"""Incidence lists: the springs and the triangles of each point, packed as the step's shader gathers them."""

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError
from ..geometry.mesh import pack_pairs, unpack_pairs
from ..gpu.layouts import SLOT_PACKET
from .spring_system import SpringSystem

SLOTS_PER_PACKET = 4
MAX_PACKETS = 8  # of slots that are alike for all points
MAX_LIST_BYTES = 1 << 30  # each point has as many slots as that with most springs
MAX_REST_SPREAD = 2.0**-22  # of rest lengths that count as one, relative: float32 has no more than two between them
LISTED_COST, ALIKE_COST, SHIFTED_COST = 1.2, 1.1, 1.0  # of a slot: lists take memory; lavapipe's times differ by less


class Slots(IntEnum):
    """How the shader finds the springs in the slots of a point."""

    LISTED = 0  # end, rest length and stiffness are listed for each point
    ALIKE = 1  # the ends are; all springs in a slot have one rest length and one stiffness
    SHIFTED = 2  # besides, their other ends are the same number of points ahead


@dataclass(frozen=True, eq=False)
class SpringSlots:
    """The springs of all points, in slots of which each point has the same number.

    kind : how they are found
    n_packets : of four slots per point
    springs : packet by packet, point by point, the other ends: uint32 (p, n, 4); for `Slots.LISTED` (p, n, 3, 4), with
        rest lengths and stiffnesses, float32 in the bits of uint32. An unused slot joins a point to itself.
    packets : `layouts.SLOT_PACKET` (p,); none for `Slots.LISTED`
    masks : a bit for each slot that a point uses, (n,) uint32; for `Slots.SHIFTED` only, which has no `springs`
    """

    kind: Slots
    n_packets: int
    springs: npt.NDArray[np.uint32]
    packets: npt.NDArray[np.void] = field(default_factory=lambda: np.zeros(0, SLOT_PACKET))
    masks: npt.NDArray[np.uint32] = field(default_factory=lambda: np.zeros(0, np.uint32))


@dataclass(frozen=True, eq=False)
class _Ends:
    """Both ends of every spring, sorted by point: (2s,) each."""

    points: IndexArray
    others: IndexArray
    rest: Float64Array
    stiffness: Float64Array


def pack_slots(system: SpringSystem) -> SpringSlots:
    """Return the springs in the kind of slots that costs the shader least.

    Cloth on a regular grid and equal strands of hair need few slots that are alike for all points, and no lists.
    """
    ends = _sort_ends(system)
    kinds, kind = np.unique(np.stack([ends.stiffness, ends.rest]), axis=1, return_inverse=True)
    keys, key = np.unique(np.stack([kind.ravel(), ends.others - ends.points]), axis=1, return_inverse=True)
    n_listed = _max_count(ends.points, system.n_points)
    per_kind = (
        [_max_count(ends.points[kind == k], system.n_points) for k in range(kinds.shape[1])] if _is_few(kinds) else []
    )
    costs = {Slots.LISTED: LISTED_COST * _pad(n_listed)}
    if _is_few(kinds) and sum(per_kind) <= SLOTS_PER_PACKET * MAX_PACKETS:
        costs[Slots.ALIKE] = ALIKE_COST * _pad(sum(per_kind))
    if _is_few(keys):
        costs[Slots.SHIFTED] = SHIFTED_COST * _pad(keys.shape[1])
    best = min(costs, key=lambda each: costs[each])
    if best is Slots.SHIFTED:
        return _pack_shifted(system.n_points, ends, kinds[:, keys[0]], keys[1], key.ravel())
    if best is Slots.ALIKE:
        return _pack_alike(system.n_points, ends, kinds, np.array(per_kind), kind.ravel())
    return _pack_listed(system.n_points, ends, n_listed)


def pack_fans(triangles: IndexArray, n_points: int) -> npt.NDArray[np.uint32]:
    """Return the other corners of the triangles around each point (f, n, 2); an unused slot names the point twice."""
    corners = np.concatenate([np.roll(triangles, -turn, axis=1) for turn in range(3)])
    order = np.lexsort((corners[:, 2], corners[:, 1], corners[:, 0]))
    corners = corners[order]
    fans = np.empty((_max_count(triangles, n_points), n_points, 2), np.uint32)
    fans[:] = np.arange(n_points, dtype=np.uint32)[:, np.newaxis]
    fans[_number_within(corners[:, 0], n_points), corners[:, 0]] = corners[:, 1:]
    return fans


def _sort_ends(system: SpringSystem) -> _Ends:
    """Return the ends of the springs; rest lengths that differ by less than float32 can say are made equal."""
    pairs, stiffness, rest = _merge_parallel(system)
    points, others = pairs.T.ravel(), pairs[:, ::-1].T.ravel()
    order = np.lexsort((others, points))
    spring = np.tile(np.arange(len(pairs)), 2)[order]
    return _Ends(points[order], others[order], _merge_close(rest)[spring], stiffness[spring])


def _merge_parallel(system: SpringSystem) -> tuple[IndexArray, Float64Array, Float64Array]:
    """Return the ends (s, 2), stiffness and rest length (s,) of springs of which no two join the same points.

    Parallel springs act as one: the sum of k (l - r) is K (l - R), with K the sum of k and R that of k r / K.
    """
    keys = pack_pairs(*system.pairs.T)
    distinct, spring = np.unique(keys, return_inverse=True)
    if len(distinct) == len(keys):
        return system.pairs, system.stiffness, system.rest
    spring = spring.ravel()
    stiffness = np.bincount(spring, system.stiffness).astype(np.float64)
    divisors = np.where(stiffness > 0.0, stiffness, 1.0)
    rest = np.bincount(spring, system.stiffness / divisors[spring] * system.rest).astype(np.float64)
    is_plain = (np.bincount(spring) == 1) | (stiffness == 0.0)
    rest[spring[is_plain[spring]]] = system.rest[is_plain[spring]]  # without rounding
    return unpack_pairs(distinct), stiffness, rest


def _merge_close(lengths: Float64Array) -> Float64Array:
    """Return lengths of which those within a part of `MAX_REST_SPREAD` are one."""
    if len(lengths) == 0:
        return lengths
    values, inverse = np.unique(lengths, return_inverse=True)
    first = 0
    for _ in range(SLOTS_PER_PACKET * MAX_PACKETS):
        end = int(np.searchsorted(values, values[first] * (1.0 + MAX_REST_SPREAD), side="right"))
        values[first:end] = values[(first + end) // 2]
        first = end
        if first == len(values):
            break
    else:
        return lengths  # they are too many for slots that are alike
    merged: Float64Array = values[inverse.ravel()]
    return merged


def _pack_listed(n_points: int, ends: _Ends, n_slots: int) -> SpringSlots:
    n_bytes = 12 * n_points * _pad(n_slots)
    if n_bytes > MAX_LIST_BYTES:
        most = MAX_LIST_BYTES // (12 * n_points * SLOTS_PER_PACKET) * SLOTS_PER_PACKET
        point = int(np.argmax(np.bincount(ends.points)))
        expected = f"be at most {most:,} per point, as {n_points:,} points have room for as many each"
        raise ArgumentError.expecting("springs", expected, f"{n_slots:,} for point {point}")
    slots = np.zeros((n_points, 3, _pad(n_slots)), np.uint32)
    slots[:, 0] = np.arange(n_points, dtype=np.uint32)[:, np.newaxis]
    slot = _number_within(ends.points, n_points)
    slots[ends.points, 0, slot] = ends.others
    slots[ends.points, 1, slot] = ends.rest.astype(np.float32).view(np.uint32)
    slots[ends.points, 2, slot] = ends.stiffness.astype(np.float32).view(np.uint32)
    packets = slots.reshape(n_points, 3, -1, SLOTS_PER_PACKET).transpose(2, 0, 1, 3)
    return SpringSlots(Slots.LISTED, packets.shape[0], np.ascontiguousarray(packets))


def _pack_alike(n_points: int, ends: _Ends, kinds: Float64Array, n_slots: IndexArray, kind: IndexArray) -> SpringSlots:
    """Pack into as many slots of each kind as the point with most springs of that kind needs."""
    slots = np.empty((n_points, _pad(int(n_slots.sum()))), np.uint32)
    slots[:] = np.arange(n_points, dtype=np.uint32)[:, np.newaxis]
    starts = np.cumsum(n_slots) - n_slots
    order = np.lexsort((ends.others, ends.points, kind))
    within = _number_within(kind[order] * n_points + ends.points[order], n_points * len(n_slots))
    slots[ends.points[order], starts[kind[order]] + within] = ends.others[order]
    packets = np.ascontiguousarray(slots.reshape(n_points, -1, SLOTS_PER_PACKET).transpose(1, 0, 2))
    columns = np.repeat(kinds, n_slots, axis=1)
    return SpringSlots(Slots.ALIKE, len(packets), packets, _describe(columns, np.zeros(columns.shape[1], np.int64)))


def _pack_shifted(
    n_points: int, ends: _Ends, columns: Float64Array, shifts: Float64Array, slot: IndexArray
) -> SpringSlots:
    masks = np.zeros(n_points, np.uint32)
    np.bitwise_or.at(masks, ends.points, np.uint32(1) << slot.astype(np.uint32))
    packets = _describe(columns, shifts)
    return SpringSlots(Slots.SHIFTED, len(packets), np.zeros((0, n_points, 4), np.uint32), packets, masks)


def _describe(columns: Float64Array, shifts: npt.NDArray[np.generic]) -> npt.NDArray[np.void]:
    """Return the packets of slots whose springs have the stiffnesses and rest lengths `columns` (2, s)."""
    n_slots = columns.shape[1]
    packets = np.zeros(_pad(n_slots) // SLOTS_PER_PACKET, SLOT_PACKET)
    for name, values in (("stiffness", columns[0]), ("rest", columns[1]), ("shift", shifts)):
        padded = np.zeros(_pad(n_slots))
        padded[:n_slots] = values
        packets[name] = padded.reshape(-1, SLOTS_PER_PACKET)
    return packets


def _is_few(columns: npt.NDArray[np.generic]) -> bool:
    return len(columns.T) <= SLOTS_PER_PACKET * MAX_PACKETS


def _pad(n_slots: int) -> int:
    return -(-n_slots // SLOTS_PER_PACKET) * SLOTS_PER_PACKET


def _max_count(indices: IndexArray, n_points: int) -> int:
    return int(np.bincount(indices.ravel(), minlength=n_points).max(initial=0))


def _number_within(points: IndexArray, n_points: int) -> IndexArray:
    """Return for each of sorted indices how many equal ones come before it."""
    counts = np.bincount(points, minlength=n_points)
    return np.arange(len(points)) - np.repeat(np.cumsum(counts) - counts, counts)
