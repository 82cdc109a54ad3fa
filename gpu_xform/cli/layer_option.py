"""The option --layer: more models for a picture, with their own transforms and style."""

import argparse
from typing import NoReturn

from . import options as groups
from .argument_types.texts import argument_type
from .argv import OptionParser, attach_values, split_words
from .paths import require_path


class _LayerParser(OptionParser):
    def error(self, message: str) -> NoReturn:
        raise ValueError(" ".join(message.split()))


@argument_type
def parse_layer(text: str) -> argparse.Namespace:
    """Parse models and their options, written as after `gpu-xform render`."""
    parser = _LayerParser()
    parser.add_argument("models", metavar="MODEL", nargs="+")
    groups.add_reading_options(parser)
    groups.add_pose(parser)
    groups.add_parts(parser)
    groups.add_transforms(parser)
    groups.add_style(parser)
    options, rest = parser.parse_known_args(attach_values(split_words(text)))
    options.models += rest
    for path in options.models:
        if path.startswith("-"):
            raise ValueError(f"expected models with transforms and a style, got {path!r}{parser.did_you_mean([path])}")
        require_path(path)
    options.extra_layers = []
    return options
