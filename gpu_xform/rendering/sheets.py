"""Sheets of views: what is drawn in each view, in which frame and where, and what stands beside all of them."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ..annotation.column import Column, lay_out_column
from ..annotation.items import NO_ANNOTATION, Annotation
from ..annotation.options import NO_OPTIONS, AnnotationOptions
from ..annotation.text_style import make_text_style
from ..drawing.axes_layout import MAX_INSET_SHARE
from ..drawing.framing import framing_points
from ..drawing.geometry_source import geometry_source
from ..drawing.keys import check_legend, check_titles, color_bars, legend_entries
from ..drawing.layer import Layer, Models, Style, as_layers, with_lengths_in_pixels
from ..drawing.lengths import MM_PER_INCH
from ..drawing.load_models import load_models
from ..drawing.prepare import Frame, parse_size
from ..drawing.sheet import check_projection, check_views, lay_out_sheet, up_of
from ..errors import ArgumentError
from ..imaging.colors import parse_background


class SheetPart(NamedTuple):
    """A view, in a frame of its own, whose first pixel lies at `offset` (x, y) of the sheet."""

    name: str
    frame: Frame
    offset: tuple[int, int]


class Sheet(NamedTuple):
    """What is drawn in each view, the views, and the legend and the colour bars of all of them."""

    layers: Sequence[Layer]
    views: Sequence[SheetPart]
    key: Annotation


def plan_sheet(models: Models, frame: Frame, style: Style, views: object, projection: object) -> Sheet | None:
    """Return a sheet, or None for a picture that is none. Raises as `render` does."""
    is_third_angle = check_projection(projection)
    names = check_views(views)
    if names is None:
        return None
    up = up_of(frame.camera)
    if check_titles(frame.annotations.axes) is not None:
        raise ArgumentError("views cannot go with axes: their numbers have no room on a sheet")
    layers = as_layers(load_models(models), style)
    size, gap, px_per_unit = parse_size(frame.size), None, None
    if frame.page is not None:
        size, px_per_mm = frame.page.size_px(frame.dpi), frame.dpi / MM_PER_INCH
        gap = px_per_mm * frame.page.margin_mm
        scale = frame.page.paper_mm_per_unit
        px_per_unit = None if scale is None else px_per_mm * scale
    key, texts = _lay_out_texts(layers, frame, size)
    room = size[0] - math.ceil(min(key.width, MAX_INSET_SHARE * size[0])), size[1]
    points = framing_points(layers)
    placed = lay_out_sheet(points, names, room, up, is_third_angle=is_third_angle, gap=gap, px_per_unit=px_per_unit)
    parts = [
        SheetPart(
            view.name, replace(frame, camera=view.camera, size=view.size, page=None, annotations=texts), view.origin
        )
        for view in placed
    ]
    return Sheet([replace(layer, colorbar=False) for layer in layers], parts, key.annotation)


def _lay_out_texts(layers: Sequence[Layer], frame: Frame, size: tuple[int, int]) -> tuple[Column, AnnotationOptions]:
    """Return the legend and the colour bars of a sheet, and how the texts of its views look: all of one size."""
    asked = frame.annotations
    if asked == NO_OPTIONS and all(layer.labels is None and layer.colorbar is False for layer in layers):
        return Column(0.0, NO_ANNOTATION), NO_OPTIONS
    style = make_text_style(asked.font, asked.font_size, size, parse_background(frame.background))
    drawn = [with_lengths_in_pixels(layer, frame.dpi) for layer in layers]
    entries = legend_entries(drawn, [geometry_source(layer) for layer in drawn], check_legend(asked.legend))
    bars = color_bars(drawn)
    if frame.page is not None and (entries or bars):
        raise ArgumentError.expecting("paper", "not be given with axes, a legend or a colour bar")
    return lay_out_column(entries, bars, size, style), AnnotationOptions(font=asked.font, font_size=style.size)
