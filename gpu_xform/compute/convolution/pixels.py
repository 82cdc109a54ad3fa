"""Images as arrays (k, h, w, c): what callers hand over, and how results go back."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ...errors import ArgumentError, ArgumentTypeError
from .._arrays import as_host_array

if TYPE_CHECKING:
    from PIL.Image import Image

ImageLike: TypeAlias = "npt.ArrayLike | Image"

DTYPES = ("float32", "float64", "uint8", "uint16")
PILLOW_MODES = ("L", "LA", "RGB", "RGBA", "I;16", "F")
N_RGBA = 4
RGB = slice(0, 3)


@dataclass(frozen=True)
class Images:
    """Images of one size and type.

    pixels : (k, h, w, c)
    shape : of the caller's array
    picture : the caller's Pillow image, if it was one
    """

    pixels: npt.NDArray[Any]
    shape: tuple[int, ...]
    picture: "Image | None" = None

    def restore(self, pixels: npt.NDArray[Any]) -> "npt.NDArray[Any] | Image":
        """Return results (k, h, w, c) as the caller's kind of image."""
        if self.picture is None:
            return pixels.reshape(self.shape)
        from PIL import Image

        array = pixels[0, :, :, 0] if pixels.shape[-1] == 1 else pixels[0]
        if self.picture.mode == "LA":
            array = array[:, :, 2:]
        result = Image.fromarray(np.ascontiguousarray(array))
        result.info = {key: value for key, value in self.picture.info.items() if key != "transparency"}
        return result


def read_images(image: ImageLike, *, stack: bool) -> Images:
    """Return the pixels of a Pillow image or of an array (h, w) or (h, w, c), with k in front for a stack."""
    from PIL import Image

    if isinstance(image, Image.Image):
        return _read_pillow(image, stack=stack)
    array = as_host_array(image, "image")
    if array.dtype.newbyteorder("=").name not in DTYPES:
        raise ArgumentTypeError.expecting("image", f"hold {', '.join(DTYPES[:-1])} or {DTYPES[-1]}", array.dtype)
    n_axes = array.ndim - stack
    if n_axes not in {2, 3}:
        shapes = "(k, h, w) or (k, h, w, c) with stack=True" if stack else "(h, w) or (h, w, c)"
        raise ArgumentError.expecting("image", f"have shape {shapes}", array.shape)
    pixels = array if stack else array[None]
    pixels = pixels if n_axes == 3 else pixels[..., None]
    if 0 in pixels.shape[1:]:
        raise ArgumentError.expecting("image", "have pixels", array.shape)
    return Images(pixels.astype(pixels.dtype.newbyteorder("="), copy=False), array.shape)


def _read_pillow(image: "Image", *, stack: bool) -> Images:
    if stack:
        raise ArgumentError.expecting("image", "be an array with stack=True", "a Pillow image")
    if image.mode not in PILLOW_MODES:
        raise ArgumentError.expecting("image", f"have a mode of {', '.join(PILLOW_MODES)}", repr(image.mode))
    array = np.asarray(image.convert("RGBA") if image.mode == "LA" else image)
    if 0 in array.shape:
        raise ArgumentError.expecting("image", "have pixels", array.shape)
    return Images((array if array.ndim == 3 else array[..., None])[None], array.shape, image)


def opaque_alpha(dtype: np.dtype[Any]) -> float:
    """Return the alpha of an opaque pixel."""
    return float(np.iinfo(dtype).max) if dtype.kind == "u" else 1.0
