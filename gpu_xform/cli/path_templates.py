"""Paths that hold the name of a model."""

import re
from collections.abc import Callable
from pathlib import Path

from ..errors import ArgumentError
from .files import STANDARD

PLACEHOLDERS: dict[str, Callable[[Path], str]] = {
    "{model}": lambda model: model.stem,
    "{folder}": lambda model: str(model.parent),
}
DOUBLED = {"{{": "{", "}}": "}"}
BRACES = re.compile(r"\{\{|\}\}|\{[^{}]*\}|[{}]")


class Template:
    """A path in which {model} stands for a model's name without folder and type, and {folder} for its folder.

    Raises `ValueError` for other braces; those of the path itself are doubled.
    """

    def __init__(self, text: str) -> None:
        found = BRACES.findall(text)
        for braces in found:
            if braces not in PLACEHOLDERS | DOUBLED:
                allowed = " or ".join(PLACEHOLDERS)
                raise ValueError(f"expected {allowed}, or braces doubled, got {braces!r} in {text!r}")
        self._text = text
        self.one_for_each = not PLACEHOLDERS.keys().isdisjoint(found)

    def path(self, model: str) -> str:
        """Return the path that belongs to the model file `model`."""
        if self.one_for_each and model == STANDARD:
            raise ArgumentError(f"{self._text}: standard input has no name to put there")

        def meant(braces: re.Match[str]) -> str:
            return DOUBLED.get(braces[0]) or PLACEHOLDERS[braces[0]](Path(model))

        return BRACES.sub(meant, self._text)
