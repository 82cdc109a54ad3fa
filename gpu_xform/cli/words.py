"""The words of a command line, before argparse has them."""

import re
from collections.abc import Sequence


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
