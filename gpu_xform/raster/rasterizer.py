"""What all rasterisers do: points are projected once, then the picture is drawn tile by tile."""

import contextlib
import math
from collections.abc import Callable, Sequence
from itertools import accumulate, chain, pairwise

import numpy as np

from .._core.interrupts import defer_interrupts
from ..drawing.draw_list import DrawList
from ..drawing.enums import Hidden
from ..drawing.view import View
from ..errors import DeviceError
from ..gpu import uniforms
from ..gpu.buffers import Buffer
from ..gpu.device import GpuDevice
from ..imaging.colors import Rgba
from ..imaging.image import Pixels, unpremultiply
from .base import PendingImage
from .binding_limits import split_to_binding_limits
from .clouds import CloudStage
from .line_stage import LineStageFactory
from .render_target import POOL_OWNER, RenderTarget
from .screen_bounds import screen_bounds
from .tile_struct import Tile, make_tile_struct
from .tiles import TILE_SIDE_PX, Region, split_into_tiles
from .triangles import Hiders, TriangleStage
from .vertex_stage import VertexStage

MAX_DEPTH_MARGIN_PX = 256


class TiledPendingImage:
    """A picture whose last tile is drawn, or being drawn."""

    def __init__(self, device: GpuDevice, pixels: Pixels, is_opaque: bool, last: Region, target: RenderTarget) -> None:
        self.device = device
        self._pixels = pixels
        self._is_opaque = is_opaque
        self._last = last
        self._target: RenderTarget | None = target

    def result(self) -> Pixels:
        """Return (height, width, 4), straight alpha, once all is drawn."""
        if self._target is not None:
            _collect(self._pixels, self._is_opaque, self._last, self._target)
            self._target = None
        return self._pixels

    def cancel(self) -> None:
        """Give the memory on the device back if the result has not been taken, and will not be."""
        if self._target is not None:
            _cancel(self._target)
            self._target = None

    def wait(self) -> None:
        """Wait until all is drawn."""
        if self._target is not None:
            self._target.wait()


class TiledRasterizer:
    """Draws on one device.

    line_stage : how it draws lines
    """

    def __init__(self, device: GpuDevice, line_stage: LineStageFactory) -> None:
        self._device = device
        self._line_stage = line_stage

    def draw(
        self, draw_list: DrawList, view: View, background: Rgba, *, overlap_with: PendingImage | None = None
    ) -> TiledPendingImage:
        """Begin to draw, as `Rasterizer.draw` says."""
        device = self._device
        is_opaque = background[3] == 1.0
        region = screen_bounds(draw_list, view.size)
        margin = _depth_margin(draw_list)
        side = min(TILE_SIDE_PX, device.limits.max_texture_side)
        tiles = [Tile(part, margin) for part in split_into_tiles(region, side)]
        clear_color = _premultiplied_bytes(background)
        is_overlapping = overlap_with is not None and overlap_with.device is device
        wait = overlap_with.wait if overlap_with and is_overlapping else lambda: None
        with device.lock, contextlib.ExitStack() as stack, contextlib.ExitStack() as unread:
            stages = _Stages(device, self._line_stage, draw_list, view, clear_color, tiles, stack)
            target = stages.draw(tiles[0], unread, wait)
            # While the device draws:
            pixels = _filled_border(region, view.size, clear_color if is_opaque else unpremultiply(clear_color))
            for last, tile in pairwise(tiles):
                next_target = stages.draw(tile, unread, target.wait)
                _collect(pixels, is_opaque, last.region, target)  # while the next tile is drawn
                target = next_target
            unread.pop_all()
        return TiledPendingImage(device, pixels, is_opaque, tiles[-1].region, target)


class _Stages:
    """The stages of one picture; what they alone need on the device is released as `stack` unwinds."""

    def __init__(
        self,
        device: GpuDevice,
        line_stage: LineStageFactory,
        draw_list: DrawList,
        view: View,
        clear_color: Pixels,
        tiles: Sequence[Tile],
        stack: contextlib.ExitStack,
    ) -> None:
        self._device = device
        self._view = view
        self._clear_color = clear_color
        self._first_tile = tiles[0]
        palette = None
        if len(draw_list.palette):
            palette = Buffer(device.context, draw_list.palette.nbytes, label="raster: palette")
            stack.callback(palette.release)
            palette.upload(draw_list.palette)
        parts = [list(split_to_binding_limits(device, drawable)) for drawable in draw_list.drawables]
        n_depths = max(math.prod(tile.depth_region.extent) for tile in tiles)
        drawn = list(chain.from_iterable(parts))
        covers = [split_to_binding_limits(device, drawable) for drawable in draw_list.covers or ()]
        self._vertices = VertexStage(device, [*drawn, *chain.from_iterable(covers)])
        projected = self._vertices.projected[: len(drawn)]
        self._projected = projected
        hides_lines = any(
            lines.hidden is not Hidden.SHOW for drawable in draw_list.drawables for lines in drawable.lines
        )
        self._triangles = self._covers = TriangleStage(device, projected, n_depths, palette, finds_flats=hides_lines)
        if draw_list.covers is not None:
            self._covers = TriangleStage(device, self._vertices.projected[len(drawn) :], n_depths, name="covers")
        hiders = Hiders(self._triangles, self._covers)
        self._lines = line_stage(device, projected, hiders, tiles[0].region.extent)
        self._clouds = CloudStage(device, draw_list.clouds, tiles[0].region.extent, hiders)
        # Drawables are split: how many parts there are before each cloud, and in all.
        n_parts = [0, *accumulate(map(len, parts))]
        self._n_parts_before = [n_parts[cloud.position] for cloud in draw_list.clouds] + [n_parts[-1]]

    @defer_interrupts()
    def draw(self, tile: Tile, unread: contextlib.ExitStack, wait: Callable[[], None]) -> RenderTarget:
        """Record a tile, call `wait`, submit the tile; its target is cancelled if `unread` unwinds."""
        (struct,) = uniforms.upload(
            self._device, POOL_OWNER, "tile", [make_tile_struct(tile, self._view, self._clear_color)]
        )
        target = RenderTarget(self._device, tile.region.extent, struct, self._clear_color)
        unread.callback(_cancel, target)
        stages = (self._vertices, self._triangles, self._covers, self._lines, self._clouds)
        used = [*target.buffers, *(buffer for stage in stages for buffer in stage.buffers)]
        with self._device.encode_commands(*used, label="raster tile") as encoder:
            if tile is self._first_tile:
                self._vertices.record(encoder)
                self._lines.measure_dashes(encoder, struct)
            self._triangles.depth_prepass(encoder, struct)
            if self._covers is not self._triangles:
                self._covers.depth_prepass(encoder, struct)
            self._triangles.composite(encoder, target, struct)
            first = 0
            for number, end in enumerate(self._n_parts_before):
                if number > 0:
                    self._clouds.draw(encoder, target, struct, number - 1)
                self._lines.draw(encoder, target, struct, self._projected[first:end])
                first = end
            target.resolve(encoder)
            wait()
        return target


def _cancel(target: RenderTarget) -> None:
    with contextlib.suppress(DeviceError):  # of a device that is closed or lost, which is what has stopped the drawing
        target.cancel()


def _collect(pixels: Pixels, is_opaque: bool, tile: Region, target: RenderTarget) -> None:
    with target.map_pixels() as own:
        pixels[tile.slices] = own if is_opaque else unpremultiply(own)


def _premultiplied_bytes(color: Rgba) -> Pixels:
    """Return a colour of straight alpha as a pixel holds it: (4,), premultiplied."""
    red, green, blue, alpha = color
    return np.floor(255.0 * np.array((red * alpha, green * alpha, blue * alpha, alpha)) + 0.5).astype(np.uint8)


def _filled_border(region: Region, size: tuple[int, int], color: Pixels) -> Pixels:
    """Return a picture (height, width, 4) of one colour (4,), except for `region`, which is still to be filled."""
    width, height = size
    # One number per pixel: NumPy fills with four bytes at a time ten times slower.
    picture = np.empty((height, width), np.uint32)
    rows, columns = region.slices
    beside = picture[rows]
    for part in (picture[: rows.start], picture[rows.stop :], beside[:, : columns.start], beside[:, columns.stop :]):
        part.fill(color.view(np.uint32)[0])
    return picture.view(np.uint8).reshape(height, width, 4)


def _depth_margin(draw_list: DrawList) -> int:
    """Return how far beside a tile the axis of a line can lie that is tested against the faces and seen in the tile."""
    tested = [
        lines.line_width or 1.0
        for drawable in draw_list.drawables
        for lines in drawable.lines
        if lines.hidden is not Hidden.SHOW
    ]
    tested += [cloud.diameter for cloud in draw_list.clouds if cloud.hidden is not Hidden.SHOW]
    # Coverage goes by columns, which are longer through a slanting line than across it: by up to 1.66 pixels at its
    # widest. Silhouettes are tested 1.5 pixels beside their axis.
    return min(MAX_DEPTH_MARGIN_PX, math.ceil(0.5 * max(tested)) + 6) if tested else 0
