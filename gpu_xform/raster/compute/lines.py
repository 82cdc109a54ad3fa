"""Edges to pixels: ink where they are anti-aliased, marks where each pixel is on or off."""

import math
from collections.abc import Sequence
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
    Batch,
    Bindings,
    batches,
    log2_lanes,
    over_edges,
    strength_constants,
    style_struct,
)
from .render_target import POOL_OWNER, Target
from .triangles import FacePass
from .vertex_stage import Projected

# Ink is counted in steps for a factor of e. Where the sum of all edges could be more than 32 bits hold, which must be
# watched, coarser steps are tried first: they make a dense opaque model a twentieth faster, and the coarsest are off by
# 5/255 at most, and a hundredth of one on average, where two million edges were compared with the finest.
INK_STEPS = (2048, 1024, 512, 256)
LEAST_LIGHT = 4e-4  # that an edge lets through, for ink: a fifth of what eight bits show
MOST_LISTED = 16384  # edges whose pixels are so few that a list of them is gone through faster than all
NARROW = 8.0  # pixels; in wider lines it shows what is told by steps along them


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
        self._styles = uniforms.upload(device, POOL_OWNER, "styles", [style_struct(batch) for batch in self._batches])
        self._constants = [strength_constants(batch, nothing_hides=faces.is_empty) for batch in self._batches]
        self._depths = faces.depths
        n_pixels = extent[0] * extent[1]
        self._ink: Buffer = device.pool.scratch(POOL_OWNER, "ink", 4 * n_pixels)
        n_keys = max((_n_keys(batch) for batch in self._batches if _is_colored(batch.lines)), default=0)
        self._inked: Buffer = device.pool.scratch(POOL_OWNER, "inked pixels", 4 * n_pixels + 4)
        self._nearest: Buffer = device.pool.scratch(POOL_OWNER, "nearest edges", max(4 * n_keys * n_pixels, 4))
        self._no_colors: Buffer = device.pool.scratch(POOL_OWNER, "no colours", COLOR_BYTES)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these passes uses."""
        own = [
            self._depths,
            self._ink,
            self._inked,
            self._nearest,
            self._no_colors,
            *(part.buffer for part in self._styles),
        ]
        for batch in self._batches:
            own += [batch.shape.positions, batch.edges.buffer, *([batch.colors.buffer] if batch.colors else [])]
        return own

    def draw(self, encoder: CommandEncoder, target: Target, tile: Binding) -> None:
        """Record all lines, each over what is there."""
        for _, alike in groupby(self._parts(tile), key=lambda part: id(part.batch.lines)):
            parts = list(alike)
            lines = parts[0].batch.lines
            if lines.line_width is None:
                self._draw_thin(encoder, target, parts)
            elif lines.colors is None:
                self._draw_ink(encoder, target, parts)
            else:
                self._draw_colored(encoder, target, parts)

    def _parts(self, tile: Binding) -> list[_Part]:
        return [
            _Part(batch, self._inputs(tile, style, batch), constants)
            for batch, style, constants in zip(self._batches, self._styles, self._constants, strict=True)
        ]

    def _inputs(self, tile: Binding, style: Binding, batch: Batch) -> Bindings:
        return {
            "tile": tile,
            "style": style,
            "projected": batch.shape.positions,
            "edges": batch.edges,
            "face_depths": self._depths,
        }

    def _draw_ink(self, encoder: CommandEncoder, target: Target, parts: Sequence[_Part]) -> None:
        n_edges = sum(batch.n_edges * batch.shape.n_instances for batch, _, _ in parts)
        looks = self._begin_ink(encoder, target, parts[0].batch.lines, n_edges)
        inked: Bindings = {"ink": self._ink, "inked": self._inked}
        for batch, bindings, constants in parts:
            self._go_along(encoder, "accumulate_lines", batch, bindings | inked, {**constants, **looks})
        inked |= {name: parts[0].bindings[name] for name in ("tile", "style")}
        self._end_ink(encoder, target, "composite_lines", inked, looks)

    def _draw_thin(self, encoder: CommandEncoder, target: Target, parts: Sequence[_Part]) -> None:
        for batch, bindings, constants in parts:
            marked = bindings | {"marks": self._ink}
            looks = {**constants, "is_plain": _is_plain(batch.lines)}
            encoder.clear_buffer(self._ink, target.n_bytes)
            over_edges(self._device, encoder, "rasterize_aliased_lines", batch, marked, 1, **looks)
            colored = {**looks, "color_mode": batch.lines.color_mode}
            target.blend(encoder, "composite_aliased_lines", marked | {"colors": self._colors(batch)}, **colored)

    def _draw_colored(self, encoder: CommandEncoder, target: Target, parts: Sequence[_Part]) -> None:
        # Keys name edges of one batch: nearer ones lie over farther ones in each, later batches over earlier ones.
        for batch, bindings, constants in parts:
            lines = batch.lines
            looks = self._begin_ink(encoder, target, lines, batch.n_edges * batch.shape.n_instances)
            looks |= constants | {"color_mode": lines.color_mode, "is_wide": _is_wide(lines), "n_keys": _n_keys(batch)}
            inked = bindings | {
                "ink": self._ink,
                "inked": self._inked,
                "nearest": self._nearest,
                "colors": self._colors(batch),
            }
            encoder.clear_buffer(self._nearest, _n_keys(batch) * target.n_bytes)
            self._go_along(
                encoder, "accumulate_colored_lines", batch, inked, looks | {"is_clear": lines.has_transparency}
            )
            self._end_ink(encoder, target, "composite_colored_lines", inked, looks)

    def _begin_ink(self, encoder: CommandEncoder, target: Target, lines: Lines, n_edges: int) -> dict[str, float]:
        """Record that there is no ink, and return what the shaders are compiled for that lay it and blend it."""
        encoder.clear_buffer(self._ink, target.n_bytes)
        encoder.clear_buffer(self._inked, 4)
        ink_steps, may_overflow = _ink_steps(lines, n_edges)
        return {"ink_steps": ink_steps, "may_overflow": may_overflow, "is_listed": n_edges <= MOST_LISTED}

    @staticmethod
    def _end_ink(
        encoder: CommandEncoder, target: Target, stage: str, bindings: Bindings, looks: dict[str, float]
    ) -> None:
        """Record what blends the ink into the picture."""
        own = {name: value for name, value in looks.items() if name != "may_overflow"}
        blend = target.blend_listed if looks["is_listed"] else target.blend
        blend(encoder, stage, bindings, **own)

    def _go_along(
        self,
        encoder: CommandEncoder,
        stage: str,
        batch: Batch,
        bindings: Bindings,
        looks: dict[str, float],
    ) -> None:
        """Record a stage that lays ink."""
        n_lanes = 1 << log2_lanes(batch)
        own = {"least_light": LEAST_LIGHT, "is_wide": _is_wide(batch.lines)}
        over_edges(self._device, encoder, stage, batch, bindings, n_lanes, **looks | own)

    def _colors(self, batch: Batch) -> Binding:
        return batch.colors or Binding(self._no_colors, 0, COLOR_BYTES)


def _ink_steps(lines: Lines, n_edges: int) -> tuple[int, bool]:
    """Return how fine ink is, and whether so many edges through one pixel could be more than 32 bits hold."""
    covered = min(1.0, 1.5 * (lines.line_width or 1.0))  # of a pixel, whose diagonal is 1.41
    most = -math.log(max(1.0 - lines.color[3] * lines.opacity * covered, LEAST_LIGHT))
    fitting = (steps for steps in INK_STEPS if n_edges * (most * steps + 1.0) < 2**32)
    steps = next(fitting, None)
    return (INK_STEPS[0], True) if steps is None else (steps, False)


def _is_plain(lines: Lines) -> bool:
    """Say whether every pixel that is drawn has the same colour and strength."""
    return lines.colors is None and lines.depth_cue.amount == 0.0 and lines.hidden in {Hidden.SHOW, Hidden.REMOVE}


def _is_colored(lines: Lines) -> bool:
    """Say whether lines are anti-aliased, and of several colours."""
    return lines.line_width is not None and lines.colors is not None


def _n_keys(batch: Batch) -> int:
    """Return how many edges a pixel tells apart: more than two hardly show where edges are many."""
    return 4 if batch.n_edges * batch.shape.n_instances <= MOST_LISTED else 2


def _is_wide(lines: Lines) -> bool:
    return (lines.line_width or 1.0) > NARROW
