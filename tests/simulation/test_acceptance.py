"""Motions whose answers are known: by formulas, by laws of conservation, or from the same steps in float64."""

import math

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from tests.support.reference_springs import ReferenceSprings

G = 9.81


def cloth_mesh(n: int, m: int | None = None, side: float = 1.0) -> gx.Mesh:
    """Return n x m points in the plane y = 0, joined to quads; `side` is the longer side."""
    m = n if m is None else m
    step = side / (max(n, m) - 1)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    points = np.stack([j * step, 0.0 * i, i * step], axis=-1).reshape(-1, 3)
    index = np.arange(n * m).reshape(n, m)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1)
    return gx.Mesh(points, quads.reshape(-1, 4))


def make_cloth(n: int, **options: object) -> gx.Springs:
    """Return a silk-like cloth of 1 m x 1 m and 0.2 kg."""
    return gx.Springs(cloth_mesh(n), **{"mass": 0.2, "stretch": 1000.0, "shear": 100.0, "bend": 50.0, **options})  # type: ignore[arg-type]


def fit_frequency(times: npt.NDArray[np.float64], values: npt.NDArray[np.float64], guess: float) -> float:
    """Return the angular frequency of a sinusoid about zero."""
    from scipy.optimize import curve_fit

    amplitude = float(np.abs(values).max())
    (found, *_), _ = curve_fit(
        lambda t, w, a, p: a * np.cos(w * t + p), times, values, p0=[guess, amplitude, 0.0], xtol=1e-14, ftol=1e-14
    )
    return float(found)


@pytest.mark.parametrize("height", [0.0, 100.0])
def test_free_fall(height: float) -> None:
    springs = gx.Springs(
        [[0.0, height, 0.0], [1.0, height, 0.5]], springs=[[0, 1]], stiffness=10.0, rest=math.hypot(1.0, 0.5), mass=0.2
    )
    path = springs.simulate(1.0, 1.0, substeps=2000 if height else 600)
    np.testing.assert_allclose(path[-1][:, 1], height - G / 2.0, rtol=1e-5)
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
    reference = ReferenceSprings(
        springs.positions.astype(np.float64),
        np.zeros((144, 3)),
        springs.masses,
        springs.pinned,
        springs.springs,
        springs.stiffness,
        springs.rest,
        2e-5,
    )
    dt = 1e-4
    springs.step(1000, dt)
    reference.run(1000, dt)
    assert np.abs(springs.positions - reference.positions).max() < 2e-5
    assert np.abs(springs.velocities - reference.velocities).max() < 1e-3
    assert reference.positions[:, 1].min() < -0.04  # it has fallen
