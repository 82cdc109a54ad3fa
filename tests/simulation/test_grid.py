"""Regular grids: found where they are, and moved as their springs one by one are."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.simulation import leapfrog
from gpu_xform.simulation.grid import Grid, find_grid
from gpu_xform.simulation.incidence import pack_slots
from gpu_xform.simulation.leapfrog import MAX_STRIP_ROWS
from tests.support.spring_models import cloth_mesh, make_cloth, make_reference, make_strands

MODELS: dict[str, Callable[..., gx.Springs]] = {
    "wide": lambda **options: make_cloth(27, 50, pinned=[0, 49, 700], **options),
    "tall": lambda **options: make_cloth(61, 18, pinned=[0, 17], **options),
    "without bending": lambda **options: make_cloth(33, 35, bend=0.0, pinned=[3], **options),
    "threads": lambda **options: make_cloth(40, 41, bend=0.0, shear=0.0, pinned=range(41), **options),
    "strands": lambda **options: make_strands(70, 20, **options),
    "columns": lambda **options: make_columns(31, 37, **options),
}


def make_columns(n: int, m: int, **options: Any) -> gx.Springs:
    """Return m strands of n points side by side, whose points follow one another from strand to strand."""
    index = np.arange(n * m).reshape(n, m)
    pairs = np.stack([index[:-1], index[1:]], axis=-1).reshape(-1, 2)
    return gx.Springs(cloth_mesh(n, m).positions, springs=pairs, stiffness=1000.0, mass=0.2, pinned=index[0], **options)


def grid_of(springs: gx.Springs) -> Grid | None:
    return find_grid(pack_slots(springs._system), springs.n_points, 50)


@pytest.mark.parametrize(
    ("name", "shape", "kinds"),
    [
        ("wide", (27, 50, 50, 1), 5),
        ("tall", (61, 18, 18, 1), 5),
        ("without bending", (33, 35, 35, 1), 3),
        ("threads", (40, 41, 41, 1), 2),
        ("strands", (20, 70, 1, 20), 2),
        ("columns", (31, 37, 37, 1), 1),
    ],
)
def test_a_grid_is_found(name: str, shape: tuple[int, ...], kinds: int) -> None:
    grid = grid_of(MODELS[name]())
    assert grid is not None
    assert (grid.n_rows, grid.n_columns, grid.row_shift, grid.column_shift) == shape
    assert len(grid.springs) == kinds
    assert grid.has_rows == (name not in ("strands", "columns"))


def test_a_grid_with_a_spring_too_few_or_too_many_or_another_is_none() -> None:
    mesh = cloth_mesh(40)
    assert grid_of(gx.Springs(mesh, mass=1.0, stretch=1.0)) is not None
    extra: dict[str, Any] = {"springs": [[0, 41]], "stiffness": 1.0}
    assert grid_of(gx.Springs(mesh, mass=1.0, stretch=1.0, **extra)) is None
    assert grid_of(gx.Springs(gx.Mesh(mesh.positions, mesh.faces[1:]), mass=1.0, stretch=1.0, bend=1.0)) is None
    longer = mesh.positions * np.where(np.arange(1600)[:, None] < 40, 1.1, 1.0)
    assert grid_of(gx.Springs(gx.Mesh(longer, mesh.faces), mass=1.0, stretch=1.0)) is None
    assert grid_of(make_cloth(8)) is None  # too small to be worth it


@pytest.mark.parametrize("damping", [0.0, 1e-4])
@pytest.mark.parametrize("name", MODELS)
def test_a_grid_moves_as_its_springs_in_float64_do(name: str, damping: float) -> None:
    springs = MODELS[name](damping=damping)
    rng = np.random.default_rng(5)
    springs.velocities = 0.3 * rng.standard_normal((springs.n_points, 3))
    reference = make_reference(springs, damping=damping)
    dt = 0.5 * springs.largest_step
    springs.step(100, dt)
    reference.run(100, dt)
    moved = np.abs(reference.positions - springs._system.points).max()
    assert np.abs(springs.positions - reference.positions).max() < 1e-6
    assert moved > 1e-3
    np.testing.assert_allclose(springs.velocities, reference.velocities, atol=2e-3)


@pytest.mark.filterwarnings("ignore:.* inside obstacle")
@pytest.mark.parametrize("name", ["wide", "strands", "columns"])
def test_a_grid_meets_obstacles_pins_and_air_as_any_springs_do(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    options: dict[str, Any] = {
        "obstacles": [
            gx.Sphere((0.2, -0.15, 0.2), 0.15, friction=0.3, transform=lambda t: gx.translate(0.0, 0.3 * t, 0.0)),
            gx.HalfSpace((0, -0.2, 0), gap=0.01),
        ],
        "move_pins": lambda t: gx.translate(0.1 * t, 0.0, 0.0),
        "drag_rate": 2.0,
        "wind": (1.0, 0.0, 0.0),
    }
    springs = MODELS[name](damping=2e-5)
    path = springs.simulate(0.1, 30.0, **options)
    monkeypatch.setattr("gpu_xform.simulation.leapfrog.find_grid", lambda *_: None)
    other = MODELS[name](damping=2e-5)
    expected = other.simulate(0.1, 30.0, **options)
    apart = np.abs(path.positions - expected.positions).max(axis=2)
    assert np.quantile(apart, 0.9) < 2e-5  # hair that buckles magnifies every rounding
    assert np.quantile(np.abs(springs.velocities - other.velocities), 0.9) < 0.02
    assert not np.array_equal(path, expected)  # or it was no grid


def test_a_grid_is_the_same_to_the_byte_in_parts_and_after_a_state() -> None:
    springs, other = make_cloth(36, pinned=[0, 35]), make_cloth(36, pinned=[0, 35])
    whole = springs.simulate(0.2, 30.0)
    first = other.simulate(0.1, 30.0)
    state = other.state()
    other.simulate(0.05, 30.0, drag=1.0)
    other.restore(state)
    second = other.simulate(0.1, 30.0)
    assert np.concatenate([first, second[1:]]).tobytes() == np.asarray(whole).tobytes()


@pytest.mark.filterwarnings("ignore:.* inside obstacle")
@pytest.mark.parametrize("rows", [1, 4, 7, 100])
def test_strips_of_any_length_give_the_same_bytes(rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    options: dict[str, Any] = {"obstacles": gx.Sphere((0.0, -0.01, 0.3), 0.1)}
    expected = MODELS["wide"](damping=1e-4).simulate(0.05, 20.0, **options)
    monkeypatch.setitem(MAX_STRIP_ROWS, "CPU", rows)
    assert (
        MODELS["wide"](damping=1e-4).simulate(0.05, 20.0, **options).positions.tobytes() == expected.positions.tobytes()
    )


@pytest.mark.parametrize("n_steps", [1, 2, 3])
@pytest.mark.parametrize("name", ["strands", "columns"])
def test_any_number_of_steps_per_dispatch_gives_the_same_bytes(
    name: str, n_steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    options: dict[str, Any] = {
        "obstacles": gx.Sphere((0.1, -0.1, 0.1), 0.15, friction=0.2, transform=lambda t: gx.translate(t, 0, 0)),
        "drag_rate": 1.0,
        "wind": (1.0, 0.0, 0.0),
    }
    expected = MODELS[name](damping=1e-5)
    expected.step(30, 0.5 * expected.largest_step, **options)
    monkeypatch.setattr(leapfrog, "MAX_STEPS_PER_DISPATCH", n_steps)
    monkeypatch.setattr(leapfrog, "MAX_STEPS_PER_SUBMISSION", 11)
    springs = MODELS[name](damping=1e-5)
    springs.step(30, 0.5 * springs.largest_step, **options)
    assert springs.positions.tobytes() == expected.positions.tobytes()
    assert springs.velocities.tobytes() == expected.velocities.tobytes()


def test_strands_too_long_for_the_loops_of_a_driver_are_stepped_as_any_springs(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = MODELS["strands"]().simulate(0.05, 20.0)
    monkeypatch.setattr(leapfrog, "MAX_LOOPS", 27)
    springs = MODELS["strands"]()
    monkeypatch.setattr(springs._stepper, "_step_strands", None)
    np.testing.assert_allclose(springs.simulate(0.05, 20.0), expected, atol=2e-6)
