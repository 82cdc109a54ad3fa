"""The options of `gpu-xform` and its help."""

import argparse
import functools
import re
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from .. import __version__
from . import commands, values
from .commands import DEVICE_FAILED, NO_ADAPTER, WRONG_INPUT

HELP_COLUMN = 31

DESCRIPTION = "Bulk homogeneous transforms and wireframe pictures on any GPU, or on none."
EPILOG = f"""\
examples:
  gpu-xform render house.obj -o house.png --rotate-y 30 --color face
  gpu-xform transform scan.ply moved.ply --scale 0.001 --translate -0.5,2,0
  gpu-xform explain --scale 0.3 --rotate-z 90 --translate -0.5,2,0 --point 1,1,0
  gpu-xform doctor
  gpu-xform bench

exit codes:
  0  done
  {DEVICE_FAILED}  the device failed, or computes wrongly
  {WRONG_INPUT}  wrong usage or input
  {NO_ADAPTER}  no graphics adapter: gpu-xform doctor says what to install

gpu-xform COMMAND --help says more of each command.
"""
RENDER = "Draw the edges of a model, transformed, as a PNG picture."
RENDER_EPILOG = """\
The camera stands where the whole model fits the picture, unless it is given a
position. Colours are names, #rrggbb, or R,G,B from 0 to 1.

examples:
  gpu-xform render ball.wrl -o ball.png --color face --no-background
  gpu-xform render part.stl -o part.png --up +Z --edges feature
  gpu-xform render house.obj -o top.png --camera-direction -Y \\
      --camera-view-up -Z --camera-orthographic
  gpu-xform render house.obj -o - --rotate-x -90 | display
  zcat ball.wrl.gz | gpu-xform render - --file-type wrl -o ball.png
"""
TRANSFORM = """\
Move the points of a model, its polygons kept, or of an array, in double
precision for models and in its own precision for an array."""
TRANSFORM_EPILOG = """\
IN and OUT are model files of any known types, or both NumPy arrays (.npy) of
shape (n, 3) or (n, 2), which may be larger than memory. With no option the file
is only converted. What an interrupted run has done of an array is kept beside
OUT, as OUT.partial, and --resume takes it up.

examples:
  gpu-xform transform in.obj out.ply --scale 0.3 --translate -0.5,2,0
  gpu-xform transform cloud.npy cloud.npy --matrix pose.txt
  gpu-xform transform cube.off flat.off --perspective-from-eye 5 --project
"""
EXPLAIN = "Print the matrix of each transform, their product, and a point's way."
EXPLAIN_EPILOG = """\
example:
  gpu-xform explain --scale 0.3 --rotate-z 90 --translate -0.5,2,0 --point 1,1,0
"""
BENCH = """\
Time one affine matrix on arrays of points, each result checked first: cold and
warm calls, the kernel by the device's own clock, and the copies on either side,
beside plain copies of the same bytes and beside NumPy."""
BENCH_EPILOG = """\
examples:
  gpu-xform bench
  gpu-xform bench --points 1e5,4e6 --dtype float64 --json
"""
DOCTOR = "Report the graphics adapters, and whether their results come out right."
DOCTOR_EPILOG = f"""\
exit codes:
  0  a transform and a picture came out right
  {DEVICE_FAILED}  one of them came out wrong
  {NO_ADAPTER}  no graphics adapter; the report says what to install
"""


class Parser(argparse.ArgumentParser):
    """An argument parser that complains in one line."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the command line, and stop."""
        self.exit(WRONG_INPUT, f"gpu-xform: error: {' '.join(message.split())}\n")


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


def make_parser() -> Parser:
    """Return the parser; what it parses has `run`, the function of the command."""
    parser = Parser(
        prog="gpu-xform",
        usage="gpu-xform COMMAND ...",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=False,
    )
    add = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND").add_parser

    def command(
        name: str, run: Callable[[argparse.Namespace], int], summary: str, usage: str, description: str, epilog: str
    ) -> Parser:
        new = add(
            name,
            help=summary,
            usage=f"gpu-xform {name} {usage}",
            description=description,
            epilog=epilog,
            formatter_class=functools.partial(argparse.RawDescriptionHelpFormatter, max_help_position=HELP_COLUMN),
            allow_abbrev=False,
            add_help=False,
        )
        new.set_defaults(run=run)
        return new

    render = command(
        "render", commands.render, "draw a model as a PNG picture", "MODEL -o PNG [options]", RENDER, RENDER_EPILOG
    )
    _add_render_files(render)
    _add_transforms(render)
    _add_picture(render)
    _add_camera(render)
    _add_rest(render, adapter=True)

    transform = command(
        "transform",
        commands.transform,
        "move the points of a model file or an array",
        "IN OUT [options]",
        TRANSFORM,
        TRANSFORM_EPILOG,
    )
    _add_transform_files(transform)
    _add_transforms(transform).add_argument(
        "--project", action="store_true", help="divide by w, as a perspective needs"
    )
    _add_rest(transform, adapter=True).add_argument(
        "--resume", action="store_true", help="go on where an interrupted run stopped (.npy)"
    )

    explain = command(
        "explain",
        commands.explain,
        "print the matrices of a transform",
        "[options]",
        EXPLAIN,
        EXPLAIN_EPILOG,
    )
    _add_transforms(explain)
    explain.add_argument_group("point").add_argument(
        "--point", metavar="X,Y,Z", type=values.point, help="follow this point through the transforms"
    )
    _add_rest(explain, adapter=False)

    doctor = command(
        "doctor", commands.doctor, "check the graphics adapter and its driver", "[options]", DOCTOR, DOCTOR_EPILOG
    )
    _add_rest(doctor, adapter=True).add_argument("--json", action="store_true", help="print the report as JSON")

    bench = command("bench", commands.bench, "measure the speed of bulk transforms", "[options]", BENCH, BENCH_EPILOG)
    _add_bench(bench)
    _add_rest(bench, adapter=True).add_argument("--json", action="store_true", help="print the figures as JSON")

    rest = _add_rest(parser, adapter=False)
    rest.add_argument("-V", "--version", action="version", version=f"gpu-xform {__version__}", help="print the version")
    return parser


def _add_render_files(parser: Parser) -> None:
    group = parser.add_argument_group("files")
    group.add_argument("input", metavar="MODEL", help="a model file; - for standard input")
    group.add_argument("-o", "--output", metavar="PNG", required=True, help="the picture; - for standard output")
    _add_file_type(group)


def _add_transform_files(parser: Parser) -> None:
    group = parser.add_argument_group("files")
    group.add_argument("input", metavar="IN", help="a model or .npy file; - for standard input")
    group.add_argument("output", metavar="OUT", help="the result; - for standard output, as the type of IN")
    _add_file_type(group)


def _add_bench(parser: Parser) -> None:
    group = parser.add_argument_group("what is measured")
    group.add_argument(
        "--points",
        metavar="N[,N...]",
        type=values.counts,
        default="1e4,1e6,8e6",
        help="numbers of points (default: %(default)s)",
    )
    group.add_argument(
        "--dtype", choices=("float32", "float64"), default="float32", help="of the points (default: %(default)s)"
    )


def _add_file_type(group: Any) -> None:
    group.add_argument("--file-type", metavar="TYPE", help="what the input is, whatever its name: obj, ...")


def _add_transforms(parser: Parser) -> Any:
    group = parser.add_argument_group("transforms, applied in the order typed (angles in degrees)")
    for flag, metavar, value, text in [
        ("--scale", "S|X,Y,Z", values.scale, "scale by one factor, or one an axis"),
        ("--rotate-x", "DEG", values.rotate_x, "turn about the x axis, y towards z"),
        ("--rotate-y", "DEG", values.rotate_y, "turn about the y axis, z towards x"),
        ("--rotate-z", "DEG", values.rotate_z, "turn about the z axis, x towards y"),
        ("--rotate", "X,Y,Z,DEG", values.rotate, "turn about the axis X,Y,Z"),
        ("--translate", "X,Y,Z", values.translate, "move"),
        ("--shear", "XY=F[,...]", values.shear, "add F times y to x; likewise xz, yx, ..."),
        ("--reflect", "X,Y,Z", values.reflect, "mirror in the plane with this normal"),
        ("--project-onto", "X,Y,Z", values.project_onto, "flatten onto the plane with this normal"),
        ("--perspective-from-eye", "D", values.perspective_from_eye, "project onto z = 0 from the eye 0,0,D"),
        ("--matrix", "M", values.matrix, "16 numbers row by row, or a file of them"),
    ]:
        group.add_argument(flag, metavar=metavar, type=value, action="append", dest="steps", default=[], help=text)
    return group


def _add_picture(parser: Parser) -> None:
    group = parser.add_argument_group("picture")
    group.add_argument(
        "--resolution",
        metavar="W,H",
        type=values.resolution,
        default="1024,1024",
        help="size in pixels, also WxH (default: %(default)s)",
    )
    group.add_argument(
        "--line-width", metavar="PIXELS", type=values.line_width, default="1.5", help="(default: %(default)s)"
    )
    group.add_argument(
        "--color",
        metavar="COLOR",
        type=values.line_color,
        default="black",
        help="or 'face', one for each (default: %(default)s)",
    )
    group.add_argument(
        "--no-antialias", action="store_false", dest="antialias", help="lines one pixel wide, on or off: fast"
    )
    group.add_argument(
        "--edges",
        metavar="SET[,...]",
        type=values.edge_sets,
        help="all, feature (creases and rims) or boundary (default: all)",
    )
    group.add_argument(
        "--feature-angle",
        metavar="DEG",
        type=values.feature_angle,
        default="30",
        help="the least turn at a crease (default: %(default)s)",
    )
    either = group.add_mutually_exclusive_group()
    either.add_argument(
        "--background-color",
        metavar="COLOR",
        type=values.color,
        default="white",
        dest="background",
        help="(default: %(default)s)",
    )
    either.add_argument("--no-background", action="store_const", const=None, dest="background", help="transparent")


def _add_camera(parser: Parser) -> None:
    group = parser.add_argument_group("camera (directions are X,Y,Z or an axis: +Y, -Z, x)")
    group.add_argument(
        "--up", metavar="DIR", type=values.direction, default="+Y", help="the model's up (default: %(default)s)"
    )
    group.add_argument(
        "--camera-direction", metavar="DIR", type=values.direction, help="look along DIR, the whole model in view"
    )
    group.add_argument("--camera-position", metavar="X,Y,Z", type=values.point, help="look from here")
    group.add_argument(
        "--camera-focal-point", metavar="X,Y,Z", type=values.point, help="to here (default: the model's centre)"
    )
    group.add_argument(
        "--camera-view-up", metavar="DIR", type=values.direction, help="up in the picture (default: --up)"
    )
    group.add_argument(
        "--camera-view-angle",
        metavar="DEG",
        type=values.view_angle,
        default="30",
        help="from bottom to top (default: %(default)s)",
    )
    group.add_argument("--camera-orthographic", action="store_true", help="parallel lines stay parallel")


def _add_rest(parser: Parser, *, adapter: bool) -> Any:
    group = parser.add_argument_group("other options")
    if adapter:
        group.add_argument(
            "--adapter",
            metavar="NAME",
            help="the device, by a part of its name (default: $GPU_XFORM_ADAPTER, else the fastest)",
        )
    group.add_argument("-h", "--help", action="help", help="print this help")
    return group
