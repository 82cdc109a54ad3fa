"""Curves and surfaces point by point, by de Casteljau's steps and the recursion of B-splines; quads between points."""

import numpy as np
import numpy.typing as npt

from gpu_xform._core.types import Float64Array


def casteljau(points: Float64Array, t: float) -> Float64Array:
    """Return the point of a Bézier curve (a, ...) at t."""
    while len(points) > 1:
        points = (1 - t) * points[:-1] + t * points[1:]
    point: Float64Array = points[0]
    return point


def patch_point(patch: Float64Array, u: float, v: float) -> Float64Array:
    """Return the point (3,) of a Bézier patch (a, b, 3 or 4)."""
    point = casteljau(casteljau(patch, u), v)
    return point if len(point) == 3 else point[:3] / point[3]


def de_boor_basis(i: int, degree: int, knots: Float64Array, t: float) -> float:
    """Return the B-spline basis function N_i of a degree at t, by its definition."""
    if degree == 0:
        last = knots[knots < knots[-1]].max()
        at_end = t == knots[-1] and knots[i] == last and knots[i + 1] == knots[-1]
        return float(knots[i] <= t < knots[i + 1] or at_end)
    value = 0.0
    if knots[i + degree] > knots[i]:
        value += (t - knots[i]) / (knots[i + degree] - knots[i]) * de_boor_basis(i, degree - 1, knots, t)
    if knots[i + degree + 1] > knots[i + 1]:
        ahead = (knots[i + degree + 1] - t) / (knots[i + degree + 1] - knots[i + 1])
        value += ahead * de_boor_basis(i + 1, degree - 1, knots, t)
    return value


def interpolate_quads(grid: npt.NDArray[np.float64], s: Float64Array) -> Float64Array:
    """Return the bilinear quads of a grid (m, m, 3) at parameters `s` (p,) of each: (p (m - 1), p (m - 1), 3)."""
    rows = grid[:-1, None] * (1 - s)[:, None, None] + grid[1:, None] * s[:, None, None]
    rows = rows.reshape(-1, *grid.shape[1:]).swapaxes(0, 1)
    both = rows[:-1, None] * (1 - s)[:, None, None] + rows[1:, None] * s[:, None, None]
    return both.reshape(-1, *rows.shape[1:]).swapaxes(0, 1)
