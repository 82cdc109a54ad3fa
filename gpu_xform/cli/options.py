"""Option groups of the commands, as the help shows them."""

import argparse
from collections.abc import Callable
from typing import Any, NamedTuple

from ..drawing.enums import HIDDEN_STYLES, SHADINGS
from ..geometry.edges import EDGE_SETS
from ..raster.names import RASTERIZERS
from .argument_types import models, numbers, paths, pictures, styles, vectors

# The types that `load_mesh` reads; asking it would import all readers.
MODEL_TYPES = (
    "3mf",
    "dae",
    "glb",
    "gltf",
    "las",
    "laz",
    "npy",
    "obj",
    "off",
    "ply",
    "step",
    "stl",
    "stp",
    "urdf",
    "vrml",
    "wrl",
    "wrz",
)


class ValueOption(NamedTuple):
    """An option that takes one value."""

    flag: str
    metavar: str
    parse: Callable[[str], Any]
    help: str


TRANSFORMS = (
    ValueOption("--scale", "S|X,Y,Z", vectors.parse_scale, "scale by one factor, or by one per axis"),
    ValueOption("--rotate-x", "DEG", vectors.parse_rotate_x, "rotate about the x axis, y towards z"),
    ValueOption("--rotate-y", "DEG", vectors.parse_rotate_y, "rotate about the y axis, z towards x"),
    ValueOption("--rotate-z", "DEG", vectors.parse_rotate_z, "rotate about the z axis, x towards y"),
    ValueOption("--rotate", "X,Y,Z,DEG", vectors.parse_rotate, "rotate about the axis X,Y,Z"),
    ValueOption("--translate", "X,Y,Z", vectors.parse_translate, "translate"),
    ValueOption("--shear", "XY=F[,...]", vectors.parse_shear, "add F times y to x; likewise xz, yx, ..."),
    ValueOption("--reflect", "X,Y,Z", vectors.parse_reflect, "reflect in the plane with this normal"),
    ValueOption("--project-onto", "X,Y,Z", vectors.parse_project_onto, "flatten onto the plane with this normal"),
    ValueOption(
        "--perspective-from-eye",
        "D",
        vectors.parse_perspective_from_eye,
        "project onto the plane z = 0 from the eye 0,0,D",
    ),
    ValueOption("--matrix", "M", vectors.parse_matrix, "16 numbers, row by row, or a file of them"),
)

# Each is a keyword of `Layer`, with dashes for underscores.
STYLE = (
    ValueOption(
        "--edges",
        "SET[,...]",
        styles.parse_edge_sets,
        f"edges to draw: {', '.join(EDGE_SETS)}, or an .npy file of pairs of points, or several of these "
        "(default: all)",
    ),
    ValueOption(
        "--feature-angle",
        "DEG",
        numbers.parse_feature_angle,
        "smallest angle between the normals of two faces at a feature edge (default: 30)",
    ),
    ValueOption(
        "--hidden",
        "HOW",
        styles.parse_hidden,
        f"how to draw edges behind faces: {', '.join(HIDDEN_STYLES[:-1])} or {HIDDEN_STYLES[-1]} "
        "(default: show, but behind opaque faces of another layer or with --fill remove); SVG and PDF of up to 65,536 "
        "segments leave out hidden lines that lie on others",
    ),
    ValueOption(
        "--hidden-style",
        "KEY=VALUE;...",
        styles.parse_hidden_style,
        "how hidden lines differ from others: color, line-width and dash, as in 'color=gray;line-width=1;dash=dotted'",
    ),
    ValueOption(
        "--line-width",
        "WIDTH",
        styles.parse_line_width,
        "width of lines, in pixels or with a unit, as 0.35mm or 1pt; or auto: thinner where the lines of a dense mesh "
        "would blacken it (default: 1.5)",
    ),
    ValueOption(
        "--dash",
        "PATTERN",
        styles.parse_dash,
        "dashes of lines: lengths of dashes and gaps in line widths, as 4,2,1,2, or a line type of ISO 128, 01 to 15 "
        "or by name, as long-dashed-dotted (default: continuous)",
    ),
    ValueOption(
        "--point-size",
        "WIDTH",
        styles.parse_point_size,
        "diameter of a dot at each point, in pixels or with a unit (default: none; 2 for models without edges)",
    ),
    ValueOption(
        "--max-points",
        "N",
        numbers.parse_count,
        "draw at most N points of a cloud, chosen evenly over their order, for a quick look (default: all)",
    ),
    ValueOption(
        "--fill",
        "COLOR",
        styles.parse_fill,
        "colour of the faces: one, 'face' for a cycle of ten, 'file' for the model's own, 'shade' for grey with "
        "--shading flat or smooth, or an .npy file with a row per face (default: no fill)",
    ),
    ValueOption(
        "--shading",
        "HOW",
        styles.parse_shading,
        f"how a lamp at the eye lights the faces: {', '.join(SHADINGS)}; smooth keeps edges sharp where faces turn by "
        "more than --feature-angle (default: none)",
    ),
    ValueOption(
        "--color",
        "COLOR",
        styles.parse_line_color,
        "colour of lines and dots: one, 'face' for a cycle of ten, or 'file' for the model's own (default: black)",
    ),
    ValueOption(
        "--scalars",
        "S",
        styles.parse_scalars,
        "values that --cmap maps to colours: x, y or z of the model's points, the name of one of its attributes, or an "
        ".npy file of a number per point",
    ),
    ValueOption(
        "--face-colors",
        "NPY",
        paths.parse_array_file,
        "colours of the outlines of faces: an .npy file with a row R,G,B or R,G,B,A per face",
    ),
    ValueOption("--edge-colors", "NPY", paths.parse_array_file, "colours of the edges: a row per edge"),
    ValueOption(
        "--vertex-colors",
        "NPY",
        paths.parse_array_file,
        "colours of the points: a row per point, interpolated along the edges",
    ),
    ValueOption("--cmap", "NAME", styles.parse_colormap, "colormap of --scalars, as in matplotlib (default: viridis)"),
    ValueOption(
        "--clim",
        "LOW,HIGH",
        numbers.parse_limits,
        "scalar values mapped to the ends of the colormap (default: the smallest and the largest)",
    ),
    ValueOption(
        "--section",
        "X,Y,Z,NX,NY,NZ",
        styles.parse_section,
        "cut the models by the plane through the point X,Y,Z with the normal NX,NY,NZ, or an axis, as +X, remove what "
        "lies before it, and draw the outline of the cut thick",
    ),
    ValueOption(
        "--hatch",
        "auto|DEG[,D]",
        styles.parse_hatch,
        "hatch what --section cuts: auto, by 45 or 135 degrees, or by DEG, with lines D apart",
    ),
    ValueOption(
        "--alpha",
        "A",
        numbers.parse_fraction,
        "opacity, 0 to 1; faces become paler, and still hide those behind (default: 1)",
    ),
    ValueOption(
        "--labels",
        "WHAT",
        styles.parse_labels,
        "texts beside points: names for the name of each model over its centre, indices for the index of each point, "
        "or a file: a .txt with a line per point, or a .csv with rows INDEX,TEXT or X,Y,Z,TEXT",
    ),
    ValueOption("--depth-cue", "D", numbers.parse_fraction, "opacity lost by the farthest point, 0 to 1 (default: 0)"),
)
LINE_COLOR_FLAGS = ("--color", "--scalars", "--face-colors", "--edge-colors", "--vertex-colors")


def add_models(group: Any, layer_type: Callable[[str], argparse.Namespace]) -> None:
    """Add the models to draw; `layer_type` parses the value of --layer."""
    group.add_argument(
        "models", metavar="MODEL", nargs="+", help="model files, or .npy files of points; - for standard input"
    )
    group.add_argument(
        "--layer",
        metavar="'MODEL ...'",
        type=layer_type,
        action="append",
        default=[],
        dest="extra_layers",
        help="more models, quoted together with their own transforms and style",
    )


def add_reading_options(group: Any) -> None:
    """Add the type of the input, the tolerance for surfaces in it, and the limits of what it may hold."""
    *others, last = MODEL_TYPES
    group.add_argument(
        "--file-type",
        metavar="TYPE",
        help=f"type of the input, if its name does not give it: {', '.join(others)} or {last}",
    )
    group.add_argument(
        "--tolerance",
        metavar="D",
        type=numbers.parse_tolerance,
        help="largest distance between polygons and the smooth surfaces of an .obj file (default: a thousandth of the "
        "diagonal of its points), or of a STEP file (default: a five-hundredth of its size)",
    )
    group.add_argument(
        "--file-limits",
        metavar="LIMITS",
        type=models.parse_file_limits,
        help="what a file may hold: points=N, faces=N, face_corners=N, nodes=N, depth=N, unpacked_bytes=N, cpu_s=S, "
        "memory_bytes=N, separated by commas",
    )
    group.add_argument(
        "--isolated",
        action="store_true",
        help="read model files in a process of its own, whose memory and time are limited (Linux)",
    )


def add_pose(group: Any) -> None:
    """Add the pose of a robot."""
    group.add_argument(
        "--pose",
        metavar="JOINT=VALUE[,...]",
        type=models.parse_pose,
        help="numbers of the joints of a .urdf file, in radians, degrees if deg follows, or metres; others stay at 0",
    )


def add_parts(group: Any) -> None:
    """Add the choice to draw the parts of an assembly as models."""
    group.add_argument(
        "--parts",
        action="store_true",
        help="draw each part of a STEP, 3MF, glTF, GLB or URDF file as a model of its own, with its name in --legend "
        "and --labels names; styles by point or by face are for files of one part",
    )


def add_json(parser: argparse.ArgumentParser, content: str) -> None:
    """Add the choice of JSON for the printed `content`."""
    group = parser.add_argument_group("output")
    group.add_argument("--json", action="store_true", help=f"print the {content} as JSON")


def add_transforms(parser: argparse.ArgumentParser) -> Any:
    """Add the transforms, whose order is kept; return the group."""
    group = parser.add_argument_group("transforms, applied in the order typed (angles in degrees)")
    for flag, metavar, parse, text in TRANSFORMS:
        group.add_argument(flag, metavar=metavar, type=parse, action="append", dest="steps", default=[], help=text)
    return group


def add_picture(parser: argparse.ArgumentParser, resolution: str) -> Any:
    """Add the picture's size, by default `resolution`, and its background; return the group."""
    group = parser.add_argument_group("picture")
    _add_with_alias(
        group,
        "--resolution",
        "--size",
        metavar="W,H",
        type=pictures.parse_resolution,
        default=resolution,
        dest="resolution",
        help="size in pixels, W,H or WxH; also --size (default: %(default)s)",
    )
    either = group.add_mutually_exclusive_group()
    _add_with_alias(
        either,
        "--background-color",
        "--background",
        metavar="COLOR",
        type=styles.parse_color,
        default="white",
        dest="background",
        help="background colour; also --background (default: %(default)s)",
    )
    either.add_argument(
        "--no-background", action="store_const", const=None, dest="background", help="transparent background"
    )
    return group


def add_annotations(parser: argparse.ArgumentParser) -> None:
    """Add what is written into a picture beside its models."""
    group = parser.add_argument_group("text (with --labels in the style of a model)")
    group.add_argument(
        "--axes", action="store_true", help="draw a box with a grid around the models, and numbers along its axes"
    )
    group.add_argument(
        "--axis-titles",
        metavar="X,Y,Z",
        type=pictures.parse_axis_titles,
        help="draw axes with these titles, of which some may be empty (default: x,y,z)",
    )
    group.add_argument("--legend", action="store_true", help="list the names of the models, beside what they look like")
    group.add_argument(
        "--font", metavar="FONT", help="font of texts: a .ttf or .otf file, or the name of an installed font"
    )
    group.add_argument(
        "--font-size",
        metavar="PIXELS",
        type=pictures.parse_font_size,
        help="size of texts (default: 10 in a picture of 256 pixels, 20 in one of 1024)",
    )


def add_style(parser: argparse.ArgumentParser) -> None:
    """Add the style of models; options that are not typed are not in the namespace: the library has the defaults."""
    group = parser.add_argument_group("style")
    either = group.add_mutually_exclusive_group()
    for flag, metavar, parse, text in STYLE:
        target = either if flag in LINE_COLOR_FLAGS else group
        action = "extend" if parse is styles.parse_edge_sets else "store"
        target.add_argument(flag, metavar=metavar, type=parse, action=action, default=argparse.SUPPRESS, help=text)
    group.add_argument(
        "--no-antialias",
        action="store_false",
        dest="antialias",
        default=argparse.SUPPRESS,
        help="draw lines one pixel wide without anti-aliasing, which is fast",
    )
    group.add_argument(
        "--colorbar",
        action="store_true",
        default=argparse.SUPPRESS,
        help="show which values the colours of --scalars stand for",
    )
    group.add_argument(
        "--instances",
        metavar="NPY",
        type=paths.parse_array_file,
        default=argparse.SUPPRESS,
        help="draw one copy per matrix (k, 4, 4) of an .npy file; the matrices apply before the transforms",
    )


def add_camera(parser: argparse.ArgumentParser) -> None:
    """Add the position and the view of the camera."""
    group = parser.add_argument_group("camera (directions are X,Y,Z or an axis: +Y, -Z, x)")
    group.add_argument(
        "--up", metavar="DIR", type=vectors.parse_direction, default="+Y", help="up axis of the models (default: +Y)"
    )
    group.add_argument(
        "--camera-direction",
        metavar="DIR",
        type=vectors.parse_direction,
        help="look along DIR, with all models in view (default: obliquely from above)",
    )
    group.add_argument(
        "--camera-position", metavar="X,Y,Z", type=vectors.parse_point, help="position of the camera (default: fitted)"
    )
    group.add_argument(
        "--camera-focal-point",
        metavar="X,Y,Z",
        type=vectors.parse_point,
        help="point that a camera with a position looks at (default: the models' centre)",
    )
    group.add_argument(
        "--camera-view-up",
        metavar="DIR",
        type=vectors.parse_direction,
        help="direction that is up in the picture (default: --up)",
    )
    _add_with_alias(
        group,
        "--camera-view-angle",
        "--fov",
        metavar="DEG",
        type=numbers.parse_view_angle,
        default="30",
        dest="camera_view_angle",
        help="vertical field of view; also --fov (default: %(default)s)",
    )
    group.add_argument("--camera-orthographic", action="store_true", help="use parallel projection")
    group.add_argument(
        "--camera-azimuth-angle",
        metavar="DEG",
        type=numbers.parse_angle,
        default="0",
        help="then turn the camera so far to the right, about the models' centre or the focal point (default: 0)",
    )
    group.add_argument(
        "--camera-elevation-angle",
        metavar="DEG",
        type=numbers.parse_angle,
        default="0",
        help="then raise the camera so far (default: 0)",
    )
    group.add_argument(
        "--camera-zoom-factor",
        metavar="F",
        type=pictures.parse_zoom_factor,
        help="part of the picture's width or height that the models fill, as in F3D: 1 fills it all, and more "
        "comes closer; not with --camera-position (default: 0.9)",
    )


def add_drawing_options(parser: argparse.ArgumentParser, resolution: str) -> Any:
    """Add the options of all commands that draw: transforms, picture, style, camera; return the picture's group."""
    add_transforms(parser)
    picture = add_picture(parser, resolution)
    add_style(parser)
    add_annotations(parser)
    add_camera(parser)
    return picture


def add_page(picture: Any) -> None:
    """Add the page that is drawn on, in place of a size in pixels, and how many pixels an inch has."""
    picture.add_argument(
        "--paper",
        metavar="NAME|WxH",
        help="draw on a page, in place of --resolution: A0 to A6, letter, legal or tabloid, with -landscape to turn "
        "it, or a size, as 200x100mm",
    )
    picture.add_argument(
        "--drawing-scale",
        metavar="N:M",
        help="lengths on the page over those of the models, as 1:10; projects in parallel (default: fill the page)",
    )
    picture.add_argument("--margin", metavar="LENGTH", help="margin of the page (default: 10mm)")
    picture.add_argument(
        "--units",
        metavar="UNIT",
        type=pictures.parse_units,
        help="unit of the models: um, mm, cm, m, in or ft (default: mm)",
    )
    picture.add_argument(
        "--dpi",
        metavar="N",
        type=pictures.parse_dpi,
        help="pixels per inch of a .png, for the page and for lengths with a unit (default: 96)",
    )


def add_web_page(parser: argparse.ArgumentParser) -> None:
    """Add what a .html page has beside the options of drawing."""
    group = parser.add_argument_group("web page (.html), without labels, colour bar, axes and legend")
    group.add_argument("--title", metavar="TEXT", help="title of the page (default: the name of the model)")
    group.add_argument(
        "--max-edges",
        metavar="N",
        type=numbers.parse_count,
        help="hold about N edges at most: points that lie close together become one (default: all)",
    )


def add_general_options(parser: argparse.ArgumentParser, *, adapter: bool, rasterizer: bool = False) -> Any:
    """Add the options of every command, and those of the commands that use a device or draw; return the group."""
    group = parser.add_argument_group("other options")
    if adapter:
        group.add_argument(
            "--adapter",
            metavar="NAME",
            help="graphics adapter, by a part of its name, or #0, #1 for its place in the list of doctor"
            f"{'' if rasterizer else ', or host for the processors'} (default: $GPU_XFORM_ADAPTER, else the fastest)",
        )
    if rasterizer:
        *others, last = RASTERIZERS
        group.add_argument(
            "--rasterizer",
            metavar="NAME",
            type=pictures.parse_rasterizer,
            default="auto",
            help=f"how edges become pixels: {', '.join(others)} or {last} "
            "(default: $GPU_XFORM_RASTERIZER, else the faster one)",
        )
    group.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help="print on standard error which files are read and written, on which adapter, and how long each stage took",
    )
    group.add_argument("-h", "--help", action="help", help="print this help")
    return group


def _add_with_alias(group: Any, name: str, alias: str, **option: Any) -> None:
    """Add an option under two names: its own line in the help for the first only, but each in messages, as typed."""
    group.add_argument(name, **option)
    group.add_argument(alias, **option | {"help": argparse.SUPPRESS})
