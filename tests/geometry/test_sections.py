"""Meshes cut by a plane: circles, ellipses and areas by their formulas; what is left, what closes, what is hatched."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import Mesh, matrices, samples
from gpu_xform.geometry.sections import (
    cut_mesh,
    find_holders,
    hatch_area,
    signed_area,
    trace_rings,
    triangulate_area,
)
from tests.support.types import Array

BALL = samples.icosphere(5)
# An L of one concave face per end, which the plane x + y = 1.5 leaves in two parts.
ELL = np.array([(0, 0), (2, 0), (2, 0.5), (0.5, 0.5), (0.5, 2), (0, 2)], float)
PRISM = Mesh(
    np.concatenate([np.column_stack([ELL, np.zeros(6)]), np.column_stack([ELL, np.ones(6)])]),
    [tuple(range(5, -1, -1)), tuple(range(6, 12)), *((i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i) for i in range(6))],
)


def volume(mesh: Mesh) -> float:
    """Return the volume between the faces and the origin: that of a body if it is closed, or cut through the origin."""
    total = 0.0
    for face in mesh.faces:
        p = mesh.positions[list(face)]
        total += sum(float(p[0] @ np.cross(p[i], p[i + 1])) for i in range(1, len(p) - 1)) / 6.0
    return total


def distances(mesh: Mesh, normal: Array, offset: float) -> Array:
    found: Array = mesh.positions @ (normal / np.linalg.norm(normal)) - offset
    return found


@pytest.mark.parametrize(("normal", "offset"), [((0, 0, 1), 0.3), ((1, 2, -1), -0.6)])
def test_a_sphere_is_cut_in_a_circle(normal: tuple[float, float, float], offset: float) -> None:
    unit = np.array(normal) / np.linalg.norm(normal)
    cut = cut_mesh(BALL, distances(BALL, unit, offset))
    on_plane = cut.mesh.positions[np.unique(cut.outline)]
    np.testing.assert_allclose(on_plane @ unit, offset, atol=1e-12)
    radius = np.sqrt(1.0 - offset**2)
    np.testing.assert_allclose(np.linalg.norm(on_plane - offset * unit, axis=1), radius, atol=1e-3)
    assert (cut.mesh.positions @ unit <= offset + 1e-12).all()
    assert (np.bincount(cut.outline.ravel())[np.unique(cut.outline)] == 2).all()
    between = (1.0 - cut.weights)[:, None] * BALL.positions[cut.ends[:, 0]] + cut.weights[:, None] * BALL.positions[
        cut.ends[:, 1]
    ]
    np.testing.assert_allclose(between, cut.mesh.positions, atol=1e-14)


def test_a_cylinder_is_cut_in_an_ellipse() -> None:
    n, slope = 400, 0.7
    angles = 2.0 * np.pi * np.arange(n) / n
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    points = np.concatenate([np.column_stack([ring, np.full(n, z)]) for z in (-3.0, 3.0)])
    tube = Mesh(points, [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)])
    unit = np.array([-slope, 0.0, 1.0]) / np.hypot(slope, 1.0)
    cut = cut_mesh(tube, tube.positions @ unit)
    axes = np.array([(1.0, 0.0, slope), (0.0, np.hypot(slope, 1.0), 0.0)]) / np.hypot(slope, 1.0)
    [ellipse] = trace_rings(cut.mesh.positions, cut.mesh.positions @ axes.T, cut.outline)
    a = np.hypot(1.0, slope)
    np.testing.assert_allclose((ellipse.points[:, 0] / a) ** 2 + ellipse.points[:, 1] ** 2, 1.0, atol=1e-3)
    assert abs(signed_area(ellipse.points)) == pytest.approx(np.pi * a, rel=1e-3)


def test_a_torus_is_cut_in_two_circles() -> None:
    torus = samples.torus(80, 60)
    cut = cut_mesh(torus, torus.positions[:, 1])
    rings = trace_rings(cut.mesh.positions, cut.mesh.positions[:, [0, 2]], cut.outline)
    assert len(rings) == 2
    assert find_holders(rings) == [[], []]
    for ring in rings:
        middle = ring.points.mean(axis=0)
        radii = np.linalg.norm(ring.points - middle, axis=1)
        np.testing.assert_allclose(radii, radii.mean(), rtol=2e-3)


@pytest.mark.parametrize("offset", [1.5, 1.0, 2.0, 0.2])
def test_what_is_cut_is_whole_again_with_its_caps(offset: float) -> None:
    unit = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    axes = np.array([(-1.0, 1.0, 0.0), (0.0, 0.0, np.sqrt(2.0))]) / np.sqrt(2.0)
    parts = []
    for sign in (1.0, -1.0):
        cut = cut_mesh(PRISM, sign * distances(PRISM, unit, offset / np.sqrt(2.0)))
        rings = trace_rings(cut.mesh.positions, cut.mesh.positions @ axes.T, cut.outline)
        areas = sum(abs(signed_area(ring.points)) for ring in rings)
        parts.append((volume(cut.mesh) + sign * areas * offset / np.sqrt(2.0) / 3.0, areas, len(rings)))
    assert parts[0][0] + parts[1][0] == pytest.approx(volume(PRISM), rel=1e-12)
    assert parts[0][1] == pytest.approx(parts[1][1], rel=1e-12)


@given(st.floats(-1.2, 1.2), st.integers(0, 5))
def test_outlines_of_closed_bodies_are_closed_even_through_corners(offset: float, seed: int) -> None:
    normal = np.eye(3)[seed % 3] if seed < 3 else np.random.default_rng(seed).normal(size=3)
    cube = samples.cube()
    cut = cut_mesh(cube, distances(cube, normal, offset))
    counts = np.bincount(cut.outline.ravel(), minlength=1)
    assert (counts[counts > 0] == 2).all()


def test_triangles_with_points_of_their_own_are_cut_alike() -> None:
    ball = samples.icosphere(2)
    loose = Mesh(ball.positions[ball.indices], np.arange(len(ball.indices)).reshape(-1, 3))
    for mesh in (ball, loose):
        cut = cut_mesh(mesh, distances(mesh, np.array([1.0, 2.0, 3.0]), 0.1))
        [ring] = trace_rings(cut.mesh.positions, cut.mesh.positions[:, :2], cut.outline)
        area = abs(signed_area(ring.points))
        assert area == pytest.approx(np.pi * (1 - 0.01) * 3 / np.sqrt(14), rel=0.05)


def test_points_and_segments_are_cut_too() -> None:
    line = Mesh([(0, 0, -1), (0, 0, 3), (1, 0, 5)], [(0, 1), (1, 2)])
    cut = cut_mesh(line, line.positions[:, 2])
    np.testing.assert_allclose(cut.mesh.positions, [(0, 0, -1), (0, 0, 0)])
    assert cut.mesh.n_faces == 1
    cloud = Mesh(line.positions)
    np.testing.assert_allclose(cut_mesh(cloud, line.positions[:, 2]).mesh.positions, [(0, 0, -1)])


@pytest.mark.parametrize("degrees", [0.0, 45.0, 135.0, 17.0])
def test_hatching_is_as_long_as_the_area_over_the_spacing(degrees: float) -> None:
    outer = np.array([(0, 0), (3, 0), (3, 2), (0, 2)], float)
    hole = np.array([(1, 0.5), (1, 1.5), (2, 1.5), (2, 0.5)], float)
    lines = hatch_area([outer, hole], degrees, 0.01)
    directions = lines[:, 1] - lines[:, 0]
    lengths = np.linalg.norm(directions, axis=1)
    assert lengths.sum() * 0.01 == pytest.approx(5.0, rel=0.01)
    turn = np.radians(degrees)
    np.testing.assert_allclose(directions @ (-np.sin(turn), np.cos(turn)), 0.0, atol=1e-12)
    middle = lines.mean(axis=1)
    assert not ((np.abs(middle - (1.5, 1.0)) < 0.499).all(axis=1)).any()
    points, corners = triangulate_area([outer, hole])
    assert sum(abs(signed_area(points[each])) for each in corners) == pytest.approx(5.0)


def test_turned_and_moved_bodies_are_cut_as_by_the_moved_plane() -> None:
    turn = matrices.chain(matrices.rotate((1, 2, 3), 0.7), matrices.translate(5, -2, 1))
    still = cut_mesh(BALL, BALL.positions[:, 2] - 0.2)
    plane = np.linalg.inv(turn).T @ np.array([0, 0, 1, -0.2])
    moved = BALL.transformed(turn)
    cut = cut_mesh(moved, moved.positions @ plane[:3] + plane[3])
    assert len(cut.outline) == len(still.outline)
