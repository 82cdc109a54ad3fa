"""Lines by render passes, a quad per edge: the fastest way on most GPUs."""

from collections.abc import Sequence
from typing import NamedTuple

from ...gpu.context import CommandEncoder
from ...gpu.device import Device
from ...gpu.dispatch import begin_render_pass
from ...gpu.shaders import ColorWrite
from ...gpu.textures import Texture
from ..line_batches import Bindings
from ..line_stage import LinePart, LineStage, is_wide
from ..quads import draw_quads
from ..render_target import POOL_OWNER, RenderTarget

FULL_TRANSMITTANCE = (1.0, 1.0, 1.0, 1.0)


class _Attachment(NamedTuple):
    """What a pass draws into."""

    texture: Texture
    write: ColorWrite
    clear_color: tuple[float, float, float, float] | None = None


class HardwareLineStage(LineStage):
    """The lines of one picture, by a render pass per batch.

    Lines of one colour multiply what shines through them into a texture of a float per pixel, where their order does
    not matter. Other lines fill the buffers that compute shaders fill as well.
    """

    def _rasterize_aliased(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        attachment = _Attachment(target.next_texture(), ColorWrite.NOTHING)
        self._draw_quads(encoder, target, "draw_aliased_lines", part, bindings, attachment, **constants)

    def _accumulate(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        attachment = _Attachment(target.next_texture(), ColorWrite.NOTHING)
        self._draw_quads(encoder, target, "draw_colored_lines", part, bindings, attachment, **constants)

    def _draw_uncolored(self, encoder: CommandEncoder, target: RenderTarget, parts: Sequence[LinePart]) -> None:
        texture_format = transmittance_format(self._device)
        texture = self._device.textures.scratch(POOL_OWNER, "transmittance", target.extent, texture_format)
        for number, part in enumerate(parts):
            clear_color = FULL_TRANSMITTANCE if number == 0 else None
            attachment = _Attachment(texture, ColorWrite.MULTIPLY_BY_REST, clear_color)
            constants = {**part.opacity, "is_wide": is_wide(part.batch.lines)}
            self._draw_quads(encoder, target, "draw_lines", part, part.bindings, attachment, **constants)
        self._composite_uncolored(encoder, target, parts, "composite_transmittance", {"transmittance": texture}, {})

    def _draw_quads(
        self,
        encoder: CommandEncoder,
        target: RenderTarget,
        stage: str,
        part: LinePart,
        bindings: Bindings,
        attachment: _Attachment,
        **constants: float,
    ) -> None:
        batch = part.batch
        constants["is_instanced"] = batch.projected.n_instances > 1
        texture, write, clear_color = attachment
        pipeline = self._device.pipelines.render(stage, texture.format, write, **constants)
        group = self._device.bind_groups.bind(pipeline, **bindings)
        with begin_render_pass(encoder, texture, target.extent, pipeline, group, clear_color=clear_color) as render:
            draw_quads(self._device, POOL_OWNER, render, batch.n_instance_edges)


def transmittance_format(device: Device) -> str:
    """Return the format of a texture that lines multiply what shines through them into.

    Half precision, if the device cannot blend more, makes many faint lines up to 2/255 too dark on drivers that round
    towards zero.
    """
    return "r32float" if "float32-blendable" in device.features else "r16float"
