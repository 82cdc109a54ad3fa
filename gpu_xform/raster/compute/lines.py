"""Lines: anti-aliased ones by the absorbance they add to pixels, aliased ones by the nearest edge of each pixel."""

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

from ...drawing.draw_list import Lines
from ...drawing.enums import Hidden
from ...gpu import uniforms
from ...gpu.buffers import Buffer
from ...gpu.context import CommandEncoder
from ...gpu.device import Device
from ...gpu.dispatch import Binding
from .line_batches import (
    COLOR_BYTES,
    Bindings,
    LineBatch,
    choose_log2_lanes,
    dispatch_over_edges,
    make_line_bindings,
    make_line_style,
    opacity_constants,
    split_batches,
)
from .render_target import POOL_OWNER, RenderTarget
from .triangles import TriangleStage
from .vertex_stage import ProjectedDrawable

# If the sum of all edges could be more than 32 bits hold, which must be watched, coarser steps are tried first: they
# make a dense opaque model a twentieth faster. The coarsest are off by 5/255 at most, and by a hundredth of one on
# average, as two million edges were compared with the finest.
ABSORBANCE_STEPS_PER_E = (2048, 1024, 512, 256)
MIN_TRANSMITTANCE = 4e-4  # of an edge in a pixel: a fifth of what eight bits show
MAX_EDGES_FOR_PIXEL_LIST = 16384  # up to here the pixels are so few that a list of them is faster than a scan of all
MAX_NARROW_WIDTH_PX = 8.0  # in wider lines it shows if opacity goes by columns


class _Part(NamedTuple):
    """A batch, the bindings of the stages that read its edges, and the constants of its opacity."""

    batch: LineBatch
    bindings: Bindings
    constants: dict[str, float]


class LineStage:
    """The lines of one picture, in their order, drawn tile by tile of at most `extent` = (width, height) pixels."""

    def __init__(
        self,
        device: Device,
        projected: Sequence[ProjectedDrawable],
        triangles: TriangleStage,
        extent: tuple[int, int],
    ) -> None:
        self._device = device
        self._batches = split_batches(device, projected)
        structs = [make_line_style(batch) for batch in self._batches]
        self._styles = uniforms.upload(device, POOL_OWNER, "line styles", structs)
        self._constants = [opacity_constants(batch, nothing_hides=triangles.is_empty) for batch in self._batches]
        self._face_depths = triangles.face_depths
        n_pixels = extent[0] * extent[1]
        k = max((_k_buffer_depth(batch) for batch in self._batches if _has_k_buffer(batch.lines)), default=0)
        pool = device.pool
        self._per_pixel: Buffer = pool.scratch(POOL_OWNER, "absorbance or depth keys", 4 * n_pixels)
        self._touched_pixels: Buffer = pool.scratch(POOL_OWNER, "touched pixels", 4 * n_pixels + 4)
        self._k_buffer: Buffer = pool.scratch(POOL_OWNER, "k-buffer", max(4 * k * n_pixels, 4))
        self._no_colors: Buffer = pool.scratch(POOL_OWNER, "no colours", COLOR_BYTES)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        own = [self._face_depths, self._per_pixel, self._touched_pixels, self._k_buffer, self._no_colors]
        own += [part.buffer for part in self._styles]
        for batch in self._batches:
            own += [batch.projected.clip_positions, batch.edges.buffer]
            own += [batch.colors.buffer] if batch.colors else []
        return own

    def draw(self, encoder: CommandEncoder, target: RenderTarget, tile: Binding) -> None:
        """Record all lines, each over what is there."""
        for _, group in groupby(self._parts(tile), key=lambda part: id(part.batch.lines)):
            parts = list(group)
            lines = parts[0].batch.lines
            if lines.line_width is None:
                self._draw_aliased(encoder, target, parts)
            elif lines.colors is None:
                self._draw_antialiased(encoder, target, parts)
            else:
                # Depth keys name edges of one batch: nearer edges lie over farther ones of their batch, later batches
                # over earlier ones.
                for part in parts:
                    self._draw_antialiased(encoder, target, [part])

    def _parts(self, tile: Binding) -> Iterator[_Part]:
        for batch, style, constants in zip(self._batches, self._styles, self._constants, strict=True):
            yield _Part(batch, make_line_bindings(batch, tile, style, self._face_depths), constants)

    def _draw_aliased(self, encoder: CommandEncoder, target: RenderTarget, parts: Sequence[_Part]) -> None:
        for batch, bindings, opacity in parts:
            keyed: Bindings = {**bindings, "depth_keys": self._per_pixel}
            constants = {**opacity, "is_uniform_style": _is_uniform_style(batch.lines)}
            encoder.clear_buffer(self._per_pixel, target.n_bytes)
            dispatch_over_edges(self._device, encoder, "rasterize_aliased_lines", batch, keyed, 1, **constants)
            keyed["colors"] = self._colors(batch)
            constants["color_mode"] = batch.lines.color_mode
            target.composite(encoder, "composite_aliased_lines", keyed, **constants)

    def _draw_antialiased(self, encoder: CommandEncoder, target: RenderTarget, parts: Sequence[_Part]) -> None:
        """Record parts of one colour, or one part of several colours."""
        lines = parts[0].batch.lines
        n_edges = sum(part.batch.n_instance_edges for part in parts)
        steps_per_e, may_overflow = _choose_absorbance_steps(lines, n_edges)
        constants: dict[str, float] = {
            "absorbance_steps_per_e": steps_per_e,
            "is_listed": n_edges <= MAX_EDGES_FOR_PIXEL_LIST,
        }
        encoder.clear_buffer(self._per_pixel, target.n_bytes)
        encoder.clear_buffer(self._touched_pixels, 4)
        if _has_k_buffer(lines):
            encoder.clear_buffer(self._k_buffer, _k_buffer_depth(parts[0].batch) * target.n_bytes)
        for part in parts:
            self._accumulate(encoder, part, may_overflow=may_overflow, **constants)
        self._composite(encoder, target, parts[0], constants)

    def _accumulate(self, encoder: CommandEncoder, part: _Part, **constants: float) -> None:
        batch, bindings, opacity = part
        accumulated = {**bindings, **self._absorbance, "colors": self._colors(batch), "k_buffer": self._k_buffer}
        constants |= {**opacity, **_color_constants(batch), "min_transmittance": MIN_TRANSMITTANCE}
        constants["has_transparency"] = batch.lines.has_transparency
        n_lanes = 1 << choose_log2_lanes(batch)
        dispatch_over_edges(self._device, encoder, "accumulate_lines", batch, accumulated, n_lanes, **constants)

    def _composite(
        self, encoder: CommandEncoder, target: RenderTarget, part: _Part, constants: dict[str, float]
    ) -> None:
        batch, bindings, opacity = part
        composite = target.composite_listed if constants["is_listed"] else target.composite
        if _has_k_buffer(batch.lines):
            colored = {**bindings, **self._absorbance, "colors": self._colors(batch), "k_buffer": self._k_buffer}
            composite(encoder, "composite_colored_lines", colored, **constants, **opacity, **_color_constants(batch))
        else:
            uncolored = {"tile": bindings["tile"], "style": bindings["style"], **self._absorbance}
            composite(encoder, "composite_lines", uncolored, **constants)

    @property
    def _absorbance(self) -> Bindings:
        return {"absorbance": self._per_pixel, "touched_pixels": self._touched_pixels}

    def _colors(self, batch: LineBatch) -> Binding:
        return batch.colors or Binding(self._no_colors, 0, COLOR_BYTES)


def _choose_absorbance_steps(lines: Lines, n_edges: int) -> tuple[int, bool]:
    """Return how fine absorbance is, and whether so many edges through one pixel could be more than 32 bits hold."""
    coverage = min(1.0, 1.5 * (lines.line_width or 1.0))  # of a pixel, whose diagonal is 1.41
    absorbance = -math.log(max(1.0 - lines.color[3] * lines.opacity * coverage, MIN_TRANSMITTANCE))
    fitting = (steps for steps in ABSORBANCE_STEPS_PER_E if n_edges * (absorbance * steps + 1.0) < 2**32)
    steps = next(fitting, None)
    return (ABSORBANCE_STEPS_PER_E[0], True) if steps is None else (steps, False)


def _is_uniform_style(lines: Lines) -> bool:
    """Say whether every pixel that is drawn has the same colour and opacity."""
    return lines.colors is None and lines.depth_cue.amount == 0.0 and lines.hidden in {Hidden.SHOW, Hidden.REMOVE}


def _has_k_buffer(lines: Lines) -> bool:
    """Say whether lines are anti-aliased, and of several colours."""
    return lines.line_width is not None and lines.colors is not None


def _k_buffer_depth(batch: LineBatch) -> int:
    """Return how many edges a pixel tells apart: more than two hardly show if edges are many."""
    return 4 if batch.n_instance_edges <= MAX_EDGES_FOR_PIXEL_LIST else 2


def _color_constants(batch: LineBatch) -> dict[str, float]:
    """Return the `override` constants that say what colours a batch has, and how finely its opacity is sampled."""
    is_wide = (batch.lines.line_width or 1.0) > MAX_NARROW_WIDTH_PX
    return {"color_mode": batch.lines.color_mode, "k": _k_buffer_depth(batch), "is_wide": is_wide}
