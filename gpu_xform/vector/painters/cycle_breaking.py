"""Polygons that hide one another in a circle, cut until none does."""

import numpy as np

from ..._core.types import BoolArray, Float64Array, IndexArray
from .clipping import clipped
from .depth_graph import circles, knotted
from .overlaps import FIRST, NEARLY, SECOND, SLIVER, Facets, Pairs, areas, facets, related
from .polygons import Pieces, chosen, extremes, fans, following, taken, together
from .ragged import members, products, starts

MOST_PIECES = 4  # a polygon, and so many more; where there would be more, some polygons stay in a circle
ROOM = 4096


def untangled(
    polygons: Pieces, these: Facets, in_knot: BoolArray, pairs: Pairs
) -> tuple[Pieces, IndexArray, IndexArray]:
    """Return the polygons, those `in_knot` (k,) cut, and of the pieces that overlap the farther and the nearer ones.

    polygons : x and y in pixels, and depth turned round; their owners are their numbers, and stay so in the pieces
    these : the facets of all
    """
    n = len(in_knot)
    inner = in_knot[pairs.i] & in_knot[pairs.j]
    cells = _flat_parts(chosen(polygons, in_knot), these)
    offsets, order = _by_owner(cells, n)
    first, second, _ = products(offsets, pairs.i[inner], pairs.j[inner])
    cells, far, near = _cut_apart(cells, order[first], order[second])
    rest = chosen(polygons, ~in_knot)
    pieces = together([rest, cells])
    offsets, order = _by_owner(pieces, n)
    first, second, _ = products(offsets, *pairs.chosen(~inner).hidden)
    n_rest = len(rest.owners)
    return pieces, np.append(order[first], far + n_rest), np.append(order[second], near + n_rest)


def _by_owner(pieces: Pieces, n: int) -> tuple[IndexArray, IndexArray]:
    """Return the pieces of n owners as groups: their offsets, and the pieces in that order."""
    return starts(np.bincount(pieces.owners, minlength=n)), np.argsort(pieces.owners, kind="stable")


def _flat_parts(polygons: Pieces, these: Facets) -> Pieces:
    """Return convex polygons that lie in a plane: those that are, and the facets of the others."""
    is_flat = _are_convex(polygons) & _are_level(polygons)
    bent = polygons.owners[~is_flat]
    rows, offsets = members(these.offsets, bent)
    corners = np.stack([these.x[:, rows], these.y[:, rows], these.depth[:, rows]]).transpose(2, 1, 0).reshape(-1, 3)
    torn = Pieces(np.arange(0, len(corners) + 1, 3), corners, np.repeat(bent, np.diff(offsets)))
    return together([chosen(polygons, is_flat), torn])


def _cut_apart(cells: Pieces, i: IndexArray, j: IndexArray) -> tuple[Pieces, IndexArray, IndexArray]:
    """Return cells cut until none hide one another in a circle, and of those that overlap the farther and the nearer.

    cells : convex, each in a plane
    i, j : (p,) which may overlap
    """
    most = MOST_PIECES * len(cells.owners) + ROOM
    planes = _planes(cells)
    tangled = related(_facets(cells), i, j)
    clear = tangled.chosen(np.zeros(len(tangled.i), np.bool_))
    while True:
        n = len(cells.owners)
        in_knot = knotted(n, *tangled.hidden)
        inner = in_knot[tangled.i] & in_knot[tangled.j]
        clear, tangled = clear.and_(tangled.chosen(~inner)), tangled.chosen(inner)
        if len(tangled.i) == 0:
            return cells, *clear.hidden
        if tangled.cross.any():
            targets, knives = _of_crossing(tangled.chosen(tangled.cross))
        else:
            targets, knives = _of_circles(cells, planes, *tangled.hidden)
        are_cut = _reach_through(cells, planes, targets, knives)
        targets, knives = targets[are_cut], knives[are_cut]
        if len(targets) == 0 or n + len(targets) > most:
            return cells, *clear.and_(_by_farthest(cells, tangled)).hidden
        cells, planes = _cut(cells, targets, planes[knives]), np.concatenate([planes, planes[targets]])
        parts = np.full(n, -1)
        parts[targets] = np.arange(n, len(cells.owners))
        these = _facets(cells)
        clear, tangled = _of_parts(clear, parts, these), _of_parts(tangled, parts, these)


def _of_crossing(pairs: Pairs) -> tuple[IndexArray, IndexArray]:
    """Return what is cut by what, once each: of two that cross, what crosses less by what crosses more."""
    i, j = pairs.i, pairs.j
    n_crossings = np.bincount(np.concatenate([i, j]))
    is_knife = n_crossings[i] > n_crossings[j]
    targets, knives = np.where(is_knife, j, i), np.where(is_knife, i, j)
    order = np.lexsort((-n_crossings[knives], targets))
    found, first = np.unique(targets[order], return_index=True)
    return found, knives[order][first]


def _of_circles(
    cells: Pieces, planes: Float64Array, far: IndexArray, near: IndexArray
) -> tuple[IndexArray, IndexArray]:
    """Return what is cut by what, so that circles are broken.

    Each plane of a circle cuts something of it: else it would lie between all that is before it and all behind it.
    """
    targets, knives = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for circle in map(np.array, circles(far, near)):
        n = len(circle)
        are_cut = _reach_through(cells, planes, np.repeat(circle, n), np.tile(circle, n)).reshape(n, n)
        n_cut = are_cut.sum(axis=0)
        knife = int(np.where(n_cut > 0, n_cut, n + 1).argmin())
        targets.append(circle[are_cut[:, knife]])
        knives.append(np.full(n_cut[knife], circle[knife]))
    return np.concatenate(targets), np.concatenate(knives)


def _reach_through(cells: Pieces, planes: Float64Array, targets: IndexArray, knives: IndexArray) -> BoolArray:
    """Tell whether cells (p,) reach to both sides of the planes of others."""
    these = taken(cells, targets)
    low, high = extremes(these, _heights(these, planes[knives]))
    reaches: BoolArray = np.minimum(high, -low) > SLIVER * np.hypot(*(planes[targets, :2] - planes[knives, :2]).T)
    return reaches


def _cut(cells: Pieces, targets: IndexArray, planes: Float64Array) -> Pieces:
    """Return the cells, in place of the targets (k,) what of them is before planes (k, 3), and last what is behind."""
    whole = taken(cells, targets)
    whole = whole._replace(corners=np.column_stack([whole.corners, _heights(whole, planes)]))
    parts = clipped(whole, lambda corners: corners[:, 3]), clipped(whole, lambda corners: -corners[:, 3])
    before, behind = (part._replace(corners=part.corners[:, :3]) for part in parts)
    n = len(cells.owners)
    places = np.arange(n)
    places[targets] = np.arange(n, n + len(targets))
    return together([taken(together([cells, before]), places), behind])


def _of_parts(pairs: Pairs, parts: IndexArray, these: Facets) -> Pairs:
    """Return the pairs of cells of which some were cut: `parts` (n,) gives what was cut off each, or -1."""
    is_same = (parts[pairs.i] < 0) & (parts[pairs.j] < 0)
    i, j = pairs.i[~is_same], pairs.j[~is_same]
    i, j = np.concatenate([i, parts[i], i, parts[i]]), np.concatenate([j, j, parts[j], parts[j]])
    exist = (i >= 0) & (j >= 0)
    return pairs.chosen(is_same).and_(related(these, i[exist], j[exist]))


def _by_farthest(cells: Pieces, pairs: Pairs) -> Pairs:
    """Return the pairs as they were if no cell reached nearer than its farthest corner."""
    rank = np.argsort(np.argsort(extremes(cells, cells.corners[:, 2])[0], kind="stable"))
    return pairs._replace(sides=np.where(rank[pairs.i] > rank[pairs.j], FIRST, SECOND))


def _heights(cells: Pieces, planes: Float64Array) -> Float64Array:
    """Return how far before a plane each, (k, 3), the corners of the cells lie: (c,)."""
    a, b, c = np.repeat(planes, np.diff(cells.offsets), axis=0).T
    x, y, depth = cells.corners.T
    heights: Float64Array = depth - a * x - b * y - c
    return heights


def _planes(cells: Pieces) -> Float64Array:
    """Return (a, b, c) of the plane a x + b y + c that each is in, by its largest triangle: (k, 3)."""
    these = _facets(cells)
    owners = np.repeat(np.arange(len(cells.owners)), np.diff(these.offsets))
    largest = np.lexsort((areas(these.x, these.y), owners))[these.offsets[1:] - 1]
    a, b = these.slope[:, largest]
    return np.column_stack([a, b, these.depth[0, largest] - a * these.x[0, largest] - b * these.y[0, largest]])


def _facets(cells: Pieces) -> Facets:
    """Return the facets of convex polygons."""
    corners, owners = fans(cells)
    return facets(np.searchsorted(owners, np.arange(len(cells.owners) + 1)), cells.corners[corners])


def _are_level(polygons: Pieces) -> BoolArray:
    """Tell of polygons whether all their corners lie in one plane."""
    off = np.abs(_heights(polygons, _planes(polygons)))
    return extremes(polygons, NEARLY * polygons.corners[:, 2] - off)[0] >= 0.0


def _are_convex(polygons: Pieces) -> BoolArray:
    """Tell of polygons whether they turn one way at all corners."""
    after = following(polygons)
    x, y, _ = (polygons.corners[after] - polygons.corners).T
    low, high = extremes(polygons, x * y[after] - y * x[after])
    return np.minimum(high, -low) <= 1e-9 * np.maximum(high, -low)
