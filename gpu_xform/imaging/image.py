"""Pixel arrays and Pillow images: straight alpha, row 0 at the top."""

import io
import os
import struct
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import require_room
from .._core.git_lfs import POINTER_WORDS, is_lfs_pointer
from .._core.masked import require_whole
from .._core.targets import require_path
from .._core.types import StrPath
from ..errors import ArgumentError, ArgumentTypeError

if TYPE_CHECKING:
    from PIL.Image import Image

Pixels = npt.NDArray[np.uint8]
EIGHT_BIT_MODES = ("1", "L", "LA", "P", "PA", "RGB", "RGBA")  # Pillow clips the values of other modes at 255
_PNG_ERRORS = (OSError, SyntaxError, ValueError, OverflowError, MemoryError, struct.error, zlib.error)
ImageLike: TypeAlias = "Image | Pixels | StrPath"


def unpremultiply(premultiplied: Pixels) -> Pixels:
    """Return the pixels (..., 4) with their colours divided by alpha; if alpha is 0, the colours are 0 too."""
    alpha = premultiplied[..., 3]
    partial = (alpha > 0) & (alpha < 255)
    straight = premultiplied.copy()
    colors = premultiplied[partial].astype(np.uint32)
    opacity = colors[:, 3:]
    straight[partial, :3] = np.minimum((colors[:, :3] * 255 + opacity // 2) // opacity, 255)
    return straight


def premultiply(straight: Pixels) -> Pixels:
    """Return the pixels (..., 4) with their colours multiplied by alpha."""
    partial = straight[..., 3] < 255
    result = straight.copy()
    colors = straight[partial].astype(np.uint32)
    result[partial, :3] = (colors[:, :3] * colors[:, 3:] + 127) // 255
    return result


def to_pillow(pixels: Pixels) -> "Image":
    """Return the Pillow image, mode RGBA, of `pixels` (height, width, 4)."""
    from PIL import Image

    return Image.fromarray(pixels, "RGBA")


def to_pixels(picture: ImageLike, name: str) -> Pixels:
    """Return the pixels (height, width, 4) of an image, of an array (height, width, 3 or 4), or of a PNG file."""
    from PIL import Image

    if isinstance(picture, str | os.PathLike):
        return _decode_png(picture, name)
    if isinstance(picture, Image.Image):
        return _pillow_to_pixels(picture, name)
    require_whole(picture, name)
    try:
        array = np.asarray(picture)
    except ValueError as error:  # a ragged list
        raise ArgumentError.expecting(
            name, "be an image, an array of uint8 or a PNG file's path", reason=error
        ) from None
    require_room(array, name)
    if array.dtype != np.uint8:
        raise ArgumentTypeError.expecting(name, "be an image, an array of uint8 or a PNG file's path", array.dtype)
    if array.ndim != 3 or array.shape[2] not in {3, 4}:
        raise ArgumentError.expecting(name, "have shape (height, width, 3) or (height, width, 4)", array.shape)
    return array if array.shape[2] == 4 else np.pad(array, ((0, 0), (0, 0), (0, 1)), constant_values=255)


def find_size(picture: ImageLike, name: str) -> tuple[int, int]:
    """Return (width, height) of what `to_pixels` takes, without decoding a PNG file, which may declare any size."""
    if isinstance(picture, str | os.PathLike):
        return _open_png(picture, name).size
    width, height = getattr(picture, "size", (0, 0)) if hasattr(picture, "convert") else np.shape(picture)[1::-1]
    return int(width), int(height)


def _decode_png(path: StrPath, name: str) -> Pixels:
    picture = _open_png(path, name)
    try:
        picture.load()
    except _PNG_ERRORS as error:
        raise ArgumentError.expecting(name, "be a PNG file", repr(os.fspath(path)), reason=error) from None
    return _pillow_to_pixels(picture, name)


def _open_png(path: StrPath, name: str) -> "Image":
    from PIL.PngImagePlugin import PngImageFile  # Image.open refuses images as large as `render` makes them

    require_path(path, name)
    data = Path(path).read_bytes()
    if is_lfs_pointer(data):
        raise ArgumentError.expecting(name, "be a PNG file", f"{POINTER_WORDS}, at {os.fspath(path)!r}")
    try:
        return PngImageFile(io.BytesIO(data))
    except _PNG_ERRORS as error:
        raise ArgumentError.expecting(name, "be a PNG file", repr(os.fspath(path)), reason=error) from None


def _pillow_to_pixels(picture: "Image", name: str) -> Pixels:
    if picture.mode not in EIGHT_BIT_MODES:
        raise ArgumentError.expecting(name, f"have a mode of {', '.join(EIGHT_BIT_MODES)}", picture.mode)
    return np.asarray(picture.convert("RGBA"))
