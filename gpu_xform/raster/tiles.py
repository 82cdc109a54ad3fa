"""A picture cut into tiles, each of which the device draws at once."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..drawing.view import View
from ..gpu import layouts

TILE_SIDE = 2048  # pixels; up to fifty bytes each, beside the models
NOTHING = np.zeros(4, np.uint8)
WIDEST_MARGIN = 256  # pixels around a tile whose depths are known, for what a line's axis is tested by


class Region(NamedTuple):
    """A rectangle of a picture: its first corner (x, y), and its (width, height), in pixels."""

    origin: tuple[int, int]
    extent: tuple[int, int]

    @property
    def place(self) -> tuple[slice, slice]:
        """Its rows and columns in the picture."""
        (x, y), (width, height) = self
        return slice(y, y + height), slice(x, x + width)


@dataclass(frozen=True)
class Tile:
    """A rectangle of a picture, and the larger one of which depths are known: (x, y) and (width, height) in pixels."""

    origin: tuple[int, int]
    extent: tuple[int, int]
    margin: int

    @property
    def depth_origin(self) -> tuple[int, int]:
        """Where the known depths begin; may lie outside the picture."""
        return self.origin[0] - self.margin, self.origin[1] - self.margin

    @property
    def depth_extent(self) -> tuple[int, int]:
        """How far the known depths reach."""
        return self.extent[0] + 2 * self.margin, self.extent[1] + 2 * self.margin

    @property
    def place(self) -> tuple[slice, slice]:
        """The tile's rows and columns in the picture."""
        return Region(self.origin, self.extent).place


def tiles(region: Region, side: int, margin: int) -> Iterator[Tile]:
    """Cut a part of a picture into tiles of at most `side` pixels each way, row by row."""
    (left, top), (width, height) = region
    for y in range(0, height, side):
        for x in range(0, width, side):
            extent = min(side, width - x), min(side, height - y)
            yield Tile((left + x, top + y), extent, margin)


def tile_struct(tile: Tile, view: View, background: npt.NDArray[np.uint8] = NOTHING) -> npt.NDArray[np.void]:
    """Return the WGSL struct of a tile; `background` is (4,), premultiplied."""
    places = (tile.origin, tile.extent, tile.depth_origin, tile.depth_extent)
    return np.array((view.size, *places, view.pixel_depth, background / 255.0), layouts.TILE)
