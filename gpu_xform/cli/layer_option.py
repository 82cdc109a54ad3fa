"""`--layer`: further models of a picture, each with transforms and a style of its own."""

import argparse
import shlex
from typing import NoReturn

from . import files
from .argument_types import option_value
from .argv import OptionParser, attach_values


class _Parser(OptionParser):
    def error(self, message: str) -> NoReturn:
        raise ValueError(" ".join(message.split()))


@option_value
def further(text: str) -> argparse.Namespace:
    """Read models and their options, as after `gpu-xform render`."""
    from . import options as option_groups

    parser = _Parser()
    parser.add_argument("models", metavar="MODEL", nargs="+")
    option_groups.add_file_type(parser)
    option_groups.add_transforms(parser)
    option_groups.add_style(parser)
    options, rest = parser.parse_known_args(attach_values(shlex.split(text)))
    options.models += rest
    for path in options.models:
        if path.startswith("-"):
            raise ValueError(f"expected models with transforms and a style, got {path!r}{parser.meant([path])}")
        files.require_path(path)
    options.further = []
    return options
