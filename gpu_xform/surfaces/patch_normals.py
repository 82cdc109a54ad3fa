"""Normals of Bézier patches, also where a derivative vanishes: at poles, and at corners with parallel sides.

The normal of a rational patch P / w has the direction of w P_u x P_v + w_v P x P_u + w_u P_v x P, which is a
polynomial. Where it is zero, its first Taylor coefficient along a line into the face that is not zero takes its place.
"""

import math
from collections.abc import Callable

import numpy as np

from .._core.types import BoolArray, Float64Array
from .bernstein import expand_bernstein
from .patch_grids import center_patches, evaluate_derivatives
from .weld import list_quads

# Of the patch's longest normal: what is shorter is zero but for rounding.
_MIN_LENGTH = 1e-9
# Of the product of both derivatives' bounds, and of the weights: a patch whose normals are all shorter has no area.
_MIN_SINE = 2.0**-40
_NUMBERS_AT_ONCE = 1 << 16
_POINTS_AT_ONCE = 1 << 12  # products so small that OpenBLAS keeps to one thread: others would wait for each of them


def compute_corner_normals(patches: Float64Array, n: int, kept: BoolArray, normals: Float64Array) -> None:
    """Compute the unit normal of each kept corner of the quads of grids of n steps; NaN where a patch has no area.

    patches : (k, a, b, 3 or 4)
    kept : which corners the faces have (k n n, 4), in the order of `list_quads`
    normals : what becomes the normals (c, 3)
    """
    k, m = len(patches), n + 1
    quads = list_quads(np.arange(k * m * m).reshape(k, m, m))
    directions, lengths, has_area = _compute_directions(patches, n)
    longest = lengths.reshape(k, -1).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        units = (directions / lengths[..., np.newaxis]).reshape(-1, 3)
    units.take(quads[kept], axis=0, out=normals, mode="clip")
    is_zero = (lengths <= _MIN_LENGTH * longest[:, np.newaxis, np.newaxis]).reshape(-1)
    if not has_area.all():
        has_area[~has_area] = _have_area(patches[~has_area])
        is_flat = np.repeat(~has_area, n * n)
        normals[np.repeat(is_flat, np.count_nonzero(kept, axis=1))] = np.nan
        is_zero[np.repeat(~has_area, m * m)] = False
    if not is_zero.any():
        return
    row, corner = np.nonzero(kept & is_zero[quads])
    patch, at = np.divmod(quads[row], m * m)
    places = np.stack(np.divmod(at, m), axis=-1) / (m - 1)  # (z, 4, 2)
    rows = np.arange(len(row))
    # A corner that stands for two, as at a pole, lies in the middle between them.
    before = np.where(kept[row, corner - 1], corner, (corner - 1) % 4)
    place = 0.5 * (places[rows, corner] + places[rows, before])
    inwards = (places.mean(axis=1) - place) * (m - 1)
    which = np.cumsum(kept.reshape(-1)).reshape(kept.shape)[row, corner] - 1
    patch = patch[:, 0]
    count = max(1, _NUMBERS_AT_ONCE // patches[0].size)
    for start in range(0, len(row), count):
        some = slice(start, start + count)
        normals[which[some]] = _find_limits(patches[patch[some]], place[some], inwards[some])


def _compute_directions(patches: Float64Array, n: int) -> tuple[Float64Array, Float64Array, BoolArray]:
    """Return vectors normal to the surface on grids of n steps (k, n + 1, n + 1, 3), their lengths, and what has area.

    The last tells of each patch whether some vector is longer than rounding makes it.
    """
    patches = center_patches(patches)
    points, along_u, along_v = evaluate_derivatives(patches, n)
    directions = _cross(along_u, along_v)
    # Derivatives lie in the hull of such differences.
    reach = math.prod(patches.shape[1:3]) * _measure(np.diff(patches, axis=1)) * _measure(np.diff(patches, axis=2))
    if patches.shape[-1] == 4:
        w, w_u, w_v = points[..., 3:], along_u[..., 3:], along_v[..., 3:]
        directions = w * directions + w_v * _cross(points, along_u) + w_u * _cross(along_v, points)
        reach *= _measure(patches)
    lengths = np.sqrt(np.einsum("...i,...i->...", directions, directions))
    return directions, lengths, lengths.reshape(len(patches), -1).max(axis=1) > _MIN_SINE * reach


def _measure(vectors: Float64Array) -> Float64Array:
    """Return the largest component of the vectors of each patch (k, ...): (k,)."""
    rows = vectors.reshape(len(vectors), -1)
    largest: Float64Array = np.maximum(rows.max(axis=1), -rows.min(axis=1))
    return largest


def _have_area(patches: Float64Array) -> BoolArray:
    """Tell which patches have normals anywhere, as a grid as fine as that of their control points shows."""
    n = max(patches.shape[1:3])
    count = max(1, _POINTS_AT_ONCE // (n + 1) ** 2)
    parts = [_compute_directions(patches[i : i + count], n)[2] for i in range(0, len(patches), count)]
    return np.concatenate(parts) if parts else np.empty(0, bool)


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the cross products of the first three components: several times faster than `np.cross`."""
    products = np.empty((*np.broadcast_shapes(a.shape[:-1], b.shape[:-1]), 3))
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        np.subtract(a[..., first] * b[..., second], a[..., second] * b[..., first], out=products[..., axis])
    return products


def _find_limits(patches: Float64Array, places: Float64Array, inwards: Float64Array) -> Float64Array:
    """Return the limits (z, 3) of unit normals at `places` (z, 2) along lines `inwards` (z, 2).

    Polynomials of the line's parameter are rows of coefficients, (terms, 3 or 1, z).
    """
    count, a, b, d = patches.shape
    rows = expand_bernstein(a - 1, places[:, 0]) @ patches.reshape(count, a, b * d)
    taylor = expand_bernstein(b - 1, places[:, 1])[:, np.newaxis] @ rows.reshape(count, a, b, d)
    taylor = np.ascontiguousarray(np.moveaxis(taylor, 0, -1))  # (a, b, d, z)
    # The terms x^i y^j of the surface and of both derivatives along the line, by the power of its parameter.
    x, y = (inwards[:, axis] ** np.arange(order)[:, np.newaxis] for axis, order in ((0, a), (1, b)))
    x_slope, y_slope = np.zeros_like(x), np.zeros_like(y)
    x_slope[1:], y_slope[1:] = np.arange(1, a)[:, np.newaxis] * x[:-1], np.arange(1, b)[:, np.newaxis] * y[:-1]
    points, along_u, along_v = (
        _sum_powers(taylor, left, right) for left, right in ((x, y), (x_slope, y), (x, y_slope))
    )
    along_u, along_v = along_u[1:], along_v[1:]  # a derivative has one power less
    coefficients = _multiply(along_u, along_v, _cross_rows)
    if d == 4:
        coefficients = (
            _multiply(points[:, 3:], coefficients, np.multiply)
            + _multiply(along_v[:, 3:], _multiply(points, along_u, _cross_rows), np.multiply)
            + _multiply(along_u[:, 3:], _multiply(along_v, points, _cross_rows), np.multiply)
        )
    lengths = np.sqrt(np.einsum("ijz,ijz->iz", coefficients, coefficients))
    first = (lengths > _MIN_LENGTH * lengths.max(axis=0)).argmax(axis=0)
    each = np.arange(count)
    with np.errstate(divide="ignore", invalid="ignore"):
        limits: Float64Array = coefficients[first, :, each] / lengths[first, each, np.newaxis]
    return limits


def _sum_powers(taylor: Float64Array, x: Float64Array, y: Float64Array) -> Float64Array:
    """Return the sums of taylor[i, j] x[i] y[j] over all i and j of the same i + j: (a + b - 1, d, z)."""
    a, b, *rest = taylor.shape
    sums = np.zeros((a + b - 1, *rest))
    for i in range(a):
        sums[i : i + b] += taylor[i] * (x[i] * y)[:, np.newaxis]
    return sums


def _multiply(
    a: Float64Array, b: Float64Array, product: Callable[[Float64Array, Float64Array], Float64Array]
) -> Float64Array:
    """Return the product of two polynomials (terms, 3 or 1, z)."""
    coefficients = np.zeros((len(a) + len(b) - 1, 3, a.shape[-1]))
    for i, row in enumerate(a):
        coefficients[i : i + len(b)] += product(row, b)
    return coefficients


def _cross_rows(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the cross products of the first three of the rows (..., 3 or 4, z)."""
    products = np.empty((*np.broadcast_shapes(a.shape[:-2], b.shape[:-2]), 3, a.shape[-1]))
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        np.subtract(
            a[..., first, :] * b[..., second, :], a[..., second, :] * b[..., first, :], out=products[..., axis, :]
        )
    return products
