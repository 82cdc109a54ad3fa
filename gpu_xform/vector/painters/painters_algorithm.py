"""The order in which a painter lays polygons: each over all that it hides.

They are sorted by their farthest corners, as Newell, Newell and Sancha do ("A solution to the hidden surface problem",
1972). Where that is wrong, whatever lies between the two in that order is sorted by what hides what; and polygons that
hide one another in a circle are cut.
"""

from collections.abc import Callable

import numpy as np

from ..._core.types import BoolArray, Float64Array, IndexArray
from .box_tree import overlapping
from .cycle_breaking import untangled
from .depth_graph import knotted, levels
from .overlaps import SLIVER, Facets, facets, related
from .polygons import Pieces, chosen, extremes, following, taken, together

MOST_PAIRS = 1 << 22  # of polygons whose boxes overlap: some seconds


def painters_order(
    polygons: Pieces, seen: BoolArray, kinds: IndexArray, triangles: Callable[[], tuple[Float64Array, IndexArray]]
) -> Pieces:
    """Return the polygons, what is farther before what is nearer, and some in several pieces.

    polygons : corners (c, 3), x and y in pixels and depth turned round; of two in one plane, the later is nearer
    seen : (k,) whether each is the nearest in the middle of some pixel. Others come first, but for those so narrow that
        they may show between the middles.
    kinds : (k,) those of one kind look the same, so that it does not matter which lies over which
    triangles : gives the triangles (t, 3, 3) of all, and which polygon each belongs to (t,), ascending

    The owners of the pieces are the polygons' numbers. Where more overlap than there is time for, all are in the order
    of their farthest corners.
    """
    polygons = polygons._replace(owners=np.arange(len(polygons.owners)))
    if len(kinds) == 0 or (kinds == kinds[0]).all():
        return polygons
    seen = seen | _are_narrow(polygons)
    shown = chosen(polygons, seen)

    def shown_facets() -> Facets:
        corners, owners = triangles()
        of_shown = seen[owners]
        return facets(np.searchsorted(owners[of_shown], np.append(shown.owners, len(seen))), corners[of_shown])

    ordered = _ordered(shown._replace(owners=np.arange(len(shown.owners))), kinds[seen], shown_facets)
    return together([chosen(polygons, ~seen), ordered._replace(owners=shown.owners[ordered.owners])])


def _are_narrow(polygons: Pieces) -> BoolArray:
    """Tell which polygons are less than a pixel wide."""
    x, y, _ = polygons.corners.T
    after = following(polygons)
    areas = 0.5 * np.abs(np.add.reduceat(x * y[after] - x[after] * y, polygons.offsets[:-1]))
    (left, right), (top, bottom) = extremes(polygons, x), extremes(polygons, y)
    return areas < np.maximum(right - left, bottom - top)


def _ordered(polygons: Pieces, kinds: IndexArray, these: Callable[[], Facets]) -> Pieces:
    """Return polygons, whose owners are their numbers, in order and some in pieces; `these` gives their facets."""
    farthest, nearest = extremes(polygons, polygons.corners[:, 2])
    order = np.argsort(farthest, kind="stable")
    rank = np.argsort(order)
    low, high = _boxes(polygons)
    try:
        i, j = overlapping(np.column_stack([low, farthest]), np.column_stack([high, nearest]), kinds, MOST_PAIRS)
        if len(i) == 0:
            return taken(polygons, order)
        all_facets = these()
        far, near = related(all_facets, i, j).hidden
        wrong = rank[far] > rank[near]
        if not wrong.any():
            return taken(polygons, order)
        blocks = _blocks(rank[near[wrong]], rank[far[wrong]], len(order))[rank]
        i, j = overlapping(np.column_stack([low, blocks]), np.column_stack([high, blocks]), kinds, MOST_PAIRS)
    except OverflowError:
        return taken(polygons, order)
    pairs = related(all_facets, i, j)
    far, near = pairs.hidden
    in_knot = knotted(len(order), far, near)
    if in_knot.any():
        polygons, far, near = untangled(polygons, all_facets, in_knot, pairs)
    owners = polygons.owners
    return taken(polygons, np.lexsort((rank[owners], levels(len(owners), far, near), blocks[owners])))


def _boxes(polygons: Pieces) -> tuple[Float64Array, Float64Array]:
    """Return the low and the high corners (k, 2) of boxes that overlap where polygons may."""
    (left, right), (top, bottom) = (extremes(polygons, polygons.corners[:, axis]) for axis in range(2))
    return np.column_stack([left, top]) + 0.5 * SLIVER, np.column_stack([right, bottom]) - 0.5 * SLIVER


def _blocks(first: IndexArray, last: IndexArray, n: int) -> IndexArray:
    """Return which of n places in a row lie together, where all from `first` to `last` (k,) do: (n,), ascending."""
    n_open = np.cumsum(np.bincount(first, minlength=n) - np.bincount(last, minlength=n))
    return np.cumsum(np.concatenate([[0], n_open[:-1] == 0]))
