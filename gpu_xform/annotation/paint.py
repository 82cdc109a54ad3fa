"""Annotations in pixels: shapes by the area that they cover, and texts by Pillow's fonts."""

import math

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..imaging.colors import Rgba
from ..imaging.image import Pixels
from .items import Annotation, Box, Disc, Line, Rectangle, Shape, Text, box_of_shape
from .text_style import HALO_WIDTH


def draw_annotation(pixels: Pixels, annotation: Annotation) -> None:
    """Draw an annotation over pixels (height, width, 4), straight alpha, in place."""
    for shape in annotation.shapes:
        for part in _split_dashes(shape):
            _draw_shape(pixels, part)
    halos = [text for text in annotation.texts if text.halo is not None]
    for text in halos:  # all before the first letter, which no halo may cover
        _draw_text(pixels, text, text.halo, HALO_WIDTH * text.font.size)
    for text in annotation.texts:
        _draw_text(pixels, text, text.color, 0.0)


def _split_dashes(shape: Shape) -> list[Shape]:
    """Return a line's dashes; any other shape as it is."""
    if not isinstance(shape, Line) or not shape.dash:
        return [shape]
    length = math.hypot(shape.x1 - shape.x0, shape.y1 - shape.y0)
    x, y = (shape.x1 - shape.x0) / length, (shape.y1 - shape.y0) / length
    parts: list[Shape] = []
    start, index = 0.0, 0
    while start < length:
        end = min(start + shape.dash[index % len(shape.dash)], length)
        if index % 2 == 0:
            ends = shape.x0 + x * start, shape.y0 + y * start, shape.x0 + x * end, shape.y0 + y * end
            parts.append(Line(*ends, shape.width, shape.color))
        start, index = end, index + 1
    return parts


def _draw_shape(pixels: Pixels, shape: Shape) -> None:
    box = box_of_shape(shape).widened(1.0)
    region = _region(pixels, box)
    if region is None:
        return
    rows, columns = region
    y, x = np.mgrid[rows, columns] + 0.5
    _blend(pixels[rows, columns], shape.color, _coverage(shape, x, y))


def _region(pixels: Pixels, box: Box) -> tuple[slice, slice] | None:
    """Return the rows and columns of the pixels that a box touches; None if there are none."""
    height, width = pixels.shape[:2]
    first_row, last_row = max(math.floor(box.top), 0), min(math.ceil(box.bottom), height)
    first_column, last_column = max(math.floor(box.left), 0), min(math.ceil(box.right), width)
    if first_row >= last_row or first_column >= last_column:
        return None
    return slice(first_row, last_row), slice(first_column, last_column)


def _coverage(shape: Shape, x: Float64Array, y: Float64Array) -> Float64Array:
    """Return how much of the pixels with centres (x, y) a shape covers, from 0 to 1."""
    if isinstance(shape, Rectangle):
        left, top, right, bottom = shape.box
        return _overlap(x, left, right) * _overlap(y, top, bottom)
    if isinstance(shape, Disc):
        return np.clip(0.5 * shape.diameter + 0.5 - np.hypot(x - shape.x, y - shape.y), 0.0, 1.0)
    dx, dy = shape.x1 - shape.x0, shape.y1 - shape.y0
    length = math.hypot(dx, dy) or 1.0
    along = ((x - shape.x0) * dx + (y - shape.y0) * dy) / length
    across = ((x - shape.x0) * dy - (y - shape.y0) * dx) / length
    return _overlap(along, 0.0, length) * _overlap(across, -0.5 * shape.width, 0.5 * shape.width)


def _overlap(center: Float64Array, low: float, high: float) -> Float64Array:
    """Return the length that intervals of length 1 have in common with [low, high]."""
    length: Float64Array = np.clip(np.minimum(center + 0.5, high) - np.maximum(center - 0.5, low), 0.0, 1.0)
    return length


def _draw_text(pixels: Pixels, text: Text, color: Rgba | None, stroke: float) -> None:
    from PIL import Image, ImageDraw

    region = _region(pixels, text.box.widened(stroke + 2.0))
    if region is None or color is None:
        return
    rows, columns = region
    mask = Image.new("L", (columns.stop - columns.start, rows.stop - rows.start))
    at = text.x - columns.start, text.y - rows.start
    ImageDraw.Draw(mask).text(at, text.text, 255, text.font.pillow, anchor="ls", stroke_width=stroke)
    _blend(pixels[rows, columns], color, np.asarray(mask) / 255.0)


def _blend(below: Pixels, color: Rgba, coverage: npt.NDArray[np.float64]) -> None:
    """Draw a colour over pixels (h, w, 4), straight alpha, as far as it covers them (h, w)."""
    alpha = coverage * color[3]
    below_alpha = below[..., 3] / 255.0 * (1.0 - alpha)
    total = alpha + below_alpha
    mixed = alpha[..., np.newaxis] * np.multiply(color[:3], 255.0) + below_alpha[..., np.newaxis] * below[..., :3]
    is_drawn = alpha > 0.0
    rgb = mixed[is_drawn] / total[is_drawn, np.newaxis]
    below[is_drawn] = np.rint(np.column_stack([rgb, 255.0 * total[is_drawn]])).astype(np.uint8)
