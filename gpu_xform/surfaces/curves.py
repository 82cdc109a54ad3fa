"""Bézier curves to polylines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import SupportsIndex

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array
from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError
from ..geometry.mesh import Mesh
from .bernstein import evaluate_bernstein, join_curves
from .control_points import divide_by_weights, number_points, number_weights, require_control_points
from .resolution import choose_steps, require_one
from .weld import compact, number_curves


@public
def curve(
    control_points: npt.ArrayLike | Sequence[npt.ArrayLike],
    n: SupportsIndex | None = None,
    tolerance: float | None = None,
) -> Mesh:
    """Return Bézier curves as a mesh of n segments per curve.

    Curves that start or end in the same control point share that point, and so do curves with the same control points
    in either direction.

    Parameters
    ----------
    control_points : (k, a, 2), (k, a, 3) or (k, a, 4) numbers, or a sequence of (a_i, 2), (a_i, 3) or (a_i, 4)
        k curves of degree a - 1, or curves of several degrees, such as the lines, quadratic and cubic curves of an SVG
        path; of one curve alone, also (a, 2) or more. Points (x, y) lie in the plane z = 0. With a fourth coordinate,
        the weight w > 0, the curves are rational: (x, y, z, w) stands for the point (x/w, y/w, z/w).
    n : int
        The number of segments of each curve, at least 1. Either n or `tolerance` must be given.
    tolerance : float
        The largest distance between curve and segment, in the unit of the points: a promise, but for rounding. It
        gives the least n with max |C''| / (8 n^2) <= `tolerance`, where the second differences of the control points
        bound C''. All curves get the same n.

    Returns
    -------
    Mesh
        Its faces are segments, from the start of each curve to its end.

    Raises
    ------
    ArgumentError
        For a wrong shape, a weight that is not positive, both or neither of n and `tolerance`, and if more than 2^24
        segments were needed.
    ArgumentTypeError
        If `control_points` holds no real numbers.
    """
    require_one(n, tolerance)
    curves = _as_curves(control_points, "control_points")
    return Mesh(*tessellate_curves(curves, choose_steps(n, tolerance, [curves])))


def tessellate_curves(curves: Float64Array, steps: int) -> tuple[Float64Array, IndexArray]:
    """Return the points (n, 3) and the segments (k steps, 2) of curves (k, a, 3 or 4), one after another."""
    numbers, places = _number_curve_points(curves, steps)
    points = evaluate_bernstein(curves.shape[1] - 1, np.arange(steps + 1) / steps) @ curves
    segments = np.stack([numbers[:, :-1], numbers[:, 1:]], axis=-1).reshape(-1, 2)
    return divide_by_weights(points).reshape(-1, 3).take(places, axis=0), segments


def _as_curves(value: npt.ArrayLike | Sequence[npt.ArrayLike], name: str) -> Float64Array:
    """Return control points of curves as (k, a, 3) or (k, a, 4), all of the highest degree that occurs."""
    try:
        orders = {np.shape(row)[:-1] for row in value}  # type: ignore[union-attr]
    except (TypeError, ValueError):  # not a sequence, or ragged within a curve
        orders = set()
    if len(orders) < 2:
        curves = as_real_array(value, name)  # type: ignore[arg-type]
        return _complete(curves[np.newaxis] if curves.ndim == 2 else curves, name)
    rows = [as_real_array(row, f"{name}[{i}]") for i, row in enumerate(value)]  # type: ignore[arg-type]
    completed = [_complete(row[np.newaxis], f"{name}[{i}]")[0] for i, row in enumerate(rows)]
    widths = {row.shape[1] for row in completed}
    if len(widths) > 1:
        raise ArgumentError.expecting(name, "be all rational or none", "3 and 4 coordinates")
    return join_curves([row[np.newaxis] for row in completed])


def _complete(curves: Float64Array, name: str) -> Float64Array:
    """Return curves (k, a, 2) as (k, a, 3) in the plane z = 0; other valid ones as they are."""
    if curves.ndim == 3 and curves.shape[-1] == 2:
        curves = np.concatenate([curves, np.zeros((*curves.shape[:-1], 1))], axis=-1)
    if curves.ndim != 3 or curves.shape[-1] not in (3, 4):
        raise ArgumentError.expecting(name, "have shape (k, a, 2), (k, a, 3) or (k, a, 4)", curves.shape)
    require_control_points(curves, name, "k, a")
    return curves


def _number_curve_points(control_points: Float64Array, n: int) -> tuple[IndexArray, IndexArray]:
    """Return the number of each of the n + 1 points of each curve, (k, n + 1), and the places of the first ones."""
    control_numbers = number_points(control_points)
    weights = number_weights(control_points) if control_points.shape[-1] == 4 else None
    curves, n_curves, is_backward, is_point = number_curves(control_numbers, weights)
    base = int(control_numbers.max()) + 1
    along = np.arange(n - 1)
    along = np.where(is_backward[:, np.newaxis], along[::-1], along)
    inner = base + curves[:, np.newaxis] * (n - 1) + along
    inner = np.where(is_point[:, np.newaxis], control_numbers[:, :1], inner)
    keys = np.concatenate([control_numbers[:, :1], inner, control_numbers[:, -1:]], axis=1)
    return compact(keys, base + n_curves * (n - 1))
