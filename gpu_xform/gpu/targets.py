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
    tile : its struct
    background : (4,), premultiplied
    apart : whether something will be drawn apart
    """

    def __init__(
        self,
        device: "Device",
        extent: tuple[int, int],
        tile: Binding,
        background: npt.NDArray[np.uint8],
        *,
        apart: bool,
    ) -> None:
        self._device = device
        self._extent = width, height = extent
        self._tile = tile
        self._background = background
        self._is_blank = True  # nothing has been recorded, not even the background
        self._is_taken = True
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
        return [self._tile.buffer, self._pixels, self._arriving, self._lines]

    def blend(
        self,
        encoder: wgpu.GPUCommandEncoder,
        stage: str,
        bindings: Mapping[int, Buffer | Binding],
        **constants: float,
    ) -> None:
        """Record a stage that goes through the pixels, with its `override` constants, after the background."""
        self._fill(encoder)
        self._go_through(encoder, stage, bindings, **constants)

    def _fill(self, encoder: wgpu.GPUCommandEncoder) -> None:
        if self._is_blank:
            self._is_blank = False
            self._go_through(encoder, "fill_picture", {0: self._tile})

    def _go_through(
        self,
        encoder: wgpu.GPUCommandEncoder,
        stage: str,
        bindings: Mapping[int, Buffer | Binding],
        **constants: float,
    ) -> None:
        size = workgroup_size(self._device)
        pipeline = self._device.pipelines.compute(stage, workgroup_size=size, **constants)
        n = -(-self.n_bytes // (4 * PIXELS_PER_INVOCATION))
        bound = bind(self._device, pipeline, {**bindings, 7: self._pixels})
        dispatch(encoder, pipeline, bound, n_workgroups(self._device, n))

    @contextlib.contextmanager
    def apart(self, encoder: wgpu.GPUCommandEncoder) -> Iterator[wgpu.GPURenderPassEncoder]:
        """Record a render pass whose result goes over the picture; the first of all has the background for ground."""
        is_first, self._is_blank = self._is_blank, False
        texture = self._device.pool.texture(self._extent, FORMAT)
        ground = (self._background / 255.0).tolist() if is_first else (0.0, 0.0, 0.0, 0.0)
        attachment = {"view": texture.create_view(), "load_op": "clear", "clear_value": ground, "store_op": "store"}
        render = encoder.begin_render_pass(color_attachments=[attachment])
        yield render
        render.end()
        row_bytes = _row_bytes(self._extent[0])
        has_gaps = row_bytes != 4 * self._extent[0]
        straight = is_first and not has_gaps
        rows = {"buffer": (self._pixels if straight else self._lines).handle, "bytes_per_row": row_bytes}
        encoder.copy_texture_to_buffer({"texture": texture}, rows, (*self._extent, 1))
        if straight:
            return
        if is_first:
            encoder.clear_buffer(self._pixels.handle, 0, self.n_bytes)  # over nothing it stays what it is
        row_step = ROW_ALIGNMENT // 4 if has_gaps else 1
        self.blend(encoder, "blend_lines", {0: self._tile, 5: self._lines}, row_step=row_step)

    def leave(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """Record what brings the finished picture to where the host can map it."""
        self._fill(encoder)
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
        self._give_back()

    def give_up(self) -> None:
        """Give its memory back unread; where it has been read, that has been done."""
        if self._is_taken:
            self._device.require_usable()
            self._arriving.forget()
            self._give_back()

    def _give_back(self) -> None:
        with self._device.lock:
            self._is_taken = False
            self._device.pool.give_back("picture", self._pixels)
            if self._arriving is not self._pixels:
                self._device.pool.give_back("readback", self._arriving)


def _row_bytes(width: int) -> int:
    return -(-4 * width // ROW_ALIGNMENT) * ROW_ALIGNMENT
