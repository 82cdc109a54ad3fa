"""Painter's algorithm: the order of polygons from back to front, each over all that it hides.

Polygons are sorted by their farthest corners (Newell, Newell and Sancha, "A solution to the hidden surface problem",
1972). Runs in which that order is wrong are sorted topologically by occlusion; polygons that overlap cyclically are
split.
"""

from collections.abc import Callable

import numpy as np

from ..._core.types import BoolArray, Float64Array, IndexArray
from ...geometry.box_tree import find_overlapping_boxes
from .cycle_breaking import break_cycles
from .depth_graph import in_cycle, topological_levels
from .overlaps import MIN_OVERLAP_PX, Facets, find_overlaps, make_facets
from .polygons import RaggedPolygons, concatenate, min_max, next_corner, select, take

MAX_PAIRS = 1 << 22  # of polygons whose boxes overlap: some seconds


def sort_back_to_front(
    polygons: RaggedPolygons,
    is_visible: BoolArray,
    kinds: IndexArray,
    triangles: Callable[[], tuple[Float64Array, IndexArray]],
) -> RaggedPolygons:
    """Return the polygons from the farthest to the nearest, some of them split into pieces.

    polygons : corners (c, 3), x and y in pixels and reversed-Z depth; of two in one plane, the later is nearer
    is_visible : (k,) whether each is the nearest at the centre of some pixel. The others come first, except those so
        narrow that they may show between the centres.
    kinds : (k,) polygons of one kind look the same, so their order does not matter
    triangles : returns the triangles (t, 3, 3) of all polygons, and the index of the polygon of each (t,), ascending

    The owners of the pieces are the indices of the polygons. If more than MAX_PAIRS overlap, all polygons are in the
    order of their farthest corners.
    """
    polygons = polygons._replace(owners=np.arange(len(polygons.owners)))
    if len(kinds) == 0 or (kinds == kinds[0]).all():
        return polygons
    is_visible = is_visible | _are_narrow(polygons)
    visible = select(polygons, is_visible)

    def visible_facets() -> Facets:
        corners, owners = triangles()
        mask = is_visible[owners]
        return make_facets(np.searchsorted(owners[mask], np.append(visible.owners, len(is_visible))), corners[mask])

    ordered = _sort(visible._replace(owners=np.arange(len(visible.owners))), kinds[is_visible], visible_facets)
    return concatenate([select(polygons, ~is_visible), ordered._replace(owners=visible.owners[ordered.owners])])


def _are_narrow(polygons: RaggedPolygons) -> BoolArray:
    """Tell which polygons are less than a pixel wide."""
    x, y, _ = polygons.corners.T
    after = next_corner(polygons)
    areas = 0.5 * np.abs(np.add.reduceat(x * y[after] - x[after] * y, polygons.offsets[:-1]))
    (left, right), (top, bottom) = min_max(polygons, x), min_max(polygons, y)
    return areas < np.maximum(right - left, bottom - top)


def _sort(polygons: RaggedPolygons, kinds: IndexArray, make_all_facets: Callable[[], Facets]) -> RaggedPolygons:
    """Return polygons, whose owners are their indices, from back to front, some of them split."""
    farthest, nearest = min_max(polygons, polygons.corners[:, 2])
    order = np.argsort(farthest, kind="stable")
    rank = np.argsort(order)
    low, high = _bounding_boxes(polygons)

    def overlapping(
        behind: Float64Array | IndexArray, before: Float64Array | IndexArray
    ) -> tuple[IndexArray, IndexArray]:
        return find_overlapping_boxes(np.column_stack([low, behind]), np.column_stack([high, before]), kinds, MAX_PAIRS)

    try:
        i, j = overlapping(farthest, nearest)
        if len(i) == 0:
            return take(polygons, order)
        facets = make_all_facets()
        farther, nearer = find_overlaps(facets, i, j).farther_nearer
        is_wrong = rank[farther] > rank[nearer]
        if not is_wrong.any():
            return take(polygons, order)
        runs = _merge_intervals(rank[nearer[is_wrong]], rank[farther[is_wrong]], len(order))[rank]
        i, j = overlapping(runs, runs)
    except OverflowError:
        return take(polygons, order)
    overlaps = find_overlaps(facets, i, j)
    farther, nearer = overlaps.farther_nearer
    is_cyclic = in_cycle(len(order), farther, nearer)
    if is_cyclic.any():
        polygons, farther, nearer = break_cycles(polygons, facets, is_cyclic, overlaps)
    owners = polygons.owners
    levels = topological_levels(len(owners), farther, nearer)
    return take(polygons, np.lexsort((rank[owners], levels, runs[owners])))


def _bounding_boxes(polygons: RaggedPolygons) -> tuple[Float64Array, Float64Array]:
    """Return the corners (k, 2) of boxes that overlap if polygons may overlap visibly."""
    (left, right), (top, bottom) = (min_max(polygons, polygons.corners[:, axis]) for axis in range(2))
    margin = 0.5 * MIN_OVERLAP_PX
    return np.column_stack([left, top]) + margin, np.column_stack([right, bottom]) - margin


def _merge_intervals(first: IndexArray, last: IndexArray, n: int) -> IndexArray:
    """Return a number for each of n ranks, the same for all from `first` to `last` of an interval: (n,), ascending."""
    n_open = np.cumsum(np.bincount(first, minlength=n) - np.bincount(last, minlength=n))
    return np.cumsum(np.concatenate([[0], n_open[:-1] == 0]))
