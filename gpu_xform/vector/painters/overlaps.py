"""Occlusion of two polygons that overlap in the picture: which is before the other."""

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._core.types import BoolArray, Float64Array, IndexArray
from .ragged import cross_join_groups

Occlusion: TypeAlias = npt.NDArray[np.uint8]

BEFORE, BEHIND, COPLANAR = np.uint8(1), np.uint8(2), np.uint8(4)  # bits of `Occlusion`

MIN_OVERLAP_PX = 0.1  # smaller overlaps and penetrations are not visible
EDGE_EPSILON_PX = 1e-6  # round-off of distances: two sides on one line do not cross
DEPTH_RTOL = 1e-6  # depths that differ by less are equal; as in the shaders
PAIRS_PER_CHUNK = 1 << 13  # their numbers stay in a cache


class Facets(NamedTuple):
    """Triangles of polygons in the picture, all of one winding; polygon i has those from offsets[i] to offsets[i + 1].

    The components come first, because NumPy is slow at short axes.

    x, y, depth : (3, t) of the corners, in pixels, and reversed-Z depth
    normal_x, normal_y : (3, t) of the inward normal of the side from each corner to the next; its length is 1, or 0 if
        the triangle is too narrow to be seen
    slope : (2, t) of the depth along x and y
    """

    offsets: IndexArray
    x: Float64Array
    y: Float64Array
    depth: Float64Array
    normal_x: Float64Array
    normal_y: Float64Array
    slope: Float64Array


class Overlaps(NamedTuple):
    """Pairs of polygons i and j (p,) that overlap, and the occlusion of each: BEFORE, BEHIND, both, or COPLANAR.

    BEFORE : i is nearer than j somewhere
    BEHIND : j is nearer than i somewhere
    COPLANAR : they lie in one plane
    """

    i: IndexArray
    j: IndexArray
    occlusion: Occlusion

    @property
    def farther_nearer(self) -> tuple[IndexArray, IndexArray]:
        """The farther and the nearer polygon of each occlusion; of two in one plane, j is the nearer."""
        is_before, is_behind = (self.occlusion & BEFORE) > 0, (self.occlusion & (BEHIND | COPLANAR)) > 0
        farther = np.concatenate([self.j[is_before], self.i[is_behind]])
        nearer = np.concatenate([self.i[is_before], self.j[is_behind]])
        return farther, nearer

    @property
    def intersecting(self) -> BoolArray:
        """Whether each polygon of a pair is before the other somewhere."""
        both: BoolArray = self.occlusion == BEFORE | BEHIND
        return both

    def selected(self, mask: BoolArray) -> "Overlaps":
        """Return the pairs for which `mask` (p,) is true."""
        return Overlaps(self.i[mask], self.j[mask], self.occlusion[mask])

    def joined(self, others: "Overlaps") -> "Overlaps":
        """Return these pairs and others."""
        i, j = np.concatenate([self.i, others.i]), np.concatenate([self.j, others.j])
        return Overlaps(i, j, np.concatenate([self.occlusion, others.occlusion]))


def make_facets(offsets: IndexArray, corners: Float64Array) -> Facets:
    """Return triangles (t, 3, 3) of x, y and depth as facets of polygons; those of no width overlap nothing."""
    x, y, depth = corners.transpose(2, 1, 0).copy()
    area = double_areas(x, y)
    for values in (x, y, depth):
        values[1:, area < 0.0] = values[:0:-1, area < 0.0]
    area = np.abs(area)
    side_x, side_y = np.roll(x, -1, axis=0) - x, np.roll(y, -1, axis=0) - y
    length = np.hypot(side_x, side_y)
    length[:, area <= MIN_OVERLAP_PX * length.max(axis=0)] = np.inf
    slope = np.stack([double_areas(depth, y), double_areas(x, depth)]) / np.where(area > 0.0, area, np.inf)
    return Facets(offsets, x, y, depth, -side_y / length, side_x / length, slope)


def double_areas(x: Float64Array, y: Float64Array) -> Float64Array:
    """Return twice the signed areas of triangles (3, t): (t,)."""
    area: Float64Array = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    return area


def find_overlaps(facets: Facets, i: IndexArray, j: IndexArray) -> Overlaps:
    """Return those of the pairs (p,) of polygons that overlap, and which is before the other."""
    overlaps = np.zeros(len(i), np.bool_)
    ahead, behind = np.zeros((2, len(i)))
    for start in range(0, len(i), PAIRS_PER_CHUNK):
        end = start + PAIRS_PER_CHUNK
        first, second, pair = cross_join_groups(facets.offsets, i[start:end], j[start:end])
        which, ahead_by, behind_by = _compare_triangles(facets, first, second)
        pair = pair[which] + start
        overlaps[pair] = True
        np.maximum.at(ahead, pair, ahead_by)
        np.maximum.at(behind, pair, behind_by)
    nearer = np.where(ahead == behind, COPLANAR, np.where(ahead > behind, BEFORE, BEHIND))
    occlusion = np.where(np.minimum(ahead, behind) > MIN_OVERLAP_PX, BEFORE | BEHIND, nearer)
    return Overlaps(i, j, occlusion).selected(overlaps)


def _compare_triangles(facets: Facets, i: IndexArray, j: IndexArray) -> tuple[IndexArray, Float64Array, Float64Array]:
    """Return which pairs (p,) of triangles overlap, and how far the first of each is before and behind the second."""
    overlapping = np.arange(len(i))
    inside: list[Float64Array] = []
    for first, second in ((i, j), (j, i)):
        distances = _side_distances(facets, first[overlapping], second[overlapping])
        overlaps = distances.max(axis=1).min(axis=0) >= MIN_OVERLAP_PX
        inside = [known[..., overlaps] for known in (*inside, distances)]
        overlapping = overlapping[overlaps]
    for distances in inside:
        distances[np.abs(distances) < EDGE_EPSILON_PX] = 0.0
    return overlapping, *_penetrations(facets, i[overlapping], j[overlapping], *inside)


def _side_distances(facets: Facets, first: IndexArray, second: IndexArray) -> Float64Array:
    """Return how far inside each side of the first triangle each corner of the second lies: (3 sides, 3 corners, p)."""
    distances = np.empty((3, 3, len(first)))
    x, y = facets.x[:, second], facets.y[:, second]
    for side in range(3):
        normal_x, normal_y = facets.normal_x[side, first], facets.normal_y[side, first]
        distances[side] = (x - facets.x[side, first]) * normal_x + (y - facets.y[side, first]) * normal_y
    return distances


def _penetrations(
    facets: Facets, i: IndexArray, j: IndexArray, in_first: Float64Array, in_second: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return how far the first triangle is before and behind the second, in pixels from the line where they intersect.

    Their depths are compared at all corners of their intersection in the picture.

    in_first : how far inside the sides of the first the corners of the second lie, as `_side_distances` returns it
    in_second : the same for the corners of the first in the second
    """
    lowest, highest = np.zeros((2, len(i)))

    def compare(first: Float64Array, second: Float64Array, where: BoolArray) -> None:
        difference = first - second
        where = where & (np.abs(difference) > DEPTH_RTOL * np.maximum(first, second))
        np.minimum(lowest, difference, out=lowest, where=where)
        np.maximum(highest, difference, out=highest, where=where)

    first, second = facets.depth[:, i], facets.depth[:, j]
    for corner in range(3):
        compare(_depth_at(facets, i, j, corner), second[corner], in_first[:, corner].min(axis=0) >= 0.0)
        compare(first[corner], _depth_at(facets, j, i, corner), in_second[:, corner].min(axis=0) >= 0.0)
    for a, next_a in ((0, 1), (1, 2), (2, 0)):
        for b, next_b in ((0, 1), (1, 2), (2, 0)):
            t, crosses_second = _zero_crossing(in_second[b, a], in_second[b, next_a])
            u, crosses_first = _zero_crossing(in_first[a, b], in_first[a, next_b])
            depth_a = first[a] + t * (first[next_a] - first[a])
            depth_b = second[b] + u * (second[next_b] - second[b])
            compare(depth_a, depth_b, crosses_first & crosses_second)
    rate = np.hypot(*(facets.slope[:, i] - facets.slope[:, j]))
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead, behind = np.nan_to_num([highest / rate, -lowest / rate], posinf=np.inf)
    return ahead, behind


def _depth_at(facets: Facets, of: IndexArray, other: IndexArray, corner: int) -> Float64Array:
    """Return the depth of triangles `of` at a corner of others."""
    x, y = facets.x[corner, other] - facets.x[0, of], facets.y[corner, other] - facets.y[0, of]
    depth: Float64Array = facets.depth[0, of] + facets.slope[0, of] * x + facets.slope[1, of] * y
    return depth


def _zero_crossing(start: Float64Array, end: Float64Array) -> tuple[Float64Array, BoolArray]:
    """Return at which share of the way from `start` to `end` a distance is zero, and whether it is."""
    crosses = (start < 0.0) != (end < 0.0)
    return start / np.where(crosses, start - end, 1.0), crosses
