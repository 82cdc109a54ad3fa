"""`gpu-xform animate`: a file that shows models in motion."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

from ...errors import ArgumentError
from .. import files
from .. import options as groups
from ..argument_types import numbers, vectors
from ..argument_types.paths import PAGE_TYPES, parse_file_path
from ..arguments_from_options import (
    choose_drawing_device,
    collect_picture_arguments,
    compose_transforms,
    require_drawing_options,
)
from ..layer_option import parse_layer
from ..option_errors import name_options_in_errors
from ..paths import expand_globs, file_type, require_type
from ..read_layers import read_layers, read_style
from ..stage_times import report_stage
from ..web_pages import LEFT_OUT, find_given

if TYPE_CHECKING:
    from ...animation import Animation
    from ...drawing.layer import Style

DEFAULT_FRAMES = 100

USAGE = "MODEL... -o OUT [options]"
DESCRIPTION = """\
Draw models that rotate once, or that are moved by one matrix per frame, as an
animated file."""
EPILOG = """\
The end of OUT gives the format: .gif, .png or .apng (animated PNG), .webp,
.mp4, .webm, or .html (a web page with a player; with --live, the models
themselves, which can be turned). If OUT holds {frame}, or
{frame:04} for four digits, one PNG per frame is written. MP4 and WebM need
PyAV: pip install 'gpu_xform[video]'. The camera is placed so that every frame
fits the picture.

examples:
  gpu-xform animate ball.wrl -o ball.gif --turntable --color face
  gpu-xform animate part.stl -o part.mp4 --up +Z --edges feature,silhouette \\
      --frames 200 --fps 30 --resolution 1280x720
  gpu-xform animate house.obj -o "frames/{frame:04}.png" --rotate-x 20
  gpu-xform animate arm.ply -o arm.html --matrices poses.npy --no-background
  gpu-xform animate house.obj -o house.html --live --hidden remove
  gpu-xform animate fox.glb -o fox.gif --animation Run
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `animate`."""
    group = parser.add_argument_group("files")
    groups.add_models(group, parse_layer)
    group.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        type=parse_file_path,
        required=True,
        help="the animation; the end of its name gives the format",
    )
    groups.add_reading_options(group)
    groups.add_pose(group)
    groups.add_parts(group)
    group = parser.add_argument_group("motion, applied after the transforms")
    either = group.add_mutually_exclusive_group()
    either.add_argument(
        "--turntable", action="store_true", help="rotate once about the centre of the models (the default)"
    )
    either.add_argument("--matrices", metavar="NPY", help="an .npy file (frames, 4, 4), one matrix per frame")
    either.add_argument(
        "--animation", metavar="NAME", help="an animation that the model's own file holds, of glTF alone"
    )
    group.add_argument(
        "--axis",
        metavar="DIR",
        type=vectors.parse_direction,
        help="axis of the rotation: X,Y,Z, +Z, ... (default: --up)",
    )
    group.add_argument(
        "--frames",
        metavar="N",
        type=numbers.parse_count,
        help=f"number of frames of the rotation (default: {DEFAULT_FRAMES})",
    )
    group.add_argument(
        "--fps",
        metavar="N",
        type=numbers.parse_frame_rate,
        default="20",
        help="frames per second (default: %(default)s)",
    )
    group.add_argument(
        "--live",
        action="store_true",
        help="write a .html page that holds the models in place of pictures: they can be turned while they move",
    )
    groups.add_drawing_options(parser, resolution="640,480")
    groups.add_web_page(parser)
    groups.add_general_options(parser, adapter=True, rasterizer=True)


def run(options: argparse.Namespace) -> int:
    """Draw models in motion."""
    require_drawing_options(options)
    if options.live:
        _require_live(options)
    elif options.max_edges is not None:
        raise ArgumentError("--max-edges must come with --live: other files hold pictures, not edges")
    elif options.title is not None and file_type(options.output) not in PAGE_TYPES:
        raise ArgumentError("--title is for web pages, whose names end in .html")
    if options.axis is not None or options.frames is not None:
        if options.matrices is not None:
            raise ArgumentError("--axis and --frames are for --turntable: --matrices has one matrix per frame")
        if options.animation is not None:
            raise ArgumentError("--axis and --frames are for --turntable: --animation has its own length")
    from ... import animation
    from ...drawing.camera import front_direction

    paths = expand_globs(options.models)
    if options.animation is not None:
        return _play(options, paths)
    layers = read_layers(options, paths, compose_transforms(options))
    is_aimed = options.camera_direction is not None or options.camera_position is not None
    if options.matrices is None and options.axis is None and not is_aimed:
        options.camera_direction = front_direction(options.up)
    arguments = collect_picture_arguments(options, layers, choose_drawing_device(options))
    arguments |= {"fps": options.fps, "rasterizer": options.rasterizer}
    with name_options_in_errors(options, paths):
        if options.matrices is None:
            axis = options.up if options.axis is None else options.axis
            n_frames = DEFAULT_FRAMES if options.frames is None else options.frames
            made = animation.turntable(layers, n_frames, axis=axis, **arguments)
        else:
            stack = files.read_matrix_stack(options.matrices, "frames")
            made = animation.animate(layers, stack, **arguments)
        _save(made, options)
    return 0


def _require_live(options: argparse.Namespace) -> None:
    """Raise `ArgumentError` for what a page that holds the models does not have."""
    require_type(options.output, PAGE_TYPES)
    given = find_given(options, LEFT_OUT)
    if given is not None:
        raise ArgumentError(f"{given} cannot go with --live")
    if options.rasterizer != "auto":
        raise ArgumentError("--rasterizer cannot go with --live: the browser draws")


def _save(made: "Animation", options: argparse.Namespace) -> None:
    with report_stage(f"drew and wrote {options.output}") as details:
        details.append(f"{len(made)} frames")
        if options.title is not None:
            made.title = options.title
        _write(made, options)


def _write(made: "Animation", options: argparse.Namespace) -> None:
    if options.live:
        from ...web.page import save_page

        save_page(made, options.output, max_edges=options.max_edges)
    else:
        made.save(options.output)


def _play(options: argparse.Namespace, paths: Sequence[str]) -> int:
    """Draw the nodes of a file as an animation moves them that the file holds."""
    from ... import animation
    from ...drawing.layer import as_layers

    if len(paths) != 1 or options.extra_layers:
        raise ArgumentError("--animation is for one model, whose file holds it")
    (path,) = paths
    scene = files.read_scene(path, options.file_type)
    if options.animation not in scene.animations:
        held = ", ".join(map(repr, scene.animations)) or "none"
        raise ArgumentError(f"--animation: {path} has no {options.animation!r}, its animations: {held}")
    style = read_style(options, path, "a file of several models, as --animation plays it") | {
        "transform": compose_transforms(options)
    }
    arguments = collect_picture_arguments(
        options, as_layers(scene, cast("Style", style)), choose_drawing_device(options)
    )
    with name_options_in_errors(options, paths):
        clip = scene.animations[options.animation]
        made = animation.animate(scene, clip, fps=options.fps, **style, **arguments)
        made.title = Path(path).stem
        _save(made, options)
    return 0
