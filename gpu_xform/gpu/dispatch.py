"""Bind groups and compute dispatches: a pipeline, its buffers, a grid of workgroups."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import wgpu

from ..errors import ShaderError
from .buffers import Buffer
from .context import CommandEncoder, GpuContext
from .errors import translate_wgpu_errors
from .shaders import ComputePipeline

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

    def bind(self, pipeline: ComputePipeline, /, **bindings: Buffer | Binding) -> wgpu.GPUBindGroup:
        """Bind whole buffers and parts of them to the variables of a pipeline's WGSL, by name.

        A group whose buffers are all persistent is kept and given again. Raises `ShaderError` if the names are not
        those of the WGSL.
        """
        parts = {
            name: part if isinstance(part, Binding) else Binding(part, 0, part.n_bytes)
            for name, part in bindings.items()
        }
        for buffer, _, _ in parts.values():
            buffer.require_submittable(self._context)
        if not all(part.buffer.persistent for part in parts.values()):
            return self._create(pipeline, parts)
        # Neither the id of a pipeline nor that of a buffer comes again: no key can mean another group.
        key = (pipeline.id, *((name, buffer.id, offset, n) for name, (buffer, offset, n) in parts.items()))
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

    def _create(self, pipeline: ComputePipeline, parts: Mapping[str, Binding]) -> wgpu.GPUBindGroup:
        if parts.keys() != pipeline.bindings.keys():
            expected = ", ".join(pipeline.bindings)
            raise ShaderError(f"the bindings of {pipeline.label} must be {expected}, got {', '.join(parts) or 'none'}")
        labels = [part.buffer.label for part in parts.values()]
        with translate_wgpu_errors("bind the buffers", pipeline.label, *labels):
            return self._context.handle.create_bind_group(
                label=pipeline.label,
                layout=pipeline.handle.get_bind_group_layout(0),
                entries=[
                    {
                        "binding": pipeline.bindings[name],
                        "resource": {"buffer": buffer.handle, "offset": offset, "size": n_bytes},
                    }
                    for name, (buffer, offset, n_bytes) in parts.items()
                ],
            )


def dispatch(
    encoder: CommandEncoder,
    pipeline: ComputePipeline,
    bindings: wgpu.GPUBindGroup,
    *n_workgroups: int | Buffer,
) -> None:
    """Encode one dispatch, in a compute pass of its own.

    n_workgroups : up to three numbers, or the one buffer that begins with three
    """
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline.handle)
    compute.set_bind_group(0, bindings)
    if isinstance(n_workgroups[0], Buffer):
        compute.dispatch_workgroups_indirect(n_workgroups[0].handle, 0)
    else:
        compute.dispatch_workgroups(*n_workgroups)
    encoder.end_compute_pass(compute, pipeline.label)
