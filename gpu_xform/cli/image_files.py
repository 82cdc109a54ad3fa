"""Image files of every kind that Pillow reads and writes, or PNG through standard streams."""

import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from .._core.git_lfs import POINTER_WORDS, is_lfs_pointer
from ..errors import ArgumentError
from . import files
from .paths import STDIO, file_type, require_type
from .streams import get_binary_stream, print_notice

if TYPE_CHECKING:
    from PIL.Image import Image

# File types that can be written, by Pillow's names of their formats.
FORMATS = {
    "bmp": "BMP",
    "jpeg": "JPEG",
    "jpg": "JPEG",
    "png": "PNG",
    "tif": "TIFF",
    "tiff": "TIFF",
    "webp": "WEBP",
}
JPEG_QUALITY = 95  # of 100: less would show more than a gentle filter does


def read_image(path: str) -> "Image":
    """Read the image in `path`, upright, with colours instead of a palette, and with alpha if it is transparent."""
    from PIL import Image, ImageOps, UnidentifiedImageError

    data = get_binary_stream("stdin").read() if path == STDIO else Path(path).read_bytes()
    if is_lfs_pointer(data):
        raise ArgumentError(f"{path}: {POINTER_WORDS}")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # twice as many pixels are an error
        try:
            stored = Image.open(io.BytesIO(data))
            stored.load()
            image: Image.Image = ImageOps.exif_transpose(stored)
        except UnidentifiedImageError:
            raise ArgumentError(f"{path}: it is not a picture that Pillow reads") from None
        except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
            raise ArgumentError(f"{path}: expected a picture that Pillow reads: {error}") from None
    for warning in caught:
        print_notice(f"warning: {path}: {' '.join(str(warning.message).split())}")
    if image.has_transparency_data and image.mode not in ("LA", "RGBA"):
        return image.convert("RGBA")
    return image.convert({"1": "L", "P": "RGB"}.get(image.mode, image.mode))


def require_image_type(path: str) -> None:
    """Raise `ArgumentError` if images of the type of `path` cannot be written."""
    if path != STDIO:
        require_type(path, FORMATS)


def write_image(image: "Image", path: str) -> None:
    """Write an image to `path`, in the format that its name ends in."""
    name = "PNG" if path == STDIO else FORMATS[file_type(path)]
    encoded = io.BytesIO()
    try:
        image.save(encoded, name, **({"quality": JPEG_QUALITY} if name == "JPEG" else {}))
    except (OSError, ValueError) as error:  # for instance alpha in JPEG
        raise ArgumentError(f"{path}: {error}") from None
    files.write_picture(encoded.getvalue(), path, make_folders=False)
