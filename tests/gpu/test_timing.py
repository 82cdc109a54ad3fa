import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gpu_xform.compute.kernels import transform as transform_kernel
from gpu_xform.compute.kernels.job import Epilogue
from gpu_xform.gpu import timestamps, timing
from gpu_xform.gpu.chunking import DispatchPlan
from gpu_xform.gpu.device import GpuDevice


@pytest.fixture
def kernel(device: GpuDevice) -> Iterator[tuple[Any, Any, int]]:
    """A pipeline, its bindings, and how many workgroups of it take a while."""
    yield from kernel_of(device)


def kernel_of(device: GpuDevice) -> Iterator[tuple[Any, Any, int]]:
    plan = DispatchPlan.of(device, 1 << 20, 3, np.dtype(np.float32))
    with device.lock:
        n_bytes = plan.chunk * plan.point_bytes
        buffers = {key: device.pool.scratch("test", key, n_bytes) for key in ("source", "destination")}
        (transforms,) = transform_kernel.upload_transforms(plan, np.eye(4)[None], plan.chunk)
        pipeline = plan.pipeline("transform_points", epilogue=Epilogue.NONE, n_matrices=1)
        yield pipeline, {"transforms": transforms, **buffers}, plan.n_workgroups(plan.chunk)


def test_a_kernel_takes_less_than_the_call_that_runs_it(device: GpuDevice, kernel: tuple[Any, Any, int]) -> None:
    start = time.perf_counter()
    seconds = timing.time_kernel(device, *kernel)
    assert 0.0 < seconds < time.perf_counter() - start


def test_a_device_without_timestamps_is_timed_by_the_host(single_device: GpuDevice) -> None:
    for kernel in kernel_of(single_device):
        start = time.perf_counter()
        seconds = timing.time_kernel(single_device, *kernel)
        assert 0.0 < seconds < time.perf_counter() - start


def test_a_devices_clock_ticks_as_it_says(
    device: GpuDevice, kernel: tuple[Any, Any, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    if "timestamp-query" not in device.features:
        pytest.skip("the host's clock is taken")
    monkeypatch.setattr(timestamps, "lib", SimpleNamespace(wgpuQueueGetTimestampPeriod=lambda _: 1e9))
    assert timing.time_kernel(device, *kernel) >= 1000.0
    monkeypatch.undo()
    assert timestamps.nanoseconds_per_tick(device.context) > 0.0
