"""The words of a command line, before argparse has them, and where it knows none of them."""

import argparse
import difflib
import re
from collections.abc import Iterable, Sequence
from typing import Any

ALIKE = 0.65  # of 1: --width is like --line-width, and --angle not like --scale


def attach_values(argv: Sequence[str]) -> list[str]:
    """Write `--translate -0.5,2,0` and `--up -Z` with an equals sign: argparse takes such values for options."""
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
    """An argument parser that takes its options by their whole names, and knows them."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, add_help=False, **settings)

    def meant(self, words: Iterable[str]) -> str:
        """Return which options may be meant by the unknown ones among `words`, to be put after what is wrong."""
        known = [name.removeprefix("--") for name in self._option_string_actions if name.startswith("--")]
        typed = [word[2:].partition("=")[0] for word in words if word.startswith("--")]
        found = [f"--{close}" for name in typed for close in difflib.get_close_matches(name, known, 1, ALIKE)]
        return f"; did you mean {' and '.join(dict.fromkeys(found))}?" if found else ""
