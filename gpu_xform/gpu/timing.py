"""How long a dispatch takes on the device itself."""

import time
from collections.abc import Sequence

import numpy as np
import wgpu
from wgpu.backends.wgpu_native import lib

from .buffers import Buffer, Usage
from .device import Device
from .dispatch import Binding, bind, dispatch


def kernel_seconds(
    device: Device, pipeline: wgpu.GPUComputePipeline, bindings: Sequence[Buffer | Binding], n_workgroups: int
) -> float:
    """Run one dispatch and return its seconds by the device's own clock; by the host's where the device has none."""
    with device.lock:
        group = bind(device, pipeline, bindings)
        buffers = [part.buffer if isinstance(part, Binding) else part for part in bindings]
        if "timestamp-query" not in device.features:
            start = time.perf_counter()
            with device.recording(*buffers) as encoder:
                dispatch(encoder, pipeline, group, n_workgroups)
            with buffers[-1].downloaded(4):
                return time.perf_counter() - start
        queries = device.handle.create_query_set(type="timestamp", count=2)
        ticks = Buffer(device, 16, Usage.QUERY_RESOLVE | Usage.COPY_SRC)
        try:
            with device.recording(ticks, *buffers) as encoder:
                dispatch(encoder, pipeline, group, n_workgroups, timestamps=queries)
                encoder.resolve_query_set(queries, 0, 2, ticks.handle, 0)
            with ticks.downloaded(16) as view:
                begin, end = view.view(np.uint64).tolist()
        finally:
            ticks.release()
        return float(end - begin) * nanoseconds_a_tick(device) * 1e-9


def nanoseconds_a_tick(device: Device) -> float:
    """Return what a device's clock counts in: a nanosecond on some, ten or eighty on others."""
    period: float = lib.wgpuQueueGetTimestampPeriod(device.handle.queue._internal)
    return period
