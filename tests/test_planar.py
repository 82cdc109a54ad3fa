import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from gpu_xform import errors, matrices, planar
from tests.support.types import Array

angles = st.floats(-20.0, 20.0)
vectors = arrays(np.float64, 2, elements=st.floats(-100.0, 100.0))
directions = vectors.filter(lambda v: bool(np.linalg.norm(v) > 1e-3))


def point(x: float, y: float) -> Array:
    return np.array([x, y, 1.0])


@pytest.mark.parametrize(
    "matrix",
    [
        planar.identity(),
        planar.scale(2),
        planar.translate(1, 2),
        planar.rotate(0),
        planar.reflect((0, 1)),
        planar.shear(xy=2),
        planar.project_onto((0, 1)),
        planar.homogeneous(np.eye(2, dtype=np.int8)),
    ],
)
def test_every_matrix_is_c_ordered_float64_with_no_negative_zero(matrix: Array) -> None:
    assert matrix.shape == (3, 3)
    assert matrix.dtype == np.float64
    assert matrix.flags.c_contiguous
    assert not np.signbit(matrix[matrix == 0.0]).any()


def test_identity() -> None:
    np.testing.assert_array_equal(planar.identity(), np.eye(3))


def test_scale() -> None:
    np.testing.assert_array_equal(planar.scale(2, -3) @ point(10, 20), (20, -60, 1))
    np.testing.assert_array_equal(planar.scale(2), planar.scale(2, 2))


def test_translate_moves_points_and_leaves_vectors() -> None:
    np.testing.assert_array_equal(planar.translate(1, 2) @ point(10, 20), (11, 22, 1))
    np.testing.assert_array_equal(planar.translate(1, 2) @ (10, 20, 0), (10, 20, 0))


@given(angles, vectors, vectors)
def test_rotate_is_scipys_about_z(angle: float, centre: Array, other: Array) -> None:
    turn = Rotation.from_euler("z", angle).as_matrix()[:2, :2]
    np.testing.assert_allclose(planar.rotate(angle)[:2, :2], turn, atol=1e-15)
    expected = centre + turn @ (other - centre)
    np.testing.assert_allclose(planar.rotate(angle, point=centre) @ point(*other), point(*expected), atol=1e-12)


def test_quarter_turns_in_degrees_are_exact() -> None:
    np.testing.assert_array_equal(planar.rotate(90, degrees=True), [[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    np.testing.assert_array_equal(planar.rotate(-450, degrees=True), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    np.testing.assert_array_equal(planar.rotate(90, point=(1, 2), degrees=True) @ point(4, 2), (1, 5, 1))


@given(directions, vectors)
def test_reflect_is_an_involution_that_mirrors_and_fixes_its_line(normal: Array, on_line: Array) -> None:
    mirror = planar.reflect(normal, point=on_line)
    np.testing.assert_allclose(mirror @ mirror, np.eye(3), atol=1e-12)
    assert np.linalg.det(mirror) == pytest.approx(-1.0, abs=1e-13)
    np.testing.assert_allclose(mirror @ [*normal, 0.0], [*-normal, 0.0], atol=1e-13)
    along = np.array([-normal[1], normal[0]])
    np.testing.assert_allclose(mirror @ point(*(on_line + along)), point(*(on_line + along)), atol=1e-12)


@given(directions, vectors, vectors)
def test_project_onto_drops_perpendiculars(normal: Array, on_line: Array, other: Array) -> None:
    onto = planar.project_onto(normal, point=on_line)
    np.testing.assert_allclose(onto @ onto, onto, atol=1e-12)
    np.testing.assert_array_equal(onto[:2, :2], onto[:2, :2].T)
    foot = (onto @ point(*other))[:2]
    unit = normal / np.linalg.norm(normal)
    assert np.dot(foot - on_line, unit) == pytest.approx(0.0, abs=1e-12)
    assert np.dot(other - foot, (-unit[1], unit[0])) == pytest.approx(0.0, abs=1e-12)


@given(directions)
def test_a_projection_has_no_inverse(normal: Array) -> None:
    with pytest.raises(errors.SingularMatrixError):
        matrices.inverse(planar.project_onto(normal))


def test_lines_of_the_plane_are_planes_of_space() -> None:
    keep = np.ix_([0, 1, 3], [0, 1, 3])
    np.testing.assert_array_equal(
        planar.reflect((1, 2), point=(3, 5)), matrices.reflect((1, 2, 0), point=(3, 5, 9))[keep]
    )
    np.testing.assert_array_equal(planar.project_onto((1, 2)), matrices.project_onto((1, 2, 0))[keep])
    np.testing.assert_array_equal(planar.rotate(0.7), matrices.rotate_z(0.7)[keep])
    np.testing.assert_array_equal(planar.shear(xy=2, yx=3), matrices.shear(xy=2, yx=3)[keep])


def test_shear() -> None:
    np.testing.assert_array_equal(planar.shear(xy=2, yx=3), [[1, 2, 0], [3, 1, 0], [0, 0, 1]])


def test_homogeneous_embeds_a_matrix() -> None:
    np.testing.assert_array_equal(planar.homogeneous([[1, 2], [3, 4]]), [[1, 2, 0], [3, 4, 0], [0, 0, 1]])


Case = tuple[Callable[[], Any], type[Exception], str]

REFUSED: list[Case] = [
    (lambda: planar.scale(math.nan), errors.ArgumentError, r"x must be finite, got nan"),
    (lambda: planar.scale(1, math.inf), errors.ArgumentError, r"y must be finite, got inf"),
    (lambda: planar.scale(True), errors.ArgumentTypeError, r"x must hold real numbers, got dtype bool"),
    (lambda: planar.translate(1, "2"), errors.ArgumentTypeError, r"y must hold real numbers, got dtype <U1"),
    (lambda: planar.rotate(1j), errors.ArgumentTypeError, r"angle must hold real numbers, got dtype complex128"),
    (lambda: planar.rotate(1, point=(1, 2, 3)), errors.ArgumentError, r"point must have shape \(2,\), got \(3,\)"),
    (lambda: planar.rotate(3, point=(1.7e308, 0)), errors.ArgumentError, r"point must stay within float64's range"),
    (lambda: planar.reflect((0, 0)), errors.ArgumentError, r"normal must not be the zero vector"),
    (lambda: planar.reflect((0, 0, 1)), errors.ArgumentError, r"normal must have shape \(2,\), got \(3,\)"),
    (lambda: planar.shear(yx=math.nan), errors.ArgumentError, r"yx must be finite, got nan"),
    (lambda: planar.project_onto((0, 0)), errors.ArgumentError, r"normal must not be the zero vector"),
    (lambda: planar.project_onto((0, math.nan)), errors.ArgumentError, r"normal must be finite, got nan at index 1"),
    (lambda: planar.homogeneous(np.eye(3)), errors.ArgumentError, r"a must have shape \(2, 2\), got \(3, 3\)"),
    (
        lambda: planar.homogeneous(Rotation.identity()),
        errors.ArgumentError,
        r"a must have shape \(2, 2\), got \(4, 4\)",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), REFUSED, ids=[message[:60] for *_, message in REFUSED])
def test_bad_arguments_are_named(call: Callable[[], Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
