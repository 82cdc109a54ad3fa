"""The vertex stage: the points of every instance of every drawable to clip space, once per picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..drawing.draw_list import Drawable
from ..drawing.limits import CLIP_POSITION_BYTES
from ..gpu import layouts, uniforms
from ..gpu.buffers import Buffer
from ..gpu.chunking import POINTS_PER_INVOCATION, align_points, choose_workgroup_size, name_number_type
from ..gpu.context import CommandEncoder
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Binding, dispatch
from .render_target import POOL_OWNER


@dataclass(frozen=True)
class ProjectedDrawable:
    """A drawable, and its points in clip space: (n_instances, instance_stride, 4) float32."""

    drawable: Drawable
    clip_positions: Buffer

    @property
    def n_instances(self) -> int:
        """The number of instances."""
        return len(self.drawable.clip_from_points)

    @property
    def instance_stride(self) -> int:
        """The number of points from one instance to the next: its own, padded to whole packets of four."""
        return align_points(self.drawable.points.n_points)


class VertexStage:
    """The transform of all points of all instances of `drawables`, recorded once before what is drawn from it."""

    def __init__(self, device: GpuDevice, drawables: Sequence[Drawable]) -> None:
        self._device = device
        self._bindings: list[dict[str, Buffer | Binding]] = []
        self.projected: list[ProjectedDrawable] = []
        for number, drawable in enumerate(drawables):
            stride = align_points(drawable.points.n_points)
            n_bytes = len(drawable.clip_from_points) * stride * CLIP_POSITION_BYTES
            clip_positions = device.pool.scratch(POOL_OWNER, f"clip positions {number}", n_bytes)
            stack = layouts.pack_matrices(drawable.clip_from_points, drawable.points.dtype)
            matrices = device.pool.scratch(POOL_OWNER, f"clip from points {number}", stack.nbytes)
            matrices.upload_changed(stack)
            struct = np.array((stride // POINTS_PER_INVOCATION,), layouts.VERTEX_TRANSFORM)
            (uniform,) = uniforms.upload(device, POOL_OWNER, f"vertex transform {number}", [struct])
            self._bindings.append(
                {
                    "vertex_transform": uniform,
                    "matrices": matrices,
                    "points": drawable.points.buffer,
                    "clip_positions": clip_positions,
                }
            )
            self.projected.append(ProjectedDrawable(drawable, clip_positions))

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of this stage uses."""
        parts = [part for bindings in self._bindings for part in bindings.values()]
        return [part.buffer if isinstance(part, Binding) else part for part in parts]

    def record(self, encoder: CommandEncoder) -> None:
        """Record a dispatch per drawable."""
        size = choose_workgroup_size(self._device)
        for projected, bindings in zip(self.projected, self._bindings, strict=True):
            number_type = name_number_type(projected.drawable.points.dtype)
            pipeline = self._device.pipelines.compute("vertex_transform", number_type, workgroup_size=size)
            n_workgroups = -(-projected.instance_stride // (POINTS_PER_INVOCATION * size))
            group = self._device.bind_groups.bind(pipeline, **bindings)
            dispatch(encoder, pipeline, group, n_workgroups, projected.n_instances)
