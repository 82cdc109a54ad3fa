"""The picture of a tile on its device, what is drawn apart before it goes over it, and its way to the host."""

import contextlib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import wgpu

from .buffers import READBACK, Buffer
from .compute import Binding, bind, dispatch
from .plans import n_workgroups, workgroup_size

if TYPE_CHECKING:
    from .device import Device

PIXELS_PER_INVOCATION = 64
ROW_ALIGNMENT = 256  # bytes, of what is copied out of a texture
FORMAT = "rgba8unorm"  # not -srgb: colours mix as the bytes of the file do, like other plotting programs' lines


class Target:
    """The premultiplied picture of one tile of `extent` = (width, height) pixels, drawn and read once.

    n_bytes : of the picture
    apart : whether something will be drawn apart
    """

    def __init__(self, device: "Device", extent: tuple[int, int], *, apart: bool) -> None:
        self._device = device
        self._extent = width, height = extent
        self.n_bytes = 4 * width * height
        self._pixels = device.pool.take("picture", self.n_bytes)
        self._arriving = self._pixels
        if not self._pixels.can_map:
            self._arriving = device.pool.take("readback", self.n_bytes, READBACK)
        # As numbers in memory they are read much faster than as a texture, on a CPU.
        self._lines = device.pool.get("lines", _row_bytes(width) * height if apart else 4)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        return [self._pixels, self._arriving, self._lines]

    def blend(
        self,
        encoder: wgpu.GPUCommandEncoder,
        stage: str,
        bindings: Mapping[int, Buffer | Binding],
        **constants: float,
    ) -> None:
        """Record a stage that goes through the pixels, with its `override` constants."""
        size = workgroup_size(self._device)
        pipeline = self._device.pipelines.compute(stage, workgroup_size=size, **constants)
        n = -(-self.n_bytes // (4 * PIXELS_PER_INVOCATION))
        bound = bind(self._device, pipeline, {**bindings, 7: self._pixels})
        dispatch(encoder, pipeline, bound, n_workgroups(self._device, n))

    @contextlib.contextmanager
    def apart(self, encoder: wgpu.GPUCommandEncoder, tile: Binding) -> Iterator[wgpu.GPURenderPassEncoder]:
        """Record a render pass whose result goes over the picture."""
        texture = self._device.pool.texture(self._extent, FORMAT)
        nothing = (0.0, 0.0, 0.0, 0.0)
        attachment = {"view": texture.create_view(), "load_op": "clear", "clear_value": nothing, "store_op": "store"}
        render = encoder.begin_render_pass(color_attachments=[attachment])
        yield render
        render.end()
        rows = {"buffer": self._lines.handle, "bytes_per_row": _row_bytes(self._extent[0])}
        encoder.copy_texture_to_buffer({"texture": texture}, rows, (*self._extent, 1))
        is_whole = 4 * self._extent[0] % ROW_ALIGNMENT == 0
        self.blend(encoder, "blend_lines", {0: tile, 5: self._lines}, row_step=1 if is_whole else ROW_ALIGNMENT // 4)

    def leave(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Record what brings the finished picture to where the host can map it."""
        if self._arriving is not self._pixels:
            encoder.copy_buffer_to_buffer(self._pixels.handle, 0, self._arriving.handle, 0, self.n_bytes)

    def arrive(self) -> None:
        """Wait until the picture is there."""
        self._arriving.arrive(self.n_bytes)

    @contextlib.contextmanager
    def arrived(self) -> Iterator[npt.NDArray[np.uint8]]:
        """Lend the picture: (height, width, 4), valid inside the block only, after which the target can go."""
        width, height = self._extent
        with self._arriving.downloaded(self.n_bytes) as view:
            yield view.reshape(height, width, 4)
        with self._device.lock:
            self._device.pool.give_back("picture", self._pixels)
            if self._arriving is not self._pixels:
                self._device.pool.give_back("readback", self._arriving)


def _row_bytes(width: int) -> int:
    return -(-4 * width // ROW_ALIGNMENT) * ROW_ALIGNMENT
