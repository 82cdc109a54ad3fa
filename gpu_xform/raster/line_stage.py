"""Lines: anti-aliased ones by the absorbance they add to pixels, aliased ones by the nearest edge of each pixel.

What is the same in all rasterisers: the order, and the stages that composite. How edges become pixels is theirs.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import NamedTuple, TypeAlias

from ..drawing.draw_list import Lines
from ..drawing.enums import Hidden
from ..gpu import uniforms
from ..gpu.buffers import Buffer
from ..gpu.context import CommandEncoder
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Bindable, Binding
from .dashes import DashStage
from .line_batches import (
    COLOR_BYTES,
    Bindings,
    LineBatch,
    make_line_bindings,
    make_line_style,
    opacity_constants,
    split_batches,
)
from .render_target import POOL_OWNER, RenderTarget
from .triangles import Hiders
from .vertex_stage import ProjectedDrawable

# If the sum of all edges could be more than 32 bits hold, which must be watched, coarser steps are tried first: they
# make a dense opaque model a twentieth faster. The coarsest are off by 5/255 at most, and by a hundredth of one on
# average, as two million edges were compared with the finest.
ABSORBANCE_STEPS_PER_E = (2048, 1024, 512, 256)
MIN_TRANSMITTANCE = 4e-4  # of an edge in a pixel: a fifth of what eight bits show
MAX_EDGES_FOR_DEEP_K_BUFFER = 16384  # of more edges, more than two per pixel hardly show
MIN_LISTED_EDGES = 1 << 14  # of fewer, all are drawn sooner than those listed that are seen
LISTED_EDGE_BYTES = 4
BLOCK_EDGES = 32  # of which an invocation lists those that are seen
MAX_NARROW_WIDTH_PX = 8.0  # in wider lines it shows if opacity goes by columns


class LinePart(NamedTuple):
    """A batch, the bindings of the stages that read its edges, and the constants of its opacity."""

    batch: LineBatch
    bindings: Bindings
    opacity: dict[str, float]


class LineStage(ABC):
    """The lines of one picture, in their order, drawn tile by tile of at most `extent` = (width, height) pixels."""

    def __init__(
        self,
        device: GpuDevice,
        projected: Sequence[ProjectedDrawable],
        hiders: Hiders,
        extent: tuple[int, int],
    ) -> None:
        self._device = device
        self._batches = split_batches(device, projected, lambda lines: not hiders.of(lines).is_empty)
        structs = [make_line_style(batch) for batch in self._batches]
        self._styles = uniforms.upload(device, POOL_OWNER, "line styles", structs)
        self._dashes = DashStage(device, self._batches, self._styles)
        stages = [hiders.of(batch.lines) for batch in self._batches]
        self._opacities = [
            opacity_constants(batch, nothing_hides=stage.is_empty, has_flats=stage.has_flats)
            for batch, stage in zip(self._batches, stages, strict=True)
        ]
        self._face_depths = [stage.face_depths for stage in stages]
        n_pixels = extent[0] * extent[1]
        k = max((_k_buffer_depth(batch) for batch in self._batches if _has_k_buffer(batch.lines)), default=0)
        pool = device.pool
        self._k_buffer: Buffer = pool.scratch(POOL_OWNER, "k-buffer", max(4 * k * n_pixels, 4))
        self._no_colors: Buffer = pool.scratch(POOL_OWNER, "no colours", COLOR_BYTES)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        own = [*self._face_depths, self._k_buffer, self._no_colors]
        own += [part.buffer for part in self._styles] + self._dashes.buffers
        for batch in self._batches:
            own += [batch.projected.clip_positions, batch.edges.buffer]
            own += [batch.colors.buffer] if batch.colors else []
        return own

    def measure_dashes(self, encoder: CommandEncoder, tile: Binding) -> None:
        """Record what all tiles need, once; `tile` may be any of them."""
        self._dashes.record(encoder, tile)

    def draw(
        self, encoder: CommandEncoder, target: RenderTarget, tile: Binding, projected: Sequence[ProjectedDrawable]
    ) -> None:
        """Record all lines of some of the drawables, each over what is there."""
        wanted = {id(each) for each in projected}
        parts_in_order = (part for part in self._parts(tile) if id(part.batch.projected) in wanted)
        for _, group in groupby(parts_in_order, key=lambda part: id(part.batch.lines)):
            parts = list(group)
            lines = parts[0].batch.lines
            if lines.line_width is not None and lines.colors is None:
                self._draw_uncolored(encoder, target, parts)
                continue
            # Depth keys name edges of one batch: nearer edges lie over farther ones of their batch, later batches over
            # earlier ones.
            draw = self._draw_aliased if lines.line_width is None else self._draw_colored
            for part in parts:
                draw(encoder, target, part)

    @abstractmethod
    def _rasterize_aliased(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        """Record what leaves the depth key of the nearest edge in each pixel."""

    @abstractmethod
    def _accumulate(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        """Record what leaves absorbance in each pixel, and, among lines of several colours, its k-buffer."""

    def _draw_aliased(self, encoder: CommandEncoder, target: RenderTarget, part: LinePart) -> None:
        batch, bindings, opacity = part
        keyed: Bindings = {**bindings, "depth_keys": target.per_pixel}
        constants = {**opacity, "is_uniform_style": _is_uniform_style(batch.lines)}
        encoder.clear_buffer(target.per_pixel, 4 * target.n_pixels)
        self._rasterize_aliased(encoder, target, part, keyed, **constants)
        keyed["colors"] = self._colors(batch)
        constants |= {"color_mode": batch.lines.color_mode, "is_instanced": batch.projected.n_instances > 1}
        target.composite_lines(encoder, "composite_aliased_lines", keyed, batch.n_instance_edges, **constants)

    def _draw_colored(self, encoder: CommandEncoder, target: RenderTarget, part: LinePart) -> None:
        batch = part.batch
        constants = self._accumulate_parts(encoder, target, [part])
        bindings = {**part.bindings, **self._absorbance(target, batch)}
        constants |= {**part.opacity, **_color_constants(batch), "is_instanced": batch.projected.n_instances > 1}
        target.composite_lines(encoder, "composite_colored_lines", bindings, batch.n_instance_edges, **constants)

    def _draw_uncolored(self, encoder: CommandEncoder, target: RenderTarget, parts: Sequence[LinePart]) -> None:
        constants = self._accumulate_parts(encoder, target, parts)
        self._composite_uncolored(
            encoder, target, parts, "composite_lines", {"absorbance": target.per_pixel}, constants
        )

    def _accumulate_parts(
        self, encoder: CommandEncoder, target: RenderTarget, parts: Sequence[LinePart]
    ) -> dict[str, float]:
        """Record the absorbance of parts that look the same; return the constants that say how it is counted."""
        lines = parts[0].batch.lines
        n_edges = sum(part.batch.n_instance_edges for part in parts)
        steps_per_e, may_overflow = _choose_absorbance_steps(lines, n_edges)
        encoder.clear_buffer(target.per_pixel, 4 * target.n_pixels)
        if _has_k_buffer(lines):
            encoder.clear_buffer(self._k_buffer, 4 * _k_buffer_depth(parts[0].batch) * target.n_pixels)
        for part in parts:
            constants = {
                **part.opacity,
                **_color_constants(part.batch),
                "has_transparency": lines.has_transparency,
                "absorbance_steps_per_e": steps_per_e,
                "min_transmittance": MIN_TRANSMITTANCE,
                "may_overflow": may_overflow,
            }
            bindings = {**part.bindings, **self._absorbance(target, part.batch)}
            self._accumulate(encoder, target, part, bindings, **constants)
        return {"absorbance_steps_per_e": steps_per_e}

    def _composite_uncolored(
        self,
        encoder: CommandEncoder,
        target: RenderTarget,
        parts: Sequence[LinePart],
        stage: str,
        own: Mapping[str, Bindable],
        constants: dict[str, float],
    ) -> None:
        """Record a stage that composites parts of one colour; `own` are its bindings beside those of edges."""
        batch, bindings, _ = parts[0]
        bound: dict[str, Bindable] = {name: bindings[name] for name in ("tile", "style", "clip_positions", "edges")}
        is_instanced = batch.projected.n_instances > 1
        # The edges of the first part alone are bound: quads can cover them if there is no other.
        n_edges = batch.n_instance_edges if len(parts) == 1 else None
        target.composite_lines(encoder, stage, {**bound, **own}, n_edges, is_instanced=is_instanced, **constants)

    def _absorbance(self, target: RenderTarget, batch: LineBatch) -> Bindings:
        return {"absorbance": target.per_pixel, "k_buffer": self._k_buffer, "colors": self._colors(batch)}

    def _colors(self, batch: LineBatch) -> Binding:
        return batch.colors or Binding(self._no_colors, 0, COLOR_BYTES)

    def _parts(self, tile: Binding) -> Iterator[LinePart]:
        per_batch = zip(
            self._batches, self._styles, self._opacities, self._face_depths, self._dashes.starts, strict=True
        )
        for batch, style, opacity, face_depths, dash_starts in per_batch:
            yield LinePart(batch, make_line_bindings(batch, tile, style, face_depths, dash_starts), opacity)


def _choose_absorbance_steps(lines: Lines, n_edges: int) -> tuple[int, bool]:
    """Return how fine absorbance is, and whether so many edges through one pixel could be more than 32 bits hold."""
    coverage = min(1.0, 1.5 * (lines.line_width or 1.0))  # of a pixel, whose diagonal is 1.41
    absorbance = -math.log(max(1.0 - lines.color[3] * lines.opacity * coverage, MIN_TRANSMITTANCE))
    fitting = (steps for steps in ABSORBANCE_STEPS_PER_E if n_edges * (absorbance * steps + 1.0) < 2**32)
    steps = next(fitting, None)
    return (ABSORBANCE_STEPS_PER_E[0], True) if steps is None else (steps, False)


def _is_uniform_style(lines: Lines) -> bool:
    """Say whether every pixel that is drawn has the same colour and opacity."""
    is_whole = not lines.dash_px and lines.hidden not in {Hidden.DASH, Hidden.FADE}
    return lines.colors is None and lines.depth_cue.amount == 0.0 and is_whole


def _has_k_buffer(lines: Lines) -> bool:
    """Say whether lines are anti-aliased, and of several colours."""
    return lines.line_width is not None and lines.colors is not None


def _k_buffer_depth(batch: LineBatch) -> int:
    """Return how many edges a pixel tells apart."""
    return 4 if batch.n_instance_edges <= MAX_EDGES_FOR_DEEP_K_BUFFER else 2


LineStageFactory: TypeAlias = Callable[[GpuDevice, Sequence[ProjectedDrawable], Hiders, tuple[int, int]], LineStage]


def is_wide(lines: Lines) -> bool:
    """Say whether lines are so wide that opacity is asked for each pixel across them."""
    return (lines.line_width or 1.0) > MAX_NARROW_WIDTH_PX


def _color_constants(batch: LineBatch) -> dict[str, float]:
    """Return the `override` constants that say what colours a batch has, and how finely its opacity is sampled."""
    return {"color_mode": batch.lines.color_mode, "k": _k_buffer_depth(batch), "is_wide": is_wide(batch.lines)}
