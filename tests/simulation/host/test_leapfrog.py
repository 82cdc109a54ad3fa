"""Leapfrog on the host: the twin of the shaders, with and without numba, on any number of threads."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.compute.host import choose
from gpu_xform.device import Device
from gpu_xform.errors import DeviceError
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.host import THREADS_VARIABLE
from gpu_xform.simulation.host import leapfrog
from gpu_xform.simulation.host.leapfrog import HostLeapfrog
from gpu_xform.simulation.host.springs_by_slot import ListedSprings, ShiftedSprings
from tests.support.spring_models import make_chain, make_cloth, make_reference, make_strands


def make_net(seed: int = 3, device: Device | None = None) -> gx.Springs:
    """Return a mesh whose points are in no order, with springs that are all different."""
    sphere = gx.samples.icosphere(4)
    order = np.random.default_rng(seed).permutation(sphere.n_points)
    mesh = gx.Mesh(sphere.positions[np.argsort(order)] * (1.0, 1.3, 0.7), order[np.asarray(sphere.faces)])
    return gx.Springs(mesh, mass=0.1, stretch=300.0, bend=20.0, damping=1e-4, pinned=[5], device=device)


MODELS: dict[str, Callable[..., gx.Springs]] = {
    "cloth": lambda **options: make_cloth(50, 61, damping=2e-5, pinned=[0, 60], **options),
    "hair": lambda **options: make_strands(300, 12, damping=1e-5, **options),
    "chain": lambda **options: make_chain(16, length=0.1, stiffness=100.0, mass=0.01, damping=1e-3, **options),
    "net": make_net,
}
OBSTACLES = [
    gx.Sphere((0.1, -0.2, 0.4), 0.17, friction=0.3),
    gx.Box((0.5, -0.3, 0.5), (0.2, 0.2, 0.3), friction=0.2, transform=lambda t: gx.translate(0, t, 0) @ gx.rotate_y(t)),
    gx.HalfSpace((0, -0.35, 0), friction=0.5, gap=0.01),
    gx.Capsule((0.8, -0.1, 0), (0.9, -0.2, 1), 0.05, transform=lambda t: gx.rotate_z(0.2 * t)),
]


def list_conditions(name: str) -> dict[str, Any]:
    """Return all that can act on a model at once."""
    air = {"drag": 1.2} if name in ("cloth", "net") else {"drag_rate": 0.5}
    return {
        **air,
        "wind": (1.0, 0.0, 2.0),
        "force": lambda time, positions, _: 1e-4 * np.cos(time) * positions[:, ::-1],
        "obstacles": OBSTACLES,
        "move_pins": lambda time: gx.translate(0.1 * time, 0, 0),
    }


def run(springs: gx.Springs, n_steps: int = 12, **conditions: Any) -> bytes:
    """Return the state after some steps."""
    springs.step(n_steps, 0.9 * min(springs.largest_step, 1e-3), **conditions)
    return springs.positions.tobytes() + springs.velocities.tobytes()


@pytest.mark.parametrize(
    ("name", "kind"), [("cloth", ShiftedSprings), ("chain", ShiftedSprings), ("net", ListedSprings)]
)
def test_what_is_alike_needs_no_lists(name: str, kind: type, host: Device) -> None:
    stepper = MODELS[name](device=host)._stepper
    assert isinstance(stepper, HostLeapfrog)
    assert isinstance(stepper._springs, kind)


@pytest.mark.parametrize("name", MODELS)
def test_without_numba_the_bytes_are_the_same(name: str, host: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    conditions = list_conditions(name)
    compiled = run(MODELS[name](device=host), **conditions)
    monkeypatch.setattr(choose, "_has_failed", True)
    assert run(MODELS[name](device=host), **conditions) == compiled


@pytest.mark.parametrize("name", MODELS)
def test_neither_threads_nor_parts_of_a_frame_change_the_bytes(
    name: str, host: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    conditions = list_conditions(name)
    expected = run(MODELS[name](device=host), **conditions)
    monkeypatch.setenv(THREADS_VARIABLE, "1")
    monkeypatch.setattr(leapfrog, "MAX_STEPS_PER_CALL", 7)
    assert run(MODELS[name](device=host), **conditions) == expected


@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(sorted(MODELS)))
def test_the_shaders_and_the_host_take_the_same_step(seed: int, name: str, device: GpuDevice, host: Device) -> None:
    """From a random state near the start, with all that can act."""
    conditions = list_conditions(name)
    rng = np.random.default_rng(seed)
    results = []
    noise: Any = None
    for each in (device, host):
        springs = MODELS[name](device=each)
        if noise is None:
            size = float(springs.rest.min())
            noise = [rng.normal(scale=scale, size=(springs.n_points, 3)) for scale in (0.1 * size, 0.3)]
        springs.positions = springs.positions + noise[0]
        springs.velocities = noise[1]
        run(springs, 1, **conditions)
        results.append((springs.positions, springs.velocities))
    (x, v), (x_host, v_host) = results
    step_s = 0.9 * min(springs.largest_step, 1e-3)
    # A kick moves a velocity by at most 4 / step_s times a shift of a position: that is what stability means.
    x_bound = 32.0 * 2.0**-24 * np.abs(x).max()
    v_bound = 32.0 * 2.0**-24 * (np.abs(v).max() + 4.0 * np.abs(x).max() / step_s)
    assert np.abs(x - x_host).max() <= x_bound + step_s * v_bound
    assert np.abs(v - v_host).max() <= v_bound


@pytest.mark.parametrize("name", ["cloth", "hair", "net"])
def test_a_run_is_that_of_the_same_steps_in_float64(name: str, host: Device) -> None:
    springs = MODELS[name](device=host)
    reference = make_reference(springs, damping=springs.damping)
    dt = 0.5 * min(springs.largest_step, 1e-3)
    springs.step(200, dt)
    reference.run(200, dt)
    np.testing.assert_allclose(springs.positions, reference.positions, atol=2e-6)


def test_a_state_of_one_device_goes_on_on_another(device: GpuDevice, host: Device) -> None:
    first = make_cloth(8, damping=1e-4, pinned=[0, 7], device=device)
    first.simulate(0.2)
    second = make_cloth(8, damping=1e-4, pinned=[0, 7], device=host)
    second.restore(first.state())
    np.testing.assert_array_equal(second.positions, first.positions)
    np.testing.assert_allclose(second.simulate(0.1)[-1], first.simulate(0.1)[-1], atol=2e-5)


def test_a_closed_host_moves_nothing() -> None:
    host = gx.Device("host")
    springs = make_cloth(4, device=host)
    host.close()
    with pytest.raises(DeviceError, match=r"^the device 'host' is closed$"):
        springs.step()


def test_frames_stay_on_the_host_but_are_not_drawn_there(host: Device) -> None:
    springs = make_cloth(4, device=host)
    path = springs.simulate(0.1, keep="device")
    np.testing.assert_array_equal(path[-1], springs.positions)
    with pytest.raises(DeviceError, match="the host device draws no pictures"):
        gx.render(springs, device=host)


def test_obstacles_do_the_same_to_points_everywhere(
    device: GpuDevice, host: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Points within and without each shape, which approach, part, slide slowly and fast."""
    rng = np.random.default_rng(8)
    points = rng.uniform((-0.3, -0.7, -0.2), (1.1, 0.2, 1.2), (6000, 3))
    velocities = rng.normal(size=(6000, 3)) * 10.0 ** rng.uniform(-2, 1, (6000, 1))
    rough = [gx.Sphere((0.6, 0.0, 0.3), 0.3, friction=1.5), gx.Box((0.2, 0.0, 0.9), (0.4, 0.2, 0.3), friction=3.0)]

    def collide(on: Device) -> tuple[Any, Any]:
        springs = gx.Springs(points, mass=1.0, velocities=velocities, device=on)
        springs.step(2, 1e-3, obstacles=[*OBSTACLES, *rough])
        return springs.positions, springs.velocities

    (x, v), (x_host, v_host) = collide(device), collide(host)
    assert np.abs(x_host - points - 2e-3 * velocities).max() > 0.1
    is_close = (np.abs(x - x_host).max(axis=1) < 2e-6) & (np.abs(v - v_host).max(axis=1) < 2e-4)
    assert is_close.mean() > 0.998  # a point on the brink of a surface, or between two, may go either way
    monkeypatch.setattr(choose, "_has_failed", True)
    for compiled, vectorized in zip((x_host, v_host), collide(host), strict=True):
        assert compiled.tobytes() == vectorized.tobytes()
