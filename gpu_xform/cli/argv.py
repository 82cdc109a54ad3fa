"""Command-line words around argparse: values that begin with a minus sign, and suggestions for unknown options."""

import argparse
import re
from collections.abc import Iterable, Sequence
from typing import Any

MIN_SIMILARITY = 0.65  # from 0 to 1; --width resembles --line-width, --angle does not resemble --scale


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


class OptionParser(argparse.ArgumentParser):
    """An argument parser that takes whole option names only, and suggests one for an unknown option."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, add_help=False, **settings)

    def did_you_mean(self, words: Iterable[str]) -> str:
        """Return a suggestion to append to an error: the options that resemble unknown ones among `words`, if any."""
        from difflib import get_close_matches

        known = [name.removeprefix("--") for name in self._option_string_actions if name.startswith("--")]
        typed = [word[2:].partition("=")[0] for word in words if word.startswith("--")]
        found = [f"--{close}" for name in typed for close in get_close_matches(name, known, 1, MIN_SIMILARITY)]
        return f"; did you mean {' and '.join(dict.fromkeys(found))}?" if found else ""
