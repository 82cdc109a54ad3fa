"""`gpu-xform render`: pictures of models, and their comparison with references."""

import argparse
import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..._core.types import Float64Array
from ...drawing.sheet import PROJECTIONS, VIEW_NAMES
from ...errors import ArgumentError
from .. import argument_types as types
from .. import exit_codes, files, references
from .. import options as groups
from ..arguments_from_options import (
    choose_device,
    collect_picture_arguments,
    compose_transforms,
    require_drawing_options,
)
from ..exit_codes import DEVICE_FAILED, MISMATCH, NO_ADAPTER, WRONG_INPUT
from ..layer_option import parse_layer
from ..option_errors import name_options_in_errors
from ..outputs import PlannedPicture, plan_outputs
from ..paths import expand_globs
from ..read_layers import read_layers
from ..streams import print_stderr

if TYPE_CHECKING:
    from ...device import Device

USAGE = "MODEL... (-o OUT | --reference PNG) [options]"
DESCRIPTION = """\
Draw the edges of models, transformed, as a PNG, SVG or PDF picture: all models
in one picture, or, if the path of the picture holds {model}, one picture per
model."""
EPILOG = f"""\
In the paths of pictures, {{model}} stands for the name of a model without folder
and type, and {{folder}} for its folder. Missing folders of such a path are made.
If one of several pictures fails, the others are still made. Without any option
of style, such pictures show shaded faces, with sharp edges and outlines where
the faces are few for the picture: a cube is legible so, and a scan is too.

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
  # a regression test: do the models look as expected?
  gpu-xform render *.obj --reference "expected/{{model}}.png"
  # pipes
  gpu-xform render house.obj -o - --rotate-x -90 | display
  zcat ball.wrl.gz | gpu-xform render - --file-type wrl -o ball.png

exit codes (for several pictures, the lowest code of those that fail):
  0  done
  {DEVICE_FAILED}  the device failed
  {WRONG_INPUT}  wrong usage or input
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
        type=types.parse_template,
        help="the picture: a .png, .svg or .pdf file, one per model if the path holds {model}; "
        "- for a PNG on standard output",
    )
    groups.add_reading_options(group)
    groups.add_page(groups.add_drawing_options(parser, resolution="1024,1024"))
    _add_views(parser)
    _add_reference(parser)
    groups.add_general_options(parser, adapter=True, rasterizer=True)


def _add_views(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("several views on one sheet, at one scale")
    group.add_argument(
        "--views",
        metavar="VIEW[,...]",
        type=types.parse_views,
        help=f"views to draw in parallel projection, among {', '.join(VIEW_NAMES)}; --up says which side is the top",
    )
    group.add_argument(
        "--projection",
        metavar="ANGLE",
        type=types.parse_projection,
        help=f"{' or '.join(PROJECTIONS)}: the top view lies above the front view, or below it (default: third)",
    )


def _add_reference(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("reference (differences are from 0 to 255)")
    group.add_argument(
        "--reference", metavar="PNG", type=types.parse_template, help="fail if the picture does not match this one"
    )
    group.add_argument(
        "--reference-threshold",
        metavar="T",
        type=types.parse_threshold,
        help="largest difference in red, green, blue or alpha at which a pixel still matches (default: 8)",
    )
    group.add_argument(
        "--reference-pixels",
        metavar="N",
        type=types.parse_count,
        help="number of pixels allowed to exceed the threshold (default: 0)",
    )
    group.add_argument(
        "--reference-diff",
        metavar="PNG",
        type=types.parse_template,
        help="write a picture of the pixels that differ to this file, if the picture does not match",
    )


def run(options: argparse.Namespace) -> int:
    """Draw the models, in one picture or in one per model, and compare the pictures with references."""
    require_drawing_options(options)
    _require_view_options(options)
    references.require_reference_options(options)
    models = expand_globs(options.models)
    pictures = plan_outputs(models, options.output, options.reference, options.reference_diff)
    _require_pixels(options, pictures)
    _require_page(options)
    open_device = functools.cache(lambda: choose_device(options))  # once for all pictures, when the first is read
    make = functools.partial(_make_picture, options, compose_transforms(options), open_device)
    if len(pictures) > 1:
        return _make_each(pictures, make)
    make(pictures[0])
    return 0


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


def _collect_page_arguments(options: argparse.Namespace) -> dict[str, Any]:
    """Return the keywords of the page that were typed."""
    names = ("paper", "drawing_scale", "margin", "units")
    return {name: getattr(options, name) for name in names if getattr(options, name) is not None}


def _require_page(options: argparse.Namespace) -> None:
    """Raise `ArgumentError` for a page that cannot be, before models are read."""
    from ...drawing.page import make_page
    from ...drawing.prepare import DEFAULT_SIZE

    given: dict[str, Any] = {"paper": None, "drawing_scale": None, "margin": None, "units": "mm"}
    given |= _collect_page_arguments(options)
    with name_options_in_errors(options, options.models):
        make_page(**given, size=options.resolution, default_size=DEFAULT_SIZE)


def _make_each(pictures: Sequence[PlannedPicture], make: Callable[[PlannedPicture], None]) -> int:
    """Make all pictures that can be made; print the errors of the others, and how many there are of each kind."""
    from ..._core import progress

    codes = []
    with progress.show_progress("render", " pictures") as move:
        for done, picture in enumerate(pictures, 1):
            try:
                make(picture)
            except exit_codes.FAILURES as error:
                progress.write_lines(exit_codes.format_error(error, picture.name))
                codes.append(exit_codes.exit_code_for(error))
            move(done, len(pictures))
    n_mismatched = codes.count(MISMATCH)
    counts = {
        "done": len(pictures) - len(codes),
        "failed": len(codes) - n_mismatched,
        "not matching the reference": n_mismatched,
    }
    summary = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count or outcome == "done")
    print_stderr(f"gpu-xform: {len(pictures)} pictures: {summary}\n")
    return min(codes, default=0)


def _make_picture(
    options: argparse.Namespace,
    world_from_model: Float64Array,
    open_device: Callable[[], "Device"],
    picture: PlannedPicture,
) -> None:
    """Draw a picture, write it, and compare it with its reference."""
    drawn = _draw(options, world_from_model, open_device, picture)
    _warn_if_blank(drawn, picture)
    if picture.output is not None:
        files.write_picture(drawn, picture.output, make_folders=options.output.is_per_model)
    if picture.reference is not None:
        references.require_match(picture.reference, drawn, picture.difference, options)


def _warn_if_blank(drawn: Any, picture: PlannedPicture) -> None:
    """Say so if all pixels are alike, as they are if a camera looks past the models."""
    if picture.file_type == "png" and all(low == high for low, high in drawn.getextrema()):
        from ..._core import progress

        reason = "the picture is blank: nothing of the models is in view, or all is of the background's colour"
        progress.write_lines(f"gpu-xform: warning: {picture.output or picture.reference}: {reason}\n")


def _draw(
    options: argparse.Namespace,
    world_from_model: Float64Array,
    open_device: Callable[[], "Device"],
    picture: PlannedPicture,
) -> Any:
    """Return a Pillow image, the text of an SVG, or the bytes of a PDF."""
    templates = (options.output, options.reference, options.reference_diff)
    is_of_many = any(template is not None and template.is_per_model for template in templates)
    layers = read_layers(options, picture.models, world_from_model, options.resolution if is_of_many else None)
    with name_options_in_errors(options, picture.models):
        renderer = _find_renderer(options, picture.file_type)
        arguments = collect_picture_arguments(options, layers, open_device())
        if options.views is not None:
            arguments |= {"views": options.views, "camera": {"up": options.up}}
            arguments |= {} if options.projection is None else {"projection": options.projection}
        return renderer(layers, **arguments)


def _find_renderer(options: argparse.Namespace, file_type: str) -> Callable[..., Any]:
    if file_type == "png":
        from ...rendering import raster

        page = _collect_page_arguments(options) | ({} if options.dpi is None else {"dpi": options.dpi})
        return functools.partial(raster.render, rasterizer=options.rasterizer, **page)
    from ...rendering import vector

    renderer = {"svg": vector.render_svg, "pdf": vector.render_pdf}[file_type]
    return functools.partial(renderer, **_collect_page_arguments(options))
