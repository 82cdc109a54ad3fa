"""How far a picture is from the one it should be."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float
from .._core.public import public
from ..errors import ArgumentError
from .image import ImageLike, Pixels, premultiply, to_pillow, to_pixels

if TYPE_CHECKING:
    from PIL.Image import Image

DEFAULT_THRESHOLD = 8.0
DARKER_COLOR, LIGHTER_COLOR = (208, 0, 0, 255), (0, 80, 255, 255)


@dataclass(frozen=True, eq=False, repr=False)
class Difference:
    """What sets a picture apart from its reference, in units of a channel, 0..255.

    picture, reference : (height, width, 4) uint8, the colours multiplied by alpha
    threshold : by how much a pixel may differ in its worst channel and count as equal
    """

    picture: Pixels
    reference: Pixels
    threshold: float

    @cached_property
    def by_channel(self) -> Pixels:
        """The absolute difference in every channel of every pixel: (height, width, 4) uint8."""
        darker_of_two: Pixels = np.minimum(self.picture, self.reference)
        return np.maximum(self.picture, self.reference) - darker_of_two

    @cached_property
    def by_pixel(self) -> Pixels:
        """The difference of every pixel in its worst channel: (height, width) uint8."""
        worst: Pixels = self.by_channel.max(axis=2)
        return worst

    @property
    def n_pixels(self) -> int:
        """The number of pixels that differ by more than the threshold."""
        return int(np.count_nonzero(self.by_pixel > self.threshold))

    @property
    def mean(self) -> float:
        """The mean over all channels of all pixels."""
        return float(self.by_channel.mean())

    @property
    def largest(self) -> int:
        """The largest difference."""
        return int(self.by_pixel.max())

    @property
    def largest_at(self) -> tuple[int, int]:
        """Where the largest difference is, the first of several: the pixel (x, y), (0, 0) at the top left."""
        y, x = np.unravel_index(self.by_pixel.argmax(), self.by_pixel.shape)
        return int(x), int(y)

    def image(self) -> "Image":
        """Return the reference, pale, with the pixels in colour that differ by more than the threshold.

        They are red where the picture is darker than the reference, both on white, and blue where it is not.
        """
        brightness, expected = _composite_on_white(self.picture), _composite_on_white(self.reference)
        different = self.by_pixel > self.threshold
        shown = np.full_like(self.picture, 255)
        shown[..., :3] = (191 + expected / 4)[..., np.newaxis]
        shown[different & (brightness < expected)] = DARKER_COLOR
        shown[different & (brightness >= expected)] = LIGHTER_COLOR
        return to_pillow(shown)

    def __repr__(self) -> str:
        height, width = self.by_pixel.shape
        where = f" at {self.largest_at}" if self.largest else ""
        return (
            f"<Difference: {self.n_pixels} of {width} x {height} pixels by more than {self.threshold:g}, "
            f"largest {self.largest}{where}, mean {self.mean:.3g}>"
        )


@public
def compare_images(picture: ImageLike, reference: ImageLike, *, threshold: float = DEFAULT_THRESHOLD) -> Difference:
    """Compare two pictures of one size, pixel by pixel.

    Colours are multiplied by alpha before: what a transparent pixel would show does not count.

    picture, reference : Pillow images, (height, width, 3 or 4) uint8 arrays with straight alpha, or paths of PNG files
    threshold : by how much of 255 a pixel may differ in its worst channel and count as equal

    Raises `ArgumentError` for different sizes and for what is no picture; a missing file as `OSError`.
    """
    threshold = as_float(threshold, "threshold")
    if not 0.0 <= threshold <= 255.0:
        raise ArgumentError.expecting("threshold", "be from 0 to 255", f"{threshold:g}")
    one, other = to_pixels(picture, "picture"), to_pixels(reference, "reference")
    if one.size == 0:
        raise ArgumentError.expecting("picture", "have pixels", "none")
    if one.shape != other.shape:
        sizes = [f"{shape[1]} x {shape[0]}" for shape in (one.shape, other.shape)]
        raise ArgumentError.expecting("reference", f"have the size of the picture, {sizes[0]}", sizes[1])
    return Difference(premultiply(one), premultiply(other), threshold)


def _composite_on_white(pixels: Pixels) -> npt.NDArray[np.float64]:
    """Return the brightness, 0..255, of premultiplied pixels (height, width, 4) on a white ground."""
    brightness: npt.NDArray[np.float64] = 255.0 - pixels[..., 3] + pixels[..., :3].mean(axis=2)
    return brightness
