"""The options of the commands, in the groups that the help shows."""

import argparse
from typing import Any

from . import argument_types as values
from . import layer_option as further_layers

# What `load_mesh` reads; asking it would cost every command the time of importing the readers.
MODEL_TYPES = ("3mf", "glb", "gltf", "npy", "obj", "off", "ply", "stl", "vrml", "wrl", "wrz")


def add_render_files(parser: argparse.ArgumentParser) -> None:
    """Add what `render` reads and writes."""
    group = parser.add_argument_group("files")
    add_models(group)
    group.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        type=values.template,
        help="the picture: a .png, .svg or .pdf, with {model} in it one of each; - for standard output, as PNG",
    )
    add_file_type(group)


def add_models(group: Any) -> None:
    """Add the models that are shown."""
    group.add_argument(
        "models", metavar="MODEL", nargs="+", help="model files, or .npy files of points; - for standard input"
    )
    group.add_argument(
        "--layer",
        metavar="'MODEL ...'",
        type=further_layers.further,
        action="append",
        default=[],
        dest="further",
        help="further models, quoted together with transforms and a style of their own",
    )


def add_reference(parser: argparse.ArgumentParser) -> None:
    """Add what a picture is compared with."""
    group = parser.add_argument_group("reference (differences are from 0 to 255)")
    group.add_argument(
        "--reference", metavar="PNG", type=values.template, help="fail if the picture is not like this one"
    )
    group.add_argument(
        "--reference-threshold",
        metavar="T",
        type=values.threshold,
        help="a pixel is like another up to this difference in red, green, blue and alpha (default: 8)",
    )
    group.add_argument(
        "--reference-pixels", metavar="N", type=values.count, help="so many pixels may differ more (default: 0)"
    )
    group.add_argument(
        "--reference-diff", metavar="PNG", type=values.template, help="draw here which pixels differ, if any do"
    )


def add_transform_files(parser: argparse.ArgumentParser) -> None:
    """Add what `transform` reads and writes."""
    group = parser.add_argument_group("files")
    group.add_argument("input", metavar="IN", type=values.file_path, help="a model or .npy file; - for standard input")
    group.add_argument(
        "output", metavar="OUT", type=values.file_path, help="the result; - for standard output, as the type of IN"
    )
    add_file_type(group)
    group.add_argument(
        "--resume", action="store_true", help="go on where an interrupted run stopped, from .npy to .npy"
    )


def add_bench(parser: argparse.ArgumentParser) -> None:
    """Add what `bench` measures."""
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


def add_file_type(group: Any) -> None:
    """Add the type of what is read."""
    *others, last = MODEL_TYPES
    group.add_argument(
        "--file-type", metavar="TYPE", help=f"what the input is, whatever its name: {', '.join(others)} or {last}"
    )


def add_json(parser: argparse.ArgumentParser, what: str) -> None:
    """Add how `what` is printed."""
    group = parser.add_argument_group("output")
    group.add_argument("--json", action="store_true", help=f"print the {what} as JSON")


def add_transforms(parser: argparse.ArgumentParser) -> Any:
    """Add the transforms; their order is kept. Return the group."""
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


def add_picture(parser: argparse.ArgumentParser) -> None:
    """Add the picture's size and ground."""
    group = parser.add_argument_group("picture")
    _add_named_twice(
        group,
        "--resolution",
        "--size",
        metavar="W,H",
        type=values.resolution,
        default="1024,1024",
        dest="resolution",
        help="size in pixels, also WxH; also --size (default: %(default)s)",
    )
    either = group.add_mutually_exclusive_group()
    _add_named_twice(
        either,
        "--background-color",
        "--background",
        metavar="COLOR",
        type=values.color,
        default="white",
        dest="background",
        help="also --background (default: %(default)s)",
    )
    either.add_argument("--no-background", action="store_const", const=None, dest="background", help="transparent")


# Each is a keyword of the library's own: the flag, what it takes, how that is read, and what the help says.
STYLE = [
    (
        "--edges",
        "SET[,...]",
        values.edge_sets,
        "all, feature (creases and rims), boundary, silhouette, or an .npy file of pairs of points (default: all)",
    ),
    ("--feature-angle", "DEG", values.feature_angle, "the least turn at a crease (default: 30)"),
    (
        "--hidden",
        "HOW",
        values.hidden,
        "show, remove, dash or fade edges behind faces (default: show, with --fill remove)",
    ),
    ("--line-width", "PIXELS", values.line_width, "(default: 1.5)"),
    (
        "--point-size",
        "PIXELS",
        values.line_width,
        "a dot at each point (default: none; 2 where nothing joins the points)",
    ),
    ("--fill", "COLOR", values.fill, "paint the faces; 'face' for one each, or an .npy file with a row for each"),
    ("--color", "COLOR", values.line_color, "of lines and dots; 'face' for one each (default: black)"),
    (
        "--scalars",
        "S",
        values.scalars,
        "colour by the x, y or z of the file, or by an .npy file of a number for each point",
    ),
    ("--face-colors", "NPY", values.array_file, "colours of the outlines of faces: R,G,B or R,G,B,A in a row for each"),
    ("--edge-colors", "NPY", values.array_file, "colours of the edges, a row for each"),
    ("--vertex-colors", "NPY", values.array_file, "colours of the points, a row for each, blended along the edges"),
    ("--cmap", "NAME", values.cmap, "the colours of --scalars, as in matplotlib (default: viridis)"),
    ("--clim", "LOW,HIGH", values.limits, "the numbers at their ends (default: the least and largest)"),
    ("--alpha", "A", values.fraction, "opacity, from 0 to 1 (default: 1)"),
    ("--depth-cue", "D", values.fraction, "what of it the farthest point loses (default: 0)"),
]
EITHER = ("--color", "--scalars", "--face-colors", "--edge-colors", "--vertex-colors")


def add_style(parser: argparse.ArgumentParser) -> None:
    """Add how models are drawn; what is not typed is not among the parsed options, but the library's default."""
    group = parser.add_argument_group("style")
    either = group.add_mutually_exclusive_group()
    for flag, metavar, value, text in STYLE:
        to = either if flag in EITHER else group
        to.add_argument(flag, metavar=metavar, type=value, default=argparse.SUPPRESS, help=text)
    group.add_argument(
        "--no-antialias",
        action="store_false",
        dest="antialias",
        default=argparse.SUPPRESS,
        help="lines one pixel wide, on or off: fast",
    )
    group.add_argument(
        "--instances",
        metavar="NPY",
        type=values.array_file,
        default=argparse.SUPPRESS,
        help="a copy at each of the matrices (k, 4, 4), which come before the transforms",
    )


def style(options: argparse.Namespace) -> dict[str, Any]:
    """Return the keywords of the library that the options of the style give."""
    names = [flag.removeprefix("--").replace("-", "_") for flag, *_ in STYLE]
    return {name: getattr(options, name) for name in [*names, "antialias", "instances"] if name in options}


def add_camera(parser: argparse.ArgumentParser) -> None:
    """Add where the camera stands and where it looks."""
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
    _add_named_twice(
        group,
        "--camera-view-angle",
        "--fov",
        metavar="DEG",
        type=values.view_angle,
        default="30",
        dest="camera_view_angle",
        help="from bottom to top; also --fov (default: %(default)s)",
    )
    group.add_argument("--camera-orthographic", action="store_true", help="parallel lines stay parallel")


def _add_named_twice(group: Any, name: str, other: str, **option: Any) -> None:
    """Add an option that is taken by another name as well: not in the help's column, but in messages, as typed."""
    group.add_argument(name, **option)
    group.add_argument(other, **option | {"help": argparse.SUPPRESS})


def add_rest(parser: argparse.ArgumentParser, *, adapter: bool) -> Any:
    """Add what every command takes; return the group."""
    group = parser.add_argument_group("other options")
    if adapter:
        group.add_argument(
            "--adapter",
            metavar="NAME",
            help="the device, by a part of its name (default: $GPU_XFORM_ADAPTER, else the fastest)",
        )
    group.add_argument("-h", "--help", action="help", help="print this help")
    return group
