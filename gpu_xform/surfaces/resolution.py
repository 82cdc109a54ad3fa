"""Resolution: the number of steps along a curve or a patch that was asked for, or that keeps a tolerance.

Linear interpolation of f between the ends of a step h errs by at most h^2 / 8 max |f''|; a bilinear quad by the sum
for both directions, h^2 / 8 (max |f_uu| + max |f_vv|). The second derivative of a polynomial curve of degree d has the
control points d (d - 1) times their second differences, and lies in their convex hull.
"""

import math
from typing import SupportsIndex

import numpy as np

from .._core.arguments import as_float, as_int
from .._core.types import Float64Array
from ..errors import ArgumentError
from .bernstein import make_differences, make_splitting

MAX_FACES = 1 << 24  # of one surface; 2 GB of mesh
_N_PIECES = 8  # a rational patch is bounded in pieces per direction: the bounds of small pieces come close to the truth


def as_tolerance(value: float, name: str = "tolerance") -> float:
    """Return a tolerance as a positive float."""
    tolerance = as_float(value, name)
    if tolerance <= 0:
        raise ArgumentError.expecting(name, "be positive", repr(tolerance))
    return tolerance


def require_one(n: object, tolerance: object) -> None:
    """Raise ArgumentError unless exactly one of `n` and `tolerance` is given."""
    if (n is None) == (tolerance is None):
        got = "neither" if n is None else "both"
        message = f"either n or tolerance must be given, got {got}"
        raise ArgumentError(message, argument="tolerance", expected="be given instead of n")


def as_steps(value: SupportsIndex, name: str = "n", minimum: int = 1) -> int:
    """Return a number of steps as an int of at least `minimum`."""
    n = as_int(value, name)
    if n < minimum:
        raise ArgumentError.expecting(name, f"be at least {minimum}", n)
    return n


def choose_steps(n: SupportsIndex | None, tolerance: float | None, control_points: Float64Array) -> int:
    """Return `n`, or the least number of steps that keeps `tolerance`, one for all curves or patches.

    control_points : (k, a, 3 or 4) of curves, (k, a, b, 3 or 4) of patches
    """
    n_parts, n_axes = len(control_points), control_points.ndim - 2
    if n is not None:
        steps, name, got = as_steps(n), "n", f"{n}"
    else:
        limit = as_tolerance(tolerance)  # type: ignore[arg-type]  # one of both is given
        steps = count_steps(limit, control_points)
        name, got = "tolerance", f"{limit:g}"
    if n_parts * steps**n_axes > MAX_FACES:
        what = "faces" if n_axes == 2 else "segments"
        reason = f"it needs {n_parts} x {' x '.join([str(steps)] * n_axes)}"
        raise ArgumentError.expecting(name, f"need at most {MAX_FACES} {what}", got, reason=reason)
    return steps


def count_steps(tolerance: float, control_points: Float64Array) -> int:
    """Return the least number of steps that keeps a tolerance, however large; 2^53 where the bound is no number."""
    axes = range(1, control_points.ndim - 1)
    largest = float(np.max(sum(bound_second_derivatives(control_points, axis) for axis in axes))) / 8.0
    steps = math.ceil(min(2.0**53, math.sqrt(largest / tolerance))) or 1
    return steps + (largest / steps**2 > tolerance)  # the square root may round down onto a whole number


def bound_second_derivatives(control_points: Float64Array, axis: int) -> Float64Array:
    """Return an upper bound of |f''| along an axis of each curve or patch: (k,).

    control_points : (k, ..., 3), or (k, ..., 4) with positive weights
    axis : which of the axes 1, 2, ... the derivative is along
    """
    degree = control_points.shape[axis] - 1
    if control_points.shape[-1] == 4:
        return _bound_rational(control_points, axis)
    differences = np.diff(control_points, 2, axis=axis)
    if differences.size == 0:
        return np.zeros(len(control_points))
    lengths = np.linalg.norm(differences, axis=-1).reshape(len(control_points), -1)
    bound: Float64Array = degree * (degree - 1) * lengths.max(axis=1)
    return bound


def _bound_rational(control_points: Float64Array, axis: int) -> Float64Array:
    """Return the bound for rational curves or patches: the largest of all their pieces'."""
    pieces = control_points[:, np.newaxis]
    for position in range(1, control_points.ndim - 1):
        splitting = make_splitting(control_points.shape[position] - 1, _N_PIECES)
        along = np.moveaxis(pieces, position + 1, 0)
        split = np.tensordot(splitting, along, axes=(2, 0))  # (pieces, order, k, m, ...)
        split = np.moveaxis(split, (1, 0), (position + 2, 2))  # (k, m, pieces, ..., order, ...)
        pieces = split.reshape(len(control_points), -1, *split.shape[3:])
    bound = _bound_rational_pieces(pieces.reshape(-1, *control_points.shape[1:]), axis)
    largest: Float64Array = bound.reshape(len(control_points), -1).max(axis=1) * _N_PIECES**2
    return largest


def _bound_rational_pieces(pieces: Float64Array, axis: int) -> Float64Array:
    """Return a bound for f = Q / w about each piece's own middle, where |f| <= r.

    From f w = Q: f' = (Q' - w' f) / w, and f'' = (Q'' - 2 w' f' - w'' f) / w.
    """
    count = len(pieces)
    weights = pieces[..., 3:]
    points = pieces[..., :3] / weights
    inner = tuple(range(1, pieces.ndim - 1))
    middle = 0.5 * (points.min(axis=inner, keepdims=True) + points.max(axis=inner, keepdims=True))
    centered = np.concatenate([pieces[..., :3] - weights * middle, weights], axis=-1)
    degree = pieces.shape[axis] - 1

    def largest(values: Float64Array) -> Float64Array:
        lengths = np.linalg.norm(values, axis=-1).reshape(count, -1)
        result: Float64Array = lengths.max(axis=1, initial=0.0)
        return result

    def derive(order: int) -> tuple[Float64Array, Float64Array]:
        """Return bounds for |Q'| and |w'|, or |Q''| and |w''|."""
        if order > degree:
            return np.zeros(count), np.zeros(count)
        factor = float(degree if order == 1 else degree * (degree - 1))
        along = np.tensordot(make_differences(degree, order), np.moveaxis(centered, axis, 0), axes=(1, 0))
        along = np.moveaxis(along, 0, axis)
        return factor * largest(along[..., :3]), factor * largest(along[..., 3:])

    least = weights.reshape(count, -1).min(axis=1)
    radius = largest(points - middle)
    (q1, w1), (q2, w2) = derive(1), derive(2)
    first = (q1 + w1 * radius) / least
    second: Float64Array = (q2 + 2.0 * w1 * first + w2 * radius) / least
    return second
