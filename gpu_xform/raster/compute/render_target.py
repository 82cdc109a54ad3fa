"""Render targets: the pixels of a tile on its device, and their readback."""

import contextlib
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from ...gpu.buffers import READBACK, Buffer
from ...gpu.chunking import choose_workgroup_size, count_workgroups
from ...gpu.context import CommandEncoder
from ...gpu.device import Device
from ...gpu.dispatch import Binding, dispatch

POOL_OWNER = "raster"
PIXELS_PER_INVOCATION = 64
CLEAR_BYTES = 16  # per store of the stage that clears: four pixels


class RenderTarget:
    """The premultiplied pixels of one tile of `extent` = (width, height), drawn and read back once.

    n_bytes : of the pixels
    tile : its struct
    """

    def __init__(self, device: Device, extent: tuple[int, int], tile: Binding) -> None:
        self._device = device
        self._extent = width, height = extent
        self._tile = tile
        self._is_blank = True  # nothing has been recorded, not even the background
        self._is_acquired = True
        self.n_bytes = 4 * width * height
        self._pixels = device.pool.acquire(POOL_OWNER, "picture", -(-self.n_bytes // CLEAR_BYTES) * CLEAR_BYTES)
        self._readback = self._pixels
        if not self._pixels.can_map:
            self._readback = device.pool.acquire(POOL_OWNER, "readback", self.n_bytes, READBACK)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        return [self._tile.buffer, self._pixels, self._readback]

    def composite(
        self, encoder: CommandEncoder, stage: str, bindings: Mapping[str, Buffer | Binding], **constants: float
    ) -> None:
        """Record a stage that composites over all pixels, with its `override` constants."""
        is_first, self._is_blank = self._is_blank, False
        self._dispatch_over_pixels(encoder, stage, bindings, **constants, is_first=is_first)

    def composite_listed(
        self, encoder: CommandEncoder, stage: str, bindings: Mapping[str, Buffer | Binding], **constants: float
    ) -> None:
        """Record a stage that composites over the few pixels in a list of its own."""
        self._clear_if_blank(encoder)
        self._dispatch_over_pixels(encoder, stage, bindings, **constants)

    def resolve(self, encoder: CommandEncoder) -> None:
        """Record what brings the finished pixels to where the host can map them."""
        self._clear_if_blank(encoder)
        if self._readback is not self._pixels:
            encoder.copy_buffer(self._pixels, self._readback, self.n_bytes)

    def wait(self) -> None:
        """Wait until the pixels can be mapped without waiting."""
        self._readback.wait_mapped(self.n_bytes)

    @contextlib.contextmanager
    def map_pixels(self) -> Iterator[npt.NDArray[np.uint8]]:
        """Lend the pixels (height, width, 4), valid inside the block only; the memory is given back at its end."""
        width, height = self._extent
        with self._readback.map_read(self.n_bytes) as view:
            yield view.reshape(height, width, 4)
        self._release()

    def cancel(self) -> None:
        """Give the memory back unread; if the pixels have been read, that has been done."""
        if self._is_acquired:
            self._device.require_usable()
            self._readback.unmap()
            self._release()

    def _clear_if_blank(self, encoder: CommandEncoder) -> None:
        if self._is_blank:
            self._is_blank = False
            self._dispatch_over_pixels(encoder, "clear_target", {"tile": self._tile})

    def _dispatch_over_pixels(
        self, encoder: CommandEncoder, stage: str, bindings: Mapping[str, Buffer | Binding], **constants: float
    ) -> None:
        size = choose_workgroup_size(self._device)
        pipeline = self._device.pipelines.compute(stage, workgroup_size=size, **constants)
        n_invocations = -(-self.n_bytes // (4 * PIXELS_PER_INVOCATION))
        group = self._device.bind_groups.bind(pipeline, **bindings, render_target=self._pixels)
        dispatch(encoder, pipeline, group, count_workgroups(self._device, n_invocations))

    def _release(self) -> None:
        with self._device.lock:
            self._is_acquired = False
            self._device.pool.release(POOL_OWNER, "picture", self._pixels)
            if self._readback is not self._pixels:
                self._device.pool.release(POOL_OWNER, "readback", self._readback)
