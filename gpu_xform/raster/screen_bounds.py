"""Screen bounds: the part of a picture that drawables lie in; beyond it is background, which need not be drawn."""

from collections.abc import Iterator

import numpy as np

from .._core.types import Float64Array
from ..drawing.boxes import box_corners
from ..drawing.draw_list import DrawList
from ..drawing.view import ndc_to_pixels
from .tiles import Region

REGION_ALIGNMENT_PX = 16  # so that the bounds of a model in motion are few
AA_MARGIN_PX = 3.0  # that a line may touch beside half its width, the error of single precision included
MIN_RELATIVE_W = 1e-4  # of the largest coordinate; nearer to the eye, single precision could place a point anywhere


def screen_bounds(draw_list: DrawList, size: tuple[int, int]) -> Region:
    """Return a part of a picture of `size` = (width, height) pixels that holds all that is drawn of a draw list."""
    width, height = size
    left, top, right, bottom = float(width), float(height), 0.0, 0.0
    for points, matrices, line_width in _list_extents(draw_list):
        pixels = _bounding_pixels(points, matrices, size)
        if pixels is None:
            return Region((0, 0), size)
        margin = AA_MARGIN_PX + 0.5 * line_width
        (first_x, first_y), (last_x, last_y) = pixels.min(axis=0).tolist(), pixels.max(axis=0).tolist()
        left, top = min(left, first_x - margin), min(top, first_y - margin)
        right, bottom = max(right, last_x + margin), max(bottom, last_y + margin)
    x, x_end = _align(left, right, width)
    y, y_end = _align(top, bottom, height)
    if x >= x_end or y >= y_end:  # nothing is in view; an empty part could not be drawn
        return Region((0, 0), (min(width, REGION_ALIGNMENT_PX), min(height, REGION_ALIGNMENT_PX)))
    return Region((x, y), (x_end - x, y_end - y))


def _align(first: float, last: float, side: int) -> tuple[int, int]:
    """Return the start and the end of an aligned part of a side that holds all from `first` to `last`."""
    alignment = REGION_ALIGNMENT_PX
    return int(max(first, 0.0) // alignment * alignment), int(min(-(-last // alignment) * alignment, side))


def _list_extents(draw_list: DrawList) -> Iterator[tuple[Float64Array | None, Float64Array, float]]:
    """Yield of each drawable and cloud the points that bound it, its matrices, and the width of its widest line."""
    for drawable in draw_list.drawables:
        widths = (lines.line_width or 1.0 for lines in drawable.lines)
        yield drawable.points.bounding_points, drawable.clip_from_points, max(widths, default=0.0)
    for cloud in draw_list.clouds:
        yield cloud.bounding_points, cloud.clip_from_points, cloud.diameter


def _bounding_pixels(points: Float64Array | None, matrices: Float64Array, size: tuple[int, int]) -> Float64Array | None:
    """Return two pixels (2, 2) between which all lies that some points bound; None if it may lie anywhere."""
    if points is None:
        return None
    if len(matrices) > 1:
        points = box_corners(np.array([points.min(axis=0), points.max(axis=0)]))
    rows = matrices[:, [0, 1, 3]]
    clip = rows[:, :, :3] @ points.T + rows[:, :, 3:]
    w = clip[:, 2:]
    if not w.min() > MIN_RELATIVE_W * max(clip.max(), -clip.min()):
        return None
    ndc = clip[:, :2] / w
    bounds = np.stack([ndc.min(axis=(0, 2)), ndc.max(axis=(0, 2))])
    return ndc_to_pixels(bounds, size)
