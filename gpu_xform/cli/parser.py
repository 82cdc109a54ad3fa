"""The options of `gpu-xform` and its help."""

import argparse
import functools
import re
from collections.abc import Callable, Sequence
from typing import NoReturn

from .. import __version__
from ..errors import ArgumentError
from . import argument_types as values
from . import files
from . import options as option_groups
from .argv import OptionParser, attach_values
from .commands import animate as animating
from .commands import render as rendering
from .commands import transform as commands
from .commands import view as viewing
from .exit_codes import DEVICE_FAILED, DIFFERENT, NO_ADAPTER, WRONG_INPUT

HELP_COLUMN = 31

DESCRIPTION = "Bulk homogeneous transforms and wireframe pictures on any GPU, or on none."
EPILOG = f"""\
examples:
  gpu-xform render house.obj -o house.png --rotate-y 30 --color face
  gpu-xform render *.obj -o "thumbs/{{model}}.png"
  gpu-xform animate house.obj -o house.gif --color face
  gpu-xform view house.obj
  gpu-xform transform scan.ply moved.ply --scale 0.001 --translate -0.5,2,0
  gpu-xform explain --scale 0.3 --rotate-z 90 --translate -0.5,2,0 --point 1,1,0
  gpu-xform doctor
  gpu-xform bench

exit codes:
  0  done
  {DEVICE_FAILED}  the device failed, or computes wrongly
  {WRONG_INPUT}  wrong usage or input
  {NO_ADAPTER}  no graphics adapter: gpu-xform doctor says what to install
  {DIFFERENT}  a picture is not like its reference

gpu-xform COMMAND --help says more of each command.
"""
USAGE = "MODEL... (-o OUT | --reference PNG) [options]"
RENDER = """\
Draw the edges of models, transformed, as a PNG, SVG or PDF picture: all models
in one, or, where the path of the picture holds {model}, each in its own."""
RENDER_EPILOG = f"""\
In the paths of pictures, {{model}} stands for a model's name without folder and
type, and {{folder}} for its folder; the folders of such a path are made. A model
that fails does not stop the rest.

The camera stands where everything fits the picture, unless it is given a
position. Colours are names, #rrggbb, or R,G,B from 0 to 1. PDF needs pydyf:
pip install 'gpu_xform[pdf]'.

examples:
  # one picture
  gpu-xform render ball.wrl -o ball.png --color face --no-background
  gpu-xform render part.stl -o part.png --up +Z --edges feature,silhouette \\
      --hidden dash
  gpu-xform render house.obj -o top.png --camera-direction -Y \\
      --camera-view-up -Z --camera-orthographic
  # the same in lines that stay sharp, for papers and plotters
  gpu-xform render part.stl -o part.svg --up +Z --edges feature,silhouette \\
      --hidden dash
  # painted faces; heights in colours
  gpu-xform render ball.wrl -o ball.png --fill face
  gpu-xform render hills.ply -o hills.png --up +Z --scalars z --cmap terrain
  gpu-xform render scan.npy -o scan.png --up +Z --scalars z --point-size 3
  # arrays of colours, of pairs of points, of places
  gpu-xform render part.stl -o part.png --face-colors stress.npy --alpha 0.8
  gpu-xform render house.obj -o street.png --instances places.npy --fill gold
  # models in one picture, each in its own style; each of many in its own
  gpu-xform render house.obj garden.ply -o both.png
  gpu-xform render floor.obj -o room.png --fill tan \\
      --layer "chair.obj table.obj --fill white --translate 0,0.5,0"
  gpu-xform render *.obj -o "thumbs/{{model}}.png" --resolution 256,256
  # a test: do they still look as they should?
  gpu-xform render *.obj --reference "expected/{{model}}.png"
  # pipes
  gpu-xform render house.obj -o - --rotate-x -90 | display
  zcat ball.wrl.gz | gpu-xform render - --file-type wrl -o ball.png

exit codes (of many pictures, the lowest that any of them fails with):
  0  done
  {DEVICE_FAILED}  the device failed
  {WRONG_INPUT}  wrong usage or input
  {NO_ADAPTER}  no graphics adapter: gpu-xform doctor says what to install
  {DIFFERENT}  a picture is not like its reference
"""
TRANSFORM = """\
Move the points of a model, its polygons kept, or of an array, in double
precision for models and in its own precision for an array."""
TRANSFORM_EPILOG = """\
IN and OUT are model files of any known types; an array of points (.npy), of
shape (n, 3), is one. From .npy to .npy the shape may be (n, 2) as well, and the
array larger than memory: what an interrupted run has done of it is kept beside
OUT, as OUT.partial, and --resume takes it up. With no option the file is only
converted.

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


class Parser(OptionParser):
    """An argument parser that complains in one line."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the command line, and stop."""
        self.exit(WRONG_INPUT, f"gpu-xform: error: {' '.join(message.split())}\n")


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """Return the options of a command line; where it asks for help or is wrong, print and raise SystemExit."""
    parser = make_parser()
    options, rest = parser.parse_known_args(attach_values(argv))
    if options.command in ("render", "animate", "view") and not any(re.match("-.", word) for word in rest):
        options.models += rest  # argparse takes models only as far as the first option between them
        _require_models(parser, options.models)
    elif rest:
        asked = parser if options.command is None else options.parser
        parser.error(f"unrecognized arguments: {' '.join(rest)}{asked.meant(rest)}")
    if options.command is None:
        parser.error(
            "a command is needed: render, animate, view, transform, explain, doctor or bench; see gpu-xform --help"
        )
    return options


def _require_models(parser: Parser, models: Sequence[str]) -> None:
    try:
        for path in models:
            files.require_path(path)
    except ArgumentError as error:
        parser.error(f"argument MODEL: {error}")


def make_parser() -> Parser:
    """Return the parser; what it parses has `run`, the function of the command, and `parser`, its own."""
    parser = Parser(
        prog="gpu-xform",
        usage="gpu-xform COMMAND ...",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
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
        )
        new.set_defaults(run=run, parser=new)
        return new

    render = command("render", rendering.render, "draw models as PNG, SVG or PDF", USAGE, RENDER, RENDER_EPILOG)
    option_groups.add_render_files(render)
    option_groups.add_transforms(render)
    option_groups.add_picture(render)
    option_groups.add_style(render)
    option_groups.add_camera(render)
    option_groups.add_reference(render)
    option_groups.add_rest(render, adapter=True)

    animate = command(
        "animate",
        animating.animate,
        animating.SUMMARY,
        animating.USAGE,
        animating.DESCRIPTION,
        animating.EPILOG,
    )
    animating.add_options(animate)

    view = command("view", viewing.view, viewing.SUMMARY, viewing.USAGE, viewing.DESCRIPTION, viewing.EPILOG)
    viewing.add_options(view)

    transform = command(
        "transform",
        commands.transform,
        "move the points of a model file or an array",
        "IN OUT [options]",
        TRANSFORM,
        TRANSFORM_EPILOG,
    )
    option_groups.add_transform_files(transform)
    option_groups.add_transforms(transform).add_argument(
        "--project", action="store_true", help="divide by w, as a perspective needs"
    )
    option_groups.add_rest(transform, adapter=True)

    explain = command(
        "explain",
        commands.explain,
        "print the matrices of a transform",
        "[options]",
        EXPLAIN,
        EXPLAIN_EPILOG,
    )
    option_groups.add_transforms(explain)
    explain.add_argument_group("point").add_argument(
        "--point", metavar="X,Y,Z", type=values.point, help="follow this point through the transforms"
    )
    option_groups.add_rest(explain, adapter=False)

    doctor = command(
        "doctor", commands.doctor, "check the graphics adapter and its driver", "[options]", DOCTOR, DOCTOR_EPILOG
    )
    option_groups.add_json(doctor, "report")
    option_groups.add_rest(doctor, adapter=True)

    bench = command("bench", commands.bench, "measure the speed of bulk transforms", "[options]", BENCH, BENCH_EPILOG)
    option_groups.add_bench(bench)
    option_groups.add_json(bench, "figures")
    option_groups.add_rest(bench, adapter=True)

    rest = option_groups.add_rest(parser, adapter=False)
    rest.add_argument("-V", "--version", action="version", version=f"gpu-xform {__version__}", help="print the version")
    return parser
