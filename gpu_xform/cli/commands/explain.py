"""`gpu-xform explain`: the matrices of a transform, printed."""

import argparse

from ... import matrices
from ...errors import ArgumentError
from .. import options as groups
from ..argument_types import vectors
from ..streams import print_stdout

USAGE = "[options]"
DESCRIPTION = "Print the matrix of each transform, their product, and the images of a point."
EPILOG = """\
example:
  gpu-xform explain --scale 0.3 --rotate-z 90 --translate -0.5,2,0 --point 1,1,0
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `explain`."""
    groups.add_transforms(parser)
    parser.add_argument_group("point").add_argument(
        "--point", metavar="X,Y,Z", type=vectors.parse_point, help="print this point after each transform"
    )
    groups.add_general_options(parser, adapter=False)


def run(options: argparse.Namespace) -> int:
    """Print matrices."""
    if not options.steps:
        raise ArgumentError("explain needs a transform, such as --rotate-z 90")
    print_stdout(matrices.explain(*options.steps, point=options.point) + "\n")
    return 0
