"""Where bodies penetrate one another: against circles and ellipses, closed, and nothing where faces only touch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import Mesh, matrices, samples
from gpu_xform.geometry.intersections import Segments, intersect_bodies, number_bodies
from gpu_xform.geometry.triangulation import triangulate
from tests.support.types import Array

TURN = matrices.rotate((1, 2, 3), 0.7)
BALL = samples.icosphere(3)
CUBE = samples.cube()


def meet(*meshes: Mesh) -> Segments:
    points: list[Array] = []
    triangles: list[Array] = []
    bodies: list[Array] = []
    for number, mesh in enumerate(meshes):
        corners, _ = triangulate(mesh.positions, mesh.offsets, mesh.indices)
        triangles.append(corners + sum(len(each) for each in points))
        points.append(mesh.positions)
        bodies.append(np.full(len(corners), number))
    return intersect_bodies(np.concatenate(points), np.concatenate(triangles), np.concatenate(bodies))


def is_closed(segments: Segments) -> bool:
    return len(segments.edges) > 0 and bool((np.bincount(segments.edges.ravel()) == 2).all())


def tube(n: int) -> Mesh:
    """Return the side of a cylinder around z, of radius 1 and from z = -3 to 3."""
    angles = 2.0 * np.pi * np.arange(n) / n
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    points = np.concatenate([np.column_stack([ring, np.full(n, z)]) for z in (-3.0, 3.0)])
    return Mesh(points, [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)])


@pytest.mark.parametrize("offset", [(1.0, 0.1, 0.0), (0.3, -0.8, 0.9)])
def test_two_spheres_meet_in_a_circle(offset: tuple[float, float, float]) -> None:
    found = meet(BALL, BALL.transformed(matrices.chain(TURN, matrices.translate(*offset))))
    middle, distance = 0.5 * np.array(offset), 0.5 * np.linalg.norm(offset)
    radius = np.sqrt(1.0 - distance**2)
    assert is_closed(found)
    np.testing.assert_allclose(np.linalg.norm(found.points - middle, axis=1), radius, atol=0.02)
    np.testing.assert_allclose((found.points - middle) @ middle / distance, 0.0, atol=0.02)


def test_a_cylinder_and_a_plane_meet_in_an_ellipse() -> None:
    slope, n = 0.7, 200
    corners = np.array([(-4, -4), (4, -4), (4, 4), (-4, 4)], float)
    plane = Mesh(np.column_stack([corners, slope * corners[:, 0]]), [(0, 1, 2, 3)])
    found = meet(tube(n), plane)
    x, y, z = found.points.T
    np.testing.assert_allclose(z, slope * x, atol=1e-12)  # half axes sqrt(1 + slope^2) and 1
    assert is_closed(found)
    on_sides = np.hypot(x, y)
    assert on_sides.min() > np.cos(np.pi / n) - 1e-12
    assert on_sides.max() < 1.0 + 1e-12
    length = np.linalg.norm(found.points[found.edges[:, 0]] - found.points[found.edges[:, 1]], axis=1).sum()
    angles = np.linspace(0, 2 * np.pi, 100_000)
    exact = np.trapezoid(np.sqrt((1 + slope**2) * np.sin(angles) ** 2 + np.cos(angles) ** 2), angles)
    assert length == pytest.approx(exact, rel=2e-4)


@pytest.mark.parametrize("by", [(2.0, 0, 0), (2.0, 0.5, 0.3), (0, 2.0, 2.0), (2, 2, 2), (2.5, 0, 0), (0.5, 0.4, 7)])
def test_bodies_that_touch_or_are_apart_do_not_meet(by: tuple[float, float, float]) -> None:
    assert len(meet(CUBE, CUBE.transformed(matrices.translate(*by))).edges) == 0


def test_a_body_inside_another_does_not_meet_it() -> None:
    assert len(meet(CUBE, CUBE.transformed(matrices.scale(0.5))).edges) == 0


@given(st.tuples(*[st.integers(-7, 7).map(lambda k: k / 4)] * 3), st.integers(0, 3))
def test_lines_of_closed_bodies_are_closed_even_where_corners_lie_in_faces(
    by: tuple[float, float, float], seed: int
) -> None:
    turn = TURN if seed else np.eye(4)
    found = meet(CUBE, CUBE.transformed(matrices.chain(matrices.scale(0.75), turn, matrices.translate(*by))))
    n_at_point = np.bincount(found.edges.ravel(), minlength=1)
    assert (n_at_point[n_at_point > 0] >= 2).all() or not seed
    inside = np.abs(found.points).max(axis=1, initial=0.0)
    assert (inside <= 1.0 + 1e-9).all()


def test_bodies_are_what_edges_connect() -> None:
    both = Mesh(
        np.concatenate([CUBE.positions, CUBE.positions + 3.0]), [*CUBE.faces, *(np.add(face, 8) for face in CUBE.faces)]
    )
    np.testing.assert_array_equal(number_bodies(both), np.repeat([0, 1], 6))
    corners, _ = triangulate(BALL.positions, BALL.offsets, BALL.indices)
    loose = Mesh(BALL.positions[corners].reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    assert number_bodies(loose).max() == 0  # each triangle with points of its own, as in STL


def lengths(found: Segments) -> Array:
    ends: Array = np.linalg.norm(np.diff(found.points[found.edges], axis=1)[:, 0], axis=1)
    return ends


def test_far_from_the_origin_as_near() -> None:
    near = meet(BALL, BALL.transformed(matrices.translate(0.8, 0.1, 0.05)))
    away = matrices.translate(1e6, -2e6, 5e5)
    far = meet(BALL.transformed(away), BALL.transformed(matrices.chain(matrices.translate(0.8, 0.1, 0.05), away)))
    assert lengths(far).sum() == pytest.approx(lengths(near).sum(), rel=1e-6)
