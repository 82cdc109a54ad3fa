"""Motions whose answers are known: by formulas, by laws of conservation, or from the same steps in float64."""

import math
import os

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from tests.support.spring_models import hanging_chain, make_chain, make_cloth, make_reference

G = 9.81


def fit_frequency(times: npt.NDArray[np.float64], values: npt.NDArray[np.float64], guess: float) -> float:
    """Return the angular frequency of a sinusoid about zero."""
    from scipy.optimize import curve_fit

    amplitude = float(np.abs(values).max())
    (found, *_), _ = curve_fit(
        lambda t, w, a, p: a * np.cos(w * t + p), times, values, p0=[guess, amplitude, 0.0], xtol=1e-14, ftol=1e-14
    )
    return float(found)


@pytest.mark.parametrize(
    ("height", "n_steps", "tolerance"),
    [
        (0.0, 600, 1e-5),
        (100.0, 2000, 1e-5),
        (1000.0, 2000, 1e-5),
        (-37.0, 2000, 1e-5),
        (0.0, 2000, 2e-5),  # the velocity, a sum of 2,000 equal kicks, is rounded each time: 8e-6 of it is lost
        (5.0, 2000, 2e-5),
    ],
)
def test_free_fall(height: float, n_steps: int, tolerance: float) -> None:
    springs = gx.Springs(
        [[0.0, height, 0.0], [1.0, height, 0.5]], springs=[[0, 1]], stiffness=10.0, rest=math.hypot(1.0, 0.5), mass=0.2
    )
    path = springs.simulate(1.0, 1.0, substeps=n_steps)
    np.testing.assert_allclose(height - path[-1][:, 1].astype(np.float64), G / 2.0, rtol=tolerance)
    np.testing.assert_allclose(path[-1][:, 0], [0.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(springs.velocities[:, 1], -G, rtol=1e-5)


@pytest.mark.parametrize("steps_per_period", [10, 20, 40])
def test_one_spring_has_the_frequency_of_the_discrete_law(steps_per_period: int) -> None:
    """A leapfrog step dt turns the frequency w into (2 / dt) asin(w dt / 2)."""
    stiffness, mass, n_periods = 100.0, 0.5, 20
    w = math.sqrt(stiffness / mass)
    dt = 2.0 * math.pi / w / steps_per_period
    springs = gx.Springs(
        [[0.0, 0.0, 0.0], [1.1, 0.0, 0.0]], springs=[[0, 1]], stiffness=stiffness, rest=1.0, mass=2 * [mass], pinned=[0]
    )
    path = springs.simulate(n_periods * steps_per_period * dt, 1.0 / dt, gravity=(0, 0, 0), substeps=1)
    found = fit_frequency(path.times, path.positions[:, 1, 0].astype(np.float64) - 1.0, w)
    assert found == pytest.approx(2.0 / dt * math.asin(w * dt / 2.0), rel=1e-6)
    assert found / w - 1.0 == pytest.approx((w * dt) ** 2 / 24.0, rel=0.06)


def test_a_run_is_that_of_the_same_steps_in_float64() -> None:
    springs = make_cloth(12, damping=2e-5, pinned=[0, 11])
    reference = make_reference(springs, damping=2e-5)
    dt = 1e-4
    springs.step(1000, dt)
    reference.run(1000, dt)
    assert np.abs(springs.positions - reference.positions).max() < 2e-5
    assert np.abs(springs.velocities - reference.velocities).max() < 1e-3
    assert reference.positions[:, 1].min() < -0.04  # it has fallen


def test_a_free_cloth_keeps_its_momenta_and_its_energy() -> None:
    springs = make_cloth(20)
    points = 1.02 * springs.positions.astype(np.float64)
    spin = np.array([1.0, 2.0, -1.5])
    springs.positions = points
    springs.velocities = np.array([0.3, 0.1, -0.2]) + np.cross(spin, points - points.mean(axis=0))
    before, energy = springs.momentum(), springs.energy((0, 0, 0)).total
    energies = []
    for _ in range(20):
        springs.simulate(0.1, 10.0, gravity=(0, 0, 0))
        energies.append(springs.energy((0, 0, 0)).total)
    after = springs.momentum()
    assert np.linalg.norm(after.linear - before.linear) < 1e-6 * np.linalg.norm(before.linear)
    assert np.linalg.norm(after.angular - before.angular) < 1e-6 * np.linalg.norm(before.angular)
    np.testing.assert_allclose(energies, energy, rtol=0.03)


@pytest.mark.slow
def test_a_hung_cloth_keeps_its_energy() -> None:
    springs = make_cloth(16, pinned=[0, 15])
    lowest = []
    for _ in range(16):
        springs.simulate(0.25, 4.0)
        lowest.append(springs.positions[:, 1].min())
        assert abs(springs.energy().total) < 0.01 * 0.2 * G  # of m g times a side; it is 0 at the start
    assert min(lowest) < -0.65


def test_a_motion_reversed_comes_back() -> None:
    springs = make_cloth(20, pinned=range(20))
    start = springs.positions
    springs.simulate(0.25, 4.0)
    assert springs.positions[:, 1].min() < -0.15
    springs.velocities = -springs.velocities
    springs.simulate(0.25, 4.0)
    assert np.abs(springs.positions - start).max() < 1e-5


def test_a_hanging_chain_stays_at_its_exact_sag() -> None:
    n, stiffness, mass = 20, 200.0, 0.01
    springs = make_chain(n, length=0.05, stiffness=stiffness, mass=mass)
    exact = hanging_chain(n, length=0.05, stiffness=stiffness, mass=mass)
    sag = mass * G * n * (n + 1) / (2.0 * stiffness)
    assert -exact[-1, 1] - n * 0.05 == pytest.approx(sag, rel=1e-12)
    springs.positions = exact
    path = springs.simulate(4.0, 25.0)
    assert np.abs(path.positions - exact).max() < 1e-5 * -exact[-1, 1]


def test_a_hanging_chain_settles_to_its_exact_sag() -> None:
    n, stiffness, mass = 8, 200.0, 0.01
    springs = make_chain(n, length=0.05, stiffness=stiffness, mass=mass, damping=2.5e-3)
    springs.simulate(25.0, 0.4)
    exact = hanging_chain(n, length=0.05, stiffness=stiffness, mass=mass)
    sag = mass * G * n * (n + 1) / (2.0 * stiffness)
    assert np.abs(springs.positions - exact).max() < 1e-5 * sag


@pytest.mark.parametrize(("strain", "tolerance"), [(1e-2, 3e-3), (1e-3, 3e-4)])
def test_a_hanging_chain_swings_as_laguerres_polynomial_says(strain: float, tolerance: float) -> None:
    """The frequencies of n equal masses on links of length l: w^2 = x g / l, x the roots of L_n (D. Bernoulli)."""
    n, length, mass, amplitude = 16, 0.02, 1e-6, 0.002
    roots = np.polynomial.laguerre.lagroots([0.0] * n + [1.0])
    w = math.sqrt(G / length * roots[0])
    weights = G * np.arange(n, 0.0, -1.0) / length  # tensions over link lengths and masses
    matrix = np.diag(weights + np.append(weights[1:], 0.0)) - np.diag(weights[1:], 1) - np.diag(weights[1:], -1)
    values, modes = np.linalg.eigh(matrix)
    assert values[0] == pytest.approx(w * w, rel=1e-9)

    stiffness = n * mass * G / (strain * length)
    springs = make_chain(n, length=length, stiffness=stiffness, mass=mass)
    start = hanging_chain(n, length=length, stiffness=stiffness, mass=mass)
    start[1:, 0] = amplitude * modes[:, 0] / modes[-1, 0]
    springs.positions = start
    path = springs.simulate(4.0, 30.0)
    found = fit_frequency(path.times, path.positions[:, -1, 0].astype(np.float64), w)
    assert found == pytest.approx(w, rel=tolerance)


def pair_at(part_of_largest: float) -> tuple[gx.Springs, float]:
    """Return two equal free masses on a spring, for which the bound is exact, and a step as a part of the largest."""
    springs = gx.Springs([[0.0, 0.0, 0.0], [1.001, 0.0, 0.0]], springs=[[0, 1]], stiffness=100.0, rest=1.0, mass=2.0)
    assert springs.largest_step == pytest.approx(2.0 / math.sqrt(2.0 * 100.0), rel=1e-12)
    return springs, part_of_largest * springs.largest_step


N_STABLE_STEPS = int(os.environ.get("GPU_XFORM_STABLE_STEPS", "50_000"))  # `make soak` takes a million


@pytest.mark.slow
def test_steps_just_below_the_largest_stay_stable() -> None:
    springs, dt = pair_at(0.99)
    for _ in range(N_STABLE_STEPS // 10_000):
        springs.step(10_000, dt, gravity=(0, 0, 0))
        length = np.linalg.norm(springs.positions[1] - springs.positions[0])
        assert abs(length - 1.0) < 0.002  # it swings by 0.001 m about its rest length


def test_steps_just_above_the_largest_blow_up(monkeypatch: pytest.MonkeyPatch) -> None:
    springs, dt = pair_at(1.01)
    monkeypatch.setattr("gpu_xform.simulation.step_choice.find_largest_step", lambda *_: math.inf)
    springs.step(300, dt, gravity=(0, 0, 0))
    assert not np.abs(springs.positions).max() <= 10.0  # it may be NaN


@pytest.mark.parametrize("damping", [1e-3, 0.1, 1.0])
def test_damping_shortens_the_largest_step_exactly(damping: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The damper acts on the velocity half a step earlier: for w = 10 / s, overdamped or not, the bound is sharp."""
    monkeypatch.setattr("gpu_xform.simulation.step_choice.find_largest_step", lambda *_: math.inf)
    for part, is_stable in ((0.99, True), (1.01, False)):
        springs = gx.Springs(
            [[0.0, 0.0, 0.0], [1.001, 0.0, 0.0]],
            springs=[[0, 1]],
            stiffness=100.0,
            rest=1.0,
            mass=[1.0, 1.0],
            pinned=[0],
            damping=damping,
        )
        z = damping * 10.0 / 2.0
        springs.step(3000, part * 2.0 / 10.0 * (math.sqrt(1.0 + z * z) - z), gravity=(0, 0, 0))
        length = float(springs.positions[1, 0])
        assert (abs(length - 1.0) < 2e-3) == is_stable


def test_every_chunking_and_every_run_gives_the_same_bytes() -> None:
    options = {"drag": 1.2, "wind": (0.5, 0.0, 3.0), "obstacles": gx.Sphere((0.1, -0.3, 0.5), 0.2, friction=0.3)}
    runs = []
    for chunks in ((12,), (12,), (5, 7), (1, 1, 10)):
        springs = make_cloth(24, damping=2e-5, pinned=[0, 23])
        paths = [springs.simulate(n / 30.0, 30.0, **options) for n in chunks]  # type: ignore[arg-type]
        runs.append(np.concatenate([paths[0], *(path[1:] for path in paths[1:])]))
    assert all(run.tobytes() == runs[0].tobytes() for run in runs[1:])
    assert np.isfinite(runs[0]).all()


def test_a_plate_that_falls_reaches_its_terminal_velocity_by_the_law_of_squares() -> None:
    """v = u tanh(g t / u), u^2 = 2 m g / (1.2 kg/m^3 C A), for a triangle, which stays flat."""
    mesh = gx.Mesh([[0, 0, 0], [2, 0, 0], [0, 0, 2]], [[0, 2, 1]])
    springs = gx.Springs(mesh, area_density=0.5, stretch=1000.0)
    terminal = math.sqrt(2.0 * 1.0 * G / (1.2 * 1.5 * 2.0))
    for _ in range(6):
        springs.simulate(0.1, 10.0, drag=1.5, substeps=200)
        expected = -terminal * math.tanh(G * springs.time / terminal)
        np.testing.assert_allclose(springs.velocities.mean(axis=0), [0.0, expected, 0.0], rtol=2e-3, atol=1e-6)


def test_points_lose_speed_to_the_air_at_the_drag_rate() -> None:
    springs = gx.Springs([[0.0, 0.0, 0.0]], mass=1.0, velocities=[[2.0, 0.0, -1.0]])
    springs.simulate(0.5, 2.0, gravity=(0, 0, 0), drag_rate=3.0, wind=(0.0, 1.0, 0.0), substeps=2000)
    decay = math.exp(-1.5)
    np.testing.assert_allclose(springs.velocities, [[2.0 * decay, 1.0 - decay, -decay]], rtol=2e-3)
