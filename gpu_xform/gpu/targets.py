"""The picture of a tile on its device, and what is drawn apart before it goes over the picture."""

import contextlib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import wgpu

from .buffers import Buffer
from .compute import Binding, bind, dispatch
from .faults import device_errors
from .plans import n_workgroups, workgroup_size

if TYPE_CHECKING:
    from .device import Device

PIXELS_PER_INVOCATION = 64
FORMAT = "rgba8unorm"  # not -srgb: colours mix as the bytes of the file do, like other plotting programs' lines


class Target:
    """The premultiplied picture of one tile after another, each of at most `extent` = (width, height) pixels."""

    def __init__(self, device: "Device", extent: tuple[int, int], *, apart: bool) -> None:
        self._device = device
        self.pixels: Buffer = device.pool.get("picture", 4 * extent[0] * extent[1])
        self._texture: wgpu.GPUTexture | None = None
        if apart:
            usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING
            with device_errors(f"allocate a picture of {extent[0]} x {extent[1]} pixels"):
                self._texture = device.handle.create_texture(size=(*extent, 1), format=FORMAT, usage=usage)
                self._view = self._texture.create_view()

    def blend(
        self,
        encoder: wgpu.GPUCommandEncoder,
        stage: str,
        bindings: Mapping[int, Buffer | Binding | wgpu.GPUTextureView],
        extent: tuple[int, int],
        **constants: float,
    ) -> None:
        """Record a stage that goes through the pixels, with its `override` constants."""
        size = workgroup_size(self._device)
        pipeline = self._device.pipelines.compute(stage, workgroup_size=size, **constants)
        n = -(-extent[0] * extent[1] // PIXELS_PER_INVOCATION)
        bound = bind(self._device, pipeline, {**bindings, 7: self.pixels})
        dispatch(encoder, pipeline, bound, n_workgroups(self._device, n))

    @contextlib.contextmanager
    def apart(
        self, encoder: wgpu.GPUCommandEncoder, tile: Binding, extent: tuple[int, int]
    ) -> Iterator[wgpu.GPURenderPassEncoder]:
        """Record a render pass whose result goes over the picture."""
        nothing = (0.0, 0.0, 0.0, 0.0)
        attachment = {"view": self._view, "load_op": "clear", "clear_value": nothing, "store_op": "store"}
        render = encoder.begin_render_pass(color_attachments=[attachment])
        render.set_viewport(0, 0, *extent, 0, 1)
        render.set_scissor_rect(0, 0, *extent)
        yield render
        render.end()
        self.blend(encoder, "blend_lines", {0: tile, 5: self._view}, extent)

    @contextlib.contextmanager
    def downloaded(self, extent: tuple[int, int]) -> Iterator[npt.NDArray[np.uint8]]:
        """Lend the picture: (height, width, 4), valid inside the block only."""
        width, height = extent
        with self.pixels.downloaded(4 * width * height) as view:
            yield view.reshape(height, width, 4)

    def release(self) -> None:
        """Give the texture back."""
        if self._texture is not None:
            self._texture.destroy()
