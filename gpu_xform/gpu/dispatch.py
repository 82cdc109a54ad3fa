"""One compute dispatch: a pipeline, its buffers, a grid of workgroups."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import wgpu

from .buffers import Buffer
from .errors import device_errors

if TYPE_CHECKING:
    from .device import Device


MOST_GROUPS = 256  # kept for the next time; small pictures take a tenth less time for it


class Binding(NamedTuple):
    """A part of a buffer."""

    buffer: Buffer
    offset_bytes: int
    n_bytes: int


def bind(
    device: "Device",
    pipeline: wgpu.GPUComputePipeline,
    bindings: Sequence[Buffer | Binding] | Mapping[int, Buffer | Binding],
) -> wgpu.GPUBindGroup:
    """Bind whole buffers and parts of them to bindings 0, 1, ... of group 0, or to those that are named.

    A group whose buffers all stay is kept and given again.
    """
    numbered = bindings.items() if isinstance(bindings, Mapping) else enumerate(bindings)
    parts = [
        (number, part if isinstance(part, Binding) else Binding(part, 0, part.n_bytes)) for number, part in numbered
    ]
    for _, (buffer, _, _) in parts:
        buffer.require_submittable(device)
    if not all(part.buffer.stays for _, part in parts):
        return _bind_group(device, pipeline, parts)
    # Pipelines live as long as their device, and numbers of buffers do not come again: no key can mean another group.
    key = (id(pipeline), *((number, buffer.number, offset, n) for number, (buffer, offset, n) in parts))
    groups = device.bind_groups
    if key not in groups:
        if len(groups) == MOST_GROUPS:
            groups.pop(next(iter(groups)))
        groups[key] = _bind_group(device, pipeline, parts)
    return groups[key]


def _bind_group(
    device: "Device",
    pipeline: wgpu.GPUComputePipeline,
    parts: Sequence[tuple[int, Binding]],
) -> wgpu.GPUBindGroup:
    with device_errors("bind the buffers"):
        return device.handle.create_bind_group(
            layout=pipeline.get_bind_group_layout(0),
            entries=[
                {"binding": number, "resource": {"buffer": buffer.handle, "offset": offset, "size": n_bytes}}
                for number, (buffer, offset, n_bytes) in parts
            ],
        )


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
