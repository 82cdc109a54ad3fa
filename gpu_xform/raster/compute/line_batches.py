"""Lines of projected shapes, cut into what one binding holds."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ...drawing.draw_list import EDGE_BYTES, Lines
from ...drawing.enums import ColorMode, Hidden
from ...gpu import layouts
from ...gpu.buffers import Buffer
from ...gpu.chunking import choose_workgroup_size, count_workgroups
from ...gpu.context import CommandEncoder
from ...gpu.device import Device
from ...gpu.dispatch import Binding, dispatch
from ..tiles import TILE_SIDE_PX
from .vertex_stage import Projected

COLOR_BYTES = 4
MOST_PIXELS = 1 << 15  # that an invocation goes through: lavapipe ends loops after twice as many, and says nothing
LEAST_EDGE_BITS = 8
INVOCATIONS = 2048  # that keep all processors of a device busy
GROUP = 64  # edges whose bindings begin where any adapter lets them

Bindings: TypeAlias = dict[str, Buffer | Binding]


@dataclass(frozen=True)
class Batch:
    """Lines whose edges, and whose colours where each has its own, are what one binding holds."""

    shape: Projected
    lines: Lines
    n_edges: int
    edges: Binding
    colors: Binding | None


def batches(device: Device, shapes: Sequence[Projected]) -> list[Batch]:
    """Return what is drawn, in order."""
    return [batch for shape in shapes for lines in shape.drawable.lines for batch in _cut(device, shape, lines)]


def _cut(device: Device, shape: Projected, lines: Lines) -> Iterator[Batch]:
    most = max(device.limits.max_bound_bytes // EDGE_BYTES // GROUP, 1) * GROUP
    for start in range(0, lines.n_edges, most):
        n_edges = min(most, lines.n_edges - start)
        colors = None
        if lines.colors is not None:
            colors = Binding(lines.colors, 0, lines.colors.n_bytes)
            if lines.color_mode is ColorMode.PER_EDGE:
                colors = Binding(lines.colors, start * COLOR_BYTES, n_edges * COLOR_BYTES)
        edges = Binding(lines.edges, start * EDGE_BYTES, n_edges * EDGE_BYTES)
        yield Batch(shape, lines, n_edges, edges, colors)


def style_struct(batch: Batch) -> npt.NDArray[np.void]:
    """Return the WGSL struct of a batch."""
    lines = batch.lines
    struct = np.zeros((), layouts.STYLE)
    struct["cue"] = lines.depth_cue
    struct["color"] = lines.color
    struct["line_width"] = 1.0 if lines.line_width is None else lines.line_width
    struct["strength"] = lines.opacity
    struct["n_edges"] = batch.n_edges
    struct["n_points"] = batch.shape.stride
    n_edges = batch.n_edges * batch.shape.n_instances  # counted from 1
    struct["edge_bits"] = max(n_edges.bit_length(), LEAST_EDGE_BITS)
    struct["log2_lanes"] = log2_lanes(batch)
    return struct


def log2_lanes(batch: Batch) -> int:
    """Return how many invocations share an edge, as a power of two: enough for short loops, and for all processors."""
    lines = batch.lines
    width = math.ceil((lines.line_width or 1.0) * math.sqrt(2.0)) + 2
    longest = width if lines.are_points else TILE_SIDE_PX
    needed = longest * min(width, TILE_SIDE_PX) / MOST_PIXELS
    wanted = min(INVOCATIONS / (batch.n_edges * batch.shape.n_instances), longest / 8)
    return max(0, math.ceil(math.log2(max(needed, wanted))))


def strength_constants(batch: Batch, *, nothing_hides: bool) -> dict[str, float]:
    """Return what strength.wgsl is compiled for."""
    hidden = Hidden.SHOW if nothing_hides else batch.lines.hidden
    return {"hidden": hidden, "is_cued": batch.lines.depth_cue.amount > 0.0, "is_outline": batch.lines.are_silhouettes}


def over_edges(
    device: Device,
    encoder: CommandEncoder,
    stage: str,
    batch: Batch,
    bindings: Bindings,
    n_lanes: int,
    /,
    **constants: float,
) -> None:
    """Record a stage that goes through the edges of a batch, an edge an invocation, or `n_lanes`."""
    pipeline = device.pipelines.compute(stage, workgroup_size=choose_workgroup_size(device), **constants)
    grid = count_workgroups(device, batch.n_edges * n_lanes), batch.shape.n_instances
    dispatch(encoder, pipeline, device.bind_groups.bind(pipeline, **bindings), *grid)
