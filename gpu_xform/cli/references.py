"""Pictures held against those that they should be like."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import ArgumentError
from . import files
from .exit_codes import DifferentError

if TYPE_CHECKING:
    from PIL.Image import Image


def require_options_together(options: Namespace) -> None:
    """Raise `ArgumentError` for options that mean nothing without --reference."""
    if options.reference is not None:
        return
    if options.output is None:
        raise ArgumentError("-o must say where the picture goes, or --reference what it should be like")
    for name in ("threshold", "pixels", "diff"):
        if getattr(options, f"reference_{name}") is not None:
            raise ArgumentError(f"--reference-{name} must come with --reference")


def require_like(reference: str, image: "Image", difference: str | None, options: Namespace) -> None:
    """Raise `DifferentError` where `image` is not like the PNG file `reference`, with `difference` drawn before."""
    from ..imaging.compare import THRESHOLD, compare_images
    from ..imaging.image import pixels

    if not Path(reference).exists():
        raise ArgumentError(f"{reference}: there is no such reference; -o {reference} instead of --reference makes it")
    expected = pixels(reference, "--reference")
    height, width = expected.shape[:2]
    if image.size != (width, height):
        raise DifferentError(
            f"{reference}: the reference is {width} x {height} pixels, the picture {image.width} x {image.height}"
        )
    threshold = THRESHOLD if options.reference_threshold is None else options.reference_threshold
    allowed = options.reference_pixels or 0
    found = compare_images(image, expected, threshold=threshold)
    if found.n_pixels <= allowed:
        return
    if difference is not None:
        files.write_picture(found.image(), difference, make_folders=options.reference_diff.one_for_each)
    x, y = found.largest_at
    raise DifferentError(
        f"{reference}: the picture differs from it by more than {threshold:g} of 255 in {found.n_pixels:,} pixels, "
        f"allowed are {allowed:,}; the largest difference is {found.largest}, at {x},{y}, the mean {found.mean:.3g}"
    )
