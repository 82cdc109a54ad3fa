"""`gpu-xform render`: pictures of models, and their comparison with references."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...drawing.sheet import PROJECTIONS, VIEW_NAMES
from ...errors import ArgumentError
from .. import options as groups
from .. import references
from ..argument_types import numbers, paths
from ..argument_types.pictures import parse_projection, parse_views
from ..arguments_from_options import require_drawing_options
from ..contact_sheet import require_sheet_options
from ..exit_codes import DEVICE_FAILED, MISMATCH, NO_ADAPTER, WRONG_INPUT
from ..layer_option import parse_layer
from ..make_pictures import collect_page_arguments, make_pictures
from ..model_paths import RECURSIVE, count_left_out, find_models
from ..option_errors import name_options_in_errors
from ..outputs import PlannedPicture, plan_outputs
from ..paths import file_type, require_room
from ..streams import print_notice
from ..web_pages import require_web_page_options

USAGE = "MODEL... (-o OUT | --reference PNG | ...) [options]"
DESCRIPTION = """\
Draw the edges of models, transformed, as a PNG, SVG or PDF picture, or as a web
page that draws them live: all models in one picture, or, if the path of the
picture holds {model}, one picture per model; compare the pictures with
references, and report on them."""
EPILOG = f"""\
A MODEL may be a folder, for the models in it but for .npy files, or
'FOLDER/**', quoted, also for those in all folders below it. In the paths of
pictures, {{model}} stands for the name of a model without folder and type,
{{suffix}} for its type, {{parent}} for the name of its folder, and {{folder}} for the
path of that. Missing folders of such paths are made, and paths that two
pictures would share are refused. If one of several pictures fails, the others
are still made. Without any option of style, such pictures show shaded faces,
with sharp edges and outlines where the faces are few for the picture: a cube is
legible so, and a scan is too.

If a folder or a pattern is given, references of no model are named, too. They
do not change the exit code. docs/continuous_integration.md has recipes for
GitHub, GitLab, pre-commit and Docker.

The camera is placed so that all models fit the picture, unless a position is
given. Colours are names, #rrggbb, or R,G,B from 0 to 1. PDF needs pydyf:
pip install 'gpu_xform[pdf]'.

The edge sets are: all edges; feature edges, where two faces meet at an angle or
one face ends; boundary edges, which have one face; the silhouette, where faces
turn away from the camera, with the boundary; and the intersection, the lines
where bodies penetrate one another.

examples:
  # one picture
  gpu-xform render ball.wrl -o ball.png --color face --no-background
  gpu-xform render part.stl -o part.png --up +Z --edges feature,silhouette \\
      --hidden dash
  gpu-xform render house.obj -o top.png --camera-direction -Y \\
      --camera-view-up -Z --camera-orthographic
  # vector graphics, for papers and plotters
  gpu-xform render part.stl -o part.svg --up +Z --edges feature,silhouette \\
      --hidden dash
  # a drawing at 1:5 on paper, with dashed hidden lines
  gpu-xform render part.stl -o part.pdf --up +Z --camera-direction +Y \\
      --edges feature --hidden dash --paper A4-landscape --drawing-scale 1:5 \\
      --line-width 0.35mm
  # filled faces; colours by height
  gpu-xform render ball.wrl -o ball.png --fill face
  gpu-xform render hills.ply -o hills.png --up +Z --scalars z --cmap terrain
  gpu-xform render scan.npy -o scan.png --up +Z --scalars z --point-size 3
  # arrays of colours and of instance matrices
  gpu-xform render part.stl -o part.png --face-colors stress.npy --alpha 0.8
  gpu-xform render house.obj -o street.png --instances places.npy --fill gold
  # several models in one picture; one style per layer; one picture per model
  gpu-xform render house.obj garden.ply -o both.png
  gpu-xform render floor.obj -o room.png --fill tan \\
      --layer "chair.obj table.obj --fill white --translate 0,0.5,0"
  gpu-xform render *.obj -o "thumbs/{{model}}.png" --resolution 256,256
  # three views and an isometric one on one sheet, in SVG
  gpu-xform render part.stl -o part.svg --views front,top,right,iso \\
      --up +Z --hidden dash --edges feature,silhouette
  # a web page in which the model can be turned, zoomed and restyled
  gpu-xform render part.stl -o part.html --up +Z --hidden remove
  # a regression test: do the models look as expected? the second line says yes
  gpu-xform render parts --reference "refs/{{model}}.png" --report report.html
  gpu-xform render parts --reference "refs/{{model}}.png" --update-references
  # a contact sheet
  gpu-xform render "parts/**" --sheet parts.pdf
  # pipes
  gpu-xform render house.obj -o - --rotate-x -90 | display
  zcat ball.wrl.gz | gpu-xform render - --file-type wrl -o ball.png

exit codes (for several pictures, the lowest code of those that fail):
  0  done
  {DEVICE_FAILED}  the device failed
  {WRONG_INPUT}  wrong usage or input; a reference that does not exist
  {NO_ADAPTER}  no graphics adapter: gpu-xform doctor says what to install
  {MISMATCH}  a picture does not match its reference
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `render`."""
    group = parser.add_argument_group("files")
    groups.add_models(group, parse_layer)
    group.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        type=paths.parse_template,
        help="the picture: a .png, .svg or .pdf file, or a .html page that draws the models live in a browser; one "
        "per model if the path holds {model}; - for a PNG on standard output",
    )
    groups.add_reading_options(group)
    groups.add_pose(group)
    groups.add_parts(group)
    groups.add_page(groups.add_drawing_options(parser, resolution="1024,1024"))
    groups.add_web_page(parser)
    _add_views(parser)
    _add_reference(parser)
    _add_reports(parser)
    groups.add_general_options(parser, adapter=True, rasterizer=True)


def _add_views(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("several views on one sheet, at one scale")
    group.add_argument(
        "--views",
        metavar="VIEW[,...]",
        type=parse_views,
        help=f"views to draw in parallel projection, among {', '.join(VIEW_NAMES)}; --up says which side is the top",
    )
    group.add_argument(
        "--projection",
        metavar="ANGLE",
        type=parse_projection,
        help=f"{' or '.join(PROJECTIONS)}: the top view lies above the front view, or below it (default: third)",
    )


def _add_reference(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("reference (differences are from 0 to 255)")
    group.add_argument(
        "--reference", metavar="PNG", type=paths.parse_template, help="fail if the picture does not match this one"
    )
    group.add_argument(
        "--reference-threshold",
        metavar="T",
        type=numbers.parse_threshold,
        help="largest difference in red, green, blue or alpha at which a pixel still matches (default: 8)",
    )
    group.add_argument(
        "--reference-pixels",
        metavar="N",
        type=numbers.parse_count,
        help="number of pixels allowed to exceed the threshold (default: 16, and one per 10,000 of the picture, so "
        "that a reference holds on other adapters)",
    )
    group.add_argument(
        "--reference-diff",
        metavar="PNG",
        type=paths.parse_template,
        help="write a picture of the pixels that differ to this file, if the picture does not match",
    )
    group.add_argument(
        "--update-references",
        action="store_true",
        help="write the pictures that do not match, or have no reference, as references, and say which",
    )


def _add_reports(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("all pictures together")
    group.add_argument(
        "--report",
        metavar="FILE",
        type=paths.parse_report_path,
        action="append",
        default=[],
        help="write what became of each picture: .html to look at, .json for programs, .xml (JUnit) for CI services; "
        "may be given several times",
    )
    group.add_argument(
        "--sheet",
        metavar="FILE",
        type=paths.parse_sheet_path,
        help="lay the models out on one contact sheet with their names: a .png, .svg or .pdf file",
    )


def run(options: argparse.Namespace) -> int:
    """Draw the models, in one picture or in one per model, compare the pictures with references, and report."""
    require_drawing_options(options)
    _require_view_options(options)
    references.require_reference_options(options)
    found = find_models(options.models)
    pictures = plan_outputs(
        found.paths,
        options.output,
        options.reference,
        options.reference_diff,
        updates_references=options.update_references,
        others=[*options.report, *([] if options.sheet is None else [options.sheet])],
    )
    _require_pixels(options, pictures)
    require_web_page_options(options, pictures)
    require_sheet_options(options, pictures)
    _require_page(options)
    for path in (*options.report, *([] if options.sheet is None else [options.sheet])):
        require_room(path)
    for path in options.models:
        if n_left_out := count_left_out(path):
            pattern = Path(path, RECURSIVE)
            print_notice(f"{path}: {n_left_out} more below it, which {pattern} takes too")
    unused: list[str] = []
    if options.reference is not None and found.is_whole_set:
        unused = references.find_unused_references(options.reference, pictures, found.roots)
    options.keeps_images = any(file_type(path) == "html" for path in options.report)
    return make_pictures(options, pictures, unused)


def _require_view_options(options: argparse.Namespace) -> None:
    if options.views is None and options.projection is not None:
        raise ArgumentError("--projection must come with --views")
    aims = ("direction", "position", "view_up", "zoom_factor", "azimuth_angle", "elevation_angle")
    given = {name: getattr(options, f"camera_{name}") for name in aims}
    aimed = next(
        (n for n, value in given.items() if not (value is None or (isinstance(value, float) and not value))), None
    )
    if options.views is not None and aimed is not None:
        raise ArgumentError(
            f"--camera-{aimed.replace('_', '-')} cannot go with --views, which aim cameras of their own"
        )


def _require_pixels(options: argparse.Namespace, pictures: Sequence[PlannedPicture]) -> None:
    vector = next((picture.output for picture in pictures if picture.file_type != "png"), None)
    if vector is not None and options.rasterizer != "auto":
        raise ArgumentError(f"{vector}: --rasterizer must come with a .png: other pictures have no pixels")
    if vector is not None and options.dpi is not None:
        raise ArgumentError(f"{vector}: --dpi must come with a .png: a pixel of other pictures is 1/96 inch")


def _require_page(options: argparse.Namespace) -> None:
    """Raise `ArgumentError` for a page that cannot be, before models are read."""
    from ...drawing.page import make_page
    from ...drawing.prepare import DEFAULT_SIZE

    given: dict[str, Any] = {"paper": None, "drawing_scale": None, "margin": None, "units": "mm"}
    typed = collect_page_arguments(options)
    if typed and options.paper is None:
        raise ArgumentError(f"--{next(iter(typed)).replace('_', '-')} must come with --paper, such as --paper A4")
    given |= typed
    with name_options_in_errors(options, ()):
        make_page(**given, size=options.resolution, default_size=DEFAULT_SIZE)
