"""Obstacles: what enters is put outside, nothing gains energy, and friction holds below its angle."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

import gpu_xform as gx
from gpu_xform.simulation.obstacles import MAX_OBSTACLES, Obstacle, _rotation_vector, _to_quaternion, pack_obstacles
from tests.support.spring_models import make_cloth

TURN = gx.translate(0.3, -0.2, 0.1) @ gx.rotate((1.0, 2.0, -0.5), 1.1)
SHAPES: dict[str, Obstacle] = {
    "sphere": gx.Sphere((0.1, -0.6, 0.4), 0.35, gap=0.01),
    "half space": gx.HalfSpace((0.0, -0.5, 0.0), (0.2, 1.0, -0.1), gap=0.02),
    "capsule": gx.Capsule((-0.4, -0.5, 0.2), (0.3, -0.4, 0.7), 0.2),
    "box": gx.Box((0.0, -0.6, 0.5), (0.6, 0.4, 0.5), gap=0.005),
    "turned box": gx.Box((0.0, -0.6, 0.5), (0.6, 0.4, 0.5), transform=TURN),
}


def distance(obstacle: Obstacle, points: npt.ArrayLike, time: float = 0.0) -> npt.NDArray[np.float64]:
    """Return the signed distance of points (n, 3) from the surface, by formulas of each shape."""
    points = np.asarray(points, np.float64)
    matrix = np.linalg.inv(obstacle._matrix_at(time))
    local = points @ matrix[:3, :3].T + matrix[:3, 3]
    outside = np.abs(local) - obstacle._half_size
    nearest = np.clip(local, -obstacle._half_size, obstacle._half_size)
    clearance: npt.NDArray[np.float64] = np.linalg.norm(local - nearest, axis=1) - obstacle._radius
    if isinstance(obstacle, gx.HalfSpace):
        clearance = local[:, 1]
    if isinstance(obstacle, gx.Box):
        clearance += np.minimum(outside.max(axis=1), 0.0)
    return clearance


@pytest.mark.parametrize("name", SHAPES)
def test_no_point_of_a_falling_cloth_enters(name: str) -> None:
    obstacle = SHAPES[name]
    springs = make_cloth(16, damping=1e-4)
    path = springs.simulate(1.0, 20.0, obstacles=obstacle)
    clearance = np.array([distance(obstacle, frame).min() for frame in path])
    assert clearance.min() > obstacle.gap - 1e-6
    assert clearance.min() < obstacle.gap + 1e-6  # some touch it


def test_the_shapes_are_where_their_arguments_say() -> None:
    capsule, half_space = SHAPES["capsule"], SHAPES["half space"]
    np.testing.assert_allclose(distance(capsule, [(-0.4, -0.5, 0.2), (0.3, -0.4, 0.7)]), -0.2, atol=1e-12)
    np.testing.assert_allclose(distance(half_space, [(0.4, 1.5, -0.2)]), math.sqrt(4.2))
    np.testing.assert_allclose(distance(SHAPES["box"], [(0.3, -0.6, 0.5), (0.0, -0.4, 0.5)]), 0.0, atol=1e-12)


def test_a_cloth_that_falls_on_a_sphere_never_gains_energy() -> None:
    springs = make_cloth(16, damping=2e-5)
    energies = [springs.energy().total]
    for _ in range(25):
        springs.simulate(0.04, 25.0, obstacles=gx.Sphere((0.0, -0.5, 0.5), 0.3, friction=0.2))
        energies.append(springs.energy().total)
    assert np.diff(energies).max() < 2e-5 * 0.2 * 9.81
    assert energies[-1] < -0.1


@pytest.mark.parametrize("slope_degrees", [10.0, 25.0, 40.0])
def test_friction_holds_below_its_angle_and_lets_slide_above(slope_degrees: float) -> None:
    """On a slope s steeper than atan(f), the acceleration is g (sin s - f cos s)."""
    friction = math.tan(math.radians(30.0))
    slope = math.radians(slope_degrees)
    plane = gx.HalfSpace((0, 0, 0), (math.sin(slope), math.cos(slope), 0.0), friction=friction)
    springs = gx.Springs([[0.0, 0.0, 0.0]], mass=1.0)
    springs.simulate(1.0, 4.0, obstacles=plane, substeps=250)
    expected = 0.5 * 9.81 * max(0.0, math.sin(slope) - friction * math.cos(slope))
    assert np.linalg.norm(springs.positions) == pytest.approx(expected, rel=2e-3, abs=1e-6)


def test_a_point_falls_onto_a_floor_and_stays() -> None:
    springs = gx.Springs([[0.0, 1.0, 0.0]], mass=1.0, velocities=[[0.5, 0.0, 0.0]])
    floor = gx.HalfSpace(gap=0.25)
    springs.simulate(2.0, 2.0, obstacles=floor, substeps=500)
    fall = math.sqrt(2.0 * 0.75 / 9.81)
    np.testing.assert_allclose(springs.positions[0], [1.0, 0.25, 0.0], atol=5e-5)  # without friction it slides on
    np.testing.assert_allclose(springs.velocities[0], [0.5, 0.0, 0.0], atol=1e-6)
    assert fall < 2.0


def test_a_point_that_leaves_is_let_go() -> None:
    springs = gx.Springs([[0.0, 0.0, 0.0]], mass=1.0, velocities=[[0.0, 3.0, 0.0]])
    springs.simulate(0.1, 10.0, obstacles=gx.HalfSpace(gap=0.1), gravity=(0, 0, 0), substeps=100)
    assert springs.positions[0, 1] == pytest.approx(0.4, abs=0.005)  # put 0.1 above the floor, then on at 3 m/s


def test_what_rests_on_a_turning_table_turns_with_it() -> None:
    """Friction 1 carries a point at 0.5 m at 2 rad/s: it needs w^2 r = 2 m/s^2 of 9.81."""
    table = gx.Box((0, -0.5, 0), (4, 1, 4), friction=1.0, transform=lambda t: gx.rotate_y(2.0 * t))
    springs = gx.Springs([[0.5, 0.0, 0.0]], mass=1.0, velocities=[[0.0, 0.0, -1.0]])
    path = springs.simulate(1.0, 50.0, obstacles=table, substeps=40)
    turned = np.stack([0.5 * np.cos(2.0 * path.times), 0.0 * path.times, -0.5 * np.sin(2.0 * path.times)], axis=1)
    np.testing.assert_allclose(path.positions[:, 0], turned, atol=0.01)


def test_a_sphere_that_moves_pushes_a_cloth_ahead() -> None:
    sphere = gx.Sphere((0.0, -1.0, 0.5), 0.3, transform=lambda t: gx.translate(0.0, t, 0.0))
    springs = make_cloth(16, pinned=[0, 15, 240, 255], damping=1e-4)
    path = springs.simulate(1.0, 30.0, obstacles=sphere, gravity=(0, 0, 0))
    clearance = [distance(sphere, frame, time).min() for frame, time in zip(path, path.times, strict=True)]
    assert min(clearance) > -1e-6
    assert path.positions[-1][:, 1].max() > 0.25


def test_quaternions_and_rotation_vectors_are_those_of_scipy() -> None:
    for rotation in (*Rotation.random(20, random_state=1), Rotation.identity(), Rotation.from_rotvec([np.pi, 0, 0])):
        ours, theirs = _to_quaternion(rotation.as_matrix()), rotation.as_quat()
        assert abs(ours @ theirs) == pytest.approx(1.0, abs=1e-12)
        np.testing.assert_allclose(
            Rotation.from_rotvec(_rotation_vector(rotation.as_matrix())).as_matrix(), rotation.as_matrix(), atol=1e-7
        )


def test_the_velocities_of_an_obstacle_are_those_of_its_matrices() -> None:
    moving = gx.Sphere((1.0, 0.0, 0.0), 0.1, transform=lambda t: gx.translate(0.0, 3.0 * t, 0.0) @ gx.rotate_z(0.5 * t))
    [packed] = pack_obstacles([moving], 1.0, 1.001)
    np.testing.assert_allclose(packed["angular_velocity"], [0.0, 0.0, 0.5], rtol=1e-4, atol=1e-6)
    centre = np.array([math.cos(0.5), math.sin(0.5)])
    np.testing.assert_allclose(packed["velocity"], [-0.5 * centre[1], 3.0 + 0.5 * centre[0], 0.0], rtol=1e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: gx.Sphere((0, 0, 0), 0.0), r"^radius must be positive, got 0$"),
        (lambda: gx.Sphere((0, 0), 1.0), r"^center must have shape \(3,\), got \(2,\)$"),
        (lambda: gx.Sphere((0, 0, 0), 1.0, friction=-0.1), r"^friction must not be negative, got -0.1$"),
        (lambda: gx.Sphere((0, 0, np.nan), 1.0), r"^center must be finite, got nan at index 2$"),
        (lambda: gx.HalfSpace(gap=-1.0), r"^gap must not be negative, got -1$"),
        (lambda: gx.HalfSpace(normal=(0, 0, 0)), r"^normal must not be the zero vector$"),
        (lambda: gx.Capsule((1, 2, 3), (1, 2, 3), 1.0), r"^end must differ from start, got \[1.0, 2.0, 3.0\]$"),
        (lambda: gx.Box((0, 0, 0), (1, 0, 1)), r"^size must be positive, got \[1.0, 0.0, 1.0\]$"),
        (
            lambda: gx.Box((0, 0, 0), (1, 1, 1), transform=gx.scale(2.0)),
            r"^transform must only rotate and translate an obstacle, got \[\[2.0",
        ),
        (lambda: gx.Box((0, 0, 0), (1, 1, 1), transform=gx.reflect((1, 0, 0))), r"^transform must only rotate"),
    ],
)
def test_an_impossible_obstacle_is_an_error(make: object, message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=message):
        make()  # type: ignore[operator]


def test_what_is_no_obstacle_and_too_many_are_errors() -> None:
    springs = gx.Springs([[0.0, 0.0, 0.0]], mass=1.0)
    with pytest.raises(gx.ArgumentTypeError, match=r"^obstacles must hold a Sphere, .* each, got Mesh$"):
        springs.step(1, 0.1, obstacles=[gx.samples.cube()])  # type: ignore[list-item]
    with pytest.raises(gx.ArgumentTypeError, match=r"^obstacles must hold a Sphere, .* each, got Mesh$"):
        springs.step(1, 0.1, obstacles=gx.samples.cube())  # type: ignore[arg-type]
    with pytest.raises(gx.ArgumentError, match=rf"^obstacles must be at most {MAX_OBSTACLES}, got 33$"):
        springs.step(1, 0.1, obstacles=(MAX_OBSTACLES + 1) * [gx.HalfSpace()])
    with pytest.raises(gx.ArgumentError, match=r"^transform raised at 0 s: ZeroDivisionError"):
        springs.step(1, 0.1, obstacles=gx.HalfSpace(transform=lambda t: gx.translate(1 / t, 0, 0)))


@pytest.mark.parametrize(
    ("obstacle", "shown"),
    [
        (gx.Sphere((0, -0.4, 0), 0.2), "<Sphere: center (0, -0.4, 0), radius 0.2, friction 0, gap 0>"),
        (gx.HalfSpace((0, 1, 0), (0, 0, 2)), "<HalfSpace: point (0, 1, 0), normal (0, 0, 1), friction 0, gap 0>"),
        (
            gx.Capsule((1, 0, 0), (3, 0, 0), 0.5, friction=0.3, transform=np.eye(4)),
            "<Capsule: start (1, 0, 0), end (3, 0, 0), radius 0.5, friction 0.3, gap 0, placed by a matrix>",
        ),
        (
            gx.Box((1, 2, 3), (4, 5, 6), gap=0.01, transform=lambda _: np.eye(4)),
            "<Box: center (1, 2, 3), size (4, 5, 6), friction 0, gap 0.01, moved>",
        ),
    ],
)
def test_an_obstacle_shows_where_it_is_and_how_large(obstacle: Any, shown: str) -> None:
    assert repr(obstacle) == shown


@pytest.mark.parametrize(
    ("make", "n_inside"),
    [
        (lambda gap: gx.Sphere((0.5, 0.0, 0.5), 0.3, gap=gap), 5),  # of a grid of points 0.25 m apart
        (lambda gap: gx.HalfSpace((0.3, 0, 0), (1, 0, 0), gap=gap, transform=gx.translate(0.0, 0.0, 1.0)), 10),
        (lambda gap: gx.Capsule((0.25, 0, 0), (0.25, 0, 1), 0.1, gap=gap), 5),
        (lambda gap: gx.Box((0, 0, 0), (0.6, 1, 0.6), gap=gap, transform=lambda _: gx.translate(1, 0, 1)), 4),
    ],
)
@pytest.mark.parametrize("keep", ["host", "device"])
def test_points_that_start_inside_an_obstacle_are_warned_of(make: Any, n_inside: int, keep: Any) -> None:
    cloth, obstacle = make_cloth(5), make(0.0)
    around = [gx.HalfSpace((0, -3, 0)), obstacle]
    message = rf"^{n_inside} points start inside obstacle 1, <{type(obstacle).__name__}: .*, up to .* m deep"
    with pytest.warns(gx.SimulationWarning, match=message) as caught:
        cloth.simulate(0.01, 100.0, obstacles=around, keep=keep)
    assert [Path(each.filename).name for each in caught] == ["test_obstacles.py"]
    cloth.simulate(0.01, 100.0, obstacles=around, keep=keep)  # which was said already
    cloth.reset()
    with pytest.warns(gx.SimulationWarning, match=message):
        cloth.simulate(0.01, 100.0, obstacles=around)


def test_points_that_are_pinned_inside_or_within_the_gap_are_not_warned_of() -> None:
    sphere = gx.Sphere((0.5, -0.3, 0.5), 0.301)
    make_cloth(5, pinned=[12]).simulate(0.01, 100.0, obstacles=sphere)
    held = make_cloth(5)
    held.hold(12)
    held.simulate(0.01, 100.0, obstacles=sphere)
    make_cloth(5).simulate(0.01, 100.0, obstacles=gx.Sphere((0.5, -0.3, 0.5), 0.301, gap=0.002))
    with pytest.warns(gx.SimulationWarning, match=r"^1 point starts inside obstacle 0, .*, up to 0.001 m deep"):
        make_cloth(5).simulate(0.01, 100.0, obstacles=sphere)
