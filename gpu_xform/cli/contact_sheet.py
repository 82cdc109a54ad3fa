"""Contact sheet of the models of a run."""

from argparse import Namespace
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..errors import ArgumentError
from . import files
from .option_errors import name_options_in_errors
from .outputs import PlannedPicture
from .paths import file_type


def require_sheet_options(options: Namespace, pictures: Sequence[PlannedPicture]) -> None:
    """Raise `ArgumentError` for a sheet of one picture, or with a page."""
    if options.sheet is None:
        return
    if not pictures[0].is_one_of_many:
        raise ArgumentError("--sheet must go with one picture per model: {model} in the path of -o or --reference")
    given = [name for name in ("paper", "drawing_scale", "margin", "units") if getattr(options, name) is not None]
    if given:
        raise ArgumentError(f"--{given[0].replace('_', '-')} cannot go with --sheet, which has a page of its own")


class SheetOfModels:
    """The contact sheet at the path of --sheet, which models are added to one by one."""

    def __init__(self, options: Namespace, models: Sequence[str]) -> None:
        from ..rendering.contact_sheet import ContactSheet

        self._path: str = options.sheet
        self._places = {model: i for i, model in enumerate(models)}
        self._raster = {"rasterizer": options.rasterizer} if file_type(options.sheet) == "png" else {}
        with name_options_in_errors(options, models):
            self._sheet = ContactSheet(
                make_distinct_names(models),
                options.resolution,
                file_type(options.sheet),
                background=options.background,
                font=options.font,
            )

    @property
    def tile(self) -> tuple[int, int]:
        """The size of each picture in pixels."""
        return self._sheet.tile

    def add(self, model: str, layers: Sequence[Any], arguments: dict[str, Any]) -> None:
        """Draw a model with the keywords that all renderers share."""
        self._sheet.add(self._places[model], layers, arguments, **self._raster)

    def write(self) -> None:
        """Write the sheet; missing folders are made."""
        files.write_picture(self._sheet.finish(), self._path, make_folders=True)


def make_distinct_names(models: Sequence[str]) -> list[str]:
    """Return the shortest names that tell models apart: without folder and type, with their type, or the whole path."""
    paths = [Path(model) for model in models]
    stems, names = Counter(path.stem for path in paths), Counter(path.name for path in paths)
    return [path.stem if stems[path.stem] == 1 else path.name if names[path.name] == 1 else str(path) for path in paths]
