"""The matrices and worked examples of the lecture whose figures `docs/lecture.ipynb` makes.

L4 to L8 are the sections of that notebook: circling the camera, homogeneous coordinates, the matrices, perspective,
composition.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gpu_xform import matrices, planar
from tests.support.types import Array

angles = st.floats(-20.0, 20.0)
coordinates = st.floats(-100.0, 100.0)

# Homogeneous points of R^2 as columns: the triangle of the composition example, closed.
TRIANGLE = np.array([[0.0, 1.0, -1.0, 0.0], [1.0, -1.0, -1.0, 1.0], [1.0, 1.0, 1.0, 1.0]])


def animation(frame: int) -> Array:
    """The matrix of the lecture's `animate(frame)`, as it is written there."""
    angle = 2.0 * np.pi * (frame / 100.0)
    return np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])


@pytest.mark.parametrize("frame", range(100))
def test_l4_the_animation_rotates_by_the_inverse_of_r_y(frame: int) -> None:
    angle = 2.0 * math.pi * frame / 100.0
    np.testing.assert_allclose(matrices.rotate_y(-angle), matrices.homogeneous(animation(frame)), rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        matrices.inverse(matrices.rotate_y(angle)), matrices.homogeneous(animation(frame)), rtol=0, atol=1e-15
    )


@given(st.floats(-3.0, 3.0))
def test_l4_where_the_animation_sends_the_unit_vectors(alpha: float) -> None:
    e1, e2, e3 = matrices.rotate_y(-alpha)[:3, :3].T
    np.testing.assert_allclose(e1, (math.cos(alpha), 0, math.sin(alpha)), atol=1e-15)
    np.testing.assert_array_equal(e2, (0, 1, 0))
    np.testing.assert_allclose(e3, (-math.sin(alpha), 0, math.cos(alpha)), atol=1e-15)


@given(coordinates, coordinates, coordinates, coordinates, coordinates, coordinates)
def test_l5_translation(x: float, y: float, z: float, h: float, k: float, m: float) -> None:
    matrix = matrices.translate(h, k, m)
    np.testing.assert_array_equal(matrix, [[1, 0, 0, h], [0, 1, 0, k], [0, 0, 1, m], [0, 0, 0, 1]])
    np.testing.assert_array_equal(matrix @ [x, y, z, 1.0], [x + h, y + k, z + m, 1.0])


def test_l5_a_3x3_is_embedded_in_a_4x4() -> None:
    a = np.arange(1.0, 10.0).reshape(3, 3)
    carried = matrices.homogeneous(a)
    np.testing.assert_array_equal(carried @ [2.0, 3.0, 5.0, 1.0], [*(a @ [2.0, 3.0, 5.0]), 1.0])
    np.testing.assert_array_equal(carried, [[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9, 0], [0, 0, 0, 1]])


def test_l6_scaling() -> None:
    expected = [[2, 0, 0, 0], [0, 3, 0, 0], [0, 0, 5, 0], [0, 0, 0, 1]]
    np.testing.assert_array_equal(matrices.scale(2, 3, 5), expected)


@given(angles)
def test_l6_rotations(alpha: float) -> None:
    c, s = math.cos(alpha), math.sin(alpha)
    np.testing.assert_array_equal(matrices.rotate_x(alpha), [[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])
    np.testing.assert_array_equal(matrices.rotate_y(alpha), [[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]])
    np.testing.assert_array_equal(matrices.rotate_z(alpha), [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


@pytest.mark.parametrize(
    ("matrix", "linear"),
    [
        (planar.reflect((0, 1)), [[1, 0], [0, -1]]),  # over the x1 axis
        (planar.reflect((1, 0)), [[-1, 0], [0, 1]]),  # over the x2 axis
        (planar.reflect((1, -1)), [[0, 1], [1, 0]]),  # over x2 = x1
        (planar.reflect((1, 1)), [[0, -1], [-1, 0]]),  # over x2 = -x1
        (planar.scale(-1), [[-1, 0], [0, -1]]),  # through the origin
        (planar.scale(3, 1), [[3, 0], [0, 1]]),  # horizontal expansion
        (planar.scale(1, 3), [[1, 0], [0, 3]]),  # vertical expansion
        (planar.shear(xy=2), [[1, 2], [0, 1]]),  # horizontal shear
        (planar.shear(yx=2), [[1, 0], [2, 1]]),  # vertical shear
        (planar.project_onto((0, 1)), [[1, 0], [0, 0]]),  # onto the x1 axis
        (planar.project_onto((1, 0)), [[0, 0], [0, 1]]),  # onto the x2 axis
    ],
)
def test_l6_the_linear_transformations_of_the_plane(matrix: Array, linear: list[list[float]]) -> None:
    np.testing.assert_array_equal(matrix, planar.homogeneous(linear))


def test_l7_the_matrix_of_perspective() -> None:
    expected = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, -1 / 8, 1]]
    np.testing.assert_array_equal(matrices.perspective_from_eye(8), expected)


@given(coordinates, coordinates, coordinates, st.floats(0.5, 50.0) | st.floats(-50.0, -0.5))
def test_l7_perspective_lets_the_fourth_coordinate_vary(x: float, y: float, z: float, d: float) -> None:
    image = matrices.perspective_from_eye(d) @ [x, y, z, 1.0]
    np.testing.assert_array_equal(image[:3], (x, y, 0.0))
    assert image[3] == pytest.approx(1.0 - z / d, rel=1e-14, abs=1e-14)


@given(coordinates, coordinates, coordinates, st.floats(0.5, 50.0))
def test_l7_eye_image_and_point_lie_on_one_line(x: float, y: float, z: float, d: float) -> None:
    assume(abs(d - z) > 0.1)
    image = matrices.perspective_from_eye(d) @ [x, y, z, 1.0]
    seen = image[:3] / image[3]
    np.testing.assert_allclose(
        seen, (d * x / (d - z), d * y / (d - z), 0.0), rtol=1e-12, atol=1e-300
    )  # similar triangles
    eye = np.array([0.0, 0.0, d])
    to_point, to_seen = np.array([x, y, z]) - eye, seen - eye
    np.testing.assert_allclose(np.cross(to_point, to_seen), 0.0, atol=1e-9 * float(np.linalg.norm(to_seen)))


def test_l7_the_cube_animation_composes_perspective_and_rotation() -> None:
    frame = 7
    p = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 0, 0], [0, 0, -1.0 / 8, 1]])
    lecture = p @ matrices.homogeneous(animation(frame))
    ours = matrices.chain(matrices.rotate_y(-2 * math.pi * frame / 100), matrices.perspective_from_eye(8))
    np.testing.assert_allclose(ours, lecture, rtol=0, atol=1e-15)


def test_l8_scale_rotate_translate() -> None:
    s, r, t = planar.scale(0.3), planar.rotate(90, degrees=True), planar.translate(-0.5, 2)
    np.testing.assert_array_equal(s, [[0.3, 0, 0], [0, 0.3, 0], [0, 0, 1]])
    np.testing.assert_array_equal(r, [[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    np.testing.assert_array_equal(t, [[1, 0, -0.5], [0, 1, 2], [0, 0, 1]])
    expected = [[0, -0.3, -0.5], [0.3, 0, 2], [0, 0, 1]]
    np.testing.assert_array_equal(matrices.chain(s, r, t), expected)
    np.testing.assert_array_equal(t @ r @ s, expected)


def test_l8_the_triangle_goes_where_the_lecture_draws_it() -> None:
    s, r, t = planar.scale(0.3), planar.rotate(90, degrees=True), planar.translate(-0.5, 2)
    moved = matrices.chain(s, r, t) @ TRIANGLE
    expected = np.array([[-0.8, -0.2, -0.2, -0.8], [2.0, 2.3, 1.7, 2.0], [1.0, 1.0, 1.0, 1.0]])
    np.testing.assert_allclose(moved, expected, rtol=0, atol=1e-15)


def test_l8_projecting_and_rotating_do_not_commute() -> None:
    p, r = planar.project_onto((0, 1)), planar.rotate(30, degrees=True)
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    np.testing.assert_allclose(p @ r, np.array([[c, -s, 0], [0, 0, 0], [0, 0, 1]]), atol=1e-15)
    np.testing.assert_allclose(r @ p, np.array([[c, 0, 0], [s, 0, 0], [0, 0, 1]]), atol=1e-15)
    np.testing.assert_array_equal(matrices.chain(r, p), p @ r)
    np.testing.assert_array_equal(matrices.chain(p, r), r @ p)
