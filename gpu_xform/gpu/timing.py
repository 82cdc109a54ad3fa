"""How long a dispatch takes on the device itself."""

import time
from collections.abc import Sequence

import numpy as np
import wgpu
from wgpu.backends.wgpu_native import lib

from .buffers import Buffer, Usage
from .device import Device
from .dispatch import Binding, dispatch


def time_kernel(
    device: Device, pipeline: wgpu.GPUComputePipeline, bindings: Sequence[Buffer | Binding], n_workgroups: int
) -> float:
    """Run one dispatch and return its seconds by the device's own clock; by the host's where the device has none."""
    with device.lock:
        group = device.bind_groups.bind(pipeline, bindings)
        buffers = [part.buffer if isinstance(part, Binding) else part for part in bindings]
        if "timestamp-query" not in device.features:
            start = time.perf_counter()
            with device.encode_commands(*buffers, label="timing") as encoder:
                dispatch(encoder, pipeline, group, n_workgroups)
            with buffers[-1].map_read(4):
                return time.perf_counter() - start
        queries = device.context.handle.create_query_set(label="timing", type="timestamp", count=2)
        ticks = Buffer(device.context, 16, Usage.QUERY_RESOLVE | Usage.COPY_SRC, label="timing: ticks")
        try:
            with device.encode_commands(ticks, *buffers, label="timing") as encoder:
                dispatch(encoder, pipeline, group, n_workgroups, timestamps=queries)
                encoder.handle.resolve_query_set(queries, 0, 2, ticks.handle, 0)
            with ticks.map_read(16) as view:
                begin, end = view.view(np.uint64).tolist()
        finally:
            ticks.release()
        return float(end - begin) * nanoseconds_per_tick(device) * 1e-9


def nanoseconds_per_tick(device: Device) -> float:
    """Return what a device's clock counts in: a nanosecond on some, ten or eighty on others."""
    period: float = lib.wgpuQueueGetTimestampPeriod(device.context.handle.queue._internal)
    return period
