"""The seam between rasterisers and what uses them: `Rasterizer` turns a draw list into a `PendingImage`."""

from typing import Protocol

from ..drawing.draw_list import DrawList
from ..drawing.view import View
from ..gpu.device import GpuDevice
from ..imaging.colors import Rgba
from ..imaging.image import Pixels


class PendingImage(Protocol):
    """A picture whose last tile is drawn, or being drawn, on its device; like `concurrent.futures.Future`."""

    @property
    def device(self) -> GpuDevice:
        """The device that draws it."""
        ...

    def result(self) -> Pixels:
        """Return (height, width, 4) uint8, straight alpha, once all is drawn; the same array each time."""
        ...

    def cancel(self) -> None:
        """Give the memory on the device back if the result has not been taken, and will not be."""
        ...

    def wait(self) -> None:
        """Wait until the result can be taken without waiting."""
        ...


class Rasterizer(Protocol):
    """Draws on one device."""

    def draw(
        self, draw_list: DrawList, view: View, background: Rgba, *, overlap_with: PendingImage | None = None
    ) -> PendingImage:
        """Begin to draw the filled faces of a draw list, then the lines of each drawable over those of the ones before.

        background : straight alpha
        overlap_with : a picture that was begun earlier. If the same device draws it, it is waited for once the first
            tile of this one is recorded, so that it can be read while that tile is drawn.
        """
        ...
