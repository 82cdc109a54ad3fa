"""Lines by render passes, a quad per edge: the fastest way on most GPUs."""

import contextlib
from collections.abc import Sequence
from typing import TypeAlias

from ...errors import DeviceError, ShaderError
from ...gpu.buffers import Buffer
from ...gpu.context import CommandEncoder
from ...gpu.device import GpuDevice
from ...gpu.dispatch import RenderPass, begin_render_pass
from ...gpu.shaders import ColorWrite, RenderPipeline
from ...gpu.textures import Texture
from ..line_batches import Bindings
from ..line_stage import LinePart, LineStage, is_wide
from ..quads import draw_listed_quads, draw_quads
from ..render_target import PIXEL_FORMAT, POOL_OWNER, RenderTarget
from ..triangles import Hiders
from ..vertex_stage import ProjectedDrawable
from .edge_lists import LISTS, EdgeLists, is_listable

ClearColor: TypeAlias = tuple[float, float, float, float]

FULL_TRANSMITTANCE: ClearColor = (1.0, 1.0, 1.0, 1.0)


class HardwareLineStage(LineStage):
    """The lines of one picture, by a render pass per batch.

    Lines of one colour multiply what shines through them into a texture of a float per pixel, where their order does
    not matter. Other lines fill the buffers that compute shaders fill as well.
    """

    def __init__(
        self,
        device: GpuDevice,
        projected: Sequence[ProjectedDrawable],
        hiders: Hiders,
        extent: tuple[int, int],
    ) -> None:
        super().__init__(device, projected, hiders, extent)
        self._lists = EdgeLists(device, self._batches, self._opacities)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        return [*super().buffers, *self._lists.buffers]

    def _rasterize_aliased(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        pipeline = self._create_pipeline("draw_aliased_lines", PIXEL_FORMAT, ColorWrite.NOTHING, part, constants)
        with self._begin(encoder, target, pipeline, bindings, target.next_texture()) as render:
            draw_quads(self._device, POOL_OWNER, render, part.batch.n_instance_edges)

    def _accumulate(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        pipelines = self._create_pipelines("draw_colored_lines", PIXEL_FORMAT, ColorWrite.NOTHING, part, constants)
        self._draw_visible(encoder, target, pipelines, part, bindings, target.next_texture())

    def _draw_uncolored(self, encoder: CommandEncoder, target: RenderTarget, parts: Sequence[LinePart]) -> None:
        texture_format, write = transmittance_format(self._device), ColorWrite.MULTIPLY_BY_REST
        pipelines = [
            self._create_pipelines(
                "draw_lines", texture_format, write, part, {**part.opacity, "is_wide": is_wide(part.batch.lines)}
            )
            for part in parts
        ]
        texture = self._device.textures.scratch(POOL_OWNER, "transmittance", target.extent, texture_format)
        clear_color: ClearColor | None = FULL_TRANSMITTANCE
        for part, own in zip(parts, pipelines, strict=True):
            self._draw_visible(encoder, target, own, part, part.bindings, texture, clear_color)
            clear_color = None
        self._composite_uncolored(encoder, target, parts, "composite_transmittance", {"transmittance": texture}, {})

    def _create_pipelines(
        self, stage: str, texture_format: str, write: ColorWrite, part: LinePart, constants: dict[str, float]
    ) -> list[RenderPipeline]:
        """Return a pipeline for the edges of each list, or, if there is none, one for all."""
        is_listed = is_listable(self._device, part.batch, part.opacity)
        return [
            self._create_pipeline(
                stage, texture_format, write, part, {**constants, "hidden": hidden, "is_listed": is_listed}
            )
            for hidden in (LISTS if is_listed else (part.opacity["hidden"],))
        ]

    def _draw_visible(
        self,
        encoder: CommandEncoder,
        target: RenderTarget,
        pipelines: Sequence[RenderPipeline],
        part: LinePart,
        bindings: Bindings,
        texture: Texture,
        clear_color: ClearColor | None = None,
    ) -> None:
        """Record quads over all edges of a part, or, if faces hide many, over those of which some may be seen."""
        lists = self._lists
        is_listed = is_listable(self._device, part.batch, part.opacity)
        if is_listed:
            lists.record(encoder, part)
        for index, pipeline in enumerate(pipelines):
            own: Bindings = {**bindings, "edge_list": lists.edges}
            with self._begin(encoder, target, pipeline, own, texture, clear_color) as render:
                if is_listed:
                    offsets = lists.draw_offsets(part.batch, index)
                    draw_listed_quads(self._device, POOL_OWNER, render, lists.draws, offsets)
                else:
                    draw_quads(self._device, POOL_OWNER, render, part.batch.n_instance_edges)
            clear_color = None

    def _create_pipeline(
        self, stage: str, texture_format: str, write: ColorWrite, part: LinePart, constants: dict[str, float]
    ) -> RenderPipeline:
        is_instanced = part.batch.projected.n_instances > 1
        try:
            return self._device.pipelines.render(stage, texture_format, write, **constants, is_instanced=is_instanced)
        except ShaderError as error:
            reason = f"{self._device.name!r} cannot draw lines into a texture of {texture_format}"
            raise DeviceError(f"{reason}, which rasterizer='compute' does without: {error}") from error

    def _begin(
        self,
        encoder: CommandEncoder,
        target: RenderTarget,
        pipeline: RenderPipeline,
        bindings: Bindings,
        texture: Texture,
        clear_color: ClearColor | None = None,
    ) -> contextlib.AbstractContextManager[RenderPass]:
        group = self._device.bind_groups.bind(pipeline, **bindings)
        return begin_render_pass(encoder, texture, target.extent, pipeline, group, clear_color=clear_color)


def transmittance_format(device: GpuDevice) -> str:
    """Return the format of a texture that lines multiply what shines through them into.

    Half precision, if the device cannot blend more, makes many faint lines up to 2/255 too dark on drivers that round
    towards zero.
    """
    return "r32float" if "float32-blendable" in device.features else "r16float"
