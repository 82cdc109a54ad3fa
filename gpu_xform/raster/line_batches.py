"""Batches of lines: slices that fit in one storage-buffer binding, and the constants and uniforms of each."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..drawing.draw_list import EDGE_BYTES, Lines
from ..drawing.enums import ColorMode, Dashes, Hidden
from ..drawing.limits import max_batch_edges
from ..gpu import layouts
from ..gpu.buffers import Buffer
from ..gpu.chunking import choose_workgroup_size, count_workgroups
from ..gpu.context import CommandEncoder
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Binding, dispatch
from .tiles import TILE_SIDE_PX
from .vertex_stage import ProjectedDrawable

COLOR_BYTES = 4
MAX_PIXELS_PER_INVOCATION = 1 << 15  # lavapipe ends loops after twice as many, and says nothing
MIN_EDGE_BITS = 8
BUSY_INVOCATIONS = 2048  # that keep all processors of a device busy
MIN_COLUMNS_PER_INVOCATION = 8
MIN_SIMPLE_DASH_PX = 1.0  # of a shorter dash, a pixel can see both ends
NO_DASH_PX = 1e9  # where dashes lie that a pattern does not have

Bindings: TypeAlias = dict[str, Buffer | Binding]


@dataclass(frozen=True)
class LineBatch:
    """A slice of lines whose edges, and whose colours if each edge has its own, fit in one binding."""

    projected: ProjectedDrawable
    lines: Lines
    n_edges: int
    edges: Binding
    colors: Binding | None
    chains: Binding | None

    @property
    def n_instance_edges(self) -> int:
        """The number of edges of all instances."""
        return self.n_edges * self.projected.n_instances


def split_batches(
    device: GpuDevice, projected: Sequence[ProjectedDrawable], may_hide: Callable[[Lines], bool]
) -> list[LineBatch]:
    """Return the lines of all drawables in the order in which they are drawn, but for hidden ones that nothing hides.

    may_hide : says whether there are faces that hide some of the lines
    """
    return [
        batch
        for each in projected
        for lines in each.drawable.lines
        if lines.hidden is not Hidden.ONLY or may_hide(lines)
        for batch in _split(device, each, lines)
    ]


def _split(device: GpuDevice, projected: ProjectedDrawable, lines: Lines) -> Iterator[LineBatch]:
    max_edges = max_batch_edges(device)
    for start in range(0, lines.n_edges, max_edges):
        n_edges = min(max_edges, lines.n_edges - start)
        colors = None
        if lines.colors is not None:
            colors = Binding(lines.colors, 0, lines.colors.n_bytes)
            if lines.color_mode is ColorMode.PER_EDGE:
                colors = Binding(lines.colors, start * COLOR_BYTES, n_edges * COLOR_BYTES)
        edges = Binding(lines.edges, start * EDGE_BYTES, n_edges * EDGE_BYTES)
        chains = None
        if lines.chains is not None:
            chains = Binding(lines.chains, start * layouts.CHAIN_EDGE.itemsize, n_edges * layouts.CHAIN_EDGE.itemsize)
        yield LineBatch(projected, lines, n_edges, edges, colors, chains)


def make_line_style(batch: LineBatch) -> npt.NDArray[np.void]:
    """Return the WGSL struct of a batch."""
    lines = batch.lines
    struct = np.zeros((), layouts.LINE_STYLE)
    struct["depth_cue"] = lines.depth_cue
    struct["color"] = lines.color
    struct["line_width"] = 1.0 if lines.line_width is None else lines.line_width
    struct["opacity"] = lines.opacity
    struct["n_edges"] = batch.n_edges
    struct["instance_stride"] = batch.projected.instance_stride
    struct["edge_bits"] = max(batch.n_instance_edges.bit_length(), MIN_EDGE_BITS)  # edges are counted from 1
    struct["log2_lanes"] = choose_log2_lanes(batch)
    bounds = [0.0, *accumulate(lines.dash_px)]
    struct["dash_period_px"] = bounds[-1] or 1.0
    struct["dash_begins"] = struct["dash_ends"] = NO_DASH_PX
    struct["dash_begins"].reshape(-1)[: len(bounds) // 2] = bounds[:-1:2]
    struct["dash_ends"].reshape(-1)[: len(bounds) // 2] = bounds[1::2]
    return struct


def choose_log2_lanes(batch: LineBatch) -> int:
    """Return how many invocations share an edge, as a power of two: enough for short loops, and for all processors."""
    lines = batch.lines
    width = math.ceil((lines.line_width or 1.0) * math.sqrt(2.0)) + 2
    max_columns = width if lines.are_points else TILE_SIDE_PX
    needed = max_columns * min(width, TILE_SIDE_PX) / MAX_PIXELS_PER_INVOCATION
    wanted = min(BUSY_INVOCATIONS / batch.n_instance_edges, max_columns / MIN_COLUMNS_PER_INVOCATION)
    return max(0, math.ceil(math.log2(max(needed, wanted))))


def opacity_constants(batch: LineBatch, *, nothing_hides: bool, has_flats: bool) -> dict[str, float]:
    """Return the `override` constants of line_opacity.wgsl."""
    lines = batch.lines
    is_continuous = not is_dashed(batch) or (nothing_hides and lines.hidden is Hidden.DASH)
    is_simple = len(lines.dash_px) == 2 and lines.dash_px[0] >= MIN_SIMPLE_DASH_PX
    return {
        "hidden": Hidden.SHOW if nothing_hides else lines.hidden,
        "dashes": Dashes.NONE if is_continuous else Dashes.SIMPLE if is_simple else Dashes.COMPOUND,
        "is_silhouette": lines.are_silhouettes,
        "has_flats": has_flats and lines.hidden is not Hidden.SHOW,
        "has_depth_cue": lines.depth_cue.amount > 0.0,
    }


def is_dashed(batch: LineBatch) -> bool:
    """Say whether dashes run along the chains of a batch."""
    return batch.chains is not None and len(batch.lines.dash_px) > 0


def make_line_bindings(
    batch: LineBatch, tile: Binding, style: Binding, face_depths: Buffer, dash_starts: Buffer
) -> Bindings:
    """Return the bindings that every stage has which reads the edges of a batch."""
    return {
        "tile": tile,
        "style": style,
        "clip_positions": batch.projected.clip_positions,
        "edges": batch.edges,
        "face_depths": face_depths,
        "dash_starts": dash_starts,
    }


def dispatch_over_edges(
    device: GpuDevice,
    encoder: CommandEncoder,
    stage: str,
    batch: LineBatch,
    bindings: Bindings,
    n_lanes: int,
    /,
    **constants: float,
) -> None:
    """Record a stage that iterates over the edges of a batch, with `n_lanes` invocations per edge."""
    pipeline = device.pipelines.compute(stage, workgroup_size=choose_workgroup_size(device), **constants)
    grid = count_workgroups(device, batch.n_edges * n_lanes), batch.projected.n_instances
    dispatch(encoder, pipeline, device.bind_groups.bind(pipeline, **bindings), *grid)
