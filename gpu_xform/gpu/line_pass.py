"""Points and edges to pixels: a compute pass projects every point once, a render pass draws the edges between them."""

import contextlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import layouts
from .buffers import UNIFORM, Buffer
from .compute import bind, dispatch
from .device import Device
from .plans import POINTS_PER_INVOCATION, precision_name, rounded_up, workgroup_size
from .targets import FORMAT, Target
from .transform_pass import ROWS_AT_ONCE, Finish

CLIP_POSITION_BYTES = 16
EDGE_BYTES = 8


@dataclass(frozen=True)
class Points:
    """What is drawn: the first `n_points` > 0 packed points of R^3 in `buffer`, which is padded to whole quads."""

    buffer: Buffer
    n_points: int
    dtype: np.dtype[Any]


def max_points(device: Device) -> int:
    """Return how many points one picture may have on `device`."""
    in_binding = binding_bytes(device) // CLIP_POSITION_BYTES
    in_dispatch = device.limits.max_workgroups * workgroup_size(device) * POINTS_PER_INVOCATION
    return min(in_binding, in_dispatch) // POINTS_PER_INVOCATION * POINTS_PER_INVOCATION


def binding_bytes(device: Device) -> int:
    """Return the largest buffer that one binding can show."""
    return min(device.limits.max_binding_bytes, device.limits.max_buffer_bytes)


def draw(
    device: Device,
    points: Points,
    clip_from_points: npt.NDArray[np.float64],
    edges: npt.NDArray[np.uint32],
    colors: npt.NDArray[np.uint32],
    *,
    size: tuple[int, int],
    line_width: float | None,
    background: tuple[float, float, float, float],
) -> npt.NDArray[np.uint8]:
    """Draw the edges in their order, each over the ones before it; return premultiplied (height, width, 4).

    clip_from_points : (4, 4)
    edges : (m, 2), m > 0
    line_width : pixels; None for the device's own lines, one pixel wide and not anti-aliased
    colors : (1,) or (m,), as WGSL's `unpack4x8unorm` takes them
    """
    with device.lock, contextlib.ExitStack() as stack:

        def filled(array: npt.NDArray[np.generic], usage: int | None = None) -> Buffer:
            buffer = Buffer(device, array.nbytes) if usage is None else Buffer(device, array.nbytes, usage)
            stack.callback(buffer.release)
            buffer.upload(array)
            return buffer

        n_padded = rounded_up(points.n_points)
        projected = Buffer(device, n_padded * CLIP_POSITION_BYTES)
        stack.callback(projected.release)
        target = Target(device, size)
        stack.callback(target.release)
        n_quads = n_padded // POINTS_PER_INVOCATION
        struct = layouts.transform_structs(clip_from_points[None], points.dtype, points.n_points)
        transforms = filled(np.tile(struct, ROWS_AT_ONCE), UNIFORM)
        constants = {"workgroup_size": workgroup_size(device), "finish": Finish.AS_IT_IS}
        project = device.pipelines.compute(f"project_vertices_{precision_name(points.dtype)}", **constants)
        if line_width is None:
            lines = device.pipelines.render("draw_thin_lines", "line-list", FORMAT)
        else:
            lines = device.pipelines.render("draw_lines", "triangle-strip", FORMAT)

        batch = binding_bytes(device) // EDGE_BYTES
        batches = []
        for start in range(0, len(edges), batch):
            part = edges[start : start + batch]
            own = colors if len(colors) == 1 else colors[start : start + batch]
            picture = filled(layouts.picture_struct(size, line_width or 1.0, len(own)), UNIFORM)
            buffers = (picture, projected, filled(part), filled(own))
            batches.append((len(part), buffers, bind(device, lines, buffers)))

        used = [
            points.buffer,
            projected,
            transforms,
            target.rows,
            *(buffer for _, buffers, _ in batches for buffer in buffers),
        ]
        with device.recording(*used) as encoder:
            n_workgroups = -(-n_quads // workgroup_size(device))
            dispatch(encoder, project, bind(device, project, (transforms, points.buffer, projected)), n_workgroups)
            render = encoder.begin_render_pass(color_attachments=[target.attachment(background)])
            render.set_pipeline(lines)
            for n_edges, _, bindings in batches:
                render.set_bind_group(0, bindings)
                if line_width is None:
                    render.draw(2 * n_edges)
                else:
                    render.draw(4, n_edges)
            render.end()
            target.copy_rows(encoder)
        return target.pixels()
