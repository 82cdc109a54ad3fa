"""What a picture is drawn from on the device: drawables, and their points projected."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...drawing.draw_list import Drawable
from ...drawing.limits import CLIP_POSITION_BYTES
from ...gpu import layouts, uniforms
from ...gpu.buffers import Buffer
from ...gpu.chunking import POINTS_PER_INVOCATION, align_points, choose_workgroup_size, name_number_type
from ...gpu.context import CommandEncoder
from ...gpu.device import Device
from ...gpu.dispatch import Binding, dispatch
from .render_target import POOL_OWNER

NUMBER_BYTES = 4
HEAD_BYTES = 16  # before the numbers of large triangles: workgroups (x, y, z), and how many triangles they take


@dataclass(frozen=True)
class Projected:
    """A drawable, and its points in clip space: (k, n_points padded to quads, 4) float32."""

    drawable: Drawable
    positions: Buffer

    @property
    def n_instances(self) -> int:
        """How often the points are there."""
        return len(self.drawable.clip_from_points)

    @property
    def stride(self) -> int:
        """The number of points from one instance to the next."""
        return align_points(self.drawable.points.n_points)


def in_bindings(device: Device, drawable: Drawable) -> Iterator[Drawable]:
    """Cut the instances of a drawable into as many as bindings need: for points, and a number a face or an edge."""
    n_numbers = max([lines.n_edges for lines in drawable.lines] + [drawable.faces.n_triangles if drawable.faces else 0])
    stride = max(align_points(drawable.points.n_points) * CLIP_POSITION_BYTES, n_numbers * NUMBER_BYTES)
    most = max(1, min((device.limits.max_bound_bytes - HEAD_BYTES) // stride, device.limits.max_workgroups))
    for start in range(0, len(drawable.clip_from_points), most):
        yield replace(drawable, clip_from_points=drawable.clip_from_points[start : start + most])


class Projection:
    """The projection of all points of all instances of `drawables`, recorded once before what is drawn from it."""

    def __init__(self, device: Device, drawables: Sequence[Drawable]) -> None:
        self._device = device
        self._bindings: list[dict[str, Buffer | Binding]] = []
        self.shapes: list[Projected] = []
        for number, drawable in enumerate(drawables):
            points = drawable.points
            n_padded = align_points(points.n_points)
            n_bytes = len(drawable.clip_from_points) * n_padded * CLIP_POSITION_BYTES
            positions = device.pool.scratch(POOL_OWNER, f"positions {number}", n_bytes)
            stack = layouts.matrix_array(drawable.clip_from_points, points.dtype)
            matrices = device.pool.scratch(POOL_OWNER, f"projections {number}", stack.nbytes)
            matrices.upload(stack)
            n_packets = np.array([n_padded // POINTS_PER_INVOCATION, 0, 0, 0], np.uint32)
            (struct,) = uniforms.upload(device, POOL_OWNER, f"vertex transform {number}", [n_packets])
            self._bindings.append(
                {
                    "vertex_transform": struct,
                    "matrices": matrices,
                    "points": points.buffer,
                    "clip_positions": positions,
                }
            )
            self.shapes.append(Projected(drawable, positions))

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of the projection uses."""
        parts = [part for bindings in self._bindings for part in bindings.values()]
        return [part.buffer if isinstance(part, Binding) else part for part in parts]

    def record(self, encoder: CommandEncoder) -> None:
        """Record a dispatch per drawable."""
        size = choose_workgroup_size(self._device)
        for projected, bindings in zip(self.shapes, self._bindings, strict=True):
            number_type = name_number_type(projected.drawable.points.dtype)
            pipeline = self._device.pipelines.compute("vertex_transform", number_type, workgroup_size=size)
            n_workgroups = -(-projected.stride // (POINTS_PER_INVOCATION * size))
            bound = self._device.bind_groups.bind(pipeline, **bindings)
            dispatch(encoder, pipeline, bound, n_workgroups, projected.n_instances)
