"""Homogeneous matrices of size n + 1 for both R^2 and R^3, built from their linear part."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_nonzero_vector, as_numbers, as_vector, describe_first_non_finite, require_flag
from .._core.types import Float64Array
from ..errors import ArgumentError


def require_finite(matrix: Float64Array, what: str) -> Float64Array:
    """Return `matrix` with +0 for every -0; raise an error that names `what` if an entry has overflowed."""
    if not np.isfinite(matrix).all():
        raise ArgumentError.expecting(what, "stay within float64's range", describe_first_non_finite(matrix))
    return matrix + 0.0


def compute_cos_sin(angle: npt.ArrayLike, *, degrees: bool) -> tuple[Any, Any]:
    """Return the cosine and the sine of an angle, or of an array; in degrees they are exact at every multiple of 90.

    Degrees are reduced, without rounding, to a number of quarter turns and a rest in [-45, 45] before they are
    converted to radians.
    """
    checked = as_numbers({"angle": angle})["angle"]
    if type(degrees) is not bool:
        degrees = require_flag(degrees, "degrees")
    if isinstance(checked, np.ndarray):
        return _compute_cos_sin_of_array(checked, degrees=degrees)
    if not degrees:
        return math.cos(checked), math.sin(checked)
    turn = math.remainder(checked, 360.0)
    quarters = round(turn / 90.0)
    rest = math.radians(turn - 90.0 * quarters)
    c, s = math.cos(rest), math.sin(rest)
    return ((c, s), (-s, c), (-c, -s), (s, -c))[quarters % 4]


def _compute_cos_sin_of_array(angle: Float64Array, *, degrees: bool) -> tuple[Float64Array, Float64Array]:
    if not degrees:
        return np.cos(angle), np.sin(angle)
    turn = np.fmod(angle, 360.0)
    quarters = np.rint(turn / 90.0)
    rest = np.radians(turn - 90.0 * quarters)
    c, s = np.cos(rest), np.sin(rest)
    quarter = quarters.astype(np.int64) % 4
    return np.choose(quarter, [c, -s, -c, s]), np.choose(quarter, [s, c, -s, -c])


def about_point(point: npt.ArrayLike | None, linear: Float64Array) -> Float64Array:
    """Return the matrix that acts as the n x n matrix A about the fixed `point` p: [[A, p - A p], [0, 1]].

    Without a point, the origin stays fixed: A is embedded. A stack of A (..., n, n) gives a stack.
    """
    n = linear.shape[-1]
    matrix = make_identities(linear.shape[:-2], n + 1)
    matrix[..., :n, :n] = linear
    if point is not None:
        fixed = as_vector(point, "point", n)
        with np.errstate(over="ignore", invalid="ignore"):
            matrix[..., :n, n] = fixed - linear @ fixed
    return require_finite(matrix, "the matrix about point")


def make_identities(shape: tuple[int, ...], n: int) -> Float64Array:
    """Return a stack of n x n identities (*shape, n, n)."""
    matrices = np.zeros((*shape, n, n))
    matrices[..., range(n), range(n)] = 1.0
    return matrices


def make_scaling(**factors: npt.ArrayLike) -> Float64Array:
    """Return diag(factors..., 1), or a stack for arrays; errors name the keywords."""
    return _make_entries(len(factors), {(i, i): factor for i, factor in enumerate(as_numbers(factors).values())})


def make_translation(**offsets: npt.ArrayLike) -> Float64Array:
    """Return [[I, offsets], [0, 1]], or a stack for arrays; errors name the keywords."""
    n = len(offsets)
    return _make_entries(n, {(i, n): offset for i, offset in enumerate(as_numbers(offsets).values())})


def make_shearing(n: int, **factors: npt.ArrayLike) -> Float64Array:
    """Return the homogeneous shear where x gains, for a keyword `xy`, that factor times y; or a stack for arrays."""
    entries = {("xyz".index(name[0]), "xyz".index(name[1])): factor for name, factor in as_numbers(factors).items()}
    return _make_entries(n, entries)


def _make_entries(n: int, entries: dict[tuple[int, int], Any]) -> Float64Array:
    """Return the identity of size n + 1 with other entries: floats, or arrays of one shape, which give a stack."""
    matrix = make_identities(np.shape(next(iter(entries.values()))), n + 1)
    for (row, column), value in entries.items():
        matrix[..., row, column] = value
    return matrix


def make_rotation(n: int, first: int, second: int, angle: npt.ArrayLike, *, degrees: bool) -> Float64Array:
    """Return the n x n rotation by `angle` that turns axis `first` towards axis `second`; or a stack for an array."""
    c, s = compute_cos_sin(angle, degrees=degrees)
    linear = make_identities(np.shape(c), n)
    linear[..., first, first] = linear[..., second, second] = c
    linear[..., second, first] = s
    linear[..., first, second] = -s
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
