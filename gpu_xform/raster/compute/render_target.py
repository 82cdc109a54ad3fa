"""The picture of a tile on its device, and its way to the host."""

import contextlib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ...gpu.buffers import READBACK, Buffer
from ...gpu.chunking import choose_workgroup_size, count_workgroups
from ...gpu.context import CommandEncoder
from ...gpu.dispatch import Binding, dispatch

if TYPE_CHECKING:
    from ...gpu.device import Device

POOL_OWNER = "raster"
PIXELS_PER_INVOCATION = 64
FILL_BYTES = 16  # of four pixels, which are filled at once


class Target:
    """The premultiplied picture of one tile of `extent` = (width, height) pixels, drawn and read once.

    n_bytes : of the picture
    tile : its struct
    """

    def __init__(self, device: "Device", extent: tuple[int, int], tile: Binding) -> None:
        self._device = device
        self._extent = width, height = extent
        self._tile = tile
        self._is_blank = True  # nothing has been recorded, not even the background
        self._is_taken = True
        self.n_bytes = 4 * width * height
        self._pixels = device.pool.acquire(POOL_OWNER, "picture", -(-self.n_bytes // FILL_BYTES) * FILL_BYTES)
        self._arriving = self._pixels
        if not self._pixels.can_map:
            self._arriving = device.pool.acquire(POOL_OWNER, "readback", self.n_bytes, READBACK)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        return [self._tile.buffer, self._pixels, self._arriving]

    def blend(
        self,
        encoder: CommandEncoder,
        stage: str,
        bindings: Mapping[str, Buffer | Binding],
        **constants: float,
    ) -> None:
        """Record a stage that goes through the pixels, with its `override` constants, over what is there."""
        is_first, self._is_blank = self._is_blank, False
        self._go_through(encoder, stage, bindings, **constants, is_first=is_first)

    def blend_listed(
        self,
        encoder: CommandEncoder,
        stage: str,
        bindings: Mapping[str, Buffer | Binding],
        **constants: float,
    ) -> None:
        """Record a stage that goes through a few pixels, which it has a list of."""
        self._fill(encoder)
        self._go_through(encoder, stage, bindings, **constants)

    def _fill(self, encoder: CommandEncoder) -> None:
        if self._is_blank:
            self._is_blank = False
            self._go_through(encoder, "clear_target", {"tile": self._tile})

    def _go_through(
        self,
        encoder: CommandEncoder,
        stage: str,
        bindings: Mapping[str, Buffer | Binding],
        **constants: float,
    ) -> None:
        size = choose_workgroup_size(self._device)
        pipeline = self._device.pipelines.compute(stage, workgroup_size=size, **constants)
        n = -(-self.n_bytes // (4 * PIXELS_PER_INVOCATION))
        bound = self._device.bind_groups.bind(pipeline, **bindings, picture=self._pixels)
        dispatch(encoder, pipeline, bound, count_workgroups(self._device, n))

    def leave(self, encoder: CommandEncoder) -> None:
        """Record what brings the finished picture to where the host can map it."""
        self._fill(encoder)
        if self._arriving is not self._pixels:
            encoder.copy_buffer(self._pixels, self._arriving, self.n_bytes)

    def arrive(self) -> None:
        """Wait until the picture is there."""
        self._arriving.wait_mapped(self.n_bytes)

    @contextlib.contextmanager
    def arrived(self) -> Iterator[npt.NDArray[np.uint8]]:
        """Lend the picture: (height, width, 4), valid inside the block only, after which the target can go."""
        width, height = self._extent
        with self._arriving.map_read(self.n_bytes) as view:
            yield view.reshape(height, width, 4)
        self._give_back()

    def give_up(self) -> None:
        """Give its memory back unread; where it has been read, that has been done."""
        if self._is_taken:
            self._device.require_usable()
            self._arriving.unmap()
            self._give_back()

    def _give_back(self) -> None:
        with self._device.lock:
            self._is_taken = False
            self._device.pool.release(POOL_OWNER, "picture", self._pixels)
            if self._arriving is not self._pixels:
                self._device.pool.release(POOL_OWNER, "readback", self._arriving)
