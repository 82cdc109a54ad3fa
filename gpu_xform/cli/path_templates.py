"""Path templates: `{model}` and `{folder}` in a path stand for parts of a model's path."""

import re
from collections.abc import Callable
from pathlib import Path

from ..errors import ArgumentError
from .paths import STDIO

PLACEHOLDERS: dict[str, Callable[[Path], str]] = {
    "{model}": lambda model: model.stem,
    "{folder}": lambda model: str(model.parent),
}
ESCAPES = {"{{": "{", "}}": "}"}
BRACES = re.compile(r"\{\{|\}\}|\{[^{}]*\}|[{}]")


class Template:
    """A path in which {model} stands for a model's name without folder and type, and {folder} for its folder.

    Doubled braces stand for braces; other braces raise `ValueError`.
    """

    def __init__(self, text: str) -> None:
        found = BRACES.findall(text)
        for braces in found:
            if braces not in PLACEHOLDERS | ESCAPES:
                allowed = " or ".join(PLACEHOLDERS)
                raise ValueError(f"expected {allowed}, or doubled braces, got {braces!r} in {text!r}")
        self._text = text
        self.is_per_model = not PLACEHOLDERS.keys().isdisjoint(found)

    def path_for(self, model: str) -> str:
        """Return the path for the model file `model`."""
        if self.is_per_model and model == STDIO:
            raise ArgumentError(f"{self._text}: standard input has no name to insert")

        def substitute(braces: re.Match[str]) -> str:
            return ESCAPES.get(braces[0]) or PLACEHOLDERS[braces[0]](Path(model))

        return BRACES.sub(substitute, self._text)
