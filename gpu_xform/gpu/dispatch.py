"""Bind groups and compute dispatches: a pipeline, its buffers, a grid of workgroups."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import wgpu

from .buffers import Buffer
from .context import CommandEncoder, GpuContext
from .errors import translate_wgpu_errors

MAX_BIND_GROUPS = 256  # kept for the next time; small pictures take a tenth less time for it


class Binding(NamedTuple):
    """A part of a buffer."""

    buffer: Buffer
    offset_bytes: int
    n_bytes: int


class BindGroupCache:
    """The bind groups of one device."""

    def __init__(self, context: GpuContext) -> None:
        self._context = context
        self._groups: dict[tuple[Any, ...], wgpu.GPUBindGroup] = {}

    def bind(
        self,
        pipeline: wgpu.GPUComputePipeline,
        bindings: Sequence[Buffer | Binding] | Mapping[int, Buffer | Binding],
    ) -> wgpu.GPUBindGroup:
        """Bind whole buffers and parts of them to bindings 0, 1, ... of group 0, or to those that are named.

        A group whose buffers are all persistent is kept and given again.
        """
        numbered = bindings.items() if isinstance(bindings, Mapping) else enumerate(bindings)
        parts = [
            (number, part if isinstance(part, Binding) else Binding(part, 0, part.n_bytes)) for number, part in numbered
        ]
        for _, (buffer, _, _) in parts:
            buffer.require_submittable(self._context)
        if not all(part.buffer.persistent for _, part in parts):
            return self._create(pipeline, parts)
        # Pipelines live as long as their device, and ids of buffers do not come again: no key can mean another group.
        key = (id(pipeline), *((number, buffer.id, offset, n) for number, (buffer, offset, n) in parts))
        if key not in self._groups:
            if len(self._groups) == MAX_BIND_GROUPS:
                self._groups.pop(next(iter(self._groups)))
            self._groups[key] = self._create(pipeline, parts)
        return self._groups[key]

    def clear(self) -> None:
        """Drop every kept group."""
        self._groups.clear()

    def __len__(self) -> int:
        return len(self._groups)

    def _create(self, pipeline: wgpu.GPUComputePipeline, parts: Sequence[tuple[int, Binding]]) -> wgpu.GPUBindGroup:
        with translate_wgpu_errors("bind the buffers", pipeline.label, *[part.buffer.label for _, part in parts]):
            return self._context.handle.create_bind_group(
                label=pipeline.label,
                layout=pipeline.get_bind_group_layout(0),
                entries=[
                    {"binding": number, "resource": {"buffer": buffer.handle, "offset": offset, "size": n_bytes}}
                    for number, (buffer, offset, n_bytes) in parts
                ],
            )


def dispatch(
    encoder: CommandEncoder,
    pipeline: wgpu.GPUComputePipeline,
    bindings: wgpu.GPUBindGroup,
    *n_workgroups: int | Buffer,
) -> None:
    """Encode one dispatch, in a compute pass of its own.

    n_workgroups : up to three numbers, or the one buffer that begins with three
    """
    compute = encoder.begin_compute_pass(pipeline.label)
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, bindings)
    if isinstance(n_workgroups[0], Buffer):
        compute.dispatch_workgroups_indirect(n_workgroups[0].handle, 0)
    else:
        compute.dispatch_workgroups(*n_workgroups)
    encoder.end_compute_pass(compute)
