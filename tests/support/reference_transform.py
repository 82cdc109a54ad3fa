"""Reference transform of points: matrices to test with, and the product in double-double arithmetic."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tests.support.types import Array

# All entries differ, none is a power of two, and nothing is symmetric, so an entry in the wrong place shows.
AFFINE = np.array([[1.1, -0.3, 0.7, 5.3], [0.2, 2.3, -0.9, -7.1], [-0.6, 0.4, 3.7, 0.13], [0.0, 0.0, 0.0, 1.0]])
PLANAR = np.array([[1.1, -0.3, 5.3], [0.7, 2.3, -7.1], [0.0, 0.0, 1.0]])
PROJECTIVE = np.vstack([AFFINE[:3], [0.13, -0.21, 0.34, 1.7]])
PLANAR_PROJECTIVE = np.vstack([PLANAR[:2], [0.13, -0.21, 1.7]])


class DoubleDouble(NamedTuple):
    """Numbers with twice the digits of float64, `high + low`; NumPy has no such type on every platform."""

    high: Array
    low: Array


def two_product(a: Array, b: Array) -> DoubleDouble:
    """Return a * b without rounding. Dekker, 1971."""
    product = a * b
    a_high, b_high = (((x * 134217729.0) - ((x * 134217729.0) - x)) for x in (a, b))
    a_low, b_low = a - a_high, b - b_high
    return DoubleDouble(product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)


def two_sum(a: Array, b: Array) -> DoubleDouble:
    """Return a + b without rounding. Knuth."""
    total = a + b
    b_seen = total - a
    return DoubleDouble(total, (a - (total - b_seen)) + (b - b_seen))


def transform_exactly(points: Array, matrix: Array) -> tuple[DoubleDouble, Array]:
    """Return matrix @ (points, 1), all rows, with twice the digits of float64, and sum_j |m_ij x_j|."""
    homogeneous = np.column_stack([points.astype(np.float64), np.ones(len(points))])
    sums = DoubleDouble(np.zeros(homogeneous.shape), np.zeros(homogeneous.shape))
    for j, column in enumerate(matrix.T):
        product = two_product(homogeneous[:, j : j + 1], column[np.newaxis])
        high, low = two_sum(sums.high, product.high)
        sums = DoubleDouble(high, sums.low + (low + product.low))
    return sums, np.abs(homogeneous) @ np.abs(matrix).T


def unit_roundoff(dtype: npt.DTypeLike) -> float:
    return {4: 2.0**-24, 8: 2.0**-53}[np.dtype(dtype).itemsize]


def assert_transformed(result: Array, points: Array, matrix: Array) -> None:
    """Compare `result` with the exact product: every error must lie within the accuracy contract."""
    exact, magnitudes = transform_exactly(points, matrix)
    n = points.shape[1]
    assert result.dtype == points.dtype.newbyteorder("=")
    assert result.shape == points.shape
    assert result.flags.c_contiguous
    error = np.abs((result - exact.high[:, :n]) - exact.low[:, :n])
    allowed = 5 * unit_roundoff(result.dtype) * magnitudes[:, :n]
    worst = np.unravel_index(np.argmax(error - allowed), error.shape) if error.size else None
    assert worst is None or error[worst] <= allowed[worst], (worst, points[worst[0]], result[worst[0]])


def some_points(n: int, dtype: npt.DTypeLike, columns: int = 3) -> Array:
    return np.random.default_rng(n).normal(scale=10.0, size=(n, columns)).astype(dtype)
