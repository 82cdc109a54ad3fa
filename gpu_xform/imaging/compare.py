"""Comparison of a picture with a reference, pixel by pixel."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float
from .._core.public import public
from ..errors import ArgumentError
from .image import ImageLike, Pixels, find_size, premultiply, to_pillow, to_pixels

if TYPE_CHECKING:
    from PIL.Image import Image

DEFAULT_THRESHOLD = 8.0
DARKER_COLOR, LIGHTER_COLOR = (208, 0, 0, 255), (0, 80, 255, 255)


@dataclass(frozen=True, eq=False, repr=False)
class Difference:
    """The difference of a picture from its reference, in units of a channel, 0..255.

    Attributes
    ----------
    picture, reference : (height, width, 4) uint8
        The pixels, with colours multiplied by alpha.
    threshold : float
        A pixel counts as equal if its worst channel differs by no more.
    """

    picture: Pixels
    reference: Pixels
    threshold: float

    @cached_property
    def by_channel(self) -> Pixels:
        """The absolute difference in every channel of every pixel: (height, width, 4) uint8."""
        minimum: Pixels = np.minimum(self.picture, self.reference)
        return np.maximum(self.picture, self.reference) - minimum

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
        """The first pixel (x, y) with the largest difference; (0, 0) is at the top left."""
        y, x = np.unravel_index(self.by_pixel.argmax(), self.by_pixel.shape)
        return int(x), int(y)

    def image(self) -> Image:
        """Return the reference, faded, with the pixels that differ by more than the threshold in colour.

        A pixel is red if the picture is darker than the reference, both composited on white, and blue otherwise.

        Returns
        -------
        PIL.Image.Image
            Mode RGBA.
        """
        brightness, expected = _compute_brightness_on_white(self.picture), _compute_brightness_on_white(self.reference)
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
    """Compare two pictures of the same size, pixel by pixel.

    Colours are multiplied by alpha first, so the colour of a transparent pixel does not count.

    Parameters
    ----------
    picture, reference : Pillow image, (height, width, 3 or 4) uint8 array with straight alpha, or path of a PNG file
        The pictures to compare.
    threshold : float
        A pixel counts as equal if its worst channel differs by no more, of 255.

    Returns
    -------
    Difference
        The number of pixels that differ, by how much and where, and an image of the difference.

    Raises
    ------
    ArgumentError
        If the sizes differ, if a file or array is not a picture, and for an array that no memory holds or that a mask
        hides a part of.
    ArgumentTypeError
        For an array of another type than uint8.
    OSError
        If a file cannot be read.
    """
    threshold = as_float(threshold, "threshold")
    if not 0.0 <= threshold <= 255.0:
        raise ArgumentError.expecting("threshold", "be from 0 to 255", f"{threshold:g}")
    actual = to_pixels(picture, "picture")
    if actual.size == 0:
        raise ArgumentError.expecting("picture", "have pixels", "none")
    if isinstance(reference, str | os.PathLike):
        _require_size(actual, find_size(reference, "reference"))  # before a file is decoded, which may declare any
    expected = to_pixels(reference, "reference")
    _require_size(actual, (expected.shape[1], expected.shape[0]))
    return Difference(premultiply(actual), premultiply(expected), threshold)


def _require_size(picture: Pixels, size: tuple[int, int]) -> None:
    if picture.shape[1::-1] != size:
        sizes = [f"{width} x {height}" for width, height in (picture.shape[1::-1], size)]
        raise ArgumentError.expecting("reference", f"have the size of the picture, {sizes[0]}", sizes[1])


def _compute_brightness_on_white(pixels: Pixels) -> npt.NDArray[np.float64]:
    """Return the brightness, 0..255, of premultiplied pixels (height, width, 4) on a white background."""
    brightness: npt.NDArray[np.float64] = 255.0 - pixels[..., 3] + pixels[..., :3].mean(axis=2)
    return brightness
