"""Edges to pieces in the picture, wholly visible or wholly hidden: what vector pictures are made of."""

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..drawing.draw_list import Drawable, Lines
from ..drawing.view import View
from ..gpu import uniforms
from ..gpu.buffers import Buffer
from ..gpu.chunking import choose_workgroup_size, count_workgroups
from ..gpu.device import Device
from ..gpu.dispatch import Binding, dispatch
from ..gpu.layouts import PIECE
from ..raster.compute.line_batches import Batch, batches, strength_constants, style_struct
from ..raster.compute.tile_struct import Tile, tile_struct
from ..raster.compute.triangles import FacePass
from ..raster.compute.vertex_stage import Projection, in_bindings
from ..raster.tiles import Region

MARGIN = 2  # pixels around a picture whose depths are known

POOL_OWNER = "edge visibility"


class Cut(NamedTuple):
    """One batch of lines in the picture.

    pieces : `layouts.PIECE` (s,), in the order of the edges
    edges : (n_edges, 2) uint32 of the batch
    colors : packed, one an edge or one a point; empty where all have one
    """

    batch: Batch
    pieces: npt.NDArray[np.void]
    edges: npt.NDArray[np.uint32]
    colors: npt.NDArray[np.uint32]


def cut(
    device: Device, drawables: Sequence[Drawable], view: View, longest: Callable[[Lines], float], *, painting: bool
) -> tuple[list[Cut], list[npt.NDArray[np.bool_]]]:
    """Return each batch of lines in the picture, and which triangles of each drawable are the nearest somewhere.

    longest : gives the pixels that a piece of lines may have along the axis that it advances most on
    painting : whether it is asked which triangles are; else none are

    Of each drawable, (n_instances, n_triangles), where it has no faces (n_instances, 0).
    """
    whole = Tile(Region((0, 0), view.size), MARGIN)
    with device.lock:
        parts = [list(in_bindings(device, drawable)) for drawable in drawables]
        projection = Projection(device, [part for own in parts for part in own])
        faces = FacePass(device, projection.shapes, math.prod(whole.depth_region.extent), numbered=painting)
        drawn = batches(device, projection.shapes)
        structs = [style_struct(batch) for batch in drawn]
        (tile,) = uniforms.upload(device, POOL_OWNER, "tile", [tile_struct(whole, view)])
        styles = uniforms.upload(device, POOL_OWNER, "styles", structs)
        with device.encode_commands(tile.buffer, *projection.buffers, *faces.buffers, label="depth prepass") as encoder:
            projection.record(encoder)
            faces.lay(encoder, tile)
        results = []
        for batch, style in zip(drawn, styles, strict=True):
            buffers = (tile, style, batch.shape.positions, batch.edges, faces.depths)
            constants = strength_constants(batch, nothing_hides=faces.is_empty) | {"longest": longest(batch.lines)}
            pieces = _pieces(device, batch, buffers, constants)
            own = _downloaded(batch.colors) if batch.colors else np.empty(0, np.uint32)
            results.append(Cut(batch, pieces, _downloaded(batch.edges).reshape(-1, 2), own))
        seen = iter(faces.seen(projection.shapes))
        return results, [np.vstack(list(islice(seen, len(own)))) for own in parts]


def _downloaded(part: Binding) -> npt.NDArray[np.uint32]:
    first = part.offset_bytes
    with part.buffer.map_read(first + part.n_bytes) as view:
        return view[first:].view(np.uint32).copy()


def _pieces(
    device: Device, batch: Batch, buffers: tuple[Buffer | Binding, ...], constants: Mapping[str, float]
) -> npt.NDArray[np.void]:
    n_edges = batch.n_edges * batch.shape.n_instances
    grid = count_workgroups(device, batch.n_edges), batch.shape.n_instances
    pipeline = device.pipelines.compute("cut_lines", workgroup_size=choose_workgroup_size(device), **constants)

    def run(counts: Buffer, pieces: Buffer, first: int | None) -> None:
        turn = np.array([first is not None, first or 0, 0, 0], np.uint32)
        bound = (*buffers, counts, pieces, *uniforms.upload(device, POOL_OWNER, "turn", [turn]))
        used = [part.buffer if isinstance(part, Binding) else part for part in bound]
        with device.encode_commands(*used, label="edge visibility") as encoder:
            dispatch(encoder, pipeline, device.bind_groups.bind(pipeline, bound), *grid)

    with contextlib.ExitStack() as stack:
        counts = Buffer(device.context, 4 * n_edges, label="edge visibility: counts")
        stack.callback(counts.release)
        nothing = Buffer(device.context, PIECE.itemsize, label="edge visibility: nothing")
        stack.callback(nothing.release)
        run(counts, nothing, None)
        with counts.map_read(4 * n_edges) as view:
            numbers = view.view(np.uint32).astype(np.int64)
        result = np.empty(int(numbers.sum()), PIECE)
        if len(result) == 0:
            return result
        counts.upload((np.cumsum(numbers) - numbers).astype(np.uint32))
        most = min(len(result), max(1, device.limits.max_bound_bytes // PIECE.itemsize))
        pieces = Buffer(device.context, PIECE.itemsize * most, label="edge visibility: pieces")
        stack.callback(pieces.release)
        for first in range(0, len(result), most):
            part = result[first : first + most]
            run(counts, pieces, first)
            with pieces.map_read(part.nbytes) as view:
                part[:] = view.view(PIECE)
        return result
