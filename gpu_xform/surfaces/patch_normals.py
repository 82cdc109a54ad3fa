"""Normals of Bézier patches, also where a derivative vanishes: at poles, and at corners with parallel sides.

The normal of a rational patch P / w has the direction of w P_u x P_v + w_v P x P_u + w_u P_v x P, which is a
polynomial. Where it is zero, its first Taylor coefficient along a line into the face that is not zero takes its place.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from .bernstein import expand_bernstein

# Of the patch's longest normal: what is shorter is zero but for rounding.
_MIN_LENGTH = 1e-9


def compute_corner_normals(
    patches: Float64Array, grids: tuple[Float64Array, Float64Array, Float64Array], quads: IndexArray, kept: BoolArray
) -> Float64Array:
    """Return the unit normal of each kept corner of the quads: (c, 3); NaN where a patch has no area.

    patches : (k, a, b, 3 or 4)
    grids : the points and both derivatives on a grid per patch, (k, m, m, 3 or 4), as homogeneous as the patches
    quads : indices of grid points (q, 4)
    kept : which corners the faces have (q, 4)
    """
    m = grids[0].shape[1]
    directions = _compute_directions(*grids)
    lengths = np.linalg.norm(directions, axis=-1)
    longest = lengths.reshape(len(patches), -1).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        units = (directions / lengths[..., np.newaxis]).reshape(-1, 3)
    normals: Float64Array = units[quads[kept]]
    is_zero = (lengths <= _MIN_LENGTH * longest[:, np.newaxis, np.newaxis]).reshape(-1)
    if not is_zero.any():
        return normals
    row, corner = np.nonzero(kept & is_zero[quads])
    patch, at = np.divmod(quads[row], m * m)
    places = np.stack(np.divmod(at, m), axis=-1) / (m - 1)  # (z, 4, 2)
    rows = np.arange(len(row))
    # A corner that stands for two, as at a pole, lies in the middle between them.
    before = np.where(kept[row, corner - 1], corner, (corner - 1) % 4)
    place = 0.5 * (places[rows, corner] + places[rows, before])
    inwards = (places.mean(axis=1) - place) * (m - 1)
    which = np.cumsum(kept.reshape(-1)).reshape(kept.shape)[row, corner] - 1
    normals[which] = _find_limits(patches[patch[:, 0]], place, inwards)
    return normals


def _compute_directions(points: Float64Array, along_u: Float64Array, along_v: Float64Array) -> Float64Array:
    """Return vectors (..., 3) normal to the surface, from points and derivatives (..., 3 or 4)."""
    normals = _cross(along_u, along_v)
    if points.shape[-1] == 4:
        w, w_u, w_v = points[..., 3:], along_u[..., 3:], along_v[..., 3:]
        normals = w * normals + w_v * _cross(points, along_u) + w_u * _cross(along_v, points)
    return normals


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the cross products of the first three components: several times faster than `np.cross`."""
    products = np.empty((*np.broadcast_shapes(a.shape[:-1], b.shape[:-1]), 3))
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        np.subtract(a[..., first] * b[..., second], a[..., second] * b[..., first], out=products[..., axis])
    return products


def _find_limits(patches: Float64Array, places: Float64Array, inwards: Float64Array) -> Float64Array:
    """Return the limits (z, 3) of unit normals at `places` (z, 2) along lines `inwards` (z, 2)."""
    u, v = places.T
    degree_u, degree_v = patches.shape[1] - 1, patches.shape[2] - 1
    count, a, b, d = patches.shape
    rows = expand_bernstein(degree_u, u) @ patches.reshape(count, a, b * d)
    taylor = expand_bernstein(degree_v, v)[:, np.newaxis] @ rows.reshape(count, a, b, d)  # (z, a, b, d)
    # The terms x^i y^j of the surface and of both derivatives along the line, by the power of its parameter.
    x, y = (inwards[:, [axis]] ** np.arange(degree + 1) for axis, degree in ((0, degree_u), (1, degree_v)))
    x_slope, y_slope = np.zeros_like(x), np.zeros_like(y)
    x_slope[:, 1:], y_slope[:, 1:] = np.arange(1, a) * x[:, :-1], np.arange(1, b) * y[:, :-1]
    powers = _sum_antidiagonals(a, b).reshape(-1, a * b)
    points, along_u, along_v = (
        (
            powers
            @ (taylor * (left[:, :, np.newaxis] * right[:, np.newaxis])[..., np.newaxis]).reshape(count, a * b, d)
        ).swapaxes(0, 1)
        for left, right in ((x, y), (x_slope, y), (x, y_slope))
    )
    along_u, along_v = along_u[1:], along_v[1:]  # a derivative has one power less
    coefficients = _multiply(along_u, along_v, _cross)
    if patches.shape[-1] == 4:
        coefficients = (
            _multiply(points[..., 3:], coefficients, np.multiply)
            + _multiply(along_v[..., 3:], _multiply(points, along_u, _cross), np.multiply)
            + _multiply(along_u[..., 3:], _multiply(along_v, points, _cross), np.multiply)
        )
    lengths = np.linalg.norm(coefficients, axis=-1)  # (terms, z)
    first = (lengths > _MIN_LENGTH * lengths.max(axis=0)).argmax(axis=0)
    each = np.arange(len(patches))
    with np.errstate(invalid="ignore"):
        limits: Float64Array = coefficients[first, each] / lengths[first, each, np.newaxis]
    return limits


def _multiply(
    a: Float64Array, b: Float64Array, product: Callable[[Float64Array, Float64Array], Float64Array]
) -> Float64Array:
    """Return the product of two polynomials whose coefficients are rows (terms, z, ...)."""
    pairs = product(a[:, np.newaxis], b[np.newaxis])
    sums = _sum_antidiagonals(len(a), len(b)).reshape(-1, len(a) * len(b))
    coefficients: Float64Array = sums @ pairs.reshape(len(a) * len(b), -1)
    return coefficients.reshape(len(sums), *pairs.shape[2:])


@cache
def _sum_antidiagonals(m: int, n: int) -> Float64Array:
    """Return what adds the entries (i, j) of a table with the same i + j: (m + n - 1, m, n)."""
    powers = np.add.outer(np.arange(m), np.arange(n))
    sums: Float64Array = (powers == np.arange(m + n - 1)[:, np.newaxis, np.newaxis]).astype(np.float64)
    return sums
