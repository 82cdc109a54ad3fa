"""One compute dispatch: a pipeline, its buffers, a grid of workgroups."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import wgpu

from .buffers import Buffer
from .faults import device_errors

if TYPE_CHECKING:
    from .device import Device


class Binding(NamedTuple):
    """A part of a buffer."""

    buffer: Buffer
    offset_bytes: int
    n_bytes: int


def bind(
    device: "Device",
    pipeline: wgpu.GPUComputePipeline | wgpu.GPURenderPipeline,
    bindings: Sequence[Buffer | Binding] | Mapping[int, Buffer | Binding],
) -> wgpu.GPUBindGroup:
    """Bind whole buffers and parts of them to bindings 0, 1, ... of group 0, or to those that are named."""
    numbered = bindings.items() if isinstance(bindings, Mapping) else enumerate(bindings)
    with device_errors("bind the buffers"):
        return device.handle.create_bind_group(
            layout=pipeline.get_bind_group_layout(0),
            entries=[{"binding": number, "resource": _resource(device, part)} for number, part in numbered],
        )


def _resource(device: "Device", part: Buffer | Binding) -> object:
    buffer, offset_bytes, n_bytes = part if isinstance(part, Binding) else Binding(part, 0, part.n_bytes)
    buffer.require_submittable(device)
    return {"buffer": buffer.handle, "offset": offset_bytes, "size": n_bytes}


def dispatch(
    encoder: wgpu.GPUCommandEncoder,
    pipeline: wgpu.GPUComputePipeline,
    bindings: wgpu.GPUBindGroup,
    *n_workgroups: int | Buffer,
    timestamps: wgpu.GPUQuerySet | None = None,
) -> None:
    """Record one compute pass; its begin and end go into queries 0 and 1 of `timestamps`.

    n_workgroups : up to three numbers, or the one buffer that begins with three
    """
    writes = {"query_set": timestamps, "beginning_of_pass_write_index": 0, "end_of_pass_write_index": 1}
    compute = encoder.begin_compute_pass(timestamp_writes=writes if timestamps else None)
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, bindings)
    if isinstance(n_workgroups[0], Buffer):
        compute.dispatch_workgroups_indirect(n_workgroups[0].handle, 0)
    else:
        compute.dispatch_workgroups(*n_workgroups)
    compute.end()
