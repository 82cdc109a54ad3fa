"""Pixels as the library hands them out: straight alpha, row 0 at the top."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from PIL.Image import Image

Pixels = npt.NDArray[np.uint8]


def straight_alpha(premultiplied: Pixels) -> Pixels:
    """Return the pixels (..., 4) with their colours divided by alpha; where alpha is 0, so are the colours."""
    alpha = premultiplied[..., 3]
    partial = (alpha > 0) & (alpha < 255)
    straight = premultiplied.copy()
    colors = premultiplied[partial].astype(np.uint32)
    opacity = colors[:, 3:]
    straight[partial, :3] = np.minimum((colors[:, :3] * 255 + opacity // 2) // opacity, 255)
    return straight


def image(pixels: Pixels) -> "Image":
    """Return the Pillow image, mode RGBA, of `pixels` (height, width, 4)."""
    from PIL import Image

    return Image.fromarray(pixels, "RGBA")
