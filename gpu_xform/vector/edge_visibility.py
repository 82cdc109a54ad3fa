"""Hidden-line removal: edges split into spans in the picture, each wholly visible or wholly hidden."""

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray
from ..drawing.draw_list import Drawable, Lines
from ..drawing.view import View
from ..gpu import uniforms
from ..gpu.buffers import Buffer
from ..gpu.chunking import choose_workgroup_size, count_workgroups
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Binding, dispatch
from ..gpu.layouts import COUNT_OR_WRITE, SPAN
from ..raster.binding_limits import split_to_binding_limits
from ..raster.dashes import DashStage
from ..raster.line_batches import (
    LineBatch,
    make_line_bindings,
    make_line_style,
    opacity_constants,
    split_batches,
)
from ..raster.tile_struct import Tile, make_tile_struct
from ..raster.tiles import Region
from ..raster.triangles import DEPTH_BYTES, Hiders, TriangleStage
from ..raster.vertex_stage import VertexStage

MARGIN_PX = 2  # around the picture, for which depths are known

POOL_OWNER = "edge visibility"


class SplitEdges(NamedTuple):
    """One batch of lines, its edges split into spans.

    spans : `layouts.SPAN` (s,), in the order of the edges
    edges : (n_edges, 2) uint32 of the batch
    colors : packed, one per edge or per point; empty if all edges have one colour
    """

    batch: LineBatch
    spans: npt.NDArray[np.void]
    edges: npt.NDArray[np.uint32]
    colors: npt.NDArray[np.uint32]


def split_edges_by_visibility(
    device: GpuDevice,
    drawables: Sequence[Drawable],
    view: View,
    max_span_px: Callable[[Lines], float],
    *,
    find_visible: bool,
    covers: Sequence[Drawable] | None = None,
) -> tuple[list[SplitEdges], list[BoolArray]]:
    """Split the edges of each batch of lines, and tell which triangles of each drawable are the nearest in some pixel.

    max_span_px : returns the length that a span of lines may have along its major axis
    find_visible : whether to tell which triangles are the nearest; else none are
    covers : as those of `DrawList`

    Returns the split batches, and per drawable (n_instances, n_triangles), or (n_instances, 0) if it has no faces.
    """
    tile = Tile(Region((0, 0), view.size), MARGIN_PX)
    with device.lock:
        parts = [list(split_to_binding_limits(device, drawable)) for drawable in drawables]
        drawn = [part for own_parts in parts for part in own_parts]
        cover_parts = [part for drawable in covers or () for part in split_to_binding_limits(device, drawable)]
        vertices = VertexStage(device, drawn + cover_parts)
        projected = vertices.projected[: len(drawn)]
        n_depths = math.prod(tile.depth_region.extent)
        # Planes take as many depths again, and all of this picture, which is not cut into tiles, lie in one binding.
        finds_flats = 2 * DEPTH_BYTES * n_depths <= device.limits.max_bound_bytes
        triangles = cover_triangles = TriangleStage(
            device, projected, n_depths, write_ids=find_visible, finds_flats=finds_flats
        )
        if covers is not None:
            projected_covers = vertices.projected[len(drawn) :]
            cover_triangles = TriangleStage(device, projected_covers, n_depths, finds_flats=finds_flats, name="covers")
        hiders = Hiders(triangles, cover_triangles)
        line_batches = split_batches(device, projected, lambda lines: not hiders.of(lines).is_empty)
        (tile_part,) = uniforms.upload(device, POOL_OWNER, "tile", [make_tile_struct(tile, view)])
        styles = uniforms.upload(device, POOL_OWNER, "styles", [make_line_style(batch) for batch in line_batches])
        dashes = DashStage(device, line_batches, styles)
        used = tile_part.buffer, *vertices.buffers, *triangles.buffers, *cover_triangles.buffers, *dashes.buffers
        used = *used, *(part.buffer for part in styles), *(batch.edges.buffer for batch in line_batches)
        with device.encode_commands(*used, label="depth prepass") as encoder:
            vertices.record(encoder)
            triangles.depth_prepass(encoder, tile_part)
            if cover_triangles is not triangles:
                cover_triangles.depth_prepass(encoder, tile_part)
            dashes.record(encoder, tile_part)
        results = []
        for batch, style, dash_starts in zip(line_batches, styles, dashes.starts, strict=True):
            hider = hiders.of(batch.lines)
            buffers = make_line_bindings(batch, tile_part, style, hider.face_depths, dash_starts)
            constants = opacity_constants(batch, nothing_hides=hider.is_empty, has_flats=hider.has_flats)
            constants["max_span_px"] = max_span_px(batch.lines)
            spans = _find_spans(device, batch, buffers, constants)
            colors = _read_back(batch.colors) if batch.colors else np.empty(0, np.uint32)
            results.append(SplitEdges(batch, spans, _read_back(batch.edges).reshape(-1, 2), colors))
        is_visible = iter(triangles.visible_triangles(projected))
        return results, [np.vstack(list(islice(is_visible, len(own_parts)))) for own_parts in parts]


def _read_back(part: Binding) -> npt.NDArray[np.uint32]:
    first = part.offset_bytes
    with part.buffer.map_read(first + part.n_bytes) as view:
        return view[first:].view(np.uint32).copy()


def _find_spans(
    device: GpuDevice, batch: LineBatch, buffers: Mapping[str, Buffer | Binding], constants: Mapping[str, float]
) -> npt.NDArray[np.void]:
    """Return the spans of a batch: counted in a first dispatch, and written in as many as the bindings need."""
    n_edges = batch.n_instance_edges
    grid = count_workgroups(device, batch.n_edges), batch.projected.n_instances
    pipeline = device.pipelines.compute(
        "split_edges_by_visibility", workgroup_size=choose_workgroup_size(device), **constants
    )

    def run(counts: Buffer, spans: Buffer, first: int | None) -> None:
        """Count the spans of each edge; or write those from `first` on, whose offsets are in `counts`."""
        struct = np.array((first is not None, first or 0), COUNT_OR_WRITE)
        (uniform,) = uniforms.upload(device, POOL_OWNER, "count or write", [struct])
        bound = {**buffers, "span_counts": counts, "spans": spans, "count_or_write": uniform}
        used = [part.buffer if isinstance(part, Binding) else part for part in bound.values()]
        with device.encode_commands(*used, label="edge visibility") as encoder:
            dispatch(encoder, pipeline, device.bind_groups.bind(pipeline, **bound), *grid)

    with contextlib.ExitStack() as stack:
        counts = Buffer(device.context, 4 * n_edges, label="edge visibility: counts")
        stack.callback(counts.release)
        no_spans = Buffer(device.context, SPAN.itemsize, label="edge visibility: no spans")
        stack.callback(no_spans.release)
        run(counts, no_spans, None)
        with counts.map_read(4 * n_edges) as view:
            n_spans = view.view(np.uint32).astype(np.int64)
        result = np.empty(int(n_spans.sum()), SPAN)
        if len(result) == 0:
            return result
        counts.upload((np.cumsum(n_spans) - n_spans).astype(np.uint32))
        max_spans = min(len(result), max(1, device.limits.max_bound_bytes // SPAN.itemsize))
        spans = Buffer(device.context, SPAN.itemsize * max_spans, label="edge visibility: spans")
        stack.callback(spans.release)
        for first in range(0, len(result), max_spans):
            part = result[first : first + max_spans]
            run(counts, spans, first)
            with spans.map_read(part.nbytes) as view:
                part[:] = view.view(SPAN)
        return result
