import numpy as np
import pytest

from gpu_xform import ArgumentError, Camera

EYE, TARGET = np.array([3.0, 4, 5]), np.array([1.0, -2, 0])


def projected(
    camera: Camera, points: list[np.ndarray[tuple[int, ...], np.dtype[np.float64]]], aspect: float
) -> list[list[float]]:
    clip = [camera.clip_from_world(aspect) @ np.append(point, 1.0) for point in points]
    return [(c[:3] / c[3]).tolist() for c in clip]


@pytest.mark.parametrize("aspect", [1.0, 1.6, 0.5])
def test_an_orthographic_look_keeps_sizes_at_every_distance(aspect: float) -> None:
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    camera = Camera.look_at(EYE, TARGET, fov_y=50, orthographic=True)
    half_height = np.linalg.norm(TARGET - EYE) * np.tan(np.radians(25))
    for away in (0.1, 1.0, 30.0):
        middle = EYE + away * forward
        corner = middle + half_height * (up - aspect * right)
        (x, y, z), (corner_x, corner_y, _) = projected(camera, [middle, corner], aspect)
        assert np.allclose([x, y, corner_x, corner_y], [0, 0, -1, 1], atol=1e-12)
        assert 0 < z < 1


def test_both_looks_agree_on_what_is_as_far_away_as_the_target() -> None:
    looks = [Camera.look_at(EYE, TARGET, orthographic=parallel) for parallel in (False, True)]
    across = np.cross(TARGET - EYE, (1.0, 2, 3)) * 0.05
    flat, parallel = ([p[:2] for p in projected(look, [TARGET, TARGET + across], 1.5)] for look in looks)
    assert np.allclose(flat, parallel, atol=1e-12)
    nearer = [projected(look, [TARGET + across + (EYE - TARGET) / 2], 1.5)[0][:2] for look in looks]
    assert not np.allclose(nearer[0], nearer[1], atol=1e-2)


def test_an_orthographic_look_cuts_off_what_lies_behind_the_eye() -> None:
    camera = Camera.look_at((0, 0, 5), (0, 0, 0), orthographic=True, near=1, far=9)
    depths = [p[2] for p in projected(camera, [np.array([0, 0, z]) for z in (4.0, 0.0, -4.0, 6.0)], 1.0)]
    assert np.allclose(depths, [0, 0.5, 1, -0.25])


@pytest.mark.parametrize("parallel", [False, True])
def test_a_look_is_refused_when_it_is_made(parallel: bool) -> None:
    with pytest.raises(ArgumentError, match="fov_y"):
        Camera.look_at(EYE, TARGET, fov_y=180, orthographic=parallel)
    with pytest.raises(ArgumentError, match="near"):
        Camera.look_at(EYE, TARGET, near=3, far=2, orthographic=parallel)
