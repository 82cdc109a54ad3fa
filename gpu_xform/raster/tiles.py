"""Tiles: the rectangles of a picture that a device draws at once."""

from collections.abc import Iterator
from typing import NamedTuple

TILE_SIDE_PX = 2048  # a pixel takes up to fifty bytes on the device, beside the models


class Region(NamedTuple):
    """A rectangle of a picture: its first corner (x, y), and its (width, height), in pixels."""

    origin: tuple[int, int]
    extent: tuple[int, int]

    @property
    def slices(self) -> tuple[slice, slice]:
        """Its rows and columns in the picture."""
        (x, y), (width, height) = self
        return slice(y, y + height), slice(x, x + width)

    def padded(self, margin: int) -> "Region":
        """Return the region with `margin` more pixels on each side; it may reach out of the picture."""
        (x, y), (width, height) = self
        return Region((x - margin, y - margin), (width + 2 * margin, height + 2 * margin))


def split_into_tiles(region: Region, side: int) -> Iterator[Region]:
    """Split a region into tiles of at most `side` pixels each way, row by row."""
    (left, top), (width, height) = region
    for y in range(0, height, side):
        for x in range(0, width, side):
            yield Region((left + x, top + y), (min(side, width - x), min(side, height - y)))
