"""Which of two triangles is before the other, where that can be said by hand."""

from typing import Any

import numpy as np
import pytest

from gpu_xform.vector.painters import Pieces, clipped, fans
from gpu_xform.vector.painters.overlaps import FIRST, LEVEL, SECOND, facets, related
from tests.support.types import Array

APART, MINE, OTHER, NEITHER = 0, int(FIRST), int(SECOND), int(LEVEL)  # which is before the other
BOTH = MINE | OTHER
FLAT = [(0, 0, 0.5), (40, 0, 0.5), (0, 40, 0.5)]

CASES: dict[str, tuple[Any, int]] = {
    "before": ([(5, 5, 0.7), (15, 5, 0.7), (5, 15, 0.7)], OTHER),
    "behind": ([(-50, -50, 0.2), (150, -50, 0.2), (-50, 150, 0.2)], MINE),
    "level": ([(5, 5, 0.5), (60, 5, 0.5), (5, 60, 0.5)], NEITHER),
    "level but for rounding": ([(5, 5, 0.5), (60, 5, 0.5 + 1e-15), (5, 60, 0.5 - 1e-15)], NEITHER),
    "nearer than single precision can tell": ([(5, 5, 0.5 + 1e-7), (60, 5, 0.5 + 1e-7), (5, 60, 0.5 + 1e-7)], NEITHER),
    "a little nearer": ([(5, 5, 0.5 + 1e-5), (60, 5, 0.5 + 1e-5), (5, 60, 0.5 + 1e-5)], OTHER),
    "crossing": ([(5, 5, 0.4), (15, 5, 0.6), (5, 15, 0.4)], BOTH),
    "crossing in what is not in common": ([(10, 10, 0.6), (150, 10, 0.4), (10, 150, 0.4)], OTHER),
    "through by less than one sees": ([(5, 5, 0.5 - 0.0005), (15, 5, 0.6), (5, 15, 0.5 - 0.0005)], OTHER),
    "folded over a side in common": ([(0, 0, 0.5), (40, 0, 0.5), (10, 30, 0.8)], OTHER),
    "folded under a part of a side": ([(10, 0, 0.5), (30, 0, 0.5), (20, 10, 0.1)], MINE),
    "beside a side in common": ([(0, 0, 0.9), (40, 0, 0.9), (0, -40, 0.9)], APART),
    "over a corner by less than one sees": ([(-9, -9, 0.9), (0.05, 0.05, 0.9), (-9, 9, 0.9)], APART),
    "far aside": ([(100, 0, 0.9), (140, 0, 0.9), (100, 40, 0.9)], APART),
    "in the box around": ([(38, 38, 0.9), (39, 30, 0.9), (35, 39, 0.9)], APART),
    "without area": ([(5, 5, 0.9), (15, 15, 0.9), (10, 10, 0.9)], APART),
    "a point": ([(5, 5, 0.9)] * 3, APART),
}


def sides(first: Array, second: Array) -> int:
    pairs = related(facets(np.arange(3), np.array([first, second])), np.array([0]), np.array([1]))
    return int(pairs.sides[0]) if len(pairs.sides) else APART


@pytest.mark.parametrize("name", CASES)
def test_two_triangles_are_compared_where_they_overlap(name: str) -> None:
    others, expected = CASES[name]
    turned = {MINE: OTHER, OTHER: MINE}.get(expected, expected)
    for mine in (np.array(FLAT), np.array(FLAT)[[2, 1, 0]]):
        for other in (np.array(others, np.float64), np.array(others, np.float64)[[1, 0, 2]]):
            assert sides(mine, other) == expected
            assert sides(other, mine) == turned


def parts(triangles: Array, others: Array, sign: float) -> Pieces:
    """Return what of triangles (n, 3, 3) is before the planes of others, where `sign` is -1 what is behind them."""
    n, ones = len(triangles), np.ones((len(triangles), 3, 1))
    planes = np.linalg.solve(np.concatenate([others[..., :2], ones], axis=2), others[..., 2:])
    levels = np.concatenate([triangles[..., :2], ones], axis=2) @ planes
    corners = np.concatenate([triangles, triangles[..., 2:] - levels], axis=2).reshape(-1, 4)
    whole = Pieces(np.arange(0, 3 * n + 1, 3), corners, np.arange(n))
    return clipped(whole, lambda corners: sign * corners[:, 3])


@pytest.mark.parametrize(("sign", "side"), [(1.0, MINE), (-1.0, OTHER)])
def test_what_is_cut_where_it_crosses_another_does_so_no_more(sign: float, side: int) -> None:
    random = np.random.default_rng(0)
    n = 2000
    places = random.uniform(0, 1000, (n, 1, 2)) + random.uniform(-60, 60, (2, n, 3, 2))
    mine, others = np.concatenate([places, random.uniform(1e-4, 9e-4, (2, n, 3, 1))], axis=3)
    corners, owners = [], []
    for part in (parts(mine, others, sign), parts(others, mine, -sign)):
        triangles, polygon = fans(part)
        corners.append(part.corners[triangles, :3])
        owners.append(part.owners[polygon])
    i, j = np.nonzero(owners[0][:, None] == owners[1])
    both = facets(np.arange(sum(map(len, owners)) + 1), np.concatenate(corners))
    pairs = related(both, i, j + len(owners[0]))
    assert len(pairs.i) > 500
    assert (pairs.sides == side).all()


def test_of_level_polygons_the_second_hides() -> None:
    level = np.array([FLAT, FLAT, FLAT], np.float64)
    pairs = related(facets(np.arange(4), level), np.array([0, 1]), np.array([1, 2]))
    far, near = pairs.hidden
    assert (far.tolist(), near.tolist()) == ([0, 1], [1, 2])
    assert not pairs.cross.any()


def test_polygons_are_before_one_another_where_their_triangles_are() -> None:
    corners = np.array(FLAT) + np.array([(0, 0, -0.2), (100, 0, 0.2), (0, 0, 0), (100, 0, 0)])[:, None]
    pairs = related(facets(np.array([0, 2, 4]), corners), np.array([0]), np.array([1]))
    assert pairs.sides.tolist() == [BOTH]
    assert [side.tolist() for side in pairs.hidden] == [[1, 0], [0, 1]]
