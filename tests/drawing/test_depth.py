"""Reversed-Z depth, the eye of a view, the slope of depth, and lines that fade with distance."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Mesh, matrices, samples
from gpu_xform.drawing.depth import depth_slope_per_pixel, eye, fit_depth_cue, reverse_z
from tests.support.projection import world_to_clip, world_to_pixels
from tests.support.types import Array

POINTS = np.random.default_rng(5).uniform(-1.0, 1.0, (40, 3)) * (1.0, 0.6, 0.3) + (0.2, -0.1, 0.4)
EYE = np.array([3.0, 4.0, 12.0])


def projected(matrix: Array, points: Array) -> Array:
    clip: Array = points @ matrix[:, :3].T + matrix[:, 3]
    result: Array = clip[:, :3] / clip[:, 3:]
    return result


@pytest.mark.parametrize(
    "camera",
    [
        Camera.look_at(EYE, (0, 0, 0)),
        Camera.look_at(EYE, (0, 0, 0), orthographic=True),
        Camera.look_at(EYE, (0, 0, 0), near=12.4, far=13.1, orthographic=True),
        Camera.look_at(EYE, (0, 0, 0), far=1e30, orthographic=True),
        Camera.window((-1, 1), (-1, 1)),
    ],
    ids=["perspective", "parallel", "slice", "far plane at infinity", "window"],
)
def test_reversed_depth_falls_away_from_the_eye_and_the_picture_stays(camera: Camera) -> None:
    clip_from_world = camera.clip_from_world(1.5)
    before, after = projected(clip_from_world, POINTS), projected(reverse_z(clip_from_world, lambda: POINTS), POINTS)
    assert np.array_equal(before[:, :2], after[:, :2])
    nearness = -before[:, 2] if clip_from_world[2, :3].any() else POINTS[:, 2]
    assert np.array_equal(np.argsort(after[:, 2]), np.argsort(nearness))


def test_the_planes_of_a_parallel_view_move_in_on_the_points_and_never_out() -> None:
    wide = Camera.look_at(EYE, (0, 0, 0), orthographic=True).clip_from_world(1.0)
    assert np.ptp(projected(wide, POINTS)[:, 2]) < 1e-3
    depth = projected(reverse_z(wide, lambda: POINTS), POINTS)[:, 2]
    assert [depth.min(), depth.max()] == pytest.approx([0.25, 0.75])

    window = Camera.window((-1, 1), (-1, 1)).clip_from_world(1.0)
    depth = projected(reverse_z(window, lambda: 9.0 * POINTS), 9.0 * POINTS)[:, 2]
    assert [depth.min(), depth.max()] == pytest.approx([0.25, 0.75])

    narrow = Camera.look_at(EYE, (0, 0, 0), near=12.4, far=13.1, orthographic=True).clip_from_world(1.0)
    matrix = reverse_z(narrow, lambda: POINTS)
    inside = (projected(narrow, POINTS)[:, 2] >= 0.0) & (projected(narrow, POINTS)[:, 2] <= 1.0)
    assert 5 < inside.sum() < 35
    assert np.array_equal((projected(matrix, POINTS)[:, 2] >= 0.0) & (projected(matrix, POINTS)[:, 2] <= 1.0), inside)


@pytest.mark.parametrize("points", [POINTS + 1e4 * EYE, POINTS[:0], 3.0 * EYE[np.newaxis]], ids=["off", "none", "one"])
def test_a_parallel_view_of_few_or_distant_points_has_depth(points: Array) -> None:
    towards_eye = np.array([EYE, 1.001 * EYE]) / 20
    for camera in (Camera.look_at(EYE, (0, 0, 0), orthographic=True), Camera.window((-1, 1), (-1, 1))):
        matrix = reverse_z(camera.clip_from_world(1.0), lambda: points)
        far, near = projected(matrix, towards_eye)[:, 2]
        assert far < near
    assert len(points) != 1 or 0.0 < projected(matrix, points)[0, 2] < 1.0


STAND, TARGET = np.array([3.0, -1.0, 4.0]), np.array([0.4, 0.5, -0.2])
FRAMING_POINTS = samples.house().positions * [1.0, 1.3, 2.0]

CAMERAS = {
    "perspective": Camera.look_at(STAND, TARGET, near=0.7, far=30.0),
    "parallel": Camera.look_at(STAND, TARGET, near=0.7, far=30.0, orthographic=True),
    "fit": Camera.fit(FRAMING_POINTS),
    "parallel fit": Camera.fit(FRAMING_POINTS, orthographic=True),
    "window": Camera.window((-2, 3), (-1, 4)),
    "eye on z": Camera.eye_on_z(5.0, (-2, 2), (-1.5, 1.5)),
}


def matrix_of(view: str, aspect: float = 1.25) -> Array:
    return reverse_z(CAMERAS[view].clip_from_world(aspect), lambda: FRAMING_POINTS)


def at(matrix: Array, point: Array) -> Array:
    """Return where one point (3,) is, and how deep."""
    position: Array = projected(matrix, point[np.newaxis])[0]
    return position


@pytest.mark.parametrize("view", CAMERAS)
def test_what_is_nearer_is_deeper_and_all_framing_points_are_between_the_planes(view: str) -> None:
    matrix = matrix_of(view)
    towards = eye(matrix)
    for point in FRAMING_POINTS:
        here = at(matrix, point)
        nearer = point + 0.01 * (towards[:3] - towards[3] * point)
        assert at(matrix, nearer)[2] > here[2]
        assert at(matrix, nearer)[:2] == pytest.approx(here[:2])
        assert 0.0 < here[2] < 1.0


@pytest.mark.parametrize("mirror", [np.eye(4), matrices.reflect((1, 2, 0.5))], ids=["as it is", "mirrored"])
def test_the_eye_is_where_the_camera_stands_in_the_models_frame(mirror: Array) -> None:
    model = matrices.chain(mirror, matrices.rotate((1, 2, 3), 0.7), matrices.translate(0.3, 2.0, -1.0))
    inverse = np.linalg.inv(model)
    position = eye(matrix_of("perspective") @ model)
    assert position[3] > 0.0
    assert position[:3] / position[3] == pytest.approx((inverse @ np.append(STAND, 1.0))[:3])
    on_z = eye(matrix_of("eye on z"))
    assert on_z[:3] / on_z[3] == pytest.approx([0.0, 0.0, 5.0])
    for view, direction in (("parallel", STAND - TARGET), ("window", np.array([0.0, 0.0, 1.0]))):
        way = eye(matrix_of(view) @ model)
        expected = inverse[:3, :3] @ direction
        assert abs(way[3]) <= 1e-9 * np.abs(way).max()
        assert way[:3] / np.linalg.norm(way[:3]) == pytest.approx(expected / np.linalg.norm(expected))


@pytest.mark.parametrize("width", [100, 1500])
@pytest.mark.parametrize("view", CAMERAS)
def test_the_change_of_depth_over_a_pixel_is_that_of_a_step_as_long_as_a_pixel_is_wide(view: str, width: int) -> None:
    matrix = matrix_of(view)
    forward = np.cross(matrix[0, :3], matrix[1, :3])
    forward /= np.linalg.norm(forward)
    across = np.cross(matrix[1, :3], forward)
    across /= np.linalg.norm(across)
    rate, constant = depth_slope_per_pixel(matrix, width)
    middle = np.linalg.solve(np.array([matrix[0, :3], matrix[1, :3], forward]), [-matrix[0, 3], -matrix[1, 3], 0.0])
    center = FRAMING_POINTS.mean(axis=0)
    for distance in (-0.5, 0.0, 0.8):
        # On the axis of the view, level with the model.
        point = middle + forward * (forward @ center + distance - forward @ middle)
        tiny = 1e-5
        pixels = abs(at(matrix, point + tiny * across)[0] - at(matrix, point)[0]) * width / 2
        one_pixel = tiny / pixels
        step = 1e-4 * one_pixel
        change = abs(at(matrix, point + step * forward)[2] - at(matrix, point - step * forward)[2])
        wanted = change / 2e-4
        assert rate * at(matrix, point)[2] + constant == pytest.approx(wanted, rel=1e-3)


@pytest.mark.parametrize("view", CAMERAS)
def test_the_depth_cue_takes_all_of_its_amount_from_the_farthest_and_nothing_from_the_nearest(view: str) -> None:
    matrix = matrix_of(view)
    x, y, z, amount = fit_depth_cue(matrix, lambda: FRAMING_POINTS, 0.8)
    assert amount == 0.8
    towards = eye(matrix)
    lost, far = [], []
    for point in FRAMING_POINTS:
        clip = matrix @ np.append(point, 1.0)
        lost.append(x * clip[2] / clip[3] + y * clip[3] + z)
        forward = np.cross(matrix[0, :3], matrix[1, :3])
        far.append(-(forward / np.linalg.norm(forward)) @ point)
    assert towards.shape == (4,)
    assert min(lost) == pytest.approx(0.0, abs=1e-9)
    assert max(lost) == pytest.approx(1.0)
    wanted = (np.array(far) - min(far)) / np.ptp(far)
    assert lost == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize("width", [2.0, 12.0])
@pytest.mark.parametrize("orthographic", [True, False])
@pytest.mark.parametrize("antialias", [True, False])
def test_a_line_into_the_distance_fades_evenly(orthographic: bool, antialias: bool, width: float) -> None:
    line = Mesh([(-1.0, -0.2, 3.0), (2.0, 0.1, -9.0)], [(0, 1)])
    camera = Camera.look_at((0.0, 0.0, 8.0), (0.0, 0.0, 0.0), fov_y=50.0, orthographic=orthographic)
    size = (300, 200)
    style: dict[str, Any] = {"camera": camera, "size": size, "line_width": width, "antialias": antialias}
    shown = gx.render_array(line, depth_cue=0.75, **style)
    ends = world_to_pixels(line.positions, camera, size)
    w = world_to_clip(line.positions, camera, size)[:, 3]
    opacities = []
    for t in np.linspace(0.02, 0.98, 30):
        x, y = np.floor(ends[0] + t * (ends[1] - ends[0])).astype(int)
        along = (t / w[1]) / ((1 - t) / w[0] + t / w[1])
        opacities.append(1 - shown[y, x, 0] / 255)
        assert opacities[-1] == pytest.approx(1 - 0.75 * along, abs=0.03)
    assert (np.diff(opacities) < 0).all()
    plain = gx.render_array(line, **style)
    assert gx.render_array(line, depth_cue=0.0, **style).tobytes() == plain.tobytes()
