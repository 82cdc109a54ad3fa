"""Render targets: the pixels of a tile, drawn by render passes over it, and their readback."""

import contextlib
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from ..gpu.buffers import READBACK, STORAGE, Buffer
from ..gpu.context import CommandEncoder
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Bindable, Binding, begin_render_pass
from ..gpu.textures import Texture, align_row
from ..imaging.image import Pixels
from .quads import draw_quads

POOL_OWNER = "raster"
PIXEL_FORMAT = "rgba8unorm"
PIXEL_BYTES = 4
TILE_VERTICES = 3  # of a triangle over a tile
MIN_PIXELS_PER_EDGE = 2048  # of a tile; where edges are fewer, quads over them are faster than a triangle over the tile
MAX_BACKGROUND_BYTES = 1 << 20  # of whole rows, copied at once; half as many take longer


class RenderTarget:
    """The premultiplied pixels of one tile of `extent` = (width, height), drawn and read back once.

    A stage cannot read the texture that it draws into: each composites into another one.

    tile : its struct
    background : (4,) premultiplied
    """

    def __init__(self, device: GpuDevice, extent: tuple[int, int], tile: Binding, background: Pixels) -> None:
        self._device = device
        self.extent = extent
        self._tile = tile
        self._background = background
        self._keys = "picture", "other picture"
        self._pixels: Texture | None = None  # nothing has been recorded, not even the background
        self._is_acquired = True
        self._row_bytes = align_row(PIXEL_BYTES * extent[0])
        self._usage = STORAGE if device.host_mappable else READBACK
        self._readback = device.pool.acquire(POOL_OWNER, "readback", self._n_bytes, self._usage)

    @property
    def n_pixels(self) -> int:
        """The number of pixels."""
        width, height = self.extent
        return width * height

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        return [self._tile.buffer, self._readback]

    @property
    def per_pixel(self) -> Buffer:
        """The 32 bits per pixel that stages may fill before `resolve` is recorded.

        If the host can map them, they are the memory that the pixels are read from afterwards.
        """
        if self._usage == STORAGE:
            return self._readback
        return self._device.pool.scratch(POOL_OWNER, "per pixel", PIXEL_BYTES * self.n_pixels)

    def composite(
        self, encoder: CommandEncoder, stage: str, bindings: Mapping[str, Bindable], **constants: float
    ) -> None:
        """Record a stage that composites over all pixels, with its `override` constants."""
        self._draw(encoder, stage, bindings, 0, **constants)

    def composite_lines(
        self,
        encoder: CommandEncoder,
        stage: str,
        bindings: Mapping[str, Bindable],
        n_edges: int | None,
        **constants: float,
    ) -> None:
        """Record a stage that composites the `n_edges` edges that `bindings` hold, or more if it is None."""
        n_quads = n_edges if n_edges and n_edges * MIN_PIXELS_PER_EDGE <= self.n_pixels else 0
        self._draw(encoder, stage, bindings, n_quads, covers_edges=n_quads > 0, **constants)

    def resolve(self, encoder: CommandEncoder) -> None:
        """Record what brings the finished pixels to where the host can map them."""
        if self._pixels is None:
            self._pixels = self.next_texture()
            self._copy_background(encoder, self._pixels)
        encoder.copy_texture_to_buffer(self._pixels, self._readback, self.extent, self._row_bytes)

    def wait(self) -> None:
        """Wait until the pixels can be mapped without waiting."""
        self._readback.wait_mapped(self._n_bytes)

    @contextlib.contextmanager
    def map_pixels(self) -> Iterator[npt.NDArray[np.uint8]]:
        """Lend the pixels (height, width, 4), valid inside the block only; the memory is given back at its end."""
        width, height = self.extent
        with self._readback.map_read(self._n_bytes) as view:
            yield view.reshape(height, -1, PIXEL_BYTES)[:, :width]
        self._release()

    def cancel(self) -> None:
        """Give the memory back unread; if the pixels have been read, that has been done."""
        if self._is_acquired:
            self._device.require_usable()
            self._readback.unmap()
            self._release()

    def next_texture(self) -> Texture:
        """Return the texture that the next stage will draw into; until then it holds nothing."""
        return self._device.textures.scratch(POOL_OWNER, self._keys[0], self.extent, PIXEL_FORMAT)

    @property
    def _n_bytes(self) -> int:
        return self._row_bytes * self.extent[1]

    def _draw(
        self, encoder: CommandEncoder, stage: str, bindings: Mapping[str, Bindable], n_quads: int, **constants: float
    ) -> None:
        before, self._pixels = self._pixels, self.next_texture()
        self._keys = self._keys[1], self._keys[0]
        destination = before or self._device.textures.scratch(POOL_OWNER, "no picture", (1, 1), PIXEL_FORMAT)
        pipeline = self._device.pipelines.render(stage, PIXEL_FORMAT, is_first=before is None, **constants)
        group = self._device.bind_groups.bind(pipeline, **bindings, destination=destination)
        if n_quads and before:
            encoder.copy_texture(before, self._pixels, self.extent)
        elif n_quads:
            self._copy_background(encoder, self._pixels)
        with begin_render_pass(encoder, self._pixels, self.extent, pipeline, group) as render:
            if n_quads:
                draw_quads(self._device, POOL_OWNER, render, n_quads)
            else:
                render.draw(TILE_VERTICES)

    def _copy_background(self, encoder: CommandEncoder, texture: Texture) -> None:
        """Record the background from a buffer of some rows of it: lavapipe copies faster than it clears."""
        width, height = self.extent
        n_rows = min(max(MAX_BACKGROUND_BYTES // self._row_bytes, 1), height)
        rows = self._device.pool.scratch(POOL_OWNER, "background", self._row_bytes * n_rows)
        content = self._background.tobytes()
        if rows.content_key != content:
            with rows.map_write(rows.n_bytes) as view:
                view.view(np.uint32).fill(self._background.view(np.uint32)[0])
            rows.content_key = content
        for first in range(0, height, n_rows):
            extent = width, min(n_rows, height - first)
            encoder.copy_buffer_to_texture(rows, texture, extent, self._row_bytes, first)

    def _release(self) -> None:
        with self._device.lock:
            self._is_acquired = False
            self._device.pool.release(POOL_OWNER, "readback", self._readback)
