"""Occlusion of two triangles, in cases that can be told by hand."""

from typing import Any

import numpy as np
import pytest

from gpu_xform.vector.painters import RaggedPolygons, clip, triangulate_fans
from gpu_xform.vector.painters.overlaps import BEFORE, BEHIND, COPLANAR, find_overlaps, make_facets
from tests.support.types import Array

APART, MINE, OTHER, NEITHER = 0, int(BEFORE), int(BEHIND), int(COPLANAR)  # which is before the other
BOTH = MINE | OTHER
FLAT = [(0, 0, 0.5), (40, 0, 0.5), (0, 40, 0.5)]

CASES: dict[str, tuple[Any, int]] = {
    "before": ([(5, 5, 0.7), (15, 5, 0.7), (5, 15, 0.7)], OTHER),
    "behind": ([(-50, -50, 0.2), (150, -50, 0.2), (-50, 150, 0.2)], MINE),
    "coplanar": ([(5, 5, 0.5), (60, 5, 0.5), (5, 60, 0.5)], NEITHER),
    "coplanar but for rounding": ([(5, 5, 0.5), (60, 5, 0.5 + 1e-15), (5, 60, 0.5 - 1e-15)], NEITHER),
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


def occlusion(first: Array, second: Array) -> int:
    pairs = find_overlaps(make_facets(np.arange(3), np.array([first, second])), np.array([0]), np.array([1]))
    return int(pairs.occlusion[0]) if len(pairs.occlusion) else APART


@pytest.mark.parametrize("name", CASES)
def test_two_triangles_are_compared_where_they_overlap(name: str) -> None:
    others, expected = CASES[name]
    turned = {MINE: OTHER, OTHER: MINE}.get(expected, expected)
    for mine in (np.array(FLAT), np.array(FLAT)[[2, 1, 0]]):
        for other in (np.array(others, np.float64), np.array(others, np.float64)[[1, 0, 2]]):
            assert occlusion(mine, other) == expected
            assert occlusion(other, mine) == turned


def clip_by_planes(triangles: Array, others: Array, sign: float) -> RaggedPolygons:
    """Return the parts of triangles (n, 3, 3) before the planes of others; behind them if `sign` is -1."""
    n, ones = len(triangles), np.ones((len(triangles), 3, 1))
    planes = np.linalg.solve(np.concatenate([others[..., :2], ones], axis=2), others[..., 2:])
    levels = np.concatenate([triangles[..., :2], ones], axis=2) @ planes
    corners = np.concatenate([triangles, triangles[..., 2:] - levels], axis=2).reshape(-1, 4)
    whole = RaggedPolygons(np.arange(0, 3 * n + 1, 3), corners, np.arange(n))
    return clip(whole, lambda corners: sign * corners[:, 3])


@pytest.mark.parametrize(("sign", "side"), [(1.0, MINE), (-1.0, OTHER)])
def test_triangles_clipped_by_the_planes_of_others_intersect_them_no_more(sign: float, side: int) -> None:
    random = np.random.default_rng(0)
    n = 2000
    places = random.uniform(0, 1000, (n, 1, 2)) + random.uniform(-60, 60, (2, n, 3, 2))
    mine, others = np.concatenate([places, random.uniform(1e-4, 9e-4, (2, n, 3, 1))], axis=3)
    corners, owners = [], []
    for part in (clip_by_planes(mine, others, sign), clip_by_planes(others, mine, -sign)):
        triangles, polygon = triangulate_fans(part)
        corners.append(part.corners[triangles, :3])
        owners.append(part.owners[polygon])
    i, j = np.nonzero(owners[0][:, None] == owners[1])
    both = make_facets(np.arange(sum(map(len, owners)) + 1), np.concatenate(corners))
    pairs = find_overlaps(both, i, j + len(owners[0]))
    assert len(pairs.i) > 500
    assert (pairs.occlusion == side).all()


def test_of_coplanar_polygons_the_second_is_the_nearer() -> None:
    level = np.array([FLAT, FLAT, FLAT], np.float64)
    pairs = find_overlaps(make_facets(np.arange(4), level), np.array([0, 1]), np.array([1, 2]))
    far, near = pairs.farther_nearer
    assert (far.tolist(), near.tolist()) == ([0, 1], [1, 2])
    assert not pairs.intersecting.any()


def test_polygons_are_before_one_another_if_their_triangles_are() -> None:
    corners = np.array(FLAT) + np.array([(0, 0, -0.2), (100, 0, 0.2), (0, 0, 0), (100, 0, 0)])[:, None]
    pairs = find_overlaps(make_facets(np.array([0, 2, 4]), corners), np.array([0]), np.array([1]))
    assert pairs.occlusion.tolist() == [BOTH]
    assert [side.tolist() for side in pairs.farther_nearer] == [[1, 0], [0, 1]]
