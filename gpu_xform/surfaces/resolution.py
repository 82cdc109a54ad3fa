"""Resolution: the number of steps along a curve or a patch that was asked for, or that keeps a tolerance.

Linear interpolation of f between the ends of a step h errs by at most h^2 / 8 max |f''|; a bilinear quad by the sum
for both directions, h^2 / 8 (max |f_uu| + max |f_vv|). The second derivative of a polynomial curve of degree d has the
control points d (d - 1) times their second differences, and lies in their convex hull.
"""

import math
from collections.abc import Sequence
from typing import SupportsIndex

import numpy as np

from .._core.arguments import as_float, as_int
from .._core.types import Float64Array
from ..errors import ArgumentError
from .bernstein import make_splitting

MAX_FACES = 1 << 24  # of one surface; 2 GB of mesh
# A rational patch is bounded in 8 pieces per direction, of many patches at once, unless their pieces were too many: a
# bound of fewer pieces is larger, and asks for more steps than are needed.
_N_PIECES = 8
_NUMBERS_AT_ONCE = 1 << 15
_MAX_SPLIT_NUMBERS = 1 << 24
_MAX_SQUARED = 1e150  # squares of more would overflow


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


def choose_steps(n: SupportsIndex | None, tolerance: float | None, blocks: Sequence[Float64Array]) -> int:
    """Return `n`, or the least number of steps that keeps `tolerance`, one for all curves or patches.

    blocks : arrays of curves (k, a, 3 or 4), or of patches (k, a, b, 3 or 4)
    """
    n_parts, n_axes = sum(map(len, blocks)), blocks[0].ndim - 2
    if n is not None:
        steps, name, got = as_steps(n), "n", f"{n}"
    else:
        limit = as_tolerance(tolerance)  # type: ignore[arg-type]  # one of both is given
        steps = count_steps(limit, blocks)
        name, got = "tolerance", f"{limit:g}"
    if n_parts * steps**n_axes > MAX_FACES:
        what = "faces" if n_axes == 2 else "segments"
        reason = f"it needs {n_parts} x {' x '.join([str(steps)] * n_axes)}"
        raise ArgumentError.expecting(name, f"need at most {MAX_FACES} {what}", got, reason=reason)
    return steps


def count_steps(tolerance: float, blocks: Sequence[Float64Array]) -> int:
    """Return the least number of steps that keeps a tolerance, however large; 2^53 where the bound is no number."""
    largest = bound_second_derivatives(blocks) / 8.0
    steps = math.ceil(min(2.0**53, math.sqrt(largest / tolerance))) or 1
    return steps + (largest / steps**2 > tolerance)  # the square root may round down onto a whole number


def bound_second_derivatives(blocks: Sequence[Float64Array]) -> float:
    """Return an upper bound of |f''| of all curves, or of |f_uu| + |f_vv| of all patches; infinite if it overflows.

    blocks : arrays (k, a, 3) or (k, a, b, 3), or with a fourth coordinate, the positive weight
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        plain = [block for block in blocks if block.shape[-1] == 3]
        largest = max((float(_bound_polynomial(block).max()) for block in plain), default=0.0)
        rational = [block for block in blocks if block.shape[-1] == 4]
        bound = _bound_rational(rational, largest)
    return math.inf if math.isnan(bound) else bound


def _bound_polynomial(block: Float64Array) -> Float64Array:
    """Return the bound of each curve or patch without weights: (k,)."""
    bounds = np.zeros(len(block))
    for axis in range(1, block.ndim - 1):
        degree = block.shape[axis] - 1
        differences = np.diff(block, 2, axis=axis)
        if differences.size:
            largest = float(np.abs(differences).max())
            scale = largest if largest > _MAX_SQUARED else 1.0
            rows = differences / scale
            squares = np.einsum("...i,...i->...", rows, rows).reshape(len(block), -1)
            bounds += degree * (degree - 1) * (scale * np.sqrt(squares.max(axis=1)))
    return bounds


def _bound_rational(blocks: Sequence[Float64Array], largest: float) -> float:
    """Return the larger of `largest` and the bounds of all curves or patches with weights.

    Those whose own bound is the largest are split, as the bounds of small pieces come close to the truth, until no
    bound of those that are left is larger, or until too many were.
    """
    bounds = [_bound_pieces(np.moveaxis(block, 0, -1)) for block in blocks]
    n_left = _MAX_SPLIT_NUMBERS
    for i in sorted(range(len(blocks)), key=lambda i: -bounds[i].max()):
        n_numbers = blocks[i][0].size * _N_PIECES ** (blocks[i].ndim - 2)
        count = max(1, _NUMBERS_AT_ONCE // n_numbers)
        order = np.argsort(-bounds[i])
        for start in range(0, len(order), count):
            rows = order[start : start + count]
            bound = float(bounds[i][rows[0]])
            if not bound > largest:
                break
            if n_left > 0:
                bound = min(bound, _bound_split(blocks[i][rows]))
                n_left -= len(rows) * n_numbers
            largest = max(largest, bound)
    return largest


def _bound_split(block: Float64Array) -> float:
    """Return the largest bound of the pieces of curves or patches (k, ..., 4)."""
    pieces = np.moveaxis(block, 0, -1)
    for axis in range(block.ndim - 2):
        splitting = make_splitting(pieces.shape[axis] - 1, _N_PIECES)
        split = np.tensordot(splitting, np.moveaxis(pieces, axis, 0), axes=(2, 0))  # (pieces, order, ...)
        pieces = np.moveaxis(split, (1, 0), (axis, -1)).reshape(*pieces.shape[:-1], -1)
    return float(_bound_pieces(pieces).max()) * _N_PIECES**2


def _bound_pieces(pieces: Float64Array) -> Float64Array:
    """Return a bound for f = Q / w about each piece's own middle, where |f| <= r; for patches, the sum of both: (k,).

    pieces : (a, 4, k) or (a, b, 4, k), so that what is added up lies far apart, and NumPy adds whole rows

    From f w = Q: f' = (Q' - w' f) / w, and f'' = (Q'' - 2 w' f' - w'' f) / w.
    """
    axes = tuple(range(pieces.ndim - 2))
    weights = pieces[..., 3, :]
    points = pieces[..., :3, :] / weights[..., np.newaxis, :]
    middle = 0.5 * (points.min(axis=axes) + points.max(axis=axes))
    centered = pieces[..., :3, :] - weights[..., np.newaxis, :] * middle
    radius = _measure(points - middle)
    least = weights.min(axis=axes)
    bounds: Float64Array = np.zeros(pieces.shape[-1])
    for axis in axes:
        degree = pieces.shape[axis] - 1
        q1 = degree * _measure(np.diff(centered, axis=axis))
        w1 = degree * np.abs(np.diff(weights, axis=axis)).max(axis=axes)
        first = (q1 + w1 * radius) / least
        q2 = degree * (degree - 1) * _measure(np.diff(centered, 2, axis=axis))
        w2 = degree * (degree - 1) * np.abs(np.diff(weights, 2, axis=axis)).max(axis=axes, initial=0.0)
        bounds += (q2 + 2.0 * w1 * first + w2 * radius) / least
    bounds[np.isnan(bounds)] = np.inf  # from terms that overflow
    return bounds


def _measure(vectors: Float64Array) -> Float64Array:
    """Return the length of the longest of vectors (..., 3, k), 0 of none: (k,)."""
    squares = np.einsum("...ik,...ik->...k", vectors, vectors)
    longest: Float64Array = np.sqrt(squares.max(axis=tuple(range(squares.ndim - 1)), initial=0.0))
    return longest
