"""`gpu-xform convolve`: an image through a kernel."""

import argparse
from typing import Any

import numpy as np

from ...errors import ArgumentError
from .. import options as groups
from ..argument_types import numbers, paths, vectors
from ..arguments_from_options import choose_device
from ..image_files import FORMATS, read_image, require_image_type, write_image
from ..paths import require_target
from ..stage_times import report_stage

USAGE = "IN OUT (--gaussian S | --kernel NAME | ...) [options]"
DESCRIPTION = """\
Convolve an image with a kernel: every pixel becomes a weighted sum of its
neighbours, rounded to the nearest."""
EPILOG = """\
examples:
  gpu-xform convolve photo.png soft.png --gaussian 2
  gpu-xform convolve photo.jpg sharp.png --kernel sharpen
  gpu-xform convolve photo.png slope.png --matrix "1,0,-1; 2,0,-2; 1,0,-1"
"""

# Those of `compute.convolution`, whose import would take longer than printing the help.
KERNELS = ("blur", "edges", "emboss", "identity", "laplace", "sharpen", "sobel-x", "sobel-y")
BORDERS = ("reflect", "symmetric", "edge", "wrap", "constant")
ALPHAS = ("premultiplied", "independent", "keep")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `convolve`."""
    group = parser.add_argument_group("files")
    group.add_argument("input", metavar="IN", type=paths.parse_file_path, help="an image; - for standard input")
    group.add_argument(
        "output",
        metavar="OUT",
        type=paths.parse_file_path,
        help=f"the result: {', '.join(FORMATS)}; - for PNG on standard output",
    )
    group = parser.add_argument_group("kernel")
    kernel = group.add_mutually_exclusive_group(required=True)
    kernel.add_argument(
        "--gaussian",
        metavar="S",
        type=numbers.parse_sigma,
        help="a Gaussian of this standard deviation in pixels, or of a vertical and a horizontal one, S,S",
    )
    kernel.add_argument("--box", metavar="N", type=numbers.parse_box_side, help="the mean of N by N pixels, N odd")
    kernel.add_argument("--kernel", metavar="NAME", choices=KERNELS, help=f"{', '.join(KERNELS[:-1])} or {KERNELS[-1]}")
    kernel.add_argument(
        "--matrix",
        metavar="M",
        type=vectors.parse_kernel,
        help="rows of numbers, separated by semicolons, or a file of them",
    )
    group = parser.add_argument_group("filtering")
    group.add_argument(
        "--border",
        metavar="HOW",
        choices=BORDERS,
        default="reflect",
        help=f"how the image goes on beyond its sides: {', '.join(BORDERS[:-1])} or {BORDERS[-1]} (default: reflect)",
    )
    group.add_argument(
        "--alpha",
        metavar="HOW",
        choices=ALPHAS,
        help="premultiplied: colours are weighted by alpha; independent: alpha is one more channel; keep: alpha stays "
        "(default: premultiplied, or keep if the kernel's sum is not positive)",
    )
    group.add_argument("--linear", action="store_true", help="filter light instead of sRGB values")
    group.add_argument("--correlate", action="store_true", help="do not flip the kernel")
    groups.add_general_options(parser, adapter=True)


def run(options: argparse.Namespace) -> int:
    """Convolve an image."""
    require_target(options.output)
    require_image_type(options.output)
    with report_stage(f"read {options.input}"):
        image = read_image(options.input)
    from ...compute.convolution.convolve import convolve, correlate

    kernel = _choose_kernel(options)
    total = np.outer(*kernel).sum() if isinstance(kernel, tuple) else kernel.sum()
    apply = correlate if options.correlate else convolve
    device = choose_device(options)
    try:
        with report_stage("convolved"):
            result = apply(
                image,
                kernel,
                border=options.border,
                alpha=options.alpha or ("premultiplied" if total > 0.0 else "keep"),
                linear=options.linear,
                device=device,
            )
    except ArgumentError as error:
        raise ArgumentError(f"{options.input}: {error}") from None
    with report_stage(f"wrote {options.output}"):
        write_image(result, options.output)
    return 0


def _choose_kernel(options: argparse.Namespace) -> Any:
    from ...compute.convolution.filters import NAMED_KERNELS, box_kernel, gaussian

    if options.gaussian is not None:
        return gaussian(options.gaussian)
    if options.box is not None:
        return box_kernel(options.box)
    return options.matrix if options.matrix is not None else NAMED_KERNELS[options.kernel]()
