"""Pictures as vectors: `render_svg` and `render_pdf`, of the same models and styles as pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Unpack

from .._core.public import public
from .._core.types import StrPath
from ..annotation.items import Annotation
from ..annotation.options import AnnotationOptions, AxesLike, LegendLike
from ..device import Device
from ..drawing.camera import CameraLike
from ..drawing.layer import Models, Style
from ..drawing.page import PaperLike, make_page
from ..drawing.prepare import DEFAULT_SIZE, Frame, PreparedFrame, Size, parse_size, prepare_frame
from ..drawing.sheet import Projection, ViewName
from ..drawing.style_signature import describe_parameters_of, show_style_keywords
from ..errors import ArgumentError
from ..imaging.colors import ColorLike, Rgba, parse_background
from ..vector import VectorLayer, format_pdf, format_svg
from ..vector.build_layers import build_layers
from ..vector.edge_visibility import MARGIN_PX
from ..vector.svg_text import SvgText
from .annotate import make_annotation
from .raster import render
from .sheets import plan_sheet


@public
@describe_parameters_of(render)
@show_style_keywords
def render_svg(  # noqa: D417 - the decorator describes the others
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = DEFAULT_SIZE,
    background: ColorLike | None = "white",
    device: Device | None = None,
    axes: AxesLike = False,
    legend: LegendLike = False,
    font: StrPath | None = None,
    font_size: float | None = None,
    paper: PaperLike | None = None,
    drawing_scale: str | float | None = None,
    margin: float | str | None = None,
    units: str = "mm",
    views: Sequence[ViewName] | str | None = None,
    projection: Projection = "third",
    **style: Unpack[Style],
) -> SvgText:
    """Draw models as `render` does; return an SVG document with a group per model.

    Parameters
    ----------
    models, camera, size, background, device, axes, legend, font, font_size, paper : as `render` takes them
    drawing_scale, margin, units, views, projection, **style : as `render` takes them

    Returns
    -------
    SvgText
        The document, a string; `save` writes it to a file, and notebooks show it. A pixel of `size` is one user unit.

    Raises
    ------
    ArgumentError
        An argument has an impossible value; the message names it: "size must be (width, height), got 5".
    ArgumentTypeError
        An argument has a wrong type, or a keyword is unknown: "unexpected keyword argument 'colour'".
    MeshError
        A model has nothing to draw, or its file is malformed.
    OSError
        A model file cannot be read.

    Notes
    -----
    The same depths as for pixels decide which parts of edges are hidden, to about a pixel. Hidden parts are left out or
    styled apart, as `hidden` says.

    Faces are painted from the farthest to the nearest. Faces that intersect, or that hide one another in a cycle, are
    split; faces that `depth_cue` fades unevenly are split into bands of one colour each. If splitting would make
    several times as many faces, or if millions overlap, some faces are painted in the order of their farthest corners.

    Without an opaque background, faces that fade let others show through, and faces that are not filled hide no other
    faces. An edge that is not opaque has one colour, that of its middle. Lines that are not anti-aliased become lines
    of one pixel.

    Texts are text, in the family of the font, fitted to the widths that the font has here: viewers without it show
    another one of the same widths.
    """
    page = make_page(paper, drawing_scale, margin, units, size, DEFAULT_SIZE)
    frame = Frame(camera, size, background, device, AnnotationOptions(axes, legend, font, font_size), page=page)
    return SvgText(format_svg(*draw_layers(models, frame, style, views, projection)))


@public
@describe_parameters_of(render)
@show_style_keywords
def render_pdf(  # noqa: D417 - the decorator describes the others
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = DEFAULT_SIZE,
    background: ColorLike | None = "white",
    device: Device | None = None,
    axes: AxesLike = False,
    legend: LegendLike = False,
    font: StrPath | None = None,
    font_size: float | None = None,
    paper: PaperLike | None = None,
    drawing_scale: str | float | None = None,
    margin: float | str | None = None,
    units: str = "mm",
    views: Sequence[ViewName] | str | None = None,
    projection: Projection = "third",
    **style: Unpack[Style],
) -> bytes:
    """Draw models as `render_svg` does; return a PDF document of one page.

    Parameters
    ----------
    models, camera, size, background, device, axes, legend, font, font_size, paper : as `render` takes them
    drawing_scale, margin, units, views, projection, **style : as `render` takes them

    Returns
    -------
    bytes
        The document; a pixel of `size` is 1/96 inch. Texts are text, and what of their fonts they need is embedded.

    Raises
    ------
    ArgumentError
        An argument has an impossible value; the message names it: "size must be (width, height), got 5".
    ArgumentTypeError
        An argument has a wrong type, or a keyword is unknown: "unexpected keyword argument 'colour'".
    MeshError
        A model has nothing to draw, or its file is malformed.
    OSError
        A model file cannot be read.
    MissingExtraError
        The extra `pdf` is not installed.
    """
    page = make_page(paper, drawing_scale, margin, units, size, DEFAULT_SIZE)
    frame = Frame(camera, size, background, device, AnnotationOptions(axes, legend, font, font_size), page=page)
    return format_pdf(*draw_layers(models, frame, style, views, projection))


def _draw_one(
    models: Models, frame: Frame, style: Style
) -> tuple[tuple[float, float], Rgba, list[VectorLayer], Annotation]:
    """Return what `draw_layers` does, of a picture."""
    with prepare_frame(models, frame, style) as prepared:
        _require_depths_fit(prepared)
        size = prepared.view.size if frame.page is None else frame.page.sides_px(frame.dpi)
        return size, prepared.background, build_layers(prepared), make_annotation(prepared)


def draw_layers(
    models: Models, frame: Frame, style: Style, views: Sequence[ViewName] | str | None, projection: Projection
) -> tuple[tuple[float, float], Rgba, list[VectorLayer], Annotation]:
    """Return the size, the background, the layers and the annotation of a picture or of a sheet of views."""
    sheet = plan_sheet(models, frame, style, views, projection)
    if sheet is None:
        return _draw_one(models, frame, style)
    all_layers, annotation = [], sheet.key
    for view in sheet.views:
        _, _, layers, texts = _draw_one(sheet.layers, view.frame, {})
        named = [replace(layer, name=f"{view.name}: {layer.name}") if layer.name else layer for layer in layers]
        all_layers += [layer.moved(*view.offset) for layer in named]
        annotation += texts.moved(*view.offset)
    size = parse_size(frame.size) if frame.page is None else frame.page.sides_px(frame.dpi)
    return size, parse_background(frame.background), all_layers, annotation


def _require_depths_fit(prepared: PreparedFrame) -> None:
    """Raise if one binding cannot hold a depth for each pixel, by which edges are split."""
    width, height = prepared.view.size
    most = prepared.device.limits.max_bound_bytes // 4
    if (width + 2 * MARGIN_PX) * (height + 2 * MARGIN_PX) > most:
        room = f"{most:,} pixels in a vector picture, {MARGIN_PX} at each side included"
        raise ArgumentError.expecting("size", f"be at most {room}", f"{width} x {height}")
