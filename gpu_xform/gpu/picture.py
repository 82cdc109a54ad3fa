"""Shapes to pixels: projected once, then drawn tile by tile."""

import contextlib
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..images import straight_alpha
from . import layouts, uniforms
from .buffers import Buffer
from .device import Device
from .face_pass import FacePass
from .frame import View, in_bindings, project
from .line_pass import LinePass
from .shapes import Hidden, Shape
from .targets import Target
from .tiles import TILE_SIDE, WIDEST_MARGIN, Tile, tiles


def draw(
    device: Device,
    shapes: Sequence[Shape],
    palette: npt.NDArray[np.uint32],
    view: View,
    background: tuple[float, float, float, float],
) -> npt.NDArray[np.uint8]:
    """Draw painted faces, then the lines of each shape over those of the shapes before it.

    palette : (c,) packed colours of faces, c may be 0
    background : straight alpha

    Returns (height, width, 4), straight alpha.
    """
    width, height = view.size
    picture = np.empty((height, width, 4), np.uint8)
    side = min(TILE_SIDE, device.limits.max_texture_size)
    parts = list(tiles(view.size, side, _margin(shapes)))
    n_depths = max(math.prod(part.depth_extent) for part in parts)
    with device.lock, contextlib.ExitStack() as stack:
        colors = None
        if len(palette):
            colors = Buffer(device, palette.nbytes)
            stack.callback(colors.release)
            colors.upload(palette)
        projected = project(device, [part for shape in shapes for part in in_bindings(device, shape)])
        faces = FacePass(device, projected, n_depths, colors)
        lines = LinePass(device, projected, faces, parts[0].extent)
        target = Target(device, parts[0].extent, apart=lines.needs_texture)
        stack.callback(target.release)
        for part in parts:
            (tile,) = uniforms.upload(device, "tile", [tile_struct(part, view, background)])
            with device.recording(tile.buffer, target.pixels, *faces.buffers, *lines.buffers) as encoder:
                target.blend(encoder, "fill_picture", {0: tile}, part.extent)
                faces.lay(encoder, tile)
                faces.paint(encoder, target, tile, part.extent)
                lines.draw(encoder, target, tile, part.extent)
            with target.downloaded(part.extent) as pixels:
                picture[part.place] = pixels if background[3] == 1.0 else straight_alpha(pixels)
    return picture


def tile_struct(
    tile: Tile, view: View, background: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
) -> npt.NDArray[np.void]:
    """Return the WGSL struct of a tile; `background` is straight alpha."""
    red, green, blue, alpha = background
    premultiplied = (red * alpha, green * alpha, blue * alpha, alpha)
    places = (tile.origin, tile.extent, tile.depth_origin, tile.depth_extent)
    return np.array((view.size, *places, view.pixel_depth, premultiplied), layouts.TILE)


def _margin(shapes: Sequence[Shape]) -> int:
    """Return how far beside a tile the axis of a line can lie that is tested against the faces and seen in the tile."""
    tested = [lines.line_width or 1.0 for shape in shapes for lines in shape.lines if lines.hidden is not Hidden.SHOWN]
    # Ink goes by columns, which are longer through a slanting line than across it: up to 1.66 pixels at its widest.
    return min(WIDEST_MARGIN, math.ceil(0.5 * max(tested)) + 4) if tested else 0
