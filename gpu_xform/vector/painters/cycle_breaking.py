"""Cyclic overlap: polygons that hide one another in a cycle are split until the occlusion graph is acyclic."""

import numpy as np

from ..._core.types import BoolArray, Float64Array, IndexArray
from .clipping import clip
from .depth_graph import find_cycles, in_cycle
from .overlaps import (
    BEFORE,
    BEHIND,
    DEPTH_RTOL,
    MIN_OVERLAP_PX,
    Facets,
    Overlaps,
    double_areas,
    find_overlaps,
    make_facets,
)
from .polygons import RaggedPolygons, concatenate, min_max, next_corner, select, take, triangulate_fans
from .ragged import cross_join_groups, rows_of, to_offsets

# Cells that there may be, for each cell at first and beside them; if splitting needs more, some cycles stay.
MAX_CELLS_PER_CELL, EXTRA_CELLS = 4, 4096


def break_cycles(
    polygons: RaggedPolygons, facets: Facets, is_cyclic: BoolArray, overlaps: Overlaps
) -> tuple[RaggedPolygons, IndexArray, IndexArray]:
    """Split polygons until the occlusion graph is acyclic; return (pieces, farther, nearer).

    polygons : x and y in pixels, and reversed-Z depth; their owners are their indices, and those of their pieces
    facets : of all polygons
    is_cyclic : (k,) which polygons to split

    `farther` and `nearer` are the pieces of each occlusion.
    """
    n = len(is_cyclic)
    is_inner = is_cyclic[overlaps.i] & is_cyclic[overlaps.j]
    cells = _planar_parts(select(polygons, is_cyclic), facets)
    offsets, order = _group_by_owner(cells, n)
    first, second, _ = cross_join_groups(offsets, overlaps.i[is_inner], overlaps.j[is_inner])
    cells, farther, nearer = _split_cells(cells, order[first], order[second])
    rest = select(polygons, ~is_cyclic)
    pieces = concatenate([rest, cells])
    offsets, order = _group_by_owner(pieces, n)
    first, second, _ = cross_join_groups(offsets, *overlaps.selected(~is_inner).farther_nearer)
    n_rest = len(rest.owners)
    return pieces, np.append(order[first], farther + n_rest), np.append(order[second], nearer + n_rest)


def _group_by_owner(pieces: RaggedPolygons, n: int) -> tuple[IndexArray, IndexArray]:
    """Return the pieces of n owners as groups: their offsets, and the pieces in that order."""
    return to_offsets(np.bincount(pieces.owners, minlength=n)), np.argsort(pieces.owners, kind="stable")


def _planar_parts(polygons: RaggedPolygons, facets: Facets) -> RaggedPolygons:
    """Return convex planar cells: the polygons that are such, and the facets of the others."""
    is_cell = _are_convex(polygons) & _are_planar(polygons)
    others = polygons.owners[~is_cell]
    rows, offsets = rows_of(facets.offsets, others)
    corners = np.stack([facets.x[:, rows], facets.y[:, rows], facets.depth[:, rows]]).transpose(2, 1, 0).reshape(-1, 3)
    triangles = RaggedPolygons(np.arange(0, len(corners) + 1, 3), corners, np.repeat(others, np.diff(offsets)))
    return concatenate([select(polygons, is_cell), triangles])


def _split_cells(cells: RaggedPolygons, i: IndexArray, j: IndexArray) -> tuple[RaggedPolygons, IndexArray, IndexArray]:
    """Split cells until the occlusion graph is acyclic; return (cells, farther, nearer).

    cells : convex and planar
    i, j : (p,) pairs that may overlap
    """
    max_cells = MAX_CELLS_PER_CELL * len(cells.owners) + EXTRA_CELLS
    planes = _fit_planes(cells)
    unordered = find_overlaps(_make_cell_facets(cells), i, j)
    ordered = unordered.selected(np.zeros(len(unordered.i), np.bool_))
    while True:
        n = len(cells.owners)
        is_cyclic = in_cycle(n, *unordered.farther_nearer)
        is_inner = is_cyclic[unordered.i] & is_cyclic[unordered.j]
        ordered, unordered = ordered.joined(unordered.selected(~is_inner)), unordered.selected(is_inner)
        if len(unordered.i) == 0:
            return cells, *ordered.farther_nearer
        if unordered.intersecting.any():
            targets, splitters = _intersecting_splits(unordered.selected(unordered.intersecting))
        else:
            targets, splitters = _cycle_splits(cells, planes, *unordered.farther_nearer)
        is_split = _straddles(cells, planes, targets, splitters)
        targets, splitters = targets[is_split], splitters[is_split]
        if len(targets) == 0 or n + len(targets) > max_cells:
            return cells, *ordered.joined(_order_by_farthest(cells, unordered)).farther_nearer
        cells = _split_by_planes(cells, targets, planes[splitters])
        planes = np.concatenate([planes, planes[targets]])
        split_off = np.full(n, -1)
        split_off[targets] = np.arange(n, len(cells.owners))
        facets = _make_cell_facets(cells)
        ordered, unordered = (
            _update_overlaps(ordered, split_off, facets),
            _update_overlaps(unordered, split_off, facets),
        )


def _intersecting_splits(overlaps: Overlaps) -> tuple[IndexArray, IndexArray]:
    """Return (targets, splitters), each target once: of two that intersect, that with fewer intersections is split."""
    i, j = overlaps.i, overlaps.j
    n_intersections = np.bincount(np.concatenate([i, j]))
    is_splitter = n_intersections[i] > n_intersections[j]
    targets, splitters = np.where(is_splitter, j, i), np.where(is_splitter, i, j)
    order = np.lexsort((-n_intersections[splitters], targets))
    unique_targets, first = np.unique(targets[order], return_index=True)
    return unique_targets, splitters[order][first]


def _cycle_splits(
    cells: RaggedPolygons, planes: Float64Array, farther: IndexArray, nearer: IndexArray
) -> tuple[IndexArray, IndexArray]:
    """Return (targets, splitters) that break cycles, each by the plane in it that splits the fewest of its cells.

    Each plane of a cycle splits one of its cells, or it would lie between all that is before it and all behind it.
    """
    targets, splitters = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for cycle in map(np.array, find_cycles(farther, nearer)):
        n = len(cycle)
        is_split = _straddles(cells, planes, np.repeat(cycle, n), np.tile(cycle, n)).reshape(n, n)
        n_split = is_split.sum(axis=0)
        splitter = int(np.where(n_split > 0, n_split, n + 1).argmin())
        targets.append(cycle[is_split[:, splitter]])
        splitters.append(np.full(n_split[splitter], cycle[splitter]))
    return np.concatenate(targets), np.concatenate(splitters)


def _straddles(cells: RaggedPolygons, planes: Float64Array, targets: IndexArray, splitters: IndexArray) -> BoolArray:
    """Tell which target cells (p,) lie on both sides of the plane of their splitter."""
    some = take(cells, targets)
    low, high = min_max(some, _plane_distances(some, planes[splitters]))
    slope = np.hypot(*(planes[targets, :2] - planes[splitters, :2]).T)
    straddles: BoolArray = np.minimum(high, -low) > MIN_OVERLAP_PX * slope
    return straddles


def _split_by_planes(cells: RaggedPolygons, targets: IndexArray, planes: Float64Array) -> RaggedPolygons:
    """Return the cells, each target (k,) cut to what is before its plane (k, 3); the parts behind come last."""
    whole = take(cells, targets)
    whole = whole._replace(corners=np.column_stack([whole.corners, _plane_distances(whole, planes)]))
    parts = clip(whole, lambda corners: corners[:, 3]), clip(whole, lambda corners: -corners[:, 3])
    before, behind = (part._replace(corners=part.corners[:, :3]) for part in parts)
    n = len(cells.owners)
    indices = np.arange(n)
    indices[targets] = np.arange(n, n + len(targets))
    return concatenate([take(concatenate([cells, before]), indices), behind])


def _update_overlaps(overlaps: Overlaps, split_off: IndexArray, facets: Facets) -> Overlaps:
    """Return the overlaps after a split; `split_off` (n,) is the new part of each cell, or -1."""
    is_same = (split_off[overlaps.i] < 0) & (split_off[overlaps.j] < 0)
    i, j = overlaps.i[~is_same], overlaps.j[~is_same]
    i, j = np.concatenate([i, split_off[i], i, split_off[i]]), np.concatenate([j, j, split_off[j], split_off[j]])
    exist = (i >= 0) & (j >= 0)
    return overlaps.selected(is_same).joined(find_overlaps(facets, i[exist], j[exist]))


def _order_by_farthest(cells: RaggedPolygons, overlaps: Overlaps) -> Overlaps:
    """Return the overlaps as they were if all of a cell were as far away as its farthest corner."""
    rank = np.argsort(np.argsort(min_max(cells, cells.corners[:, 2])[0], kind="stable"))
    return overlaps._replace(occlusion=np.where(rank[overlaps.i] > rank[overlaps.j], BEFORE, BEHIND))


def _plane_distances(cells: RaggedPolygons, planes: Float64Array) -> Float64Array:
    """Return the depth of the corners of cells before the plane of each cell (k, 3): (c,)."""
    a, b, c = np.repeat(planes, np.diff(cells.offsets), axis=0).T
    x, y, depth = cells.corners.T
    distances: Float64Array = depth - a * x - b * y - c
    return distances


def _fit_planes(cells: RaggedPolygons) -> Float64Array:
    """Return (a, b, c) of the plane a x + b y + c through the largest triangle of each cell: (k, 3)."""
    facets = _make_cell_facets(cells)
    owners = np.repeat(np.arange(len(cells.owners)), np.diff(facets.offsets))
    largest = np.lexsort((double_areas(facets.x, facets.y), owners))[facets.offsets[1:] - 1]
    a, b = facets.slope[:, largest]
    return np.column_stack([a, b, facets.depth[0, largest] - a * facets.x[0, largest] - b * facets.y[0, largest]])


def _make_cell_facets(cells: RaggedPolygons) -> Facets:
    """Return the facets of convex polygons."""
    corners, owners = triangulate_fans(cells)
    return make_facets(np.searchsorted(owners, np.arange(len(cells.owners) + 1)), cells.corners[corners])


def _are_planar(polygons: RaggedPolygons) -> BoolArray:
    """Tell which polygons have all their corners in one plane."""
    distances = np.abs(_plane_distances(polygons, _fit_planes(polygons)))
    return min_max(polygons, DEPTH_RTOL * polygons.corners[:, 2] - distances)[0] >= 0.0


def _are_convex(polygons: RaggedPolygons) -> BoolArray:
    """Tell which polygons turn the same way at all corners."""
    after = next_corner(polygons)
    x, y, _ = (polygons.corners[after] - polygons.corners).T
    low, high = min_max(polygons, x * y[after] - y * x[after])
    return np.minimum(high, -low) <= 1e-9 * np.maximum(high, -low)
