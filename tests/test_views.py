"""What depth is made of a camera's, for pictures in which faces hide edges."""

import numpy as np
import pytest
from oracles import Array

from gpu_xform import Camera
from gpu_xform.views import with_depth

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
        Camera.window((-1, 1), (-1, 1)),
    ],
    ids=["perspective", "parallel", "slice", "window"],
)
def test_depth_falls_away_from_the_eye_and_the_picture_stays(camera: Camera) -> None:
    clip_from_world = camera.clip_from_world(1.5)
    before, after = projected(clip_from_world, POINTS), projected(with_depth(clip_from_world, lambda: POINTS), POINTS)
    assert np.array_equal(before[:, :2], after[:, :2])
    nearness = -before[:, 2] if clip_from_world[2, :3].any() else POINTS[:, 2]
    assert np.array_equal(np.argsort(after[:, 2]), np.argsort(nearness))


def test_the_planes_of_a_parallel_view_move_in_on_the_points_and_never_out() -> None:
    wide = Camera.look_at(EYE, (0, 0, 0), orthographic=True).clip_from_world(1.0)
    assert np.ptp(projected(wide, POINTS)[:, 2]) < 1e-3
    depth = projected(with_depth(wide, lambda: POINTS), POINTS)[:, 2]
    assert [depth.min(), depth.max()] == pytest.approx([0.25, 0.75])

    window = Camera.window((-1, 1), (-1, 1)).clip_from_world(1.0)
    depth = projected(with_depth(window, lambda: 9.0 * POINTS), 9.0 * POINTS)[:, 2]
    assert [depth.min(), depth.max()] == pytest.approx([0.25, 0.75])

    narrow = Camera.look_at(EYE, (0, 0, 0), near=12.4, far=13.1, orthographic=True).clip_from_world(1.0)
    matrix = with_depth(narrow, lambda: POINTS)
    inside = (projected(narrow, POINTS)[:, 2] >= 0.0) & (projected(narrow, POINTS)[:, 2] <= 1.0)
    assert 5 < inside.sum() < 35
    assert np.array_equal((projected(matrix, POINTS)[:, 2] >= 0.0) & (projected(matrix, POINTS)[:, 2] <= 1.0), inside)


@pytest.mark.parametrize("points", [POINTS + 1e4 * EYE, POINTS[:0], 3.0 * EYE[np.newaxis]], ids=["off", "none", "one"])
def test_a_parallel_view_of_nothing_much_has_a_depth(points: Array) -> None:
    towards_eye = np.array([EYE, 1.001 * EYE]) / 20
    for camera in (Camera.look_at(EYE, (0, 0, 0), orthographic=True), Camera.window((-1, 1), (-1, 1))):
        matrix = with_depth(camera.clip_from_world(1.0), lambda: points)
        far, near = projected(matrix, towards_eye)[:, 2]
        assert far < near
    assert len(points) != 1 or 0.0 < projected(matrix, points)[0, 2] < 1.0
