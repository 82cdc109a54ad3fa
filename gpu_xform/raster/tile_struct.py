"""A tile with the depths around it, and the WGSL struct that tells the shaders of both."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..drawing.depth import depth_slope_per_pixel
from ..drawing.view import View
from ..gpu import layouts
from .tiles import Region

TRANSPARENT = np.zeros(4, np.uint8)


@dataclass(frozen=True)
class Tile:
    """A part of a picture that is drawn at once.

    margin : pixels around it whose depths are known too, against which the axes of lines are tested
    """

    region: Region
    margin: int

    @property
    def depth_region(self) -> Region:
        """Where depths are known; may reach out of the picture."""
        return self.region.padded(self.margin)


def make_tile_struct(tile: Tile, view: View, background: npt.NDArray[np.uint8] = TRANSPARENT) -> npt.NDArray[np.void]:
    """Return the WGSL struct of a tile; `background` is (4,), premultiplied."""
    slope = depth_slope_per_pixel(view.clip_from_world, view.size[0])
    return np.array((view.size, *tile.region, *tile.depth_region, slope, background / 255.0), layouts.TILE)
