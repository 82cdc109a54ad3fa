"""`gpu-xform animate`: from a model file to one that shows it moving."""

import argparse
import sys
import warnings
from typing import Any

from ...errors import ArgumentError, SizeWarning
from .. import argument_types as values
from .. import camera_options as aim
from .. import files
from .. import options as option_groups
from ..read_layers import naming, read_layers, require_scalars
from .transform import chosen_device, composed

SUMMARY = "draw models in motion, as a GIF, MP4 or page"
USAGE = "MODEL... -o OUT [options]"
DESCRIPTION = """\
Draw models that turn once, or that a matrix moves in each frame, as a file that
shows them moving."""
EPILOG = """\
The name of OUT says what is written: .gif, .png or .apng (animated), .webp,
.mp4, .webm, .html (a page with a player); with {frame} in it, or {frame:04} for
four digits, one PNG a frame. MP4 and WebM need PyAV: pip install
'gpu_xform[video]'. The camera stands where every frame fits the picture.

examples:
  gpu-xform animate ball.wrl -o ball.gif --turntable --color face
  gpu-xform animate part.stl -o part.mp4 --up +Z --edges feature,silhouette \\
      --frames 200 --fps 30 --resolution 1280x720
  gpu-xform animate house.obj -o "frames/{frame:04}.png" --rotate-x 20
  gpu-xform animate arm.ply -o arm.html --matrices poses.npy --no-background
"""
DEFAULT_FRAMES = 100


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `animate` to its parser."""
    group = parser.add_argument_group("files")
    option_groups.add_models(group)
    group.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        type=values.file_path,
        required=True,
        help="where to; its name says what is written",
    )
    option_groups.add_file_type(group)
    group = parser.add_argument_group("motion, after the transforms")
    either = group.add_mutually_exclusive_group()
    either.add_argument("--turntable", action="store_true", help="turn once, about the middle (the default)")
    either.add_argument("--matrices", metavar="NPY", help="an array (frames, 4, 4), one matrix a frame")
    group.add_argument(
        "--axis", metavar="DIR", type=values.direction, help="of the turn: X,Y,Z, +Z, ... (default: --up)"
    )
    group.add_argument("--frames", metavar="N", type=values.count, help=f"in a turn (default: {DEFAULT_FRAMES})")
    group.add_argument("--fps", metavar="N", type=values.rate, default="20", help="frames a second (default: 20)")
    option_groups.add_transforms(parser)
    option_groups.add_picture(parser)
    parser.set_defaults(resolution="640,480")
    option_groups.add_style(parser)
    option_groups.add_camera(parser)
    option_groups.add_rest(parser, adapter=True)


def animate(options: argparse.Namespace) -> int:
    """Draw models in motion."""
    aim.require_one_aim(options)
    require_scalars(options)
    if options.matrices is not None and (options.axis is not None or options.frames is not None):
        raise ArgumentError("--axis and --frames are for --turntable: there is one frame for each of the --matrices")
    from ... import animation

    paths = files.matching(options.models)
    shown = read_layers(options, paths, composed(options))
    arguments: dict[str, Any] = {
        "fps": options.fps,
        "size": options.resolution,
        "camera": aim.camera(options, shown),
        "background": options.background,
        "device": chosen_device(options),
    }
    with warnings.catch_warnings(record=True) as caught, naming(options, paths):
        warnings.simplefilter("always", SizeWarning)
        if options.matrices is None:
            axis = options.up if options.axis is None else options.axis
            n_frames = DEFAULT_FRAMES if options.frames is None else options.frames
            animation.turntable(shown, n_frames, options.output, axis=axis, **arguments)
        else:
            animation.animate(shown, files.read_stack(options.matrices, "frames"), options.output, **arguments)
    for warning in caught:
        sys.stderr.write(f"gpu-xform: warning: {warning.message}\n")
    return 0
