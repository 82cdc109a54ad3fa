"""`gpu-xform bench`: the speed of bulk transforms, printed."""

import argparse

from .. import options as groups
from ..argument_types import numbers
from ..arguments_from_options import choose_device
from ..streams import print_stdout

USAGE = "[options]"
DESCRIPTION = """\
Measure how fast one affine matrix transforms arrays of points: the first call
and later ones, their upload, kernel and download, beside plain copies of the
same bytes, beside NumPy and beside the host device. Each result is checked
first."""
EPILOG = """\
examples:
  gpu-xform bench
  gpu-xform bench --adapter host
  gpu-xform bench --points 1e5,4e6 --dtype float64 --json
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `bench`."""
    group = parser.add_argument_group("input")
    group.add_argument(
        "--points",
        metavar="N[,N...]",
        type=numbers.parse_point_counts,
        default="1e4,1e6,8e6",
        help="numbers of points (default: %(default)s)",
    )
    group.add_argument(
        "--dtype",
        choices=("float32", "float64"),
        default="float32",
        help="data type of the points (default: %(default)s)",
    )
    groups.add_json(parser, "measurements")
    groups.add_general_options(parser, adapter=True)


def run(options: argparse.Namespace) -> int:
    """Measure bulk transforms."""
    from ..._core import progress
    from ...diagnostics.bench import measure
    from ...diagnostics.bench_report import to_json, to_text

    device = choose_device(options)
    timings = []
    with progress.show_progress("bench", " sizes") as move:
        for done, n_points in enumerate(options.points, 1):
            timings.append(measure(device, n_points, options.dtype))
            move(done, len(options.points))
    format_report = to_json if options.json else to_text
    print_stdout(format_report(device, options.dtype, timings))
    return 0
