"""Polygons painted from back to front, beside the nearest at the centre of every pixel."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pytest

from gpu_xform.vector.painters import (
    RaggedPolygons,
    cycle_breaking,
    painters_algorithm,
    sort_back_to_front,
    triangulate_fans,
)
from tests.support.types import Array

Kinds = npt.NDArray[np.int64]

SIDE = 100
X, Y = np.meshgrid(np.arange(SIDE) + 0.5, np.arange(SIDE) + 0.5)
NOTHING = -1


def ragged(polygons: Sequence[Array]) -> RaggedPolygons:
    return RaggedPolygons(
        np.cumsum([0, *map(len, polygons)]), np.concatenate(polygons), np.zeros(len(polygons), np.int64)
    )


def sort(polygons: Sequence[Array], kinds: Kinds, triangles: Sequence[Array] | None = None) -> RaggedPolygons:
    """Return convex polygons (k, 3) in order, or any for which `triangles` are given, (t, 3, 3) each."""
    pieces = ragged(polygons)

    def all_triangles() -> tuple[Array, Kinds]:
        if triangles is None:
            corners, owners = triangulate_fans(pieces)
            return pieces.corners[corners], owners
        return np.concatenate(triangles), np.repeat(np.arange(len(triangles)), [len(some) for some in triangles])

    return sort_back_to_front(pieces, np.ones(len(polygons), np.bool_), kinds, all_triangles)


def covered(polygon: Array) -> npt.NDArray[np.bool_]:
    """Return the pixels whose centre lies in a polygon."""
    inside = np.zeros(X.shape, np.bool_)
    for (x0, y0), (x1, y1) in zip(polygon[:, :2], np.roll(polygon[:, :2], -1, axis=0), strict=True):
        if y0 != y1:
            inside ^= ((y0 > Y) != (y1 > Y)) & (x0 + (Y - y0) / (y1 - y0) * (x1 - x0) > X)
    return inside


def painted(pieces: RaggedPolygons, kinds: Kinds) -> Kinds:
    picture = np.full(X.shape, NOTHING)
    for owner, first, last in zip(pieces.owners, pieces.offsets[:-1], pieces.offsets[1:], strict=True):
        picture[covered(pieces.corners[first:last])] = kinds[owner]
    return picture


def nearest(triangles: Sequence[Array], kinds: Kinds) -> Kinds:
    """Return the kind of the nearest triangle (t, 3, 3), one list per polygon; of two that are coplanar, the later."""
    picture, depth = np.full(X.shape, NOTHING), np.full(X.shape, -np.inf)
    for some, kind in zip(triangles, kinds, strict=True):
        for triangle in some:
            a, b, c = np.linalg.solve(np.column_stack([triangle[:, :2], np.ones(3)]), triangle[:, 2])
            own = a * X + b * Y + c
            shown = covered(triangle) & (own >= depth - 1e-9)
            picture[shown], depth[shown] = kind, own[shown]
    return picture


def quad(corners: Sequence[tuple[float, float]], plane: tuple[float, float, float]) -> Array:
    """Return a polygon of the plane a x + b y + c."""
    points = np.array(corners, np.float64)
    return np.column_stack([points, points @ plane[:2] + plane[2]])


def plank(turn: float) -> Array:
    """Return a plank that passes beside the centre, and is nearer the farther along it is."""
    along, across = np.array([math.cos(turn), math.sin(turn)]), np.array([-math.sin(turn), math.cos(turn)])
    corners = [50 + side * across + way * along for way, side in ((-40, 8), (40, 8), (40, 18), (-40, 18))]
    return np.array([[*corner, 0.5 + 0.004 * ((corner - 50) @ along)] for corner in corners])


def wrong(polygons: Sequence[Array], kinds: Kinds) -> float:
    triangles = [polygon[np.array([(0, i, i + 1) for i in range(1, len(polygon) - 1)])] for polygon in polygons]
    return float((painted(sort(polygons, kinds), kinds) != nearest(triangles, kinds)).mean())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(("n", "size"), [(5, 60), (40, 15), (40, 40)])
def test_the_nearest_of_intersecting_triangles_is_painted_last(n: int, size: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    corners = random.uniform(0, SIDE, (n, 1, 2)) + random.normal(scale=size, size=(n, 3, 2))
    depth = random.uniform(0.2, 0.8, (n, 1, 1)) + random.normal(scale=0.1, size=(n, 3, 1))
    triangles = list(np.concatenate([corners, depth], axis=2))
    kinds = random.integers(0, 10, n)
    assert wrong(triangles, kinds) <= 0.01
    assert wrong(triangles, np.arange(n)) <= 0.01


FLOOR = quad([(0, 0), (99, 0), (99, 99), (0, 99)], (0, 0.008, 0.1))
SCENES = {
    "planks that overlap cyclically": [plank(turn) for turn in (0.0, math.tau / 3, 2 * math.tau / 3)],
    "a floor that reaches behind what it hides": [FLOOR, quad([(30, 60), (50, 60), (50, 80), (30, 80)], (0, 0, 0.3))],
    "a wall that stands on a floor": [FLOOR, quad([(30, 20), (60, 20), (60, 70), (30, 70)], (0, 0, 0.66))],
    "two that intersect": [FLOOR, quad([(20, 20), (80, 20), (80, 80), (20, 80)], (0.004, 0, 0.3))],
    "of two in one plane the later": [
        quad([(40, 5), (60, 5), (60, 95), (40, 95)], (0, 0.008, 0.1)),
        quad([(10, 40), (90, 40), (90, 60), (10, 60)], (0, 0.008, 0.1)),
    ],
    "two planes that hold a third between them": [
        quad([(10, 10), (90, 10), (90, 90), (10, 90)], (0, 0, 0.5)),
        quad([(20, 20), (80, 20), (80, 80), (20, 80)], (0, 0, 0.5 + 1e-4)),
        quad([(30, 0), (70, 0), (70, 99), (30, 99)], (0, 0, 0.5 + 5e-5)),
    ],
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("backwards", [False, True])
def test_a_scene_is_painted_as_it_is_seen(name: str, *, backwards: bool) -> None:
    polygons = SCENES[name][:: -1 if backwards else 1]
    assert wrong(polygons, np.arange(len(polygons))) <= 0.005


def test_only_cyclic_overlaps_are_split() -> None:
    aside = [quad([(x, 0), (x + 5, 0), (x + 5, 5), (x, 5)], (0, 0, 0.9)) for x in range(0, 90, 10)]
    polygons = [*SCENES["planks that overlap cyclically"], *aside]
    found = sort(polygons, np.arange(len(polygons)))
    counts = np.bincount(found.owners)
    assert (counts[3:] == 1).all()
    assert 4 <= counts[:3].sum() <= 5
    found = sort(SCENES["two that intersect"], np.arange(2))
    assert len(found.owners) == 3
    standing = sort(SCENES["a wall that stands on a floor"], np.arange(2))
    assert standing.owners.tolist() == [0, 1]


def test_polygons_of_one_kind_are_neither_sorted_nor_split() -> None:
    pieces = ragged(SCENES["two that intersect"])

    def unasked() -> tuple[Array, Kinds]:
        raise AssertionError("nothing has to be known of the triangles")

    found = sort_back_to_front(pieces, np.ones(2, np.bool_), np.full(2, 7), unasked)
    assert found.owners.tolist() == [0, 1]
    np.testing.assert_array_equal(found.corners, pieces.corners)


def test_no_polygons_are_in_order() -> None:
    nothing = RaggedPolygons(np.zeros(1, np.int64), np.empty((0, 3)), np.empty(0, np.int64))
    no_triangles = (np.empty((0, 3, 3)), np.empty(0, np.int64))
    found = sort_back_to_front(nothing, np.empty(0, np.bool_), np.empty(0, np.int64), lambda: no_triangles)
    assert len(found.owners) == 0


def test_bent_and_notched_polygons_are_painted_as_their_triangles_are_seen() -> None:
    notched = quad([(10, 10), (90, 10), (90, 90), (50, 30), (10, 90)], (0, 0.002, 0.3))
    in_notch = quad([(40, 40), (95, 40), (95, 70), (40, 70)], (0.01, 0, -0.2))
    bent = np.array([(20.0, 5.0, 0.2), (80.0, 5.0, 0.8), (80.0, 50.0, 0.2), (20.0, 50.0, 0.8)])
    polygons = [notched, in_notch, bent]
    hubs = ([(3, 4, 0), (3, 0, 1), (3, 1, 2)], [(0, 1, 2), (0, 2, 3)], [(0, 1, 2), (0, 2, 3)])
    triangles = [polygon[np.array(hub)] for polygon, hub in zip(polygons, hubs, strict=True)]
    kinds = np.arange(3)
    found = sort(polygons, kinds, triangles)
    assert (painted(found, kinds) != nearest(triangles, kinds)).mean() <= 0.01


def test_invisible_polygons_come_first_unless_they_may_show_between_pixels() -> None:
    far, hidden, near = (quad([(20, 20), (80, 20), (80, 80), (20, 80)], (0, 0, depth)) for depth in (0.2, 0.5, 0.6))
    narrow = quad([(30, 10), (30.4, 10), (30.4, 90), (30, 90)], (0, 0, 0.4))
    pieces = ragged([far, narrow, hidden, near])
    corners, owners = triangulate_fans(pieces)
    is_visible = np.array([True, False, False, True])
    found = sort_back_to_front(pieces, is_visible, np.arange(4), lambda: (pieces.corners[corners], owners))
    assert found.owners.tolist() == [2, 0, 1, 3]


def test_if_too_many_overlap_the_farthest_corners_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(painters_algorithm, "MAX_PAIRS", 0)
    assert sort(SCENES["two that intersect"], np.arange(2)).owners.tolist() == [0, 1]


def test_if_too_many_are_split_all_are_there_and_those_in_no_cycle_are_in_order(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cycle_breaking, "MAX_CELLS_PER_CELL", 1)
    monkeypatch.setattr(cycle_breaking, "EXTRA_CELLS", 0)
    polygons = [*SCENES["planks that overlap cyclically"], FLOOR - (0, 0, 0.9)]
    found = sort(polygons, np.arange(4))
    assert sorted(found.owners.tolist()) == [0, 1, 2, 3]
    assert found.owners[0] == 3
