"""Comparison of pictures with reference pictures."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import ArgumentError
from . import files
from .exit_codes import MismatchError

if TYPE_CHECKING:
    from PIL.Image import Image


def require_reference_options(options: Namespace) -> None:
    """Raise `ArgumentError` for options that mean nothing without --reference."""
    if options.reference is not None:
        return
    if options.output is None:
        raise ArgumentError("-o must give the file of the picture, or --reference a picture to compare it with")
    for name in ("threshold", "pixels", "diff"):
        if getattr(options, f"reference_{name}") is not None:
            raise ArgumentError(f"--reference-{name} must come with --reference")


def require_match(reference: str, image: "Image", difference: str | None, options: Namespace) -> None:
    """Raise `MismatchError` if `image` does not match the PNG file `reference`, after writing `difference`."""
    from ..imaging.compare import DEFAULT_THRESHOLD, compare_images
    from ..imaging.image import find_size, to_pixels

    if not Path(reference).exists():
        raise ArgumentError(
            f"{reference}: the reference does not exist; to make it, give -o {reference} instead of --reference"
        )
    width, height = find_size(reference, "--reference")
    if image.size != (width, height):
        raise MismatchError(
            f"{reference}: the reference is {width} x {height} pixels, the picture {image.width} x {image.height}"
        )
    threshold = DEFAULT_THRESHOLD if options.reference_threshold is None else options.reference_threshold
    allowed = options.reference_pixels or 0
    found = compare_images(image, to_pixels(reference, "--reference"), threshold=threshold)
    if found.n_pixels <= allowed:
        return
    if difference is not None:
        files.write_picture(found.image(), difference, make_folders=options.reference_diff.is_per_model)
    x, y = found.largest_at
    raise MismatchError(
        f"{reference}: the picture differs by more than {threshold:g} of 255 in {found.n_pixels:,} pixels, "
        f"{allowed:,} allowed; the largest difference is {found.largest}, at {x},{y}, the mean {found.mean:.3g}"
    )
