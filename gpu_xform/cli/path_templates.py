"""Path templates: placeholders in a path, such as `{model}`, stand for parts of a model's path."""

import os
import re
from collections.abc import Callable
from pathlib import Path

from ..errors import ArgumentError
from .paths import STDIO

PLACEHOLDERS: dict[str, Callable[[Path], str]] = {
    "{model}": lambda model: Path(model.stem).stem if model.name.lower().endswith(".copc.laz") else model.stem,
    "{suffix}": lambda model: model.suffix.removeprefix("."),
    "{parent}": lambda model: Path(os.path.abspath(model)).parent.name,  # noqa: PTH100 - links stay as they are named
    "{folder}": lambda model: str(model.parent),
}
PLACEHOLDERS_IN_WORDS = f"{', '.join([*PLACEHOLDERS][:-1])} or {[*PLACEHOLDERS][-1]}"
ESCAPES = {"{{": "{", "}}": "}"}
BRACES = re.compile(r"\{\{|\}\}|\{[^{}]*\}|[{}]")


class Template:
    """A path in which placeholders stand for parts of the path of a model.

    {model} is its name without folder and type, {suffix} its type without the dot, {parent} the name of its folder, and
    {folder} the path of that. Behind the name of a folder, {folder} never leads out of it: the steps upwards of
    ../models are left out. Doubled braces stand for braces; other braces raise `ValueError`.
    """

    def __init__(self, text: str) -> None:
        if os.path.split(text)[1] in ("", "."):
            is_folder = text.endswith("/") and not Path(text).suffix
            hint = f"; {text}{{model}}.png is a file per model in that folder" if is_folder else ""
            raise ValueError(f"expected the path of a file, got {text!r}{hint}")
        found = BRACES.findall(text)
        for braces in found:
            if braces not in PLACEHOLDERS | ESCAPES:
                raise ValueError(f"expected {PLACEHOLDERS_IN_WORDS}, or doubled braces, got {braces!r} in {text!r}")
        self._text = text
        self.is_per_model = not PLACEHOLDERS.keys().isdisjoint(found)

    def path_for(self, model: str) -> str:
        """Return the path for the model file `model`."""
        if self.is_per_model and model == STDIO:
            raise ArgumentError(f"{self._text}: standard input has no name to insert")

        def substitute(braces: re.Match[str]) -> str:
            if braces[0] == "{folder}":
                return self.folder_of(str(Path(model).parent), braces.start())
            return ESCAPES.get(braces[0]) or PLACEHOLDERS[braces[0]](Path(model))

        return BRACES.sub(substitute, self._text)

    def folder_of(self, folder: str, start: int | None = None) -> str:
        """Return what stands for {folder}, by default for the first, of models in a folder."""
        before = self._text[: self._text.index("{folder}") if start is None else start]
        return folder if os.path.normpath(before) == "." else _stay_below(folder)

    @property
    def root(self) -> str:
        """The folder of the path as far as it is the same for all models; "" if it is not at all."""
        literal, is_cut = "", False
        for part, is_placeholder in self._parts():
            is_cut = is_cut or is_placeholder
            literal += "" if is_cut else part
        return os.path.dirname(literal)  # noqa: PTH120 - "" and ".", which Path makes one, differ here

    @property
    def marks_names(self) -> bool:
        """Whether names of files alone say that they are of the template, as those of `{model}.expected.png` do."""
        rest = "".join(" " if is_placeholder else part for part, is_placeholder in self._parts())
        return Path(rest).stem.strip() != ""

    def matches(self, path: str) -> bool:
        """Whether there could be a model whose path by the template is `path`."""
        return self._match(path) is not None

    def folder_in(self, path: str) -> str | None:
        """Return what stands for {folder} in a path that matches; None if the template has none."""
        match = self._match(path)
        return match["folder"] if match is not None and "folder" in match.re.groupindex else None

    def _match(self, path: str) -> re.Match[str] | None:
        regex = "".join(
            (".+" if part == "{folder}" else "[^/]+") if is_placeholder else re.escape(part)
            for part, is_placeholder in self._parts()
        )
        return re.fullmatch(regex.replace(".+", "(?P<folder>.+)", 1), path, re.DOTALL)

    def _parts(self) -> list[tuple[str, bool]]:
        """Return the text in parts, each with whether it is a placeholder."""
        return [
            (ESCAPES.get(part, part), part in PLACEHOLDERS)
            for part in re.split(f"({BRACES.pattern})", self._text)
            if part
        ]


def _stay_below(folder: str) -> str:
    """Return a folder without the steps upwards that it begins with, by which it would leave the one before it."""
    if ".." not in Path(folder).parts:
        return folder
    return str(Path(*(part for part in Path(os.path.normpath(folder)).parts if part != "..")))
