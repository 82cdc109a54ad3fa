"""Cameras: what they hold, how they frame it, and what they refuse."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gpu_xform import Camera, Mesh, matrices, render_array, samples
from gpu_xform.drawing.camera import extreme_points
from gpu_xform.drawing.sheet import lay_out_sheet
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError
from tests.support.types import Array

ASPECTS = [0.25, 1.0, 1.7, 6.0]
DIRECTIONS = [(0, 0, -1), (1, 0, 0), (-0.45, -0.4, -1.0), (0.3, 1.0, 0.2), (-5.0, 2.0, 0.1)]


def seen(camera: Camera, points: npt.ArrayLike, aspect: float = 1.0) -> Array:
    """Return x, y and depth of points (n, 3) in the picture: (n, 3)."""
    positions = np.asarray(points, np.float64)
    clip = np.column_stack([positions, np.ones(len(positions))]) @ camera.clip_from_world(aspect).T
    assert (clip[:, 3] > 0.0).all()
    result: Array = clip[:, :3] / clip[:, 3:]
    return result


@pytest.mark.parametrize("aspect", ASPECTS)
@pytest.mark.parametrize("direction", DIRECTIONS, ids=str)
@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize(("margin", "fov_y"), [(0.05, 30.0), (0.0, 100.0), (0.3, 2.0)])
def test_a_fitted_model_lies_within_the_margins_and_touches_them(
    aspect: float, direction: tuple[float, float, float], orthographic: bool, margin: float, fov_y: float
) -> None:
    model = samples.house().transformed(matrices.chain(matrices.scale(1, 2, 0.5), matrices.translate(30, -20, 10)))
    camera = Camera.fit(model, direction=direction, margin=margin, fov_y=fov_y, orthographic=orthographic)
    ndc = seen(camera, model.positions, aspect)
    filled = 1.0 - 2.0 * margin
    extent = np.abs(ndc[:, :2]).max(axis=0)
    assert (extent <= filled + 1e-9).all()
    assert extent.max() == pytest.approx(filled, abs=1e-9)
    tight = int(np.argmax(extent))
    assert ndc[:, tight].min() == pytest.approx(-filled, abs=1e-9)
    assert ndc[:, tight].max() == pytest.approx(filled, abs=1e-9)
    assert (ndc[:, 2] > 0.0).all()
    assert (ndc[:, 2] < 1.0).all()


@given(
    points=arrays(np.float64, (5, 3), elements=st.floats(-100.0, 100.0)),
    aspect=st.floats(0.1, 10.0),
    direction=arrays(np.float64, 3, elements=st.floats(-1.0, 1.0)),
    fov_y=st.floats(1.0, 150.0),
    orthographic=st.booleans(),
)
def test_any_points_are_held_by_the_margins(
    points: Array, aspect: float, direction: Array, fov_y: float, orthographic: bool
) -> None:
    assume(np.linalg.norm(np.cross(direction, (0, 1, 0))) > 1e-2)
    camera = Camera.fit(points, direction=direction, fov_y=fov_y, orthographic=orthographic)
    ndc = seen(camera, points, aspect)
    assert np.abs(ndc[:, :2]).max() <= 0.9 + 1e-6
    assert ndc[:, 2].min() >= 0.0
    assert ndc[:, 2].max() <= 1.0


@pytest.mark.parametrize("size", [1e-290, 1e-299, 1e-305, 1e-311, 5e-324, 0.0])
@pytest.mark.parametrize("aspect", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("orthographic", [False, True])
def test_points_at_nearly_one_place_are_held(size: float, aspect: float, orthographic: bool) -> None:
    """Of 1e-308 and less, whose reciprocal overflows, a parallel view was refused."""
    points = np.array([[size, 0, 0], [0, 0, 0], [0, 2 * size, 0]])
    for near in (points, points + np.array([3, 0, 0])):
        camera = Camera.fit(near, direction=(1, 1, 1), orthographic=orthographic)
        ndc = seen(camera, near, aspect)
        assert np.abs(ndc[:, :2]).max() <= 0.9 + 1e-6
        assert 0.0 <= ndc[:, 2].min() <= ndc[:, 2].max() <= 1.0


@pytest.mark.parametrize("distance", [1e-300, 1e-200, 1e-40, 1e-30, 1e-9, 1.0, 1e9, 1e17, 1e40, 1e200, 1e300])
@pytest.mark.parametrize("direction", [(0.3, -0.77, 0.123), (1, 0, 0), (-1, -1, -1)], ids=str)
@pytest.mark.parametrize("orthographic", [False, True])
def test_one_point_is_in_the_middle_wherever_it_is(
    distance: float, direction: tuple[float, float, float], orthographic: bool
) -> None:
    """Beyond 1e16 it was not in a parallel view, and within 1e-36 not in a picture, of single precision."""
    point = distance * np.array([direction])
    camera = Camera.fit(point, direction=DIRECTIONS[2], orthographic=orthographic)
    assert np.abs(seen(camera, point)[:, :2]).max() <= 0.01
    ink = 255.0 - render_array(point, size=(20, 20), camera=camera, point_size=4.0)[..., 0]
    middle = [np.average(np.arange(20), weights=ink.sum(axis)) for axis in (0, 1)]
    assert np.allclose(middle, 9.5, atol=0.1)  # of a picture, 0.01 is 0.1 pixels


def test_a_fitted_camera_looks_along_its_direction_with_up_upwards() -> None:
    points = np.vstack([np.eye(3), -np.eye(3)])
    origin, x, y, z = (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)
    for direction, up, right_of, above, nearer in [
        ((0, 0, -1), y, x, y, z),
        ((-1, 0, 0), y, (0, 0, -1), y, x),
        ((0, -1, 0), (0, 0, -1), x, (0, 0, -1), y),
    ]:
        for orthographic in (False, True):
            camera = Camera.fit(points, direction=direction, up=up, orthographic=orthographic)
            middle, right, top, front = seen(camera, np.array([origin, right_of, above, nearer], float))
            assert right[0] > middle[0] + 0.5
            assert right[1] == pytest.approx(middle[1])
            assert top[1] > middle[1] + 0.5
            assert top[0] == pytest.approx(middle[0])
            assert front[2] < middle[2]


@pytest.mark.parametrize("orthographic", [False, True])
def test_the_default_direction_turns_with_up(orthographic: bool) -> None:
    house = samples.house()
    usual = Camera.fit(house, orthographic=orthographic).clip_from_world(1.5)
    explicit = Camera.fit(house, direction=(-0.45, -0.4, -1.0), orthographic=orthographic)
    assert np.array_equal(explicit.clip_from_world(1.5), usual)
    for up, turn in [
        ((0, 0, 1), matrices.rotate_x(90, degrees=True)),
        ((0, 0, -7e-5), matrices.rotate_x(-90, degrees=True)),
        ((1, 0, 0), matrices.rotate_z(-90, degrees=True)),
        ((0, -1e200, 0), matrices.rotate_x(180, degrees=True)),
        ((0, 3, 4), matrices.rotate_x(np.arctan2(4, 3))),
    ]:
        turned = house.transformed(turn)
        camera = Camera.fit(turned, up=up, orthographic=orthographic)
        np.testing.assert_allclose(camera.clip_from_world(1.5) @ turn, usual, rtol=0, atol=1e-12)
        held = extreme_points(turned.positions, 1.5, up=up, orthographic=orthographic)
        few = Camera.fit(held, up=up, orthographic=orthographic)
        np.testing.assert_allclose(few.clip_from_world(1.5) @ turn, usual, rtol=0, atol=1e-12)


def test_a_cube_looks_larger_in_front_in_perspective_and_not_in_parallel() -> None:
    front, back = np.array([(-1.0, 0, 1), (1, 0, 1)]), np.array([(-1.0, 0, -1), (1, 0, -1)])
    for orthographic in (False, True):
        camera = Camera.fit(samples.cube(), direction=(0, 0, -1), orthographic=orthographic)
        widths = [np.ptp(seen(camera, ends)[:, 0]) for ends in (front, back)]
        assert (widths[0] == pytest.approx(widths[1])) == orthographic
        assert widths[0] >= widths[1] - 1e-12


@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize("point", [(0.0, 0.0, 0.0), (3.0, -4.0, 5.0), (1e7, 2e7, -3e7), (1e-30, 0.0, 0.0)])
def test_a_single_point_is_seen_in_the_middle(point: tuple[float, float, float], orthographic: bool) -> None:
    ndc = seen(Camera.fit([point], orthographic=orthographic), [point], 1.5)[0]
    assert np.abs(ndc[:2]).max() < 1e-4
    assert 0.0 < ndc[2] < 1.0


@pytest.mark.parametrize("direction", [(0, 0, -1), (1, 0, 0), (-0.45, -0.4, -1.0)])
@pytest.mark.parametrize("orthographic", [False, True])
def test_a_flat_model_is_framed_face_on_edge_on_and_aslant(
    direction: tuple[float, float, float], orthographic: bool
) -> None:
    flat = samples.grid(3)
    ndc = seen(Camera.fit(flat, direction=direction, orthographic=orthographic), flat.positions, 1.3)
    assert np.abs(ndc[:, :2]).max() == pytest.approx(0.9)
    assert (ndc[:, 2] > 0.0).all()
    assert (ndc[:, 2] < 1.0).all()


@pytest.mark.parametrize("size", [1e-200, 1e-30, 1e30, 1e200])
@pytest.mark.parametrize("orthographic", [False, True])
def test_a_model_of_any_size_fills_the_picture(size: float, orthographic: bool) -> None:
    points = samples.house().positions * size
    ndc = seen(Camera.fit(points, orthographic=orthographic), points)
    assert np.abs(ndc[:, :2]).max() == pytest.approx(0.9)


def test_look_at_puts_the_target_in_the_middle_and_the_field_of_view_at_the_edge() -> None:
    eye, target = np.array([3.0, 4.0, 5.0]), np.array([-1.0, 0.5, 2.0])
    camera = Camera.look_at(eye, target, fov_y=50.0)
    assert seen(camera, [target], 1.6)[0, :2] == pytest.approx([0.0, 0.0], abs=1e-12)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    tangent = np.tan(np.radians(25.0))
    corner = eye + 7.0 * (forward + tangent * up + 1.6 * tangent * right)
    assert seen(camera, [corner], 1.6)[0, :2] == pytest.approx([1.0, 1.0])


def test_look_at_sees_from_near_to_far() -> None:
    camera = Camera.look_at((0, 0, 0), (0, 0, -2), near=0.5, far=8.0)
    assert seen(camera, [(0, 0, -0.5), (0, 0, -8)])[:, 2] == pytest.approx([0.0, 1.0])
    default = Camera.look_at((0, 0, 0), (0, 0, -2))
    assert seen(default, [(0, 0, -0.002), (0, 0, -2000)])[:, 2] == pytest.approx([0.0, 1.0])


def test_a_window_shows_its_corners_in_the_corners() -> None:
    camera = Camera.window((-1.0, 5.0), (2.0, 4.0))
    corners = [(-1, 2, 0.5), (5, 2, -3.0), (-1, 4, 100.0), (5, 4, 0)]
    expected = [(-1, -1), (1, -1), (-1, 1), (1, 1)]
    assert seen(camera, corners, 3.0)[:, :2] == pytest.approx(np.array(expected))
    depths = seen(camera, corners, 3.0)[:, 2]
    assert ((depths > 0) & (depths < 1)).all()


@pytest.mark.parametrize("aspect", ASPECTS)
@pytest.mark.parametrize("camera", [Camera.window((-1, 5), (2, 4)), Camera.eye_on_z(4.0, (-1, 5), (2, 4))])
def test_a_window_holds_its_limits_and_never_stretches(camera: Camera, aspect: float) -> None:
    center, right, top = seen(camera, [(2, 3, 0), (3, 3, 0), (2, 4, 0)], aspect)
    assert center[:2] == pytest.approx([0, 0])
    assert (right - center)[0] * aspect == pytest.approx((top - center)[1])
    corners = np.abs(seen(camera, [(-1, 2, 0), (5, 4, 0)], aspect)[:, :2])
    assert corners.max() == pytest.approx(1.0)
    assert corners[0] == pytest.approx(corners[1])


@given(
    d=st.floats(0.1, 100.0),
    points=arrays(np.float64, (4, 3), elements=st.floats(-50.0, 50.0)),
)
def test_the_eye_on_z_sees_as_the_lecture_computes(d: float, points: Array) -> None:
    # x* = x / (1 - z/d), y* = y / (1 - z/d)
    visible = points[points[:, 2] < d * 0.99]
    assume(len(visible) > 0)
    camera = Camera.eye_on_z(d, (-2.0, 4.0), (-1.0, 2.0))
    ndc = seen(camera, visible, 2.0)
    image = visible[:, :2] / (1.0 - visible[:, 2:] / d)
    np.testing.assert_allclose(ndc[:, :2], (image - [1.0, 0.5]) / [3.0, 1.5], rtol=1e-9, atol=1e-9)
    assert (ndc[:, 2] > 0.0).all()
    assert (ndc[:, 2] < 1.0).all()


def test_what_is_at_or_behind_the_eye_on_z_is_cut_off_by_depth() -> None:
    clip = Camera.eye_on_z(2.0, (-1, 1), (-1, 1)).clip_from_world(1.0)
    for z, inside in [(-100.0, True), (0.0, True), (1.9, True), (2.0, False), (2.1, False), (50.0, False)]:
        depth, w = (clip @ [0.3, 0.2, z, 1.0])[2:]
        assert (depth > 0.0) == inside
        assert depth < w


def test_nearer_to_the_eye_on_z_is_less_deep() -> None:
    depths = seen(Camera.eye_on_z(2.0, (-1, 1), (-1, 1)), [(0, 0, z) for z in (1.9, 1.0, 0.0, -5.0, -1e5)])[:, 2]
    assert (np.diff(depths) > 0).all()


def test_a_mesh_and_its_points_are_fitted_alike_and_aspects_need_no_new_camera() -> None:
    mesh = samples.house()
    for aspect in ASPECTS:
        expected = Camera.fit(mesh).clip_from_world(aspect)
        assert np.array_equal(Camera.fit(mesh.positions).clip_from_world(aspect), expected)
        assert np.array_equal(Camera.fit(mesh.positions.tolist()).clip_from_world(aspect), expected)


def test_a_camera_tells_how_it_was_made() -> None:
    assert repr(Camera.window((-1, 5), (2, 4))) == "Camera.window(xlim=(-1, 5), ylim=(2, 4))"
    assert repr(Camera.eye_on_z(2.5, (-1, 5), (2, 4))) == "Camera.eye_on_z(2.5, xlim=(-1, 5), ylim=(2, 4))"
    assert repr(Camera.look_at((1, 2, 3), (0, 0, 0))).startswith("Camera.look_at(eye=(1, 2, 3), target=(0, 0, 0)")
    assert repr(Camera.fit(samples.cube(), margin=0.2)).startswith("Camera.fit(direction=")


@pytest.mark.parametrize(
    "made",
    [
        "Camera.fit(direction=None, up=(0, 0, 1), margin=0.05)",
        "Camera.fit(direction=(0, 0, -1), up=(0.0, 1.0, 0.0), margin=0.2, fov_y=60, orthographic=True)",
        "Camera.fit(direction=(0, 0, -1), up=(0.0, 1.0, 0.0), margin=0.2, orthographic=True)",
        "Camera.look_at(eye=(1, 2, 3), target=(0, 0, 0), up=(0.0, 1.0, 0.0), fov_y=30.0)",
        "Camera.look_at(eye=(1, 2, 3), target=(0, 0, 0), up=(0, 0, 1), fov_y=50, near=1, far=9.5, orthographic=True)",
        "Camera.look_at(eye=(1, 2, 3), target=(0, 0, 0), up=(0, 0, 1), fov_y=50, far=9.5)",
    ],
)
def test_what_a_camera_tells_makes_another_that_tells_the_same(made: str) -> None:
    names = {"Camera": Camera, "house": samples.house()}
    camera = eval(made.replace("fit(", "fit(house, "), names)  # noqa: S307 - the text is ours
    assert repr(camera) == made


WRONG: list[tuple[Any, type[Exception], str]] = [
    (lambda: Camera.fit(Mesh([])), MeshError, "without points"),
    (lambda: Camera.fit(np.empty((0, 3))), MeshError, "without points"),
    (lambda: Camera.fit([1.0, 2.0, 3.0]), ArgumentError, r"^model must be a Mesh or points of shape \(n, 3\)"),
    (lambda: Camera.fit([(0.0, 0.0, np.inf)]), ArgumentError, "^model must be finite"),
    (lambda: Camera.fit("cube.obj"), ArgumentTypeError, "model"),
    (lambda: Camera.fit(samples.cube(), margin=0.5), ArgumentError, r"^margin must lie in \[-50, 0\.5\), got 0\.5$"),
    (lambda: Camera.fit(samples.cube(), margin=-51), ArgumentError, "margin"),
    (lambda: Camera.fit(samples.cube(), fov_y=180.0), ArgumentError, "fov_y"),
    (lambda: Camera.fit(samples.cube(), direction=(0, 0, 0)), ArgumentError, "direction"),
    (lambda: Camera.fit(samples.cube(), up=(0, 0, 0)), ArgumentError, "^up must not be the zero vector$"),
    (lambda: Camera.fit(samples.cube(), up=(0, 1)), ArgumentError, r"^up must have shape \(3,\), got \(2,\)$"),
    (lambda: Camera.fit(samples.cube(), up="w"), ArgumentError, "^up must be three numbers, or an axis such as"),
    (lambda: Camera.look_at((1, 2, 3), (1, 2, 3)), ArgumentError, "eye and target must differ"),
    (lambda: Camera.look_at((0, 0, 0), (0, 1, 0)), ArgumentError, "up must not be parallel"),
    (lambda: Camera.look_at((0, 0, 0), (0, 0, 1), fov_y=0), ArgumentError, "fov_y"),
    (lambda: Camera.look_at((0, 0, 0), (0, 0, 1), near=2, far=1), ArgumentError, "near must be less than far"),
    (lambda: Camera.look_at((0, 0, 0), (0, 0, 1), near=0), ArgumentError, "near must be positive"),
    (lambda: Camera.window((1, 1), (0, 1)), ArgumentError, r"^xlim must ascend, got \(1\.0, 1\.0\)$"),
    (lambda: Camera.window((0, 1), (1, 0)), ArgumentError, r"^ylim must ascend, got \(1\.0, 0\.0\)$"),
    (lambda: Camera.window((0, 1, 2), (0, 1)), ArgumentError, "xlim must have shape"),
    (lambda: Camera.eye_on_z(0.0, (0, 1), (0, 1)), ArgumentError, r"^d must be positive, got 0\.0$"),
    (lambda: Camera.eye_on_z(-3.0, (0, 1), (0, 1)), ArgumentError, "d must be positive"),
    (lambda: Camera.eye_on_z(np.nan, (0, 1), (0, 1)), ArgumentError, "d must be finite"),
]


@pytest.mark.parametrize(("make", "error", "message"), WRONG, ids=[message for _, _, message in WRONG])
def test_an_impossible_camera_is_refused_when_it_is_made(make: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        make()


@pytest.mark.slow
@given(
    points=arrays(np.float64, (300, 3), elements=st.floats(-100.0, 100.0)),
    aspect=st.floats(0.1, 10.0),
    direction=arrays(np.float64, 3, elements=st.floats(-1.0, 1.0)),
    margin=st.floats(0.0, 0.45),
    fov_y=st.floats(1.0, 150.0),
    orthographic=st.booleans(),
)
def test_the_extreme_points_so_far_decide_where_a_camera_stands(
    points: Array, aspect: float, direction: Array, margin: float, fov_y: float, orthographic: bool
) -> None:
    assume(np.linalg.norm(np.cross(direction, (0, 1, 0))) > 1e-2)
    options: dict[str, Any] = {
        "direction": direction,
        "margin": margin,
        "fov_y": fov_y,
        "orthographic": orthographic,
    }
    held = np.empty((0, 3))
    for part in np.split(points, 6):
        held = extreme_points(np.concatenate([held, part]), aspect, **options)
        assert len(held) <= 14
    few, all_of_them = Camera.fit(held, **options), Camera.fit(points, **options)
    expected = all_of_them.clip_from_world(aspect)
    np.testing.assert_allclose(few.clip_from_world(aspect), expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_points_too_far_out_for_a_camera_are_named() -> None:
    with pytest.raises(ArgumentError, match=r"^model must have coordinates of at most 1e\+300, got -1e\+301$"):
        Camera.fit([(0, 0, 0), (0, -1e301, 1)])
    cube = samples.cube()
    with pytest.raises(ArgumentError, match=r"^models must have coordinates of at most 1e\+300, got "):
        render_array(cube, transform=matrices.translate(0, 1e308, 0), size=(20, 20))
    camera = Camera.look_at((3, 2, 5), (0, 0, 0))
    with pytest.raises(ArgumentError, match=r"^transform must be a matrix of numbers that do not overflow in the pict"):
        render_array(cube, transform=matrices.scale(1e308), camera=camera, size=(20, 20))


EYE, TARGET = np.array([3.0, 4, 5]), np.array([1.0, -2, 0])


def project(camera: Camera, points: list[Array], aspect: float) -> list[list[float]]:
    clip = [camera.clip_from_world(aspect) @ np.append(point, 1.0) for point in points]
    return [(c[:3] / c[3]).tolist() for c in clip]


@pytest.mark.parametrize("aspect", [1.0, 1.6, 0.5])
def test_an_orthographic_camera_keeps_sizes_at_every_distance(aspect: float) -> None:
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    camera = Camera.look_at(EYE, TARGET, fov_y=50, orthographic=True)
    half_height = np.linalg.norm(TARGET - EYE) * np.tan(np.radians(25))
    for away in (0.1, 1.0, 30.0):
        middle = EYE + away * forward
        corner = middle + half_height * (up - aspect * right)
        (x, y, z), (corner_x, corner_y, _) = project(camera, [middle, corner], aspect)
        assert np.allclose([x, y, corner_x, corner_y], [0, 0, -1, 1], atol=1e-12)
        assert 0 < z < 1


def test_both_projections_agree_on_what_is_as_far_away_as_the_target() -> None:
    cameras = [Camera.look_at(EYE, TARGET, orthographic=parallel) for parallel in (False, True)]
    across = np.cross(TARGET - EYE, (1.0, 2, 3)) * 0.05
    flat, parallel = ([p[:2] for p in project(camera, [TARGET, TARGET + across], 1.5)] for camera in cameras)
    assert np.allclose(flat, parallel, atol=1e-12)
    nearer = [project(camera, [TARGET + across + (EYE - TARGET) / 2], 1.5)[0][:2] for camera in cameras]
    assert not np.allclose(nearer[0], nearer[1], atol=1e-2)


def test_an_orthographic_camera_cuts_off_what_lies_behind_the_eye() -> None:
    camera = Camera.look_at((0, 0, 5), (0, 0, 0), orthographic=True, near=1, far=9)
    depths = [p[2] for p in project(camera, [np.array([0, 0, z]) for z in (4.0, 0.0, -4.0, 6.0)], 1.0)]
    assert np.allclose(depths, [0, 0.5, 1, -0.25])


@pytest.mark.parametrize("parallel", [False, True])
def test_impossible_planes_are_refused_when_a_camera_is_made(parallel: bool) -> None:
    with pytest.raises(ArgumentError, match="fov_y"):
        Camera.look_at(EYE, TARGET, fov_y=180, orthographic=parallel)
    with pytest.raises(ArgumentError, match="near"):
        Camera.look_at(EYE, TARGET, near=3, far=2, orthographic=parallel)


@pytest.mark.parametrize("orthographic", [False, True])
def test_a_focal_point_right_before_the_eye_cuts_nothing_off(orthographic: bool) -> None:
    cube = samples.cube().transformed(matrices.scale(400))
    pictures = []
    for distance in (5000.0, 1.0):
        target, angle = (0.0, 0.0, 5000.0 - distance), 30.0
        if orthographic:  # as large in the picture
            angle = 2.0 * np.degrees(np.arctan(np.tan(np.radians(15.0)) * 5000.0 / distance))
        camera = Camera.look_at((0, 0, 5000), target, fov_y=float(angle), orthographic=orthographic)
        pictures.append(render_array(cube, size=(100, 80), camera=camera, hidden="remove"))
    assert (pictures[0] < 128).any()
    assert np.abs(pictures[0].astype(int) - pictures[1]).max() <= 1


def test_planes_that_are_given_stay() -> None:
    cube = samples.cube()
    camera = Camera.look_at((0, 0, 10), (0, 0, 0), near=10.0)  # through the cube
    assert (render_array(cube, size=(100, 80), camera=camera) < 128).any()
    behind = Camera.look_at((0, 0, 10), (0, 0, 0), far=5.0)
    assert (render_array(cube, size=(100, 80), camera=behind) == 255).all()


def test_a_camera_among_the_points_shows_near_ones_and_far_ones() -> None:
    points = np.array([[0.0, 0, -0.01], [0, 0.001, -50.0], [0, 0, 80.0]])
    camera = Camera.look_at((0, 0, 0), (0, 0, -1), fov_y=90.0)
    picture = render_array(Mesh(points[:1]), size=(50, 50), camera=camera)
    assert (picture < 128).any()
    fitted = camera.with_planes_around(lambda: points)
    depth = seen(fitted, points[:2])[:, 2]
    assert ((depth > 0) & (depth < 1)).all()
    assert camera.with_planes_around(lambda: points[2:]) is camera  # all is behind


def test_a_camera_whose_planes_are_fitted_says_so_and_is_made_again_by_what_it_says() -> None:
    points = samples.cube().positions
    camera = Camera.look_at((3, 2, 5), (0, 0.5, 0), fov_y=30.0, orthographic=True, near=0.5)
    fitted = camera.with_planes_around(lambda: points)
    assert repr(fitted).startswith("Camera.look_at(eye=(3, 2, 5), target=(0, 0.5, 0), up=(0.0, 1.0, 0.0), fov_y=30.0, ")
    assert "near=0.5" in repr(fitted)
    assert repr(fitted).endswith("orthographic=True)")
    again: Camera = eval(repr(fitted), {"Camera": Camera})  # noqa: S307
    assert np.array_equal(again.clip_from_world(1.5), fitted.clip_from_world(1.5))
    depths = np.column_stack((points, np.ones(8))) @ fitted.clip_from_world(1.5)[2]
    assert ((depths > 0.0) & (depths < 1.0)).all()


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, 1), (2, 0, 0), (0, -1, 0)])
def test_a_view_along_the_up_direction_is_turned_as_the_view_of_a_sheet(up: Any) -> None:
    points = np.random.default_rng(3).normal(size=(9, 3))
    for sign, name in ((-1.0, "top"), (1.0, "bottom")):
        plan = Camera.fit(points, direction=sign * np.array(up), up=up, orthographic=True)
        [view] = lay_out_sheet(points, [name], (200, 200), up, is_third_angle=True)
        aspect = view.size[0] / view.size[1]
        found, expected = seen(plan, points, aspect)[:, :2], seen(view.camera, points, aspect)[:, :2]
        scale = np.ptp(found, axis=0) / np.ptp(expected, axis=0)
        assert np.allclose(scale, scale[0])
        assert np.allclose(found - found[0], scale * (expected - expected[0]), atol=1e-9)


def test_keywords_of_other_cameras_are_told_of_them() -> None:
    with pytest.raises(ArgumentTypeError, match=r"such as Camera.look_at\(eye, target\), got 'azimuth'"):
        render_array(samples.cube(), camera={"azimuth": 30}, size=(8, 8))
