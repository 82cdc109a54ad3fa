"""How far the shapes of a picture reach: what lies beyond is background, and need not be drawn."""

import itertools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ..drawing.draw_list import Shape
from .tiles import Region

GRID = 64  # pixels from one place where a region may begin to the next, so that what moves finds memory of its size
RIM = 3.0  # pixels that a line may touch beside half its width, single precision's own included
LEAST_W = 1e-4  # of the largest coordinate; nearer to the eye, single precision could place a point anywhere
UNIT_CORNERS = np.array(list(itertools.product((0.0, 1.0), repeat=3)))


def reached(shapes: Sequence[Shape], size: tuple[int, int]) -> Region:
    """Return a part of a picture of `size` = (width, height) pixels that holds everything drawn of `shapes`."""
    width, height = size
    left, top, right, bottom = float(width), float(height), 0.0, 0.0
    for shape in shapes:
        places = _places(shape, size)
        if places is None:
            return Region((0, 0), size)
        rim = RIM + 0.5 * max((lines.line_width or 1.0 for lines in shape.lines), default=0.0)
        (first_x, first_y), (last_x, last_y) = places.min(axis=0).tolist(), places.max(axis=0).tolist()
        left, top = min(left, first_x - rim), min(top, first_y - rim)
        right, bottom = max(right, last_x + rim), max(bottom, last_y + rim)
    x, x_end = _on_grid(left, right, width)
    y, y_end = _on_grid(top, bottom, height)
    if x >= x_end or y >= y_end:  # nothing is in view; an empty part could not be drawn
        return Region((0, 0), (min(width, GRID), min(height, GRID)))
    return Region((x, y), (x_end - x, y_end - y))


def _on_grid(first: float, last: float, side: int) -> tuple[int, int]:
    """Return where a part of a side begins and ends that holds all from `first` to `last`."""
    return int(max(first, 0.0) // GRID * GRID), int(min(-(-last // GRID) * GRID, side))


def _places(shape: Shape, size: tuple[int, int]) -> npt.NDArray[np.float64] | None:
    """Return pixels (p, 2) between which all of a shape lies; None where it may lie anywhere."""
    bounding_points, matrices = shape.points.bounding_points, shape.clip_from_points
    if bounding_points is None:
        return None
    if len(matrices) > 1:
        first, last = bounding_points.min(axis=0), bounding_points.max(axis=0)
        bounding_points = first + (last - first) * UNIT_CORNERS
    rows = matrices[:, [0, 1, 3]]
    clip = np.einsum("kij,nj->kni", rows[:, :, :3], bounding_points) + rows[:, np.newaxis, :, 3]
    w = clip[..., 2:]
    if not w.min() > LEAST_W * np.abs(clip).max():
        return None
    places: npt.NDArray[np.float64] = (clip[..., :2] / w * (0.5, -0.5) + 0.5) * size
    return places.reshape(-1, 2)
