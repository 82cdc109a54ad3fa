"""Edges to pixels, in one of three ways: ink, marks, or quads."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import wgpu

from . import layouts, uniforms
from .buffers import Buffer
from .compute import Binding, bind, dispatch
from .device import Device
from .face_pass import FacePass
from .frame import Projected, binding_bytes
from .plans import n_workgroups, workgroup_size
from .shapes import ColorMode, Hidden, Lines
from .targets import FORMAT, Target

EDGE_BYTES = 8
COLOR_BYTES = 4
WIDEST_INK = 8.0  # pixels; an invocation lays an edge's ink alone, so that wide lines are better off as quads
GROUP = 64  # edges whose bindings begin where any adapter lets them


@dataclass(frozen=True)
class Batch:
    """Lines whose edges, and whose colours where each has its own, are what one binding holds."""

    shape: Projected
    lines: Lines
    first: int
    n_edges: int
    edges: Binding
    colors: Binding | None


_Part: TypeAlias = tuple[Batch, Binding]
_Bindings: TypeAlias = dict[int, Buffer | Binding]


def batches(device: Device, shapes: Sequence[Projected]) -> list[Batch]:
    """Return what is drawn, in order."""
    return [batch for shape in shapes for lines in shape.shape.lines for batch in _cut(device, shape, lines)]


def _cut(device: Device, shape: Projected, lines: Lines) -> Iterator[Batch]:
    most = max(binding_bytes(device) // EDGE_BYTES // GROUP, 1) * GROUP
    for start in range(0, lines.n_edges, most):
        n_edges = min(most, lines.n_edges - start)
        colors = None
        if lines.colors is not None:
            colors = Binding(lines.colors, 0, lines.colors.n_bytes)
            if lines.color_mode is ColorMode.AN_EDGE:
                colors = Binding(lines.colors, start * COLOR_BYTES, n_edges * COLOR_BYTES)
        edges = Binding(lines.edges, start * EDGE_BYTES, n_edges * EDGE_BYTES)
        yield Batch(shape, lines, start, n_edges, edges, colors)


def style_struct(batch: Batch, *, nothing_hides: bool) -> npt.NDArray[np.void]:
    """Return the WGSL struct of a batch."""
    lines = batch.lines
    struct = np.zeros((), layouts.STYLE)
    struct["cue"] = lines.cue
    struct["color"] = lines.color
    struct["line_width"] = 1.0 if lines.line_width is None else lines.line_width
    struct["strength"] = lines.strength
    struct["color_mode"] = lines.color_mode
    struct["hidden"] = Hidden.SHOWN if nothing_hides else lines.hidden
    struct["n_edges"] = batch.n_edges
    struct["n_points"] = batch.shape.stride
    return struct


class LinePass:
    """The lines of one picture, drawn tile by tile in their order."""

    def __init__(self, device: Device, shapes: Sequence[Projected], faces: FacePass, n_pixels: int) -> None:
        self._device = device
        self._batches = batches(device, shapes)
        styles = [style_struct(batch, nothing_hides=faces.is_empty) for batch in self._batches]
        self._styles = uniforms.upload(device, "styles", styles)
        self._depths = faces.depths
        on_pixels = any(not _is_quads(batch.lines) for batch in self._batches)
        self._ink: Buffer = device.pool.get("ink", 4 * n_pixels if on_pixels else 4)
        self._no_colors: Buffer = device.pool.get("no colours", 4)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these passes uses."""
        own = [self._depths, self._ink, self._no_colors, *(part.buffer for part in self._styles)]
        for batch in self._batches:
            own += [batch.shape.positions, batch.edges.buffer, *([batch.colors.buffer] if batch.colors else [])]
        return own

    @property
    def needs_texture(self) -> bool:
        """Whether anything is drawn as quads."""
        return any(_is_quads(batch.lines) for batch in self._batches)

    def draw(self, encoder: wgpu.GPUCommandEncoder, target: Target, tile: Binding, extent: tuple[int, int]) -> None:
        """Record all lines, each over what is there."""
        for _, alike in groupby(zip(self._batches, self._styles, strict=True), key=lambda part: id(part[0].lines)):
            parts = list(alike)
            lines = parts[0][0].lines
            if _is_quads(lines):
                self._draw_quads(encoder, target, tile, extent, parts)
            elif lines.line_width is None:
                self._draw_thin(encoder, target, tile, extent, parts)
            else:
                encoder.clear_buffer(self._ink.handle)
                for batch, style in parts:
                    self._lay(encoder, "ink_lines", self._bindings(tile, batch, style), batch)
                target.blend(encoder, "blend_ink", {0: tile, 1: parts[0][1], 5: self._ink}, extent)

    def _draw_quads(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        tile: Binding,
        extent: tuple[int, int],
        parts: list[_Part],
    ) -> None:
        pipeline = self._device.pipelines.render("draw_lines", "triangle-strip", FORMAT)
        with target.apart(encoder, tile, extent) as render:
            render.set_pipeline(pipeline)
            for batch, style in parts:
                bound = bind(self._device, pipeline, self._bindings(tile, batch, style) | {6: self._colors(batch)})
                render.set_bind_group(0, bound)
                render.draw(4, batch.n_edges * batch.shape.n_instances)

    def _draw_thin(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        tile: Binding,
        extent: tuple[int, int],
        parts: list[_Part],
    ) -> None:
        for batch, style in parts:
            is_plain = _is_plain(batch.lines)
            bindings = self._bindings(tile, batch, style)
            encoder.clear_buffer(self._ink.handle)
            self._lay(encoder, "mark_thin_lines", bindings, batch, is_plain=is_plain)
            marked = bindings | {5: self._ink, 6: self._colors(batch)}
            target.blend(encoder, "blend_thin_lines", marked, extent, is_plain=is_plain)

    def _bindings(self, tile: Binding, batch: Batch, style: Binding) -> _Bindings:
        return {0: tile, 1: style, 2: batch.shape.positions, 3: batch.edges, 4: self._depths}

    def _colors(self, batch: Batch) -> Binding:
        return batch.colors or Binding(self._no_colors, 0, COLOR_BYTES)

    def _lay(
        self,
        encoder: wgpu.GPUCommandEncoder,
        stage: str,
        bindings: _Bindings,
        batch: Batch,
        **constants: float,
    ) -> None:
        pipeline = self._device.pipelines.compute(stage, workgroup_size=workgroup_size(self._device), **constants)
        bound = bind(self._device, pipeline, bindings | {5: self._ink})
        dispatch(encoder, pipeline, bound, n_workgroups(self._device, batch.n_edges), batch.shape.n_instances)


def _is_plain(lines: Lines) -> bool:
    """Say whether every pixel that is drawn has the same colour and strength."""
    return lines.colors is None and lines.cue[3] == 0.0 and lines.hidden in {Hidden.SHOWN, Hidden.REMOVED}


def _is_quads(lines: Lines) -> bool:
    return lines.line_width is not None and (lines.line_width > WIDEST_INK or lines.colors is not None)
