"""Plan of the pictures that `render` makes: which models each shows, and which paths belong to it."""

import os
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

from ..errors import ArgumentError
from .argument_types.paths import PAGE_TYPES, PICTURE_TYPES
from .path_templates import Template
from .paths import STDIO, describe_files, file_type, require_target, require_type


@dataclass(frozen=True)
class PlannedPicture:
    """The models of one picture, the file it goes to, and the files it is compared with.

    reference : the PNG file that the picture must match
    difference : the PNG file that shows where it does not
    is_one_of_many : whether there is a picture per model
    """

    models: Sequence[str]
    output: str | None
    reference: str | None
    difference: str | None
    _: KW_ONLY
    is_one_of_many: bool = False

    @property
    def name(self) -> str:
        """How messages name the picture."""
        return describe_files(self.models)

    @property
    def file_type(self) -> str:
        """One of PICTURE_TYPES or PAGE_TYPES: "png" if no path gives another."""
        return "png" if self.output is None or self.output == STDIO else file_type(self.output)

    @property
    def written_paths(self) -> list[str]:
        """The paths that may be written."""
        return [path for path in (self.output, self.difference) if path is not None]


def plan_outputs(
    models: Sequence[str],
    output: Template | None,
    reference: Template | None,
    difference: Template | None,
    *,
    updates_references: bool = False,
    others: Sequence[str] = (),
) -> list[PlannedPicture]:
    """Return one picture per model if a template is per model, or if there is none; else one picture of all models.

    updates_references : whether the references may be written, too
    others : paths of other files that will be written, of all pictures together

    Raises `ArgumentError` if a path has a type that cannot be written, or would be written twice.
    """
    if models.count(STDIO) > 1:
        raise ArgumentError("standard input can be read only once")
    templates = (output, reference, difference)
    given = [template for template in templates if template is not None]
    is_per_model = not given or any(template.is_per_model for template in given)
    pictures = []
    for group in [[model] for model in models] if is_per_model else [models]:
        paths = [None if template is None else template.path_for(group[0]) for template in templates]
        pictures.append(PlannedPicture(group, *paths, is_one_of_many=is_per_model))
    for picture in pictures:
        _require_types(picture)
        if updates_references and picture.reference is not None:
            require_target(picture.reference)
        for path in picture.written_paths:
            require_target(path)
    _require_distinct_paths(pictures, others, updates_references=updates_references)
    return pictures


def _require_types(picture: PlannedPicture) -> None:
    if picture.output is not None and picture.output != STDIO:
        _require_picture_type(picture.output, (*PICTURE_TYPES, *PAGE_TYPES))
    if picture.difference == STDIO:
        raise ArgumentError("--reference-diff must be a file: only the picture itself can go to standard output")
    if picture.difference is not None:
        require_type(picture.difference, ("png",))
    if picture.reference is not None and picture.file_type != "png":
        raise ArgumentError(f"{picture.output}: only a .png can be compared with a --reference")
    if picture.reference is not None:
        _require_picture_type(picture.reference, ("png",))


def _require_picture_type(path: str, known: Sequence[str]) -> None:
    """Raise `ArgumentError` if the type of a path is not known; without any, it is likely meant for a folder."""
    try:
        require_type(path, known)
    except ArgumentError as error:
        hint = "" if file_type(path) else f"; {path}/{{model}}.png is a picture per model in that folder"
        raise ArgumentError(f"{error}{hint}") from None


def _require_distinct_paths(
    pictures: Sequence[PlannedPicture], others: Sequence[str], *, updates_references: bool
) -> None:
    owners: dict[str, str] = {}
    for picture in pictures:
        for path in picture.written_paths:
            _claim(path, picture, owners)
    references = {_resolve_location(picture.reference) for picture in pictures if picture.reference is not None}
    for picture in pictures:
        if picture.reference is not None and _resolve_location(picture.reference) in owners:
            raise ArgumentError(f"{picture.reference}: a picture must not overwrite a reference")
    if updates_references:
        for picture in pictures:
            if picture.reference is not None:
                _claim(picture.reference, picture, owners)
    models = {_resolve_location(model) for picture in pictures for model in picture.models if model != STDIO}
    for path in others:
        location = _resolve_location(path)
        if location in owners.keys() | references | models or [*map(_resolve_location, others)].count(location) > 1:
            raise ArgumentError(f"{path}: another file of this run has that path")


def _claim(path: str, picture: PlannedPicture, owners: dict[str, str]) -> None:
    """Note that a picture is written to a path; raise `ArgumentError` if another one is."""
    location = _resolve_location(path)
    if location in owners:
        both = f"two pictures would be written there, of {owners[location]} and of {picture.name}"
        raise ArgumentError(f"{path}: {both}; {{suffix}}, {{parent}} or {{folder}} in its path may keep them apart")
    owners[location] = picture.name


def _resolve_location(path: str) -> str:
    return os.path.normcase(os.path.realpath(path))
