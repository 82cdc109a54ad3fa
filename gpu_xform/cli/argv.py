"""Command-line words around argparse: values that begin with a minus sign, and suggestions for unknown options."""

import argparse
import os
import re
from collections.abc import Iterable, Sequence
from typing import Any

from .._core.suggestions import MIN_OPTION_SIMILARITY, did_you_mean, find_similar


def attach_values(argv: Sequence[str]) -> list[str]:
    """Join `--translate -0.5,2,0` and `--up -Z` with an equals sign: argparse takes such values for options."""
    attached: list[str] = []
    for i, argument in enumerate(argv):
        if argument == "--":
            return [*attached, *argv[i:]]
        is_value = re.match(r"-\.?\d|-[xyz]$", argument, re.IGNORECASE)
        if is_value and attached and re.fullmatch(r"--[a-z-]+", attached[-1]):
            attached[-1] += f"={argument}"
        else:
            attached.append(argument)
    return attached


def split_words(text: str, *, is_windows: bool = os.name == "nt") -> list[str]:
    """Split the text of an option into words as a shell does; on Windows, a backslash is a part of a path."""
    import shlex

    lexer = shlex.shlex(text, posix=True, punctuation_chars=False)
    lexer.whitespace_split, lexer.commenters = True, ""
    if is_windows:
        lexer.escape = ""
    return list(lexer)


class OptionParser(argparse.ArgumentParser):
    """An argument parser that takes whole option names only, and suggests one for an unknown option."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, add_help=False, **settings)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Raise an error with a suggestion for a value that is not among the choices of an option or a command."""
        if action.choices is not None and value not in action.choices:
            names = [str(choice) for choice in action.choices]
            message = f"expected {', '.join(names)}, got {value!r}{did_you_mean(str(value), names)}"
            raise argparse.ArgumentError(action, message)

    def did_you_mean(self, words: Iterable[str]) -> str:
        """Return a suggestion to append to an error: the options that resemble unknown ones among `words`, if any."""
        known = [name.removeprefix("--") for name in self._option_string_actions if name.startswith("--")]
        typed = [word[2:].partition("=")[0] for word in words if word.startswith("--")]
        found = [f"--{close}" for name in typed for close in find_similar(name, known, MIN_OPTION_SIMILARITY)]
        return f"; did you mean {' and '.join(dict.fromkeys(found))}?" if found else ""
