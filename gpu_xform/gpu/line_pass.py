"""Edges to pixels, in one of three ways: ink, marks, or quads."""

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import wgpu

from . import uniforms
from .buffers import Buffer
from .compute import Binding, bind
from .device import Device
from .face_pass import FacePass
from .frame import Projected
from .line_batches import COLOR_BYTES, Batch, Bindings, batches, over_edges, strength_constants, style_struct
from .shapes import Hidden, Lines
from .targets import FORMAT, Target

# Ink is counted in steps for a factor of e. Where the sum of all edges could be more than 32 bits hold, which must be
# watched, coarser steps are tried first: they make a dense opaque model a twentieth faster, and the coarsest are off by
# 5/255 at most, and a hundredth of one on average, where two million edges were compared with the finest.
INK_STEPS = (2048, 1024, 512, 256)
LEAST_LIGHT = 4e-4  # that an edge lets through, for ink: a fifth of what eight bits show
HIDDEN_PARTS, VISIBLE_PARTS = 1, 2  # as in strength.wgsl
WIDEST_INK = 8.0  # pixels; an invocation lays an edge's ink alone, so that wide lines are better off as quads


class _Part(NamedTuple):
    """A batch; where it, its style and the depths are bound; what its shaders are compiled for."""

    batch: Batch
    bindings: Bindings
    constants: dict[str, float]


class LinePass:
    """The lines of one picture, in their order, drawn tile by tile of at most `extent` = (width, height) pixels."""

    def __init__(self, device: Device, shapes: Sequence[Projected], faces: FacePass, extent: tuple[int, int]) -> None:
        self._device = device
        self._batches = batches(device, shapes)
        self._styles = uniforms.upload(device, "styles", [style_struct(batch) for batch in self._batches])
        self._constants = [strength_constants(batch, nothing_hides=faces.is_empty) for batch in self._batches]
        self._depths = faces.depths
        on_pixels = any(not _is_quads(batch.lines) for batch in self._batches)
        self._ink: Buffer = device.pool.get("ink", 4 * extent[0] * extent[1] if on_pixels else 4)
        self._no_colors: Buffer = device.pool.get("no colours", COLOR_BYTES)

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

    def draw(self, encoder: wgpu.GPUCommandEncoder, target: Target, tile: Binding) -> None:
        """Record all lines, each over what is there."""
        for _, alike in groupby(self._parts(tile), key=lambda part: id(part.batch.lines)):
            parts = list(alike)
            lines = parts[0].batch.lines
            if _is_quads(lines):
                self._draw_quads(encoder, target, parts)
            elif lines.line_width is None:
                self._draw_thin(encoder, target, parts)
            else:
                self._draw_ink(encoder, target, parts)

    def _parts(self, tile: Binding) -> list[_Part]:
        return [
            _Part(batch, {0: tile, 1: style, 2: batch.shape.positions, 3: batch.edges, 4: self._depths}, constants)
            for batch, style, constants in zip(self._batches, self._styles, self._constants, strict=True)
        ]

    def _draw_ink(self, encoder: wgpu.GPUCommandEncoder, target: Target, parts: Sequence[_Part]) -> None:
        n_edges = sum(batch.n_edges * batch.shape.n_instances for batch, _, _ in parts)
        ink_steps, may_overflow = _ink_steps(parts[0].batch.lines, n_edges)
        ink = {"ink_steps": ink_steps, "least_light": LEAST_LIGHT}
        encoder.clear_buffer(self._ink.handle, 0, target.n_bytes)
        for batch, bindings, constants in parts:
            looks = {**constants, **ink, "may_overflow": may_overflow}
            over_edges(encoder, "ink_lines", batch, bindings | {5: self._ink}, **looks)
        tile, style = parts[0].bindings[0], parts[0].bindings[1]
        target.blend(encoder, "blend_ink", {0: tile, 1: style, 5: self._ink}, **ink)

    def _draw_thin(self, encoder: wgpu.GPUCommandEncoder, target: Target, parts: Sequence[_Part]) -> None:
        for batch, bindings, constants in _in_turns(parts):
            marked = bindings | {5: self._ink}
            looks = {**constants, "is_plain": _is_plain(batch.lines)}
            encoder.clear_buffer(self._ink.handle, 0, target.n_bytes)
            over_edges(encoder, "mark_thin_lines", batch, marked, **looks)
            colored = {**looks, "color_mode": batch.lines.color_mode}
            target.blend(encoder, "blend_thin_lines", marked | {6: self._colors(batch)}, **colored)

    def _draw_quads(
        self,
        encoder: wgpu.GPUCommandEncoder,
        target: Target,
        parts: Sequence[_Part],
    ) -> None:
        with target.apart(encoder) as render:
            for batch, bindings, constants in _in_turns(parts):
                looks = {**constants, "color_mode": batch.lines.color_mode}
                pipeline = self._device.pipelines.render("draw_lines", "triangle-strip", FORMAT, **looks)
                render.set_pipeline(pipeline)
                render.set_bind_group(0, bind(self._device, pipeline, bindings | {6: self._colors(batch)}))
                render.draw(4, batch.n_edges * batch.shape.n_instances)

    def _colors(self, batch: Batch) -> Binding:
        return batch.colors or Binding(self._no_colors, 0, COLOR_BYTES)


def _in_turns(parts: Sequence[_Part]) -> Iterator[_Part]:
    """Yield the parts; where hidden lines show in colours of their own, all hidden ones before all visible ones."""
    lines = parts[0].batch.lines
    if lines.colors is None or lines.hidden not in {Hidden.DASHED, Hidden.FADED}:
        yield from parts
        return
    for drawn in (HIDDEN_PARTS, VISIBLE_PARTS):
        yield from (part._replace(constants=part.constants | {"drawn": drawn}) for part in parts)


def _ink_steps(lines: Lines, n_edges: int) -> tuple[int, bool]:
    """Return how fine ink is, and whether so many edges through one pixel could be more than 32 bits hold."""
    covered = min(1.0, 1.5 * (lines.line_width or 1.0))  # of a pixel, whose diagonal is 1.41
    most = -math.log(max(1.0 - lines.color[3] * lines.strength * covered, LEAST_LIGHT))
    fitting = (steps for steps in INK_STEPS if n_edges * (most * steps + 1.0) < 2**32)
    steps = next(fitting, None)
    return (INK_STEPS[0], True) if steps is None else (steps, False)


def _is_plain(lines: Lines) -> bool:
    """Say whether every pixel that is drawn has the same colour and strength."""
    return lines.colors is None and lines.cue[3] == 0.0 and lines.hidden in {Hidden.SHOWN, Hidden.REMOVED}


def _is_quads(lines: Lines) -> bool:
    return lines.line_width is not None and (lines.line_width > WIDEST_INK or lines.colors is not None)
