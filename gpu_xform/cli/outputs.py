"""Which models go into which pictures, and which paths belong to these."""

import os
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import ArgumentError
from . import files
from .path_templates import Template

PICTURE_TYPES = ("png", "svg", "pdf")


@dataclass(frozen=True)
class Picture:
    """The model files that are drawn together, where to, and what the result is compared with."""

    models: Sequence[str]
    output: str | None
    reference: str | None
    difference: str | None

    @property
    def name(self) -> str:
        """What messages call it."""
        return files.called(self.models)

    @property
    def kind(self) -> str:
        """One of PICTURE_TYPES: "png" where no path says otherwise."""
        return "png" if self.output is None or self.output == files.STANDARD else files.kind(self.output)

    @property
    def written(self) -> list[str]:
        """The paths that may be written."""
        return [path for path in (self.output, self.difference) if path is not None]


def planned(
    models: Sequence[str], output: Template | None, reference: Template | None, difference: Template | None
) -> list[Picture]:
    """Return one picture for each model where one of the paths says so, else one for all of them.

    Raises `ArgumentError` where a path has no type that can be written, or belongs to two things.
    """
    if models.count(files.STANDARD) > 1:
        raise ArgumentError("standard input can be read only once")
    templates = (output, reference, difference)
    one_for_each = any(template.one_for_each for template in templates if template is not None)
    pictures = [
        Picture(group, *(None if template is None else template.path(group[0]) for template in templates))
        for group in ([[model] for model in models] if one_for_each else [models])
    ]
    for picture in pictures:
        _require_types(picture)
    _require_apart(pictures)
    return pictures


def _require_types(picture: Picture) -> None:
    if picture.output is not None and picture.output != files.STANDARD:
        files.require_type(picture.output, PICTURE_TYPES)
    if picture.difference == files.STANDARD:
        raise ArgumentError("--reference-diff must be a file: only the picture itself can go to standard output")
    if picture.difference is not None:
        files.require_type(picture.difference, ("png",))
    if picture.reference is not None and picture.kind != "png":
        raise ArgumentError(f"{picture.output}: only a .png can be compared with a --reference")


def _require_apart(pictures: Sequence[Picture]) -> None:
    owners: dict[str, str] = {}
    for picture in pictures:
        for path in picture.written:
            place = os.path.normcase(os.path.realpath(path))
            if place in owners:
                raise ArgumentError(f"{path}: two pictures would go there, of {owners[place]} and of {picture.name}")
            owners[place] = picture.name
    for picture in pictures:
        if picture.reference is not None and os.path.normcase(os.path.realpath(picture.reference)) in owners:
            raise ArgumentError(f"{picture.reference}: a picture cannot take the place of a reference")
