"""One compute dispatch: a pipeline, its buffers, a count of workgroups."""

from typing import TYPE_CHECKING

import wgpu

from .buffers import Buffer
from .faults import device_errors

if TYPE_CHECKING:
    from .device import Device


def bind(
    device: "Device", pipeline: wgpu.GPUComputePipeline | wgpu.GPURenderPipeline, buffers: tuple[Buffer, ...]
) -> wgpu.GPUBindGroup:
    """Bind `buffers` to bindings 0, 1, ... of group 0."""
    for buffer in buffers:
        buffer.require_submittable(device)
    with device_errors("bind the buffers"):
        return device.handle.create_bind_group(
            layout=pipeline.get_bind_group_layout(0),
            entries=[{"binding": index, "resource": {"buffer": buffer.handle}} for index, buffer in enumerate(buffers)],
        )


def dispatch(
    encoder: wgpu.GPUCommandEncoder, pipeline: wgpu.GPUComputePipeline, bindings: wgpu.GPUBindGroup, n_workgroups: int
) -> None:
    """Record one compute pass."""
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, bindings)
    compute.dispatch_workgroups(n_workgroups)
    compute.end()
