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
    {folder} the path of that. Doubled braces stand for braces; other braces raise `ValueError`.
    """

    def __init__(self, text: str) -> None:
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
            return ESCAPES.get(braces[0]) or PLACEHOLDERS[braces[0]](Path(model))

        return BRACES.sub(substitute, self._text)

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
        regex = "".join(
            (".+" if part == "{folder}" else "[^/]+") if is_placeholder else re.escape(part)
            for part, is_placeholder in self._parts()
        )
        return re.fullmatch(regex, path, re.DOTALL) is not None

    def _parts(self) -> list[tuple[str, bool]]:
        """Return the text in parts, each with whether it is a placeholder."""
        return [
            (ESCAPES.get(part, part), part in PLACEHOLDERS)
            for part in re.split(f"({BRACES.pattern})", self._text)
            if part
        ]
