"""Axes and keys of a picture: what they need of its sides, and the layers of the axes in space."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array
from ..annotation.axes import PADDING, AxesFigure, inset_matrix, lay_out_axes, overflow, pad_bounds
from ..annotation.column import Column
from ..annotation.items import Annotation, Box
from ..annotation.text_style import TextStyle
from ..errors import MeshError
from ..geometry.mesh import Mesh
from .depth import eye, reverse_z
from .layer import Layer

MAX_INSET_SHARE = 0.4  # of a side of the picture, at either end
_MARGIN = 0.4  # around the texts, in sizes of the font
_MAX_ROUNDS = 5
_BEYOND = 2.0 * PADDING  # of the frame
_GRID_COLORS = {True: "#d9d9d9", False: "#4d4d4d"}  # on light and on dark
_SPINE_COLORS = {True: "#555555", False: "#bbbbbb"}


class Layout(NamedTuple):
    """The view of a picture with axes and keys.

    forward_z : (4, 4), from the world to clip space
    layers : the grid and the axes, beneath all models
    """

    forward_z: Float64Array
    annotation: Annotation
    layers: Sequence[Layer]


def box_of_axes(points: Float64Array) -> Float64Array:
    """Return the bounds (2, 3) of the box of axes around points (n, 3)."""
    if len(points) == 0:
        raise MeshError("models must have finite points with w > 0 to have axes around them")
    return pad_bounds(np.stack([points.min(axis=0), points.max(axis=0)]))


def lay_out(
    clip_from_world: Callable[[float], Float64Array],
    box: Float64Array | None,
    titles: Sequence[str | None],
    column: Column,
    size: tuple[int, int],
    style: TextStyle,
) -> Layout:
    """Return the view that leaves room at the sides: as `clip_from_world` gives it for an aspect, in a smaller frame.

    box : the bounds (2, 3) of the axes; None for no axes
    """

    def find_eye(forward_z: Float64Array) -> Float64Array:
        return eye(reverse_z(forward_z, lambda: np.zeros((0, 3)) if box is None else box))

    inset = np.array((0.0, 0.0, min(column.width, MAX_INSET_SHARE * size[0]), 0.0))
    sides = np.array((*size, *size))
    for _ in range(_MAX_ROUNDS):
        left, top, right, bottom = inset.tolist()
        inner = Box(left, top, size[0] - right, size[1] - bottom)
        aspect = (inner.right - inner.left) / (inner.bottom - inner.top)
        forward_z: Float64Array = inset_matrix(inset, size) @ clip_from_world(aspect)
        if box is None:
            return Layout(forward_z, column.annotation, ())
        figure = lay_out_axes(box, forward_z, find_eye(forward_z), size, _widen(inner), titles, style)
        room = (size[0] - column.width, size[1])
        lacking = overflow(figure.annotation.texts, room, _MARGIN * style.size)
        if (lacking < 0.5).all():
            break
        lacking[2] = min(lacking[2], max(0.0, MAX_INSET_SHARE * size[0] + column.width - right))
        inset = np.minimum(inset + lacking, MAX_INSET_SHARE * sides + (0.0, 0.0, column.width, 0.0))
    return Layout(forward_z, figure.annotation + column.annotation, _make_layers(figure, style))


def _widen(frame: Box) -> Box:
    """Return where ticks may lie: a little beyond the frame too, as the box of the axes is larger than the models."""
    x, y = _BEYOND * (frame.right - frame.left), _BEYOND * (frame.bottom - frame.top)
    return Box(frame.left - x, frame.top - y, frame.right + x, frame.bottom + y)


def _make_layers(figure: AxesFigure, style: TextStyle) -> list[Layer]:
    width = max(0.75, 0.05 * style.size)
    spines = "axes", figure.spines, _SPINE_COLORS[style.is_dark], 1.5 * width
    parts = [("grid", figure.grid, _GRID_COLORS[style.is_dark], width), spines]
    return [
        Layer(_segments(segments), name=name, color=color, line_width=line_width, hidden="remove")
        for name, segments, color, line_width in parts
        if len(segments)
    ]


def _segments(segments: Float64Array) -> Mesh:
    n = len(segments)
    return Mesh(segments.reshape(-1, 3), np.arange(2 * n).reshape(n, 2).tolist())
