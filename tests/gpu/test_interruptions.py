"""Exceptions that pass by a buffer: Ctrl+C, and any other, at every place; the device goes on as if there were none."""

import gc
import os
import signal
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import wgpu

import gpu_xform as gx
from gpu_xform._core import interrupts
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.context import GpuContext
from gpu_xform.gpu.device import GpuDevice
from tests.support.interruptions import count_lines, interrupt_at, require_healthy, sample_lines

N_SAMPLES = int(os.environ.get("GPU_XFORM_INTERRUPTIONS", "20"))
MATRIX = gx.translate(1, 2, 3) @ gx.rotate_y(0.3) @ gx.scale(2, 3, 4)
LARGE = np.random.default_rng(1).normal(size=(40_000, 3)).astype(np.float32)
SMALL = LARGE[:7]
STACK = np.stack([gx.rotate_x(k / 5) for k in range(11)])
INDICES = np.arange(len(LARGE)) % len(STACK)

Operation = Callable[[GpuDevice], Any]

OPERATIONS: dict[str, Operation] = {
    "transform": lambda device: gx.transform_points(LARGE, MATRIX, device=device),
    "a small array": lambda device: gx.transform_points(SMALL, MATRIX, device=device),
    "a stack": lambda device: gx.transform_points(LARGE, STACK, device=device),
    "bounds": lambda device: gx.bounds(LARGE, device=device),
    "a point buffer": lambda device: gx.PointBuffer(LARGE, device=device).transformed(MATRIX).numpy(),
    "its plain points": lambda device: gx.PointBuffer(LARGE, device=device).numpy(),
    "convolution": lambda device: gx.convolve(LARGE.reshape(300, 400), np.ones((3, 3), np.float32), device=device),
    "a picture": lambda device: gx.render_array(
        gx.samples.icosphere(2), size=(96, 64), hidden="remove", fill="tan", device=device
    ),
    "an SVG": lambda device: gx.render_svg(gx.samples.icosphere(1), size=(96, 64), hidden="remove", device=device),
}


@pytest.fixture(params=[True, False], ids=["mapped", "staging"])
def any_device(request: pytest.FixtureRequest) -> GpuDevice:
    """A device whose memory the host maps, and one whose memory it does not."""
    found: GpuDevice = request.getfixturevalue("device" if request.param else "staging_device")
    return found


@pytest.mark.parametrize("name", OPERATIONS)
def test_an_interrupt_at_any_line_leaves_a_device_that_works(name: str, any_device: GpuDevice) -> None:
    def run() -> Any:
        return OPERATIONS[name](any_device)

    expected = run()
    n_lines = count_lines(run)
    for line in sample_lines(n_lines, N_SAMPLES, seed=n_lines):
        interrupt_at(run, line)
        require_healthy(any_device)
        assert np.array_equal(run(), expected), line


@pytest.mark.parametrize("error", [MemoryError, SystemExit, RuntimeError])
def test_any_other_exception_leaves_a_device_that_works(error: type[BaseException], device: GpuDevice) -> None:
    def run() -> Any:
        return gx.transform_points(LARGE, MATRIX, device=device)

    expected = run()
    for line in sample_lines(count_lines(run), N_SAMPLES // 4, seed=2):
        interrupt_at(run, line, error())
        assert np.array_equal(run(), expected), line


def test_points_that_stay_on_the_device_outlive_an_interrupt(device: GpuDevice) -> None:
    with gx.PointBuffer(LARGE, device=device) as points:
        for line in sample_lines(count_lines(points.numpy), N_SAMPLES, seed=3):
            interrupt_at(points.numpy, line)
            assert np.array_equal(points.numpy(), LARGE), line


def test_a_uniform_that_an_interrupt_left_half_sent_is_sent_again(
    device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The pool knows what a buffer holds so as not to send it again: not after an upload that was cut short."""
    first = gx.transform_points(SMALL, MATRIX, device=device)
    upload = Buffer.upload

    def upload_and_stop(buffer: Buffer, array: Any) -> None:
        upload(buffer, array)
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Buffer, "upload", upload_and_stop)
        with pytest.raises(KeyboardInterrupt):
            gx.transform_points(SMALL, gx.scale(5), device=device)
    assert np.array_equal(gx.transform_points(SMALL, MATRIX, device=device), first)


def simulate(device: GpuDevice) -> None:
    """Take steps of a cloth and of a ball, which have kernels of their own, and drop both."""
    for mesh in (gx.samples.cloth(10, 10), gx.samples.icosphere(1)):
        springs = gx.Springs(mesh, mass=0.1, stretch=50, damping=1e-3, pinned=[0], device=device)
        springs.step(3, drag=1.0)
        springs.hold(3)
        springs.simulate(0.1, keep="device")
        springs.restore(springs.state())


def run_interrupted(work: Callable[[], object], after_s: float) -> None:
    """Repeat `work` until Ctrl+C, which is pressed after so many seconds, raises `KeyboardInterrupt`."""
    timer = threading.Timer(after_s, os.kill, (os.getpid(), signal.SIGINT))
    try:
        timer.start()
        while True:
            work()
    except KeyboardInterrupt:
        timer.join()


def test_ctrl_c_at_random_moments_leaves_a_device_that_works(device: GpuDevice) -> None:
    points = np.random.default_rng(1).normal(size=(600_000, 3)).astype(np.float32)
    expected = gx.transform_points(points, MATRIX, device=device)

    def work() -> None:
        gx.transform_points(points, MATRIX, device=device)
        gx.bounds(SMALL, device=device)

    for delay_s in np.random.default_rng(4).uniform(0, 0.02, N_SAMPLES // 2):
        run_interrupted(work, delay_s)
        assert np.array_equal(gx.transform_points(points, MATRIX, device=device), expected)
        require_healthy(device)


def test_ctrl_c_while_a_device_opens_opens_it_or_is_raised() -> None:
    for delay_s in np.random.default_rng(5).uniform(0, 0.3, N_SAMPLES // 5):
        run_interrupted(lambda: gx.Device().close(), delay_s)
    with gx.Device() as opened:
        assert np.array_equal(gx.transform_points(SMALL, np.eye(4), device=opened), SMALL)


def test_no_object_of_wgpu_dies_where_ctrl_c_would_be_lost(
    any_device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python prints what is raised in a destructor, and goes on: the next Ctrl+C would be the first to be heard."""

    def work() -> None:
        for operation in OPERATIONS.values():
            operation(any_device)
        gx.transform_points(LARGE, STACK, index=INDICES, device=any_device)
        with any_device.time_dispatches():
            gx.PointBuffer(SMALL, device=any_device).bounds()
        simulate(any_device)
        any_device.resource_cache.trim()  # the mesh of the pictures is gone
        any_device.resource_cache.clear()
        any_device.bind_groups.clear()
        any_device.textures.clear()
        any_device.pool.clear()
        with GpuDevice.from_context(GpuContext(wanted_features=any_device.features)) as other:
            OPERATIONS["a picture"](other)

    work()
    gc.collect()  # a device of wgpu and its queue hold each other: they alone end when Python finds them
    died: list[str] = []
    delete = wgpu.GPUObjectBase.__del__

    def delete_and_note(wgpu_object: wgpu.GPUObjectBase) -> None:
        if interrupts._came is None:
            died.append(repr(wgpu_object))
        delete(wgpu_object)

    monkeypatch.setattr(wgpu.GPUObjectBase, "__del__", delete_and_note)
    gc.disable()
    try:
        work()
    finally:
        gc.enable()
    assert died == []
