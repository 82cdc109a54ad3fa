"""Shapes to pixels: projected once, then drawn tile by tile."""

import contextlib
import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..._core.interrupts import uninterrupted
from ...drawing.draw_list import Shape
from ...drawing.enums import Hidden
from ...drawing.view import View
from ...errors import DeviceError
from ...gpu import uniforms
from ...gpu.buffers import Buffer
from ...gpu.device import Device
from ...imaging.image import straight_alpha
from ..screen_bounds import reached
from ..tiles import TILE_SIDE, WIDEST_MARGIN, Region, Tile, tile_struct, tiles
from .lines import LinePass
from .render_target import POOL_OWNER, Target
from .triangles import FacePass
from .vertex_stage import Projection, in_bindings


class Drawn:
    """A picture whose last tile is drawn, or being drawn, on its device."""

    def __init__(self, device: Device, picture: npt.NDArray[np.uint8], is_opaque: bool, last: Tile, target: Target):
        self._device = device
        self._picture = picture
        self._is_opaque = is_opaque
        self._tile = last
        self._target: Target | None = target

    def pixels(self) -> npt.NDArray[np.uint8]:
        """Return (height, width, 4), straight alpha, once all is drawn."""
        if self._target is not None:
            _collect(self._picture, self._is_opaque, self._tile, self._target)
            self._target = None
        return self._picture

    def give_up(self) -> None:
        """Give the device's memory back where the pixels have not been asked for, and will not be."""
        if self._target is not None:
            _give_up(self._target)
            self._target = None

    def arrive(self, device: Device) -> None:
        """Wait until all is drawn, where it is `device` that draws it."""
        if self._target is not None and self._device is device:
            self._target.arrive()


def draw(
    device: Device,
    shapes: Sequence[Shape],
    palette: npt.NDArray[np.uint32],
    view: View,
    background: tuple[float, float, float, float],
    after: Drawn | None = None,
) -> Drawn:
    """Have painted faces drawn, then the lines of each shape over those of the shapes before it.

    palette : (c,) packed colours of faces, c may be 0
    background : straight alpha
    after : what is waited for when all of the first tile is recorded, so that it can be read while that is drawn
    """
    is_opaque = background[3] == 1.0
    region = reached(shapes, view.size)
    parts = list(tiles(region, TILE_SIDE, _margin(shapes)))
    ground = _in_bytes(background)
    picture = _around(region, view.size, ground if is_opaque else straight_alpha(ground))
    n_depths = max(math.prod(part.depth_extent) for part in parts)
    with device.lock, contextlib.ExitStack() as stack, contextlib.ExitStack() as unread:
        colors = None
        if len(palette):
            colors = Buffer(device.context, palette.nbytes, label="raster: palette")
            stack.callback(colors.release)
            colors.upload(palette)
        projection = Projection(device, [part for shape in shapes for part in in_bindings(device, shape)])
        faces = FacePass(device, projection.shapes, n_depths, colors)
        lines = LinePass(device, projection.shapes, faces, parts[0].extent)
        common = [*projection.buffers, *faces.buffers, *lines.buffers]

        @uninterrupted()
        def drawn(part: Tile, wait: Callable[[], None]) -> Target:
            (tile,) = uniforms.upload(device, POOL_OWNER, "tile", [tile_struct(part, view, ground)])
            target = Target(device, part.extent, tile)
            unread.callback(_give_up, target)
            with device.encode_commands(*target.buffers, *common, label="raster tile") as encoder:
                if part is parts[0]:
                    projection.record(encoder)
                faces.lay(encoder, tile)
                faces.paint(encoder, target, tile)
                lines.draw(encoder, target, tile)
                target.leave(encoder)
                wait()
            return target

        target = drawn(parts[0], lambda: after.arrive(device) if after else None)
        for last, part in pairwise(parts):
            following = drawn(part, target.arrive)
            _collect(picture, is_opaque, last, target)  # while the following is drawn
            target = following
        unread.pop_all()
    return Drawn(device, picture, is_opaque, parts[-1], target)


def _give_up(target: Target) -> None:
    with contextlib.suppress(DeviceError):  # of a device that is closed or lost, which is what has stopped the drawing
        target.give_up()


def _collect(picture: npt.NDArray[np.uint8], is_opaque: bool, tile: Tile, target: Target) -> None:
    with target.arrived() as pixels:
        picture[tile.place] = pixels if is_opaque else straight_alpha(pixels)


def _in_bytes(background: tuple[float, float, float, float]) -> npt.NDArray[np.uint8]:
    """Return a colour of straight alpha as a pixel holds it: (4,), premultiplied."""
    red, green, blue, alpha = background
    return np.floor(255.0 * np.array((red * alpha, green * alpha, blue * alpha, alpha)) + 0.5).astype(np.uint8)


def _around(region: Region, size: tuple[int, int], color: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return a picture (height, width, 4) of one colour (4,), but for `region`, which is still to be filled."""
    width, height = size
    picture = np.empty((height, width), np.uint32)  # a pixel a number: NumPy fills with fours of bytes ten times slower
    rows, columns = region.place
    beside = picture[rows]
    for part in (picture[: rows.start], picture[rows.stop :], beside[:, : columns.start], beside[:, columns.stop :]):
        part.fill(color.view(np.uint32)[0])
    return picture.view(np.uint8).reshape(height, width, 4)


def _margin(shapes: Sequence[Shape]) -> int:
    """Return how far beside a tile the axis of a line can lie that is tested against the faces and seen in the tile."""
    tested = [lines.line_width or 1.0 for shape in shapes for lines in shape.lines if lines.hidden is not Hidden.SHOW]
    # Ink goes by columns, which are longer through a slanting line than across it: up to 1.66 pixels at its widest.
    # Outlines are tested 1.5 pixels beside their axis.
    return min(WIDEST_MARGIN, math.ceil(0.5 * max(tested)) + 6) if tested else 0
