"""Sheets of views: the layers, the frame and the place of each view."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ..annotation.options import NO_OPTIONS
from ..drawing.framing import framing_points
from ..drawing.layer import Layer, Models, Style, as_layers
from ..drawing.lengths import MM_PER_INCH
from ..drawing.load_models import load_models
from ..drawing.prepare import Frame, parse_size
from ..drawing.sheet import check_projection, check_views, lay_out_sheet, up_of
from ..errors import ArgumentError


class SheetPart(NamedTuple):
    """What is drawn of a sheet at once: a view, in a frame of its own, whose first pixel lies at `offset` (x, y)."""

    layers: Sequence[Layer]
    frame: Frame
    offset: tuple[int, int]


def plan_sheet(models: Models, frame: Frame, style: Style, views: object, projection: object) -> list[SheetPart] | None:
    """Return the parts of a sheet, or None for a picture that is none. Raises as `render` does."""
    is_third_angle = check_projection(projection)
    names = check_views(views)
    if names is None:
        return None
    up = up_of(frame.camera)
    if frame.annotations != NO_OPTIONS:
        raise ArgumentError("views cannot go with axes, a legend or a font: their texts have no room on a sheet")
    layers = as_layers(load_models(models), style)
    size, gap, px_per_unit = parse_size(frame.size), None, None
    if frame.page is not None:
        size, px_per_mm = frame.page.size_px(frame.dpi), frame.dpi / MM_PER_INCH
        gap = px_per_mm * frame.page.margin_mm
        scale = frame.page.paper_mm_per_unit
        px_per_unit = None if scale is None else px_per_mm * scale
    points = framing_points(layers)
    sheet = lay_out_sheet(points, names, size, up, is_third_angle=is_third_angle, gap=gap, px_per_unit=px_per_unit)
    return [
        SheetPart(
            [replace(layer, name=f"{view.name}: {layer.name}") if layer.name else layer for layer in layers],
            replace(frame, camera=view.camera, size=view.size, page=None),
            view.origin,
        )
        for view in sheet
    ]
