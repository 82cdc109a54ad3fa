"""Homogeneous matrices of size n + 1 for both R^2 and R^3, built from their linear part."""

import math

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_nonzero_vector, as_vector, describe_first_non_finite
from .._core.types import Float64Array
from ..errors import ArgumentError


def require_finite(matrix: Float64Array, what: str) -> Float64Array:
    """Return `matrix` with +0 for every -0; raise an error that names `what` if an entry has overflowed."""
    if not np.isfinite(matrix).all():
        raise ArgumentError.expecting(what, "stay within float64's range", describe_first_non_finite(matrix))
    return matrix + 0.0


def compute_cos_sin(angle: float, *, degrees: bool) -> tuple[float, float]:
    """Return the cosine and the sine of `angle`; in degrees they are exact at every multiple of 90.

    Degrees are reduced, without rounding, to a number of quarter turns and a rest in [-45, 45] before they are
    converted to radians.
    """
    angle = as_float(angle, "angle")
    if not degrees:
        return math.cos(angle), math.sin(angle)
    turn = math.remainder(angle, 360.0)
    quarters = round(turn / 90.0)
    rest = math.radians(turn - 90.0 * quarters)
    c, s = math.cos(rest), math.sin(rest)
    return ((c, s), (-s, c), (-c, -s), (s, -c))[quarters % 4]


def about_point(point: npt.ArrayLike | None, linear: Float64Array) -> Float64Array:
    """Return the matrix that acts as the n x n matrix A about the fixed `point` p: [[A, p - A p], [0, 1]].

    Without a point, the origin stays fixed: A is embedded.
    """
    n = len(linear)
    matrix = np.eye(n + 1)
    matrix[:n, :n] = linear
    if point is not None:
        fixed = as_vector(point, "point", n)
        with np.errstate(over="ignore", invalid="ignore"):
            matrix[:n, n] = fixed - linear @ fixed
    return require_finite(matrix, "the matrix about point")


def make_scaling(**factors: float) -> Float64Array:
    """Return diag(factors..., 1); errors name the keywords."""
    return np.diag([*(as_float(factor, name) for name, factor in factors.items()), 1.0])


def make_translation(**offsets: float) -> Float64Array:
    """Return [[I, offsets], [0, 1]]; errors name the keywords."""
    matrix = np.eye(len(offsets) + 1)
    matrix[:-1, -1] = [as_float(offset, name) for name, offset in offsets.items()]
    return matrix


def make_shearing(n: int, **factors: float) -> Float64Array:
    """Return the homogeneous shear where x gains, for a keyword `xy`, that factor times y."""
    matrix = np.eye(n + 1)
    for name, factor in factors.items():
        target, source = ("xyz".index(axis) for axis in name)
        matrix[target, source] = as_float(factor, name)
    return matrix


def make_rotation(n: int, first: int, second: int, angle: float, *, degrees: bool) -> Float64Array:
    """Return the n x n rotation by `angle` that turns axis `first` towards axis `second`."""
    c, s = compute_cos_sin(angle, degrees=degrees)
    linear = np.eye(n)
    linear[first, first] = linear[second, second] = c
    linear[second, first] = s
    linear[first, second] = -s
    return linear


def make_projection(normal: npt.ArrayLike, n: int) -> Float64Array:
    """Return the n x n orthogonal projection I - v v^T / (v . v) along v, the normal.

    Its diagonal is summed from the squares of the other components: 1 - v_i^2 would cancel, and a projection along
    almost an axis would not be singular.
    """
    v = as_nonzero_vector(normal, "normal", n)
    v[v * v < np.finfo(np.float64).tiny] = 0.0  # negligible beside the largest component
    squares = v * v
    linear = -np.outer(v, v)
    np.fill_diagonal(linear, (1.0 - np.eye(n)) @ squares)
    linear /= squares.sum()
    return linear


def make_reflection(normal: npt.ArrayLike, n: int) -> Float64Array:
    """Return the n x n reflection I - 2 v v^T / (v . v), which reverses v, the normal."""
    return 2.0 * make_projection(normal, n) - np.eye(n)
