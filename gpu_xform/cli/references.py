"""Comparison of pictures with reference pictures, and their update."""

import contextlib
import os
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .._core.git_lfs import MAX_POINTER_BYTES, POINTER_WORDS, is_lfs_pointer
from ..errors import ArgumentError, GpuXformError
from . import files
from .arguments_from_options import collect_style_arguments
from .exit_codes import FAILURES, MismatchError
from .model_paths import list_near_models
from .outcome import DifferenceNumbers, Outcome
from .outputs import PlannedPicture
from .path_templates import Template

if TYPE_CHECKING:
    from PIL.Image import Image


# Pixels that may differ by more than the threshold, at any size, and per pixel of the picture: more than twice what was
# measured between drivers. docs/continuous_integration.md has the figures.
MIN_ALLOWED_PIXELS = 16
PIXELS_PER_ALLOWED_ONE = 10_000
MAX_SHOWN_PIXELS = 1 << 24  # of a reference in a report, if no picture of its size was asked for


class MissingReferenceError(ArgumentError):
    """A reference does not exist."""


def require_reference_options(options: Namespace) -> None:
    """Raise `ArgumentError` for options that mean nothing without --reference."""
    if options.reference is not None:
        return
    if options.output is None and not options.report and options.sheet is None:
        raise ArgumentError("-o must give the file of the picture, or --reference a picture to compare it with")
    for name in ("threshold", "pixels", "diff"):
        if getattr(options, f"reference_{name}") is not None:
            raise ArgumentError(f"--reference-{name} must come with --reference")
    if options.update_references:
        raise ArgumentError("--update-references must come with --reference")


def find_threshold(options: Namespace) -> float:
    """Return the largest difference of a pixel that still matches: the one typed, or the default."""
    from ..imaging.compare import DEFAULT_THRESHOLD

    return DEFAULT_THRESHOLD if options.reference_threshold is None else float(options.reference_threshold)


def compare_with_reference(image: "Image", outcome: Outcome, options: Namespace) -> None:
    """Compare a picture with its reference, and say in `outcome` how they differ.

    Raises `MismatchError` if they do not match, after writing the difference, and `MissingReferenceError`; with
    --update-references, writes the picture in place of the reference instead, and says so.
    """
    try:
        problem = _find_problem(image, outcome, options)
    except FAILURES:  # the picture is drawn: its reference cannot be read, or its difference not be written
        outcome.status = "no reference" if outcome.numbers is None else "differs"
        raise
    reference = outcome.picture.reference
    if problem is None:
        outcome.status = "matched"
        return
    if not options.update_references or reference is None:
        outcome.status = "differs" if isinstance(problem, MismatchError) else "no reference"
        raise problem
    files.write_picture(image, reference, make_folders=options.reference.is_per_model)
    is_new = isinstance(problem, MissingReferenceError)
    outcome.status = "added" if is_new else "updated"
    from .._core import progress

    change = "added" if is_new else f"updated: {str(problem).removeprefix(f'{reference}: ')}"
    progress.write_line(f"gpu-xform: {reference}: {change}")


def keep_reference(outcome: Outcome, options: Namespace) -> None:
    """Keep the picture of a reference that can be read for the report, also if the model's own cannot be drawn.

    A small file may declare any size: a large one that was not asked for is not decoded.
    """
    from ..imaging.image import find_size, to_pillow, to_pixels

    if outcome.picture.reference is not None:
        with contextlib.suppress(GpuXformError, OSError):
            size = find_size(outcome.picture.reference, "--reference")
            if size == options.resolution or size[0] * size[1] <= MAX_SHOWN_PIXELS:
                outcome.images["reference"] = to_pillow(to_pixels(outcome.picture.reference, "--reference"))


def find_unused_references(template: Template, pictures: Sequence[PlannedPicture], roots: Sequence[str]) -> list[str]:
    """Return the files that could be references by the template, but of no model of the pictures or near them.

    If neither the folder nor the names of references are apart from those of other files, none is found.

    roots : the folders that the models lie in or below; of a template with {folder}, no other's references are found
    """
    used = {os.path.realpath(picture.reference) for picture in pictures if picture.reference is not None}
    used |= {os.path.realpath(path) for picture in pictures for path in picture.written_paths}
    found = [path for path in _list_candidates(template, pictures) if template.matches(path)]
    found = [path for path in found if os.path.realpath(path) not in used and _is_within(template, path, roots)]
    others = list_near_models(roots) if found else []
    if others is None:
        return []
    used |= {os.path.realpath(template.path_for(model)) for model in others}
    return sorted(path for path in found if os.path.realpath(path) not in used)


def _is_within(template: Template, path: str, roots: Sequence[str]) -> bool:
    """Return whether the model of a reference would lie in or below one of `roots`, as far as the template says."""
    folder = template.folder_in(path)
    return folder is None or any(
        place == "." or Path(folder).is_relative_to(place) for place in map(template.folder_of, roots)
    )


def _list_candidates(template: Template, pictures: Sequence[PlannedPicture]) -> Iterator[str]:
    if not template.is_per_model:
        return
    if template.root:
        for folder, _, names in os.walk(template.root):
            yield from (os.path.join(folder, name) for name in names)  # noqa: PTH118 - written as the template is
    elif template.marks_names:
        for folder in sorted({os.path.dirname(picture.reference or "") for picture in pictures}):  # noqa: PTH120
            if Path(folder).is_dir():
                yield from (os.path.join(folder, path.name) for path in Path(folder).iterdir())  # noqa: PTH118


def _find_problem(image: "Image", outcome: Outcome, options: Namespace) -> GpuXformError | None:
    """Return why a picture does not match its reference, after writing the difference; None if it does."""
    from ..imaging.compare import compare_images
    from ..imaging.image import find_size, to_pixels

    reference = outcome.picture.reference
    if reference is None:
        return None
    if not Path(reference).exists():
        return MissingReferenceError(
            f"{reference}: the reference does not exist; if the picture is right, --update-references makes it one"
        )
    _require_content(reference)
    width, height = find_size(reference, "--reference")
    if image.size != (width, height):
        return MismatchError(
            f"{reference}: the reference is {width} x {height} pixels, the picture {image.width} x {image.height}"
        )
    threshold, allowed = find_threshold(options), options.reference_pixels
    if allowed is None:
        allowed = MIN_ALLOWED_PIXELS + width * height // PIXELS_PER_ALLOWED_ONE
    found = compare_images(image, to_pixels(reference, "--reference"), threshold=threshold)
    outcome.numbers = DifferenceNumbers(found.n_pixels, allowed, found.largest, found.largest_at, found.mean)
    if found.n_pixels <= allowed:
        return None
    if options.keeps_images:
        outcome.images["difference"] = found.image()
    if outcome.picture.difference is not None:
        files.write_picture(found.image(), outcome.picture.difference, make_folders=options.reference_diff.is_per_model)
    x, y = found.largest_at
    return MismatchError(
        f"{reference}: the picture differs by more than {threshold:g} of 255 in {found.n_pixels:,} pixels, "
        f"{allowed:,} allowed; the largest difference is {found.largest}, at {x},{y}, the mean {found.mean:.3g}"
        f"{_hint_at_style(outcome, options)}"
    )


def _hint_at_style(outcome: Outcome, options: Namespace) -> str:
    """Return what to say if the reference may be one of many pictures, which have another style by default."""
    if outcome.picture.is_one_of_many or collect_style_arguments(options):
        return ""
    return "; if it was drawn by a path with {model}, type that path: one picture per model has another default style"


def _require_content(reference: str) -> None:
    """Raise `ArgumentError` for what stands in a checkout for a file that has not been fetched."""
    with Path(reference).open("rb") as file:
        if is_lfs_pointer(file.read(MAX_POINTER_BYTES)):
            raise ArgumentError(f"{reference}: {POINTER_WORDS}")
