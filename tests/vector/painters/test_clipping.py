"""Clipping of polygons: nothing is lost, nothing is there twice, and each piece lies where it should."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gpu_xform.vector.painters import RaggedPolygons, clip, concatenate, select, split_bands
from tests.support.types import Array

TRIANGLES = arrays(np.float64, (4, 3, 2), elements=st.integers(-8, 8).map(float))
PLANES = arrays(np.float64, 3, elements=st.integers(-5, 5).map(float))


def flat(triangles: Array) -> RaggedPolygons:
    """Return triangles of the plane (t, 3, 2) in clip space, at w = 1."""
    corners = np.column_stack([triangles.reshape(-1, 2), np.zeros(3 * len(triangles)), np.ones(3 * len(triangles))])
    return RaggedPolygons(np.arange(0, len(corners) + 1, 3), corners, np.arange(len(triangles)))


def polygons(pieces: RaggedPolygons, owner: int) -> list[Array]:
    return [
        pieces.corners[pieces.offsets[i] : pieces.offsets[i + 1], :2] for i in np.flatnonzero(pieces.owners == owner)
    ]


def area(points: Array) -> float:
    x, y = points.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def require_whole(pieces: RaggedPolygons) -> None:
    assert pieces.offsets[0] == 0
    assert pieces.offsets[-1] == len(pieces.corners)
    assert len(pieces.owners) == len(pieces.offsets) - 1
    assert (np.diff(pieces.offsets) >= 3).all()


@given(TRIANGLES, PLANES)
def test_two_sides_of_a_plane_make_the_whole(triangles: Array, plane: Array) -> None:
    pieces = flat(triangles)
    above = clip(pieces, lambda corners: corners[:, [0, 1, 3]] @ plane)
    below = clip(pieces, lambda corners: corners[:, [0, 1, 3]] @ -plane)
    for side, sign in ((above, 1.0), (below, -1.0)):
        require_whole(side)
        assert (sign * (side.corners[:, [0, 1, 3]] @ plane) >= -1e-9).all()
    if plane.any():
        for owner, triangle in enumerate(triangles):
            parts = [area(polygon) for polygon in polygons(above, owner) + polygons(below, owner)]
            assert sum(parts) == pytest.approx(area(triangle), abs=1e-9)
            assert all(part * area(triangle) >= -1e-9 for part in parts)


@pytest.mark.slow
@given(TRIANGLES, PLANES, st.sampled_from([0.3, 1.0, 7.0, 1000.0]))
def test_bands_make_the_whole_and_differ_by_a_step(triangles: Array, slope: Array, step: float) -> None:
    levels = np.arange(-20.0, 20.0, step) if step < 1000.0 else np.empty(0)
    made = split_bands(flat(triangles), lambda corners: corners[:, [0, 1, 3]] @ slope, levels)
    require_whole(made)
    for owner, triangle in enumerate(triangles):
        own = polygons(made, owner)
        assert sum(map(area, own)) == pytest.approx(area(triangle), abs=1e-9)
        for band in own:
            values = band @ slope[:2] + slope[2]
            assert not ((levels > values.min() + 1e-9) & (levels < values.max() - 1e-9)).any()


def test_corners_are_interpolated_before_they_are_divided_by_w() -> None:
    triangle = RaggedPolygons(
        np.array([0, 3]), np.array([(0, 0, 0, 1), (4, 0, 0, 3), (0, 4, 0, 1)], float), np.array([7])
    )
    cut = clip(triangle, lambda corners: corners[:, 3] - 2.0)
    assert {tuple(corner) for corner in cut.corners.tolist()} == {(2, 0, 0, 2), (4, 0, 0, 3), (2, 2, 0, 2)}
    assert cut.owners.tolist() == [7]


def test_nothing_stays_nothing() -> None:
    nothing = select(flat(np.zeros((1, 3, 2))), np.array([False]))
    for made in (
        clip(nothing, lambda corners: corners[:, 0]),
        split_bands(nothing, lambda corners: corners[:, 0], np.array([0.5])),
        concatenate([nothing, nothing]),
    ):
        require_whole(made)
        assert len(made.owners) == 0
