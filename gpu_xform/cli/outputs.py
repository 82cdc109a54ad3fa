"""Plan of the pictures that `render` makes: which models each shows, and which paths belong to it."""

import os
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import ArgumentError
from .path_templates import Template
from .paths import STDIO, describe_files, file_type, require_target, require_type

PICTURE_TYPES = ("png", "svg", "pdf")


@dataclass(frozen=True)
class PlannedPicture:
    """The models of one picture, the file it goes to, and the files it is compared with.

    reference : the PNG file that the picture must match
    difference : the PNG file that shows where it does not
    """

    models: Sequence[str]
    output: str | None
    reference: str | None
    difference: str | None

    @property
    def name(self) -> str:
        """How messages name the picture."""
        return describe_files(self.models)

    @property
    def file_type(self) -> str:
        """One of PICTURE_TYPES: "png" if no path gives another."""
        return "png" if self.output is None or self.output == STDIO else file_type(self.output)

    @property
    def written_paths(self) -> list[str]:
        """The paths that may be written."""
        return [path for path in (self.output, self.difference) if path is not None]


def plan_outputs(
    models: Sequence[str], output: Template | None, reference: Template | None, difference: Template | None
) -> list[PlannedPicture]:
    """Return one picture per model if one of the templates is per model, else one picture of all models.

    Raises `ArgumentError` if a path has a type that cannot be written, or would be written twice.
    """
    if models.count(STDIO) > 1:
        raise ArgumentError("standard input can be read only once")
    templates = (output, reference, difference)
    is_per_model = any(template.is_per_model for template in templates if template is not None)
    pictures = [
        PlannedPicture(group, *(None if template is None else template.path_for(group[0]) for template in templates))
        for group in ([[model] for model in models] if is_per_model else [models])
    ]
    for picture in pictures:
        _require_types(picture)
        for path in picture.written_paths:
            require_target(path)
    _require_distinct_paths(pictures)
    return pictures


def _require_types(picture: PlannedPicture) -> None:
    if picture.output is not None and picture.output != STDIO:
        require_type(picture.output, PICTURE_TYPES)
    if picture.difference == STDIO:
        raise ArgumentError("--reference-diff must be a file: only the picture itself can go to standard output")
    if picture.difference is not None:
        require_type(picture.difference, ("png",))
    if picture.reference is not None and picture.file_type != "png":
        raise ArgumentError(f"{picture.output}: only a .png can be compared with a --reference")


def _require_distinct_paths(pictures: Sequence[PlannedPicture]) -> None:
    owners: dict[str, str] = {}
    for picture in pictures:
        for path in picture.written_paths:
            location = _resolve_location(path)
            if location in owners:
                raise ArgumentError(
                    f"{path}: two pictures would be written there, of {owners[location]} and of {picture.name}"
                )
            owners[location] = picture.name
    for picture in pictures:
        if picture.reference is not None and _resolve_location(picture.reference) in owners:
            raise ArgumentError(f"{picture.reference}: a picture must not overwrite a reference")


def _resolve_location(path: str) -> str:
    return os.path.normcase(os.path.realpath(path))
