"""Lines by render passes, a quad per edge: the fastest way on most GPUs."""

from collections.abc import Sequence

from ...errors import DeviceError, ShaderError
from ...gpu.context import CommandEncoder
from ...gpu.device import GpuDevice
from ...gpu.dispatch import begin_render_pass
from ...gpu.shaders import ColorWrite, RenderPipeline
from ...gpu.textures import Texture
from ..line_batches import Bindings
from ..line_stage import LinePart, LineStage, is_wide
from ..quads import draw_quads
from ..render_target import PIXEL_FORMAT, POOL_OWNER, RenderTarget

FULL_TRANSMITTANCE = (1.0, 1.0, 1.0, 1.0)


class HardwareLineStage(LineStage):
    """The lines of one picture, by a render pass per batch.

    Lines of one colour multiply what shines through them into a texture of a float per pixel, where their order does
    not matter. Other lines fill the buffers that compute shaders fill as well.
    """

    def _rasterize_aliased(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        pipeline = self._create_pipeline("draw_aliased_lines", PIXEL_FORMAT, ColorWrite.NOTHING, part, constants)
        self._draw_quads(encoder, target, pipeline, part, bindings, target.next_texture())

    def _accumulate(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        pipeline = self._create_pipeline("draw_colored_lines", PIXEL_FORMAT, ColorWrite.NOTHING, part, constants)
        self._draw_quads(encoder, target, pipeline, part, bindings, target.next_texture())

    def _draw_uncolored(self, encoder: CommandEncoder, target: RenderTarget, parts: Sequence[LinePart]) -> None:
        texture_format, write = transmittance_format(self._device), ColorWrite.MULTIPLY_BY_REST
        pipelines = [
            self._create_pipeline(
                "draw_lines", texture_format, write, part, {**part.opacity, "is_wide": is_wide(part.batch.lines)}
            )
            for part in parts
        ]
        texture = self._device.textures.scratch(POOL_OWNER, "transmittance", target.extent, texture_format)
        clear_color: tuple[float, float, float, float] | None = FULL_TRANSMITTANCE
        for part, pipeline in zip(parts, pipelines, strict=True):
            self._draw_quads(encoder, target, pipeline, part, part.bindings, texture, clear_color)
            clear_color = None
        self._composite_uncolored(encoder, target, parts, "composite_transmittance", {"transmittance": texture}, {})

    def _create_pipeline(
        self, stage: str, texture_format: str, write: ColorWrite, part: LinePart, constants: dict[str, float]
    ) -> RenderPipeline:
        is_instanced = part.batch.projected.n_instances > 1
        try:
            return self._device.pipelines.render(stage, texture_format, write, **constants, is_instanced=is_instanced)
        except ShaderError as error:
            reason = f"{self._device.name!r} cannot draw lines into a texture of {texture_format}"
            raise DeviceError(f"{reason}, which rasterizer='compute' does without: {error}") from error

    def _draw_quads(
        self,
        encoder: CommandEncoder,
        target: RenderTarget,
        pipeline: RenderPipeline,
        part: LinePart,
        bindings: Bindings,
        texture: Texture,
        clear_color: tuple[float, float, float, float] | None = None,
    ) -> None:
        group = self._device.bind_groups.bind(pipeline, **bindings)
        with begin_render_pass(encoder, texture, target.extent, pipeline, group, clear_color=clear_color) as render:
            draw_quads(self._device, POOL_OWNER, render, part.batch.n_instance_edges)


def transmittance_format(device: GpuDevice) -> str:
    """Return the format of a texture that lines multiply what shines through them into.

    Half precision, if the device cannot blend more, makes many faint lines up to 2/255 too dark on drivers that round
    towards zero.
    """
    return "r32float" if "float32-blendable" in device.features else "r16float"
