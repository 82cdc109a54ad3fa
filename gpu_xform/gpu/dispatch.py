"""Bind groups, compute dispatches and render passes: a pipeline, its buffers and textures, and what it runs over."""

import contextlib
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, TypeAlias

from .._core.interrupts import defer_interrupts
from ..errors import ShaderError
from .binding import wgpu
from .buffers import Buffer
from .context import CommandEncoder, GpuContext
from .deletion_queue import own
from .shaders import ComputePipeline, Pipeline, RenderPipeline
from .textures import Texture

MAX_BIND_GROUPS = 256  # kept for the next time; small pictures take a tenth less time for it


class Binding(NamedTuple):
    """A part of a buffer."""

    buffer: Buffer
    offset_bytes: int
    n_bytes: int


Bindable: TypeAlias = Buffer | Binding | Texture


class BindGroup:
    """What the variables of a pipeline's WGSL are bound to."""

    def __init__(self, handle: wgpu.GPUBindGroup) -> None:
        self.handle = handle
        own(self, handle)


class BindGroupCache:
    """The bind groups of one device."""

    def __init__(self, context: GpuContext) -> None:
        self._context = context
        self._groups: dict[tuple[Any, ...], BindGroup] = {}

    def bind(self, pipeline: Pipeline, /, **bindings: Bindable) -> BindGroup:
        """Bind buffers, parts of buffers, and textures to the variables of a pipeline's WGSL, by name.

        A group of what is all persistent is kept and given again. Raises `ShaderError` if the names are not those of
        the WGSL.
        """
        parts = {
            name: Binding(part, 0, part.n_bytes) if isinstance(part, Buffer) else part
            for name, part in bindings.items()
        }
        for part in parts.values():
            _owner(part).require_submittable(self._context)
        if not all(_owner(part).persistent for part in parts.values()):
            return self._create(pipeline, parts)
        # Neither the id of a pipeline nor that of a buffer or of a texture comes again: no key can mean another group.
        key = (pipeline.id, *((name, *_identity(part)) for name, part in parts.items()))
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

    def _create(self, pipeline: Pipeline, parts: Mapping[str, Binding | Texture]) -> BindGroup:
        if parts.keys() != pipeline.bindings.keys():
            expected = ", ".join(pipeline.bindings)
            raise ShaderError(f"the bindings of {pipeline.label} must be {expected}, got {', '.join(parts) or 'none'}")
        labels = [_owner(part).label for part in parts.values()]
        entries = [{"binding": pipeline.bindings[name], "resource": _resource(part)} for name, part in parts.items()]
        with defer_interrupts(), self._context.translate_errors("bind the buffers", pipeline.label, *labels):
            return BindGroup(
                self._context.handle.create_bind_group(
                    label=pipeline.label, layout=pipeline.handle.get_bind_group_layout(0), entries=entries
                )
            )


def _owner(part: Binding | Texture) -> Buffer | Texture:
    return part if isinstance(part, Texture) else part.buffer


def _identity(part: Binding | Texture) -> tuple[object, ...]:
    if isinstance(part, Texture):
        return ("texture", part.id)
    return (part.buffer.id, part.offset_bytes, part.n_bytes)


def _resource(part: Binding | Texture) -> Any:
    if isinstance(part, Texture):
        return part.view
    return {"buffer": part.buffer.handle, "offset": part.offset_bytes, "size": part.n_bytes}


def dispatch(
    encoder: CommandEncoder,
    pipeline: ComputePipeline,
    bindings: BindGroup,
    *n_workgroups: int | Buffer,
) -> None:
    """Encode one dispatch.

    n_workgroups : up to three numbers, or the one buffer that begins with three
    """
    compute = encoder.begin_compute_pass(pipeline.handle)
    compute.set_bind_group(0, bindings.handle)
    if isinstance(n_workgroups[0], Buffer):
        compute.dispatch_workgroups_indirect(n_workgroups[0].handle, 0)
    else:
        compute.dispatch_workgroups(*n_workgroups)
    encoder.end_dispatch(pipeline.label)


class RenderPass:
    """Triangles drawn into a texture by one pipeline; `begin_render_pass` lends it."""

    def __init__(self, handle: wgpu.GPURenderPassEncoder) -> None:
        self._handle = handle

    def draw(self, n_vertices: int) -> None:
        """Draw a triangle per three vertices."""
        self._handle.draw(n_vertices)

    def draw_indexed(self, indices: Buffer, n_indices: int, first_vertex: int) -> None:
        """Draw a triangle per three of the first 16-bit indices, which count from `first_vertex`."""
        self._handle.set_index_buffer(indices.handle, "uint16")
        self._handle.draw_indexed(n_indices, 1, 0, first_vertex)

    def draw_indexed_indirect(self, indices: Buffer, draws: Buffer, offset_bytes: int) -> None:
        """Draw what five numbers in a buffer say, by 16-bit indices."""
        self._handle.set_index_buffer(indices.handle, "uint16")
        self._handle.draw_indexed_indirect(draws.handle, offset_bytes)


@contextlib.contextmanager
def begin_render_pass(
    encoder: CommandEncoder,
    target: Texture,
    extent: tuple[int, int],
    pipeline: RenderPipeline,
    bindings: BindGroup,
    *,
    clear_color: tuple[float, float, float, float] | None = None,
) -> Iterator[RenderPass]:
    """Encode a render pass into the first `extent` texels of a texture.

    clear_color : what all texels of the texture are before; None for what they hold
    """
    target.require_submittable(encoder.context)
    render = encoder.begin_render_pass(target.view, clear_color)
    if extent != target.extent:
        render.set_viewport(0.0, 0.0, *map(float, extent), 0.0, 1.0)
    render.set_pipeline(pipeline.handle)
    render.set_bind_group(0, bindings.handle)
    yield RenderPass(render)
    encoder.end_render_pass(render, pipeline.label)
