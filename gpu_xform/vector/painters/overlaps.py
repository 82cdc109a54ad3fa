"""Which of two polygons lies before the other, where they overlap in the picture."""

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._core.types import BoolArray, Float64Array, IndexArray
from .ragged import products

Sides: TypeAlias = npt.NDArray[np.uint8]

FIRST, SECOND, LEVEL = np.uint8(1), np.uint8(2), np.uint8(4)  # bits of `Sides`

SLIVER = 0.1  # pixels: nobody looks for what overlaps less, or reaches less far through
NOTHING = 1e-6  # pixels: rounding; two sides in one line do not cross
NEARLY = 1e-6  # of a depth, by which it is another; as in the shaders
AT_ONCE = 1 << 13  # pairs, whose numbers stay in a cache


class Facets(NamedTuple):
    """Polygons as triangles in the picture, all turned one way; polygon i has those from offsets[i] to offsets[i + 1].

    The components come first, because NumPy is slow at short axes.

    x, y, depth : (3, t) of the corners, in pixels, and depth turned round
    across, down : (3, t) of the normal, to the inside, of the side from each corner to the next; its length is 1, or 0
        where the triangle is too narrow to be seen
    slope : (2, t) of the depth along x and y
    """

    offsets: IndexArray
    x: Float64Array
    y: Float64Array
    depth: Float64Array
    across: Float64Array
    down: Float64Array
    slope: Float64Array


class Pairs(NamedTuple):
    """Polygons i and j (p,) that overlap, and which is before the other somewhere: FIRST, SECOND, both, or LEVEL.

    LEVEL are those that lie in one plane.
    """

    i: IndexArray
    j: IndexArray
    sides: Sides

    @property
    def hidden(self) -> tuple[IndexArray, IndexArray]:
        """What hides something, and what it hides, the latter first; of two in one plane, the second hides."""
        first, second = (self.sides & FIRST) > 0, (self.sides & (SECOND | LEVEL)) > 0
        return np.concatenate([self.j[first], self.i[second]]), np.concatenate([self.i[first], self.j[second]])

    @property
    def cross(self) -> BoolArray:
        """Whether each is before the other somewhere."""
        both: BoolArray = self.sides == FIRST | SECOND
        return both

    def chosen(self, which: BoolArray) -> "Pairs":
        """Return some of the pairs."""
        return Pairs(self.i[which], self.j[which], self.sides[which])

    def and_(self, others: "Pairs") -> "Pairs":
        """Return these and others."""
        i, j = np.concatenate([self.i, others.i]), np.concatenate([self.j, others.j])
        return Pairs(i, j, np.concatenate([self.sides, others.sides]))


def facets(offsets: IndexArray, corners: Float64Array) -> Facets:
    """Return triangles (t, 3, 3) of x, y and depth as facets of polygons; those of no width overlap nothing."""
    x, y, depth = corners.transpose(2, 1, 0).copy()
    area = areas(x, y)
    for values in (x, y, depth):
        values[1:, area < 0.0] = values[:0:-1, area < 0.0]
    area = np.abs(area)
    along, up = np.roll(x, -1, axis=0) - x, np.roll(y, -1, axis=0) - y
    length = np.hypot(along, up)
    length[:, area <= SLIVER * length.max(axis=0)] = np.inf
    slope = np.stack([areas(depth, y), areas(x, depth)]) / np.where(area > 0.0, area, np.inf)
    return Facets(offsets, x, y, depth, -up / length, along / length, slope)


def areas(x: Float64Array, y: Float64Array) -> Float64Array:
    """Return twice the signed areas of triangles (3, t): (t,)."""
    area: Float64Array = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    return area


def related(these: Facets, i: IndexArray, j: IndexArray) -> Pairs:
    """Return those of the pairs (p,) of polygons that overlap."""
    met = np.zeros(len(i), np.bool_)
    ahead, behind = np.zeros((2, len(i)))
    for start in range(0, len(i), AT_ONCE):
        one, other, pair = products(these.offsets, i[start : start + AT_ONCE], j[start : start + AT_ONCE])
        which, before, after = _of_triangles(these, one, other)
        pair = pair[which] + start
        met[pair] = True
        np.maximum.at(ahead, pair, before)
        np.maximum.at(behind, pair, after)
    nearer = np.where(ahead == behind, LEVEL, np.where(ahead > behind, FIRST, SECOND))
    sides = np.where(np.minimum(ahead, behind) > SLIVER, FIRST | SECOND, nearer)
    return Pairs(i, j, sides).chosen(met)


def _of_triangles(these: Facets, i: IndexArray, j: IndexArray) -> tuple[IndexArray, Float64Array, Float64Array]:
    """Return which pairs (p,) of triangles overlap, and how far the first is before the second, and behind it."""
    met = np.arange(len(i))
    inside: list[Float64Array] = []
    for one, other in ((i, j), (j, i)):
        distances = _distances(these, one[met], other[met])
        overlap = distances.max(axis=1).min(axis=0) >= SLIVER
        inside = [known[..., overlap] for known in (*inside, distances)]
        met = met[overlap]
    for distances in inside:
        distances[np.abs(distances) < NOTHING] = 0.0
    return met, *_reaches(these, i[met], j[met], *inside)


def _distances(these: Facets, one: IndexArray, other: IndexArray) -> Float64Array:
    """Return how far inside each side of one triangle each corner of another lies: (3 sides, 3 corners, p)."""
    distances = np.empty((3, 3, len(one)))
    x, y = these.x[:, other], these.y[:, other]
    for side in range(3):
        across, down = these.across[side, one], these.down[side, one]
        distances[side] = (x - these.x[side, one]) * across + (y - these.y[side, one]) * down
    return distances


def _reaches(
    these: Facets, i: IndexArray, j: IndexArray, in_first: Float64Array, in_second: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return how far the first triangle is before the second, and behind it: in pixels from where they are level.

    Their depths are compared at all corners of what they have in common.

    in_first : how far inside the sides of the first the corners of the second lie, as `_distances` gives it
    in_second : the same the other way round
    """
    least, most = np.zeros((2, len(i)))

    def compare(first: Float64Array, second: Float64Array, where: BoolArray) -> None:
        ahead = first - second
        where = where & (np.abs(ahead) > NEARLY * np.maximum(first, second))
        np.minimum(least, ahead, out=least, where=where)
        np.maximum(most, ahead, out=most, where=where)

    first, second = these.depth[:, i], these.depth[:, j]
    for corner in range(3):
        compare(_depth_at(these, i, j, corner), second[corner], in_first[:, corner].min(axis=0) >= 0.0)
        compare(first[corner], _depth_at(these, j, i, corner), in_second[:, corner].min(axis=0) >= 0.0)
    for a, next_a in ((0, 1), (1, 2), (2, 0)):
        for b, next_b in ((0, 1), (1, 2), (2, 0)):
            t, leaves_second = _crossing(in_second[b, a], in_second[b, next_a])
            u, leaves_first = _crossing(in_first[a, b], in_first[a, next_b])
            depth_a = first[a] + t * (first[next_a] - first[a])
            depth_b = second[b] + u * (second[next_b] - second[b])
            compare(depth_a, depth_b, leaves_first & leaves_second)
    rate = np.hypot(*(these.slope[:, i] - these.slope[:, j]))
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead, behind = np.nan_to_num([most / rate, -least / rate], posinf=np.inf)
    return ahead, behind


def _depth_at(these: Facets, of: IndexArray, other: IndexArray, corner: int) -> Float64Array:
    """Return the depth of triangles `of` where others have a corner."""
    x, y = these.x[corner, other] - these.x[0, of], these.y[corner, other] - these.y[0, of]
    depth: Float64Array = these.depth[0, of] + these.slope[0, of] * x + these.slope[1, of] * y
    return depth


def _crossing(start: Float64Array, end: Float64Array) -> tuple[Float64Array, BoolArray]:
    """Return where on the way from `start` to `end` a distance is zero, and whether it is."""
    crosses = (start < 0.0) != (end < 0.0)
    return start / np.where(crosses, start - end, 1.0), crosses
