import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import RigidTransform, Rotation

from gpu_xform import errors, planar
from gpu_xform.matrices import (
    Decomposition,
    chain,
    decompose,
    explain,
    homogeneous,
    identity,
    inverse,
    look_at,
    orthographic,
    perspective,
    perspective_from_eye,
    project_onto,
    reflect,
    rotate,
    rotate_x,
    rotate_y,
    rotate_z,
    scale,
    shear,
    translate,
)
from tests.support.types import Array

SUBNORMAL = 1e-300  # below this no relative bound holds
DISTINCT = np.arange(1.0, 17.0).reshape(4, 4)

angles = st.floats(-20.0, 20.0)
coordinates = st.floats(-100.0, 100.0)
vectors = arrays(np.float64, 3, elements=coordinates)
directions = vectors.filter(lambda v: bool(np.linalg.norm(v) > 1e-3))
factors = st.floats(1e-3, 1e3)
slopes = st.floats(-3.0, 3.0)


@st.composite
def affine_matrices(draw: st.DrawFn) -> Array:
    """Scale, shear, turn and move, by other amounts on every axis; half of them mirror."""
    return chain(
        scale(draw(factors), draw(factors), draw(factors) * draw(st.sampled_from([1.0, -1.0]))),
        shear(xy=draw(slopes), zx=draw(st.floats(-0.3, 0.3))),
        rotate(draw(directions), draw(angles)),
        translate(*draw(vectors)),
    )


def point(x: float, y: float, z: float) -> Array:
    return np.array([x, y, z, 1.0])


def ndc(matrix: Array, x: float, y: float, z: float) -> Array:
    projected = matrix @ point(x, y, z)
    return np.asarray(projected[:3] / projected[3])


# -- elementary ----------------------------------------------------------------


@pytest.mark.parametrize(
    "matrix",
    [
        identity(),
        scale(2),
        translate(1, 2, 3),
        rotate_x(0),
        rotate_y(0),
        rotate_z(0),
        rotate((1, 2, 3), 0, point=(0, 0, 0)),
        reflect((0, 0, 1)),
        shear(xy=2),
        project_onto((0, 1, 0)),
        homogeneous(np.eye(3, dtype=np.float32)),
        perspective_from_eye(8),
        perspective(60, 1.5, 1, 10),
        orthographic(0, 2, 0, 2, 0, 2),
        look_at((0, 0, 1), (0, 0, 0)),
        chain(identity(), np.eye(4).T),
        inverse(scale(2)),
        decompose(scale(2)).as_matrix(),
    ],
)
def test_every_matrix_is_c_ordered_float64_with_no_negative_zero(matrix: Array) -> None:
    assert matrix.shape == (4, 4)
    assert matrix.dtype == np.float64
    assert matrix.flags.c_contiguous
    assert matrix.flags.writeable
    assert not np.signbit(matrix[matrix == 0.0]).any()


def test_identity() -> None:
    np.testing.assert_array_equal(identity(), np.eye(4))


def test_scale() -> None:
    np.testing.assert_array_equal(scale(2.0, -3.0, 0.5) @ point(10, 20, 30), (20, -60, 15, 1))
    np.testing.assert_array_equal(scale(2.0), scale(2.0, 2.0, 2.0))


def test_translate_moves_points_and_leaves_vectors() -> None:
    np.testing.assert_array_equal(translate(1, 2, 3) @ point(10, 20, 30), (11, 22, 33, 1))
    np.testing.assert_array_equal(translate(1, 2, 3) @ (10, 20, 30, 0), (10, 20, 30, 0))


@given(angles)
@pytest.mark.parametrize(("turn", "axis"), [(rotate_x, "x"), (rotate_y, "y"), (rotate_z, "z")])
def test_rotations_about_the_axes_are_scipys(turn: Callable[[float], Array], axis: str, angle: float) -> None:
    np.testing.assert_allclose(turn(angle)[:3, :3], Rotation.from_euler(axis, angle).as_matrix(), atol=1e-15)
    np.testing.assert_array_equal(turn(angle)[3], (0, 0, 0, 1))
    np.testing.assert_array_equal(turn(angle)[:, 3], (0, 0, 0, 1))


@pytest.mark.parametrize(
    ("turn", "from_axis", "to_axis"), [(rotate_x, 1, 2), (rotate_y, 2, 0), (rotate_z, 0, 1)], ids=["x", "y", "z"]
)
def test_a_quarter_turn_is_counter_clockwise(turn: Callable[..., Array], from_axis: int, to_axis: int) -> None:
    np.testing.assert_array_equal(turn(90, degrees=True)[:, from_axis], np.eye(4)[to_axis])


@given(directions, angles, st.sampled_from([1.0, 1e-300, 1e300]))
def test_rotate_is_scipys_whatever_the_length_of_the_axis(axis: Array, angle: float, length: float) -> None:
    expected = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).as_matrix()
    np.testing.assert_allclose(rotate(axis * length, angle)[:3, :3], expected, atol=1e-14)


@given(directions, angles, vectors, vectors)
def test_rotate_about_a_point_is_there_and_back_again(axis: Array, angle: float, centre: Array, other: Array) -> None:
    turn = rotate(axis, angle, point=centre)
    np.testing.assert_allclose(turn @ point(*(centre + 0.5 * axis)), point(*(centre + 0.5 * axis)), atol=1e-12)
    expected = centre + Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).apply(other - centre)
    np.testing.assert_allclose(turn @ point(*other), point(*expected), atol=1e-12)


@pytest.mark.parametrize(
    "turn", [rotate_x, rotate_y, rotate_z, lambda a, degrees: rotate((0, -3, 0), a, degrees=degrees)]
)
@pytest.mark.parametrize("quarters", [*range(-9, 10), 2**40 + 1, -(2**46) + 2])
def test_quarter_turns_in_degrees_are_exact(turn: Callable[..., Array], quarters: int) -> None:
    matrix = turn(90 * quarters, degrees=True)
    assert set(np.unique(matrix)) <= {-1.0, 0.0, 1.0}
    np.testing.assert_array_equal(
        matrix, np.linalg.matrix_power(np.rint(turn(90, degrees=True)).astype(int), quarters % 4)
    )


@given(st.floats(-1000.0, 1000.0), directions)
def test_degrees_are_radians_times_pi_over_180(angle: float, axis: Array) -> None:
    for turn in (rotate_x, rotate_y, rotate_z):
        np.testing.assert_allclose(turn(angle, degrees=True), turn(math.radians(angle)), atol=1e-14)
    np.testing.assert_allclose(rotate(axis, angle, degrees=True), rotate(axis, math.radians(angle)), atol=1e-14)


@pytest.mark.parametrize("angle", [37.0 + 360.0 * 2**30, 1e17, -1e22, 1e300])
def test_whole_turns_in_degrees_cost_no_precision(angle: float) -> None:
    np.testing.assert_array_equal(rotate_z(angle, degrees=True), rotate_z(int(angle) % 360, degrees=True))


@given(directions, vectors, vectors)
def test_reflect_is_an_involution_that_mirrors_and_fixes_its_plane(
    normal: Array, on_plane: Array, other: Array
) -> None:
    mirror = reflect(normal, point=on_plane)
    np.testing.assert_allclose(mirror @ mirror, identity(), atol=1e-12)
    assert np.linalg.det(mirror) == pytest.approx(-1.0, abs=1e-13)
    np.testing.assert_allclose(mirror @ [*normal, 0.0], [*-normal, 0.0], atol=1e-13)
    along = np.cross(normal, other)
    np.testing.assert_allclose(mirror[:3, :3] @ along, along, atol=1e-10)
    np.testing.assert_allclose(mirror @ point(*on_plane), point(*on_plane), atol=1e-12)


def test_reflect_in_slanted_planes_is_exact() -> None:
    np.testing.assert_array_equal(reflect((1, -1, 0)), np.eye(4)[[1, 0, 2, 3]])  # the plane x = y swaps x and y
    np.testing.assert_array_equal(
        reflect((0, 0, 7), point=(5, 5, 3)), [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 6], [0, 0, 0, 1]]
    )


@pytest.mark.slow
@given(directions, vectors, vectors)
def test_project_onto_drops_perpendiculars(normal: Array, on_plane: Array, other: Array) -> None:
    onto = project_onto(normal, point=on_plane)
    np.testing.assert_allclose(onto @ onto, onto, atol=1e-12)
    np.testing.assert_array_equal(onto[:3, :3], onto[:3, :3].T)
    foot = onto @ point(*other)
    unit = normal / np.linalg.norm(normal)
    assert np.dot(foot[:3] - on_plane, unit) == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(np.cross(other - foot[:3], unit), 0.0, atol=1e-12)
    assert foot[3] == 1.0


def test_project_onto_a_coordinate_plane() -> None:
    np.testing.assert_array_equal(project_onto((0, 0, 1), point=(4, 5, 6)) @ point(1, 2, 3), (1, 2, 6, 1))


def test_shear_adds_to_the_first_axis_the_second() -> None:
    matrix = shear(xy=2, xz=3, yx=4, yz=5, zx=6, zy=7)
    np.testing.assert_array_equal(matrix, [[1, 2, 3, 0], [4, 1, 5, 0], [6, 7, 1, 0], [0, 0, 0, 1]])
    np.testing.assert_array_equal(shear(xy=2) @ point(1, 10, 100), (21, 10, 100, 1))


def test_homogeneous_embeds_a_matrix() -> None:
    np.testing.assert_array_equal(
        homogeneous([[1, 2, 3], [4, 5, 6], [7, 8, 9]]), [[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9, 0], [0, 0, 0, 1]]
    )
    np.testing.assert_array_equal(homogeneous([[1, 2], [3, 4]]), [[1, 2, 0], [3, 4, 0], [0, 0, 1]])


def test_homogeneous_of_scipys_objects_is_their_4x4() -> None:
    rotation = Rotation.from_euler("xyz", [0.1, 0.2, 0.3])
    rigid = RigidTransform.from_components([1, 2, 3], rotation)
    np.testing.assert_array_equal(homogeneous(rotation)[:3, :3], rotation.as_matrix())
    np.testing.assert_array_equal(homogeneous(rigid), rigid.as_matrix())


# -- viewing -------------------------------------------------------------------


@given(st.floats(5, 170), st.floats(0.2, 5), st.floats(1e-3, 10), st.floats(1.1, 1e5))
def test_perspective_sends_the_frustum_to_the_clip_box(fov_y: float, aspect: float, near: float, ratio: float) -> None:
    far = near * ratio
    matrix = perspective(fov_y, aspect, near, far)
    for depth, z in [(near, 0.0), (far, 1.0)]:
        top = depth * math.tan(math.radians(fov_y / 2))
        right = top * aspect
        for x, y in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]:
            np.testing.assert_allclose(
                ndc(matrix, x * right, y * top, -depth), (x, y, z), rtol=1e-13, atol=1e-12 * ratio
            )
    assert (matrix @ point(0, 0, -near))[2] == pytest.approx(0.0, abs=1e-13 * far)


def test_perspective_keeps_w_positive_in_front_and_depth_increasing() -> None:
    matrix = perspective(50, 1.6, 0.5, 20)
    assert (matrix @ point(1, 2, -3))[3] == 3.0
    depths = [ndc(matrix, 0, 0, -d)[2] for d in (0.5, 1, 5, 20)]
    assert depths == sorted(depths)
    assert depths[0] == 0.0


@given(st.floats(-9, -1), st.floats(1, 9), st.floats(-90, -10), st.floats(10, 90), st.floats(-5, 5), st.floats(6, 50))
def test_orthographic_sends_the_box_to_the_clip_box(
    left: float, right: float, bottom: float, top: float, near: float, far: float
) -> None:
    matrix = orthographic(left, right, bottom, top, near, far)
    np.testing.assert_allclose(matrix @ point(left, bottom, -near), (-1, -1, 0, 1), atol=1e-12)
    np.testing.assert_allclose(matrix @ point(right, top, -far), (1, 1, 1, 1), atol=1e-12)
    np.testing.assert_allclose(matrix @ point(left, top, -far), (-1, 1, 1, 1), atol=1e-12)


def test_orthographic_may_flip_an_axis() -> None:
    np.testing.assert_array_equal(orthographic(0, 4, 2, 0, 0, 1) @ point(4, 2, 0), (1, -1, 0, 1))


@given(vectors, vectors, directions)
def test_look_at_puts_the_eye_at_the_origin_and_the_target_on_minus_z(eye: Array, target: Array, up: Array) -> None:
    view = target - eye
    assume(np.linalg.norm(view) > 1e-2)
    assume(np.linalg.norm(np.cross(view, up)) > 1e-2 * np.linalg.norm(view) * np.linalg.norm(up))
    matrix = look_at(eye, target, up)
    np.testing.assert_allclose(matrix @ point(*eye), point(0, 0, 0), atol=1e-10)
    np.testing.assert_allclose(matrix @ point(*target), point(0, 0, -float(np.linalg.norm(view))), atol=1e-10)
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-13)
    assert np.linalg.det(matrix) == pytest.approx(1.0)
    seen_up = matrix[:3, :3] @ up / np.linalg.norm(up)
    assert seen_up[0] == pytest.approx(0.0, abs=1e-12)
    assert seen_up[1] > 0.0


def test_look_at_from_the_side() -> None:
    matrix = look_at((10, 2, 3), (0, 2, 3))
    np.testing.assert_allclose(matrix @ point(0, 2, 0), (3, 0, -10, 1), atol=1e-15)  # -z of the world is on the right
    np.testing.assert_allclose(matrix @ point(0, 7, 3), (0, 5, -10, 1), atol=1e-15)


# -- composition ---------------------------------------------------------------


@given(affine_matrices(), affine_matrices(), affine_matrices())
def test_chain_applies_the_first_first(a: Array, b: Array, c: Array) -> None:
    bound = np.abs(c) @ np.abs(b) @ np.abs(a)
    assert (np.abs(chain(a, b, c) - c @ b @ a) <= 1e-14 * bound + SUBNORMAL).all()


def test_chain_order_in_figures() -> None:
    np.testing.assert_array_equal(chain(scale(2), translate(1, 0, 0)) @ point(1, 1, 1), (3, 2, 2, 1))
    np.testing.assert_array_equal(chain(translate(1, 0, 0), scale(2)) @ point(1, 1, 1), (4, 2, 2, 1))


def test_chain_takes_3x3_lists_and_as_matrix() -> None:
    rotation = Rotation.from_euler("z", 0.3)
    np.testing.assert_allclose(chain(rotation, translate(1, 2, 3)), translate(1, 2, 3) @ rotate_z(0.3), atol=1e-15)
    np.testing.assert_array_equal(
        chain([[2, 0, 0], [0, 3, 0], [0, 0, 1]], planar.translate(1, 2)), [[2, 0, 1], [0, 3, 2], [0, 0, 1]]
    )


def test_chain_of_one_is_a_copy() -> None:
    matrix = DISTINCT.copy()
    chained = chain(matrix)
    chained[0, 0] = -1.0
    np.testing.assert_array_equal(matrix, DISTINCT)


@given(affine_matrices())
def test_inverse_undoes_an_affine_matrix_and_stays_affine(m: Array) -> None:
    undo = inverse(m)
    assert (np.abs(undo @ m - identity()) <= 1e-12 * (np.abs(undo) @ np.abs(m)) + SUBNORMAL).all()
    assert (np.abs(m @ undo - identity()) <= 1e-12 * (np.abs(m) @ np.abs(undo)) + SUBNORMAL).all()
    np.testing.assert_array_equal(undo[3], (0, 0, 0, 1))


@given(directions, angles, vectors)
def test_inverse_of_a_rigid_transform_is_scipys(axis: Array, angle: float, offset: Array) -> None:
    rotation = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle)
    rigid = RigidTransform.from_components(offset, rotation)
    np.testing.assert_allclose(inverse(rigid), rigid.inv().as_matrix(), atol=1e-12)


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        (translate(1, 2, 3), translate(-1, -2, -3)),
        (scale(1e-12), scale(1e12)),
        (scale(1e-300, 1, 1e300), scale(1e300, 1, 1e-300)),
        (shear(xy=1e20), shear(xy=-1e20)),
        (
            chain(rotate_z(90, degrees=True), translate(1e20, 0, 0)),
            chain(translate(-1e20, 0, 0), rotate_z(-90, degrees=True)),
        ),
        (chain(scale(1, 1e-40, 1), rotate_y(0.3)), chain(rotate_y(-0.3), scale(1, 1e40, 1))),
        (np.diag([1.0, 1.0, 1.0, 0.5]), np.diag([1.0, 1.0, 1.0, 2.0])),
        (planar.scale(1e-12, 4), planar.scale(1e12, 0.25)),
        (rotate_x(0.3)[:3, :3], rotate_x(-0.3)[:3, :3]),
        (
            np.array([[1, 1, 0], [1, 1 + 2**-40, 0], [0, 0, 1]]),
            np.array([[2**40 + 1, -(2**40), 0], [-(2**40), 2**40, 0], [0, 0, 1]]),
        ),
    ],
)
def test_bad_scaling_and_near_misses_are_not_singularity(matrix: Array, expected: Array) -> None:
    np.testing.assert_allclose(inverse(matrix), expected, rtol=1e-14)


def test_the_inverse_of_a_camera_maps_back_to_the_world() -> None:
    clip_from_world = perspective(40, 1.5, 0.1, 1000) @ look_at((3, 4, 5), (1, 0, -1))
    back = inverse(clip_from_world) @ clip_from_world @ point(0.3, -0.7, 0.9)
    np.testing.assert_allclose(back / back[3], point(0.3, -0.7, 0.9), rtol=1e-11)


@given(arrays(np.float64, 3, elements=st.floats(-1, 1).map(lambda x: x**7)), vectors)
def test_a_projection_has_no_inverse(normal: Array, on_plane: Array) -> None:
    assume(normal.any())
    with pytest.raises(errors.SingularMatrixError, match="m must have an inverse, got a singular matrix"):
        inverse(project_onto(normal, point=on_plane))


@pytest.mark.parametrize(
    "matrix",
    [
        np.zeros((4, 4)),
        DISTINCT,
        perspective_from_eye(8),
        np.diag([1.0, 1.0, 1.0, 0.0]),
        chain(rotate((1, 2, 3), 0.4), project_onto((3, -1, 2), point=(1, 2, 3)), scale(1e-6, 1, 1e6)),
        1e-300 * np.ones((3, 3)),
    ],
)
def test_a_singular_matrix_has_no_inverse(matrix: Array) -> None:
    with pytest.raises(errors.SingularMatrixError, match="m must have an inverse, got a singular matrix"):
        inverse(matrix)


@pytest.mark.slow
@given(affine_matrices())
def test_decompose_rebuilds_and_keeps_the_flip_in_the_scale(m: Array) -> None:
    parts = decompose(m)
    assert (np.abs(parts.as_matrix() - m).max(axis=0) <= 1e-12 * np.abs(m).max(axis=0) + SUBNORMAL).all()
    np.testing.assert_allclose(parts.rotation @ parts.rotation.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(parts.rotation) == pytest.approx(1.0)
    assert (parts.scale < 0.0).sum() == (np.linalg.det(m) < 0.0)
    assert [part.shape for part in parts] == [(3,), (3, 3), (3,), (3,)]


@given(vectors, directions, angles, st.tuples(factors, factors, factors), st.tuples(slopes, slopes, slopes))
def test_decompose_finds_the_parts(
    offset: Array, axis: Array, angle: float, size: tuple[float, float, float], slant: tuple[float, float, float]
) -> None:
    turn = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).as_matrix()
    upper = np.array([[1.0, slant[0], slant[1]], [0.0, 1.0, slant[2]], [0.0, 0.0, 1.0]])
    m = identity()
    m[:3, :3] = turn @ upper @ np.diag(size)
    m[:3, 3] = offset
    parts = decompose(m)
    np.testing.assert_array_equal(parts.translation, offset)
    np.testing.assert_allclose(parts.rotation, turn, atol=1e-12)
    np.testing.assert_allclose(parts.scale, size, rtol=1e-12)
    np.testing.assert_allclose(parts.shear, slant, atol=1e-12)


@pytest.mark.parametrize("size", [(1, -2, 3), (-5, 1, 1), (1, 1, -1e-9)])
def test_decompose_flips_the_axis_that_was_flipped(size: tuple[float, float, float]) -> None:
    parts = decompose(scale(*size))
    np.testing.assert_array_equal(parts.scale, size)
    np.testing.assert_array_equal(parts.rotation, np.eye(3))


def test_a_decomposition_is_taken_where_a_matrix_is() -> None:
    parts = decompose(chain(scale(2, 3, 4), rotate_x(0.5)))
    assert isinstance(parts, Decomposition)
    np.testing.assert_allclose(
        chain(parts, translate(1, 2, 3)), chain(scale(2, 3, 4), rotate_x(0.5), translate(1, 2, 3))
    )


@pytest.mark.parametrize("matrix", [scale(0), project_onto((1, 2, 3)), shear(xy=1, yx=1)])
def test_decompose_refuses_a_singular_matrix(matrix: Array) -> None:
    with pytest.raises(errors.SingularMatrixError, match="m must have an inverse"):
        decompose(matrix)


# -- explanation ---------------------------------------------------------------


def test_explain_shows_factors_product_and_the_point_on_its_way() -> None:
    text = explain(scale(0.5, 2, 1), translate(-10.25, 0, 4), perspective_from_eye(8), point=(1, 2, -12))
    assert (
        text
        == """\
First M1:
    [ 0.5  0  0  0 ]
    [ 0    2  0  0 ]
    [ 0    0  1  0 ]
    [ 0    0  0  1 ]

Then M2:
    [ 1  0  0  -10.25 ]
    [ 0  1  0    0    ]
    [ 0  0  1    4    ]
    [ 0  0  0    1    ]

Then M3:
    [ 1  0   0      0 ]
    [ 0  1   0      0 ]
    [ 0  0   0      0 ]
    [ 0  0  -0.125  1 ]

Together M3 M2 M1:
    [ 0.5  0   0      -10.25 ]
    [ 0    2   0        0    ]
    [ 0    0   0        0    ]
    [ 0    0  -0.125    0.5  ]

The point (x, y, z, w):
    given         [  1      2  -12  1 ]
    after M1      [  0.5    4  -12  1 ]
    after M2      [ -9.75   4   -8  1 ]
    after M3      [ -9.75   4    0  2 ]
    divided by w  [ -4.875  2    0  1 ]"""
    )


def test_an_explanation_shows_its_lines_in_ipython() -> None:
    pretty = pytest.importorskip("IPython.lib.pretty")
    text = explain(scale(2), scale(3))
    assert pretty.pretty(text) == text
    assert isinstance(text, str)
    assert pickle.loads(pickle.dumps(text)) == text  # noqa: S301 - made here


def test_explain_in_the_plane_needs_no_division() -> None:
    text = explain(planar.rotate(90, degrees=True), planar.scale(1e-12, 3), point=(2, 5))
    assert text.endswith("""\
Together M2 M1:
    [ 0  -1e-12  0 ]
    [ 3   0      0 ]
    [ 0   0      1 ]

The point (x, y, w):
    given     [  2      5  1 ]
    after M1  [ -5      2  1 ]
    after M2  [ -5e-12  6  1 ]""")


def test_explain_a_direction() -> None:
    text = explain(Rotation.from_euler("z", 90, degrees=True), point=(1, 0, 3, 0))
    assert "Together" not in text
    assert text.endswith("    w = 0: a direction, with nothing to divide by")


def test_explain_without_a_point_ends_with_the_product() -> None:
    assert explain(scale(2), scale(3)).endswith("[ 0  0  0  1 ]")


# -- what is refused -----------------------------------------------------------

BIG = 1.7e308
Case = tuple[Callable[[], Any], type[Exception], str]

REFUSED: list[Case] = [
    (lambda: scale(1, 2), errors.ArgumentError, r"scale must have one factor or three, got x = 1, y = 2, z = None"),
    (lambda: scale(1, z=2), errors.ArgumentError, r"scale must have one factor or three, got x = 1, y = None, z = 2"),
    (lambda: scale(math.nan), errors.ArgumentError, r"x must be finite, got nan"),
    (lambda: scale(1, 2, math.inf), errors.ArgumentError, r"z must be finite, got inf"),
    (lambda: scale([1, 2], 1, [1, 2, 3]), errors.ArgumentError, r"x and y and z must broadcast, got shapes \(2,\), \("),
    (lambda: scale(True), errors.ArgumentTypeError, r"x must hold real numbers, got dtype bool"),
    (lambda: scale("2"), errors.ArgumentTypeError, r"x must hold real numbers, got dtype <U1"),
    (lambda: translate(0, 1j, 0), errors.ArgumentTypeError, r"y must hold real numbers, got dtype complex128"),
    (lambda: translate(0, 0, -math.inf), errors.ArgumentError, r"z must be finite, got -inf"),
    (lambda: rotate_x(math.nan), errors.ArgumentError, r"angle must be finite, got nan"),
    (lambda: rotate_y("1"), errors.ArgumentTypeError, r"angle must hold real numbers"),
    (lambda: rotate_z([1, np.nan]), errors.ArgumentError, r"angle must be finite, got nan at index 1"),
    (lambda: rotate((0, 0, 0), 1), errors.ArgumentError, r"axis must not be the zero vector"),
    (lambda: rotate((0, 1), 1), errors.ArgumentError, r"axis must have shape \(3,\), got \(2,\)"),
    (lambda: rotate((0, 1, 0), math.inf), errors.ArgumentError, r"angle must be finite, got inf"),
    (lambda: rotate((0, 1, 0), 1, point=(1, 2)), errors.ArgumentError, r"point must have shape \(3,\), got \(2,\)"),
    (lambda: rotate((0, math.nan, 0), 1), errors.ArgumentError, r"axis must be finite, got nan at index 1"),
    (
        lambda: rotate((1, 1, 1), 3, point=(BIG, -BIG, BIG)),
        errors.ArgumentError,
        r"the matrix about point must stay within",
    ),
    (lambda: reflect((0, 0, 0)), errors.ArgumentError, r"normal must not be the zero vector"),
    (
        lambda: reflect((0, 0, 1), point=(0, 0, BIG)),
        errors.ArgumentError,
        r"point must stay within float64's range, got inf",
    ),
    (lambda: shear(zy=math.nan), errors.ArgumentError, r"zy must be finite, got nan"),
    (lambda: shear(xz=False), errors.ArgumentTypeError, r"xz must hold real numbers, got dtype bool"),
    (lambda: project_onto((0, 0, 0)), errors.ArgumentError, r"normal must not be the zero vector"),
    (lambda: project_onto([[1, 0, 0]]), errors.ArgumentError, r"normal must have shape \(3,\), got \(1, 3\)"),
    (lambda: homogeneous(np.eye(4)), errors.ArgumentError, r"a must have shape \(2, 2\) or \(3, 3\), got \(4, 4\)"),
    (lambda: homogeneous([[1, 2], [3]]), errors.ArgumentError, r"a must be a rectangular array of numbers"),
    (lambda: perspective_from_eye(0), errors.ArgumentError, r"d must not be 0: the eye would lie in the viewing plane"),
    (
        lambda: perspective_from_eye(5e-324),
        errors.ArgumentError,
        r"1/d for d = 5e-324 must stay within float64's range",
    ),
    (lambda: perspective_from_eye(math.inf), errors.ArgumentError, r"d must be finite, got inf"),
    (lambda: perspective(0, 1, 1, 2), errors.ArgumentError, r"fov_y must lie between 0 and 180 degrees, got 0"),
    (lambda: perspective(180, 1, 1, 2), errors.ArgumentError, r"fov_y must lie between 0 and 180 degrees, got 180"),
    (lambda: perspective(1e-320, 1, 1, 2), errors.ArgumentError, r"tan\(fov_y / 2\) .*must have a finite reciprocal"),
    (lambda: perspective(60, 0, 1, 2), errors.ArgumentError, r"aspect must be positive, got 0"),
    (lambda: perspective(60, -1, 1, 2), errors.ArgumentError, r"aspect must be positive, got -1"),
    (lambda: perspective(60, 1e-320, 1, 2), errors.ArgumentError, r"\* aspect must have a finite reciprocal"),
    (lambda: perspective(60, 1, 0, 2), errors.ArgumentError, r"near must be positive, got 0"),
    (lambda: perspective(60, 1, -1, 2), errors.ArgumentError, r"near must be positive, got -1"),
    (lambda: perspective(60, 1, 2, 2), errors.ArgumentError, r"near must be less than far, got near = 2.0, far = 2.0"),
    (lambda: perspective(60, 1, 3, 2), errors.ArgumentError, r"near must be less than far, got near = 3.0, far = 2.0"),
    (lambda: perspective(60, 1, 1, math.inf), errors.ArgumentError, r"far must be finite, got inf"),
    (lambda: perspective(60, 1, 1e308, math.nextafter(1e308, 2e308)), errors.ArgumentError, r"near = 1e\+308, far = "),
    (lambda: orthographic(1, 1, 0, 1, 0, 1), errors.ArgumentError, r"left and right must differ, both are 1"),
    (lambda: orthographic(0, 1, 2, 2, 0, 1), errors.ArgumentError, r"bottom and top must differ, both are 2"),
    (
        lambda: orthographic(0, 1, 0, 1, 1, 1),
        errors.ArgumentError,
        r"near must be less than far, got near = 1.0, far = 1.0",
    ),
    (lambda: orthographic(0, 1, 0, 1, 1, -1), errors.ArgumentError, r"near must be less than far"),
    (
        lambda: orthographic(-BIG, BIG, 0, 1, 0, 1),
        errors.ArgumentError,
        r"right - left must have a finite reciprocal, got inf",
    ),
    (lambda: orthographic(0, 1, 0, 5e-324, 0, 1), errors.ArgumentError, r"top - bottom must have a finite reciprocal"),
    (lambda: orthographic(0, 1, 0, 1, math.nan, 1), errors.ArgumentError, r"near must be finite, got nan"),
    (
        lambda: look_at((1, 2, 3), (1, 2, 3)),
        errors.ArgumentError,
        r"eye and target must differ, both are \(1.0, 2.0, 3.0\)",
    ),
    (
        lambda: look_at((0, 0, 0), (0, 5, 0)),
        errors.ArgumentError,
        r"up must not be parallel to target - eye = \(0.0, 5.0, 0.0\)",
    ),
    (
        lambda: look_at((0, 0, 0), (0.1, 0.2, 0.3), (-1, -2, -3)),
        errors.ArgumentError,
        r"up must not be parallel .* got \(-1",
    ),
    (lambda: look_at((0, 0, 0), (0, 0, 1), (0, 0, 0)), errors.ArgumentError, r"up must not be the zero vector"),
    (lambda: look_at((0, 0), (0, 0, 1)), errors.ArgumentError, r"eye must have shape \(3,\), got \(2,\)"),
    (lambda: look_at((0, 0, 0), (0, math.nan, 1)), errors.ArgumentError, r"target must be finite, got nan at index 1"),
    (
        lambda: look_at((-BIG, 0, 0), (BIG, 0, 0)),
        errors.ArgumentError,
        r"target - eye must be finite, got inf at index 0",
    ),
    (lambda: chain(), errors.ArgumentError, r"matrices must hold at least one 3x3 or 4x4 matrix, got none"),
    (
        lambda: chain(np.eye(2)),
        errors.ArgumentError,
        r"matrices\[0\] must have shape \(3, 3\) or \(4, 4\), got \(2, 2\)",
    ),
    (
        lambda: chain(np.eye(4), np.eye(3)),
        errors.ArgumentError,
        r"matrices\[1\] must have shape \(4, 4\), got \(3, 3\); homogeneous",
    ),
    (
        lambda: chain(np.eye(4), np.full((4, 4), np.nan)),
        errors.ArgumentError,
        r"matrices\[1\] must be finite, got nan at index \(0, 0\)",
    ),
    (
        lambda: chain(np.eye(4, dtype=bool)),
        errors.ArgumentTypeError,
        r"matrices\[0\] must hold real numbers, got dtype bool",
    ),
    (
        lambda: chain(scale(1e200), scale(1e200)),
        errors.ArgumentError,
        r"the product of matrices must stay within float64's range",
    ),
    (lambda: inverse(np.ones((3, 4))), errors.ArgumentError, r"m must have shape \(3, 3\) or \(4, 4\), got \(3, 4\)"),
    (lambda: inverse(1j * np.eye(4)), errors.ArgumentTypeError, r"m must hold real numbers, got dtype complex128"),
    (
        lambda: inverse(scale(1e-310)),
        errors.ArgumentError,
        r"the inverse of m must stay within float64's range, got inf",
    ),
    (lambda: decompose(np.eye(3)), errors.ArgumentError, r"m must have shape \(4, 4\), got \(3, 3\)"),
    (
        lambda: decompose(perspective(60, 1, 1, 2)),
        errors.ArgumentError,
        r"m must be affine, .* got \(0, 0, -1, 0\)",
    ),
    (
        lambda: decompose(homogeneous([[BIG, 1, 0], [BIG, 0, 1], [BIG, 0, 0]])),
        errors.ArgumentError,
        r"the scale in m must stay within float64's range",
    ),
    (lambda: explain(), errors.ArgumentError, r"matrices must hold at least one 3x3 or 4x4 matrix, got none"),
    (
        lambda: explain(np.eye(4), point=(1, 2)),
        errors.ArgumentError,
        r"point must have shape \(3,\) or \(4,\), got \(2,\)",
    ),
    (lambda: explain(scale(1e300), point=(1e300, 0, 0)), errors.ArgumentError, r"the point after M1 must stay within"),
]


@pytest.mark.parametrize(("call", "error", "message"), REFUSED, ids=[message[:60] for *_, message in REFUSED])
def test_bad_arguments_are_named(call: Callable[[], Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()
