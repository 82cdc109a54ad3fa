"""How long one dispatch takes, for benchmarks."""

from collections.abc import Mapping

from .buffers import Buffer
from .device import GpuDevice
from .dispatch import Binding, dispatch
from .shaders import ComputePipeline


def time_kernel(
    device: GpuDevice, pipeline: ComputePipeline, bindings: Mapping[str, Buffer | Binding], n_workgroups: int
) -> float:
    """Run one dispatch and return its seconds by the device's own clock, or by the host's if the device has none."""
    buffers = [part.buffer if isinstance(part, Binding) else part for part in bindings.values()]
    with device.time_dispatches() as timer:
        with device.encode_commands(*buffers, label="timing") as encoder:
            dispatch(encoder, pipeline, device.bind_groups.bind(pipeline, **bindings), n_workgroups)
        [(_, begin_ns, end_ns)] = timer.times
        return (end_ns - begin_ns) * 1e-9
