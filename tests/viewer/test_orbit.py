import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import Camera
from gpu_xform.viewer.orbit import SIDES, BoundingSphere, Orbit
from tests.support.types import Array

ASPECT = 1.5
BOUNDS = BoundingSphere(np.array([1.0, -2.0, 0.5]), 3.0)
POINTS = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3)) * 1.7 + BOUNDS.center

angles = st.floats(-10.0, 10.0)
places = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)).map(np.array)


def cameras() -> list[Camera]:
    fits = [
        Camera.fit(POINTS, orthographic=orthographic, direction=direction, up=up)
        for orthographic in (False, True)
        for direction, up in [((-0.45, -0.4, -1.0), (0, 1, 0)), ((0.1, 0.1, -1.0), (0, 0, 1)), ((0, -1, 0), (0, 0, -1))]
    ]
    return [
        *fits,
        Camera.look_at((9, 3, -4), BOUNDS.center, up=(0.3, 1, 0.2), fov_y=50),
        Camera.look_at((9, 3, -4), (0, 0, 0), orthographic=True),
        Camera.window((-4, 3), (-5, 2)),
        Camera.eye_on_z(9, (-4, 3), (-5, 1)),
    ]


CAMERAS = cameras()


def orbits() -> st.SearchStrategy[Orbit]:
    """Orbits of every kind, somewhere."""

    def moved(camera: Camera, sideways: float, downwards: float, factor: float, at: Array) -> Orbit:
        orbit = Orbit.from_camera(camera, ASPECT, BOUNDS).rotated(sideways, downwards)
        return orbit.zoomed(factor, at, ASPECT)

    return st.builds(moved, st.sampled_from(CAMERAS), angles, angles, st.floats(0.1, 10.0), places)


def seen(camera: Camera, points: Array, aspect: float = ASPECT) -> Array:
    """Where points (n, 3) are in the picture: (n, 2)."""
    clip = np.column_stack([points, np.ones(len(points))]) @ camera.clip_from_world(aspect).T
    assert (clip[:, 3] > 0.0).all()
    ndc: Array = clip[:, :2] / clip[:, 3:]
    return ndc


def angle_between(a: Orbit, b: Orbit) -> float:
    """The angle by which the axes of one are turned from those of the other."""
    return 2.0 * math.asin(min(1.0, float(np.linalg.norm(a.axes - b.axes)) / math.sqrt(8.0)))


def assert_same(a: Orbit, b: Orbit) -> None:
    np.testing.assert_allclose(a.camera.clip_from_world(ASPECT), b.camera.clip_from_world(ASPECT), atol=1e-9, rtol=1e-9)


@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
@pytest.mark.parametrize("aspect", [0.5, 1.0, 1.5])
def test_an_orbit_begins_with_what_its_camera_sees(camera: Camera, aspect: float) -> None:
    orbit = Orbit.from_camera(camera, aspect, BOUNDS)
    np.testing.assert_allclose(seen(orbit.camera, POINTS, aspect), seen(camera, POINTS, aspect), atol=1e-12)
    np.testing.assert_allclose(orbit.axes @ orbit.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(orbit.axes) == pytest.approx(1.0)


@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
def test_nothing_of_the_model_is_cut_off_before_or_behind(camera: Camera) -> None:
    orbit = Orbit.from_camera(camera, ASPECT, BOUNDS)
    for farther in (1.0, 20.0):
        shown = orbit.zoomed(farther, np.zeros(2), ASPECT)
        clip = np.column_stack([POINTS, np.ones(len(POINTS))]) @ shown.camera.clip_from_world(ASPECT).T
        depth = clip[:, 2] / clip[:, 3]
        assert depth.min() > 0.0
        assert depth.max() < 1.0


def test_a_parallel_view_from_close_by_still_shows_what_lies_before_its_target() -> None:
    orbit = Orbit.from_camera(CAMERAS[3], ASPECT, BOUNDS).zoomed(0.01, np.zeros(2), ASPECT)
    depth = (np.column_stack([POINTS, np.ones(len(POINTS))]) @ orbit.camera.clip_from_world(ASPECT).T)[:, 2]
    assert depth.min() > 0.0
    assert depth.max() < 1.0


@given(orbits(), angles, angles)
def test_rotation_keeps_the_distance_and_the_target_in_its_place(
    orbit: Orbit, sideways: float, downwards: float
) -> None:
    turned = orbit.rotated(sideways, downwards)
    assert np.linalg.norm(turned.eye - orbit.target) == pytest.approx(orbit.distance)
    np.testing.assert_array_equal(turned.target, orbit.target)
    np.testing.assert_allclose(seen(turned.camera, turned.target[None])[0], orbit.shift, atol=1e-9)
    np.testing.assert_allclose(turned.axes @ turned.axes.T, np.eye(3), atol=1e-12)


@given(orbits(), st.integers(1, 20))
def test_a_full_turn_comes_back(orbit: Orbit, steps: int) -> None:
    turned = orbit
    for _ in range(steps):
        turned = turned.rotated(2.0 * math.pi / steps, 0.0)
    assert_same(turned, orbit)


@given(orbits(), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_a_rotation_is_never_larger_than_its_drag(orbit: Orbit, sideways: float, downwards: float) -> None:
    # Wherever it looks from, the poles included: no small drag makes the picture jump.
    turned = orbit.rotated(sideways, downwards)
    assert angle_between(turned, orbit) <= abs(sideways) + abs(downwards) + 1e-7


@given(orbits(), angles, angles)
def test_the_world_is_never_upside_down(orbit: Orbit, sideways: float, downwards: float) -> None:
    assert orbit.rotated(sideways, downwards).axes[1] @ orbit.up >= -1e-12


@given(st.sampled_from(CAMERAS[:6]), angles)
def test_a_level_view_stays_level(camera: Camera, sideways: float) -> None:
    orbit = Orbit.from_camera(camera, ASPECT, BOUNDS)
    assert orbit.rotated(sideways, 0.3).rotated(0.0, -9.0).axes[0] @ orbit.up == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("downwards", [9.0, -9.0])
def test_rotation_stops_at_the_poles_and_comes_back_the_way_it_went(downwards: float) -> None:
    orbit = Orbit.from_camera(CAMERAS[0], ASPECT, BOUNDS)
    pole = orbit.rotated(0.0, downwards)
    assert pole.axes[2] @ orbit.up == pytest.approx(math.copysign(1.0, downwards))
    assert_same(pole.rotated(0.0, downwards), pole)
    back = pole.rotated(0.0, -downwards / 20)
    assert angle_between(back, pole) == pytest.approx(9.0 / 20)
    assert angle_between(back, orbit) == pytest.approx(abs(angle_between(pole, orbit) - 9.0 / 20))


@pytest.mark.parametrize(
    ("sideways", "downwards", "expected"),
    [(0.1, 0.0, (1, 0)), (-0.1, 0.0, (-1, 0)), (0.0, 0.1, (0, -1)), (0.0, -0.1, (0, 1))],
)
def test_what_is_in_front_follows_the_pointer(sideways: float, downwards: float, expected: tuple[float, float]) -> None:
    orbit = Orbit.from_camera(Camera.look_at((0, 0, 9), (0, 0, 0)), ASPECT, BoundingSphere(np.zeros(3), 1.0))
    front = np.array([[0.0, 0.0, 1.0]])
    way = seen(orbit.rotated(sideways, downwards).camera, front)[0]
    np.testing.assert_allclose(way / np.linalg.norm(way), expected, atol=1e-12)


@given(orbits(), places, places, st.floats(0.3, 3.0))
def test_a_pan_takes_what_is_under_the_pointer_along(orbit: Orbit, start: Array, end: Array, aspect: float) -> None:
    held = orbit.point_at(start, aspect)
    np.testing.assert_allclose(seen(orbit.camera, held[None], aspect)[0], start, atol=1e-9)
    panned = orbit.panned(start, end, aspect)
    np.testing.assert_allclose(seen(panned.camera, held[None], aspect)[0], end, atol=1e-7)
    np.testing.assert_array_equal(panned.axes, orbit.axes)
    assert panned.distance == orbit.distance


@given(orbits(), places, st.floats(0.2, 5.0), st.floats(0.3, 3.0))
def test_zooming_keeps_what_is_under_the_pointer(orbit: Orbit, at: Array, factor: float, aspect: float) -> None:
    held = orbit.point_at(at, aspect)
    zoomed = orbit.zoomed(factor, at, aspect)
    np.testing.assert_allclose(seen(zoomed.camera, held[None], aspect)[0], at, atol=1e-7)
    assert zoomed.distance == pytest.approx(factor * orbit.distance)
    beside = held + 0.01 * orbit.distance * orbit.axes[0]
    before, after = (seen(shown.camera, np.array([held, beside]), aspect) for shown in (orbit, zoomed))
    grown = (after[1] - after[0])[0] / (before[1] - before[0])[0]
    assert grown == pytest.approx(1.0 / factor, rel=1e-6)


@given(orbits(), st.sampled_from([1e-9, 1e9]))
def test_zooming_stops_far_out_and_close_by(orbit: Orbit, factor: float) -> None:
    end = orbit.zoomed(factor, np.zeros(2), ASPECT)
    assert end.zoomed(factor, np.zeros(2), ASPECT).distance == end.distance
    assert 1e-4 * BOUNDS.radius <= end.distance <= 1e4 * BOUNDS.radius
    assert np.isfinite(end.camera.clip_from_world(ASPECT)).all()


@given(orbits())
def test_the_target_is_as_large_in_parallel_as_in_perspective(orbit: Orbit) -> None:
    import dataclasses

    other = dataclasses.replace(orbit, orthographic=not orbit.orthographic)
    in_plane = np.array([orbit.point_at(np.array(at), ASPECT) for at in [(0, 0), (1, 1), (-0.5, 0.3)]])
    np.testing.assert_allclose(seen(other.camera, in_plane), seen(orbit.camera, in_plane), atol=1e-9)


UPS: list[tuple[float, float, float]] = [(0, 1, 0), (0, 0, 1), (1, 0, 0), (0, -1, 0), (0.6, 0.8, 0)]


@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("side", SIDES)
def test_each_side_shows_the_model_upright_and_fills_the_picture(
    side: str, up: tuple[float, float, float], orthographic: bool
) -> None:
    axis = np.array(up, np.float64)
    camera = Camera.fit(POINTS, direction=(-0.4, -0.3, -0.55), up=up, orthographic=orthographic)
    orbit = Orbit.from_camera(camera, ASPECT, BOUNDS, axis).seen_from(side, POINTS, ASPECT)
    assert np.linalg.det(orbit.axes) == pytest.approx(1.0)
    assert orbit.orthographic is orthographic
    assert np.abs(seen(orbit.camera, POINTS)).max() == pytest.approx(0.9)
    np.testing.assert_array_equal(orbit.up, axis)
    if side in ("above", "below"):
        assert orbit.axes[2] @ axis == pytest.approx(1.0 if side == "above" else -1.0)
    else:
        assert orbit.axes[1] @ axis == pytest.approx(1.0)


def test_the_sides_are_where_people_look_for_them() -> None:
    up_y = Orbit.from_camera(Camera.fit(POINTS), ASPECT, BOUNDS)
    up_z = Orbit.from_camera(Camera.fit(POINTS, direction=(-1, 1, -1), up=(0, 0, 1)), ASPECT, BOUNDS)
    eyes: list[tuple[Orbit, str, tuple[int, int, int]]] = [
        *((up_y, "front", (0, 0, 1)), (up_y, "right", (1, 0, 0)), (up_y, "above", (0, 1, 0))),
        *((up_y, "back", (0, 0, -1)), (up_y, "left", (-1, 0, 0)), (up_y, "below", (0, -1, 0))),
        *((up_z, "front", (0, -1, 0)), (up_z, "right", (1, 0, 0)), (up_z, "above", (0, 0, 1))),
    ]
    for orbit, side, eye in eyes:
        np.testing.assert_allclose(orbit.seen_from(side, POINTS, ASPECT).axes[2], eye, atol=1e-12)


@pytest.mark.parametrize(
    ("direction", "up"),
    [((-0.45, -0.4, -1), (0, 1, 0)), ((0.1, 0.1, -1), (0, 0, 1)), ((0, 0, -1), (0, 1, 0)), ((0, 2, -1), (0, 0, 1))],
)
@pytest.mark.parametrize("orthographic", [False, True])
def test_the_axis_that_the_camera_keeps_upright_is_found(
    direction: tuple[float, float, float], up: tuple[float, float, float], orthographic: bool
) -> None:
    orbit = Orbit.from_camera(Camera.fit(POINTS, direction=direction, up=up, orthographic=orthographic), ASPECT, BOUNDS)
    np.testing.assert_array_equal(orbit.up, up)


def test_a_camera_that_is_upside_down_rotates_about_what_is_up_in_its_picture() -> None:
    orbit = Orbit.from_camera(Camera.fit(POINTS, up=(0, -1, 0)), ASPECT, BOUNDS, np.array([0.0, 1.0, 0.0]))
    np.testing.assert_array_equal(orbit.up, (0, -1, 0))


def test_a_camera_that_looks_away_gets_a_target_before_it() -> None:
    camera = Camera.look_at((0, 0, 50), (0, 0, 60))
    orbit = Orbit.from_camera(camera, ASPECT, BOUNDS)
    assert orbit.distance == BOUNDS.radius
    np.testing.assert_allclose(orbit.target, (0, 0, 53), atol=1e-9)


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_orbits_are_the_same_in_every_unit(scale: float) -> None:
    camera = Camera.fit(POINTS * scale)
    orbit = Orbit.from_camera(camera, ASPECT, BoundingSphere.around(POINTS * scale)).rotated(0.3, 0.2)
    one = Orbit.from_camera(Camera.fit(POINTS), ASPECT, BoundingSphere.around(POINTS)).rotated(0.3, 0.2)
    np.testing.assert_allclose(seen(orbit.camera, POINTS * scale), seen(one.camera, POINTS), atol=1e-9)


@given(st.integers(0, 2**32))
def test_a_bounding_sphere_holds_its_points(seed: int) -> None:
    random = np.random.default_rng(seed)
    points = random.normal(size=(int(random.integers(1, 9)), 3))
    sphere = BoundingSphere.around(points)
    assert np.linalg.norm(points - sphere.center, axis=1).max() <= sphere.radius * (1 + 1e-12)
    assert sphere.radius > 0.0


def test_nothing_can_be_looked_at() -> None:
    nothing = np.empty((0, 3))
    assert BoundingSphere.around(nothing).radius == 1.0
    orbit = Orbit.from_camera(CAMERAS[0], ASPECT, BoundingSphere.around(nothing))
    assert orbit.seen_from("front", nothing, ASPECT) is orbit
