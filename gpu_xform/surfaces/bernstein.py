"""The Bernstein basis as matrices: values, derivatives, Taylor coefficients, splitting and raising of degrees.

A Bézier curve of degree d with control points P (d + 1, ...) is B(t) P, where row j of B(t) holds the basis at t[j].
Source of the formulas: G. Farin, "Curves and Surfaces for CAGD", 5th edition, chapters 4 to 6.
"""

from collections.abc import Sequence
from functools import cache
from math import comb

import numpy as np

from .._core.types import Float64Array, IndexArray


def evaluate_bernstein(degree: int, t: Float64Array) -> Float64Array:
    """Return the basis of a degree at parameters `t` (m,): (m, degree + 1); exact at 0 and 1."""
    i = np.arange(degree + 1)
    binomials = np.array([comb(degree, k) for k in range(degree + 1)], np.float64)
    t = t[:, np.newaxis]
    basis: Float64Array = binomials * t**i * (1.0 - t) ** (degree - i)
    return basis


def differentiate_bernstein(degree: int, t: Float64Array) -> Float64Array:
    """Return the derivatives of the basis at parameters `t` (m,): (m, degree + 1)."""
    return degree * evaluate_bernstein(degree - 1, t) @ make_differences(degree, 1)


def make_differences(degree: int, order: int) -> Float64Array:
    """Return the matrix of forward differences of an order: (degree + 1 - order, degree + 1), of whole numbers."""
    return np.diff(np.eye(degree + 1), order, axis=0)


def expand_bernstein(degree: int, t: Float64Array) -> Float64Array:
    """Return the Taylor coefficients of the basis about parameters `t` (m,): (m, degree + 1, degree + 1).

    Row k holds those of x^k in the basis at t + x.
    """
    rows = [
        comb(degree, k) * evaluate_bernstein(degree - k, t) @ make_differences(degree, k) for k in range(degree + 1)
    ]
    return np.stack(rows, axis=1)


@cache
def make_splitting(degree: int, n_pieces: int) -> Float64Array:
    """Return the matrices that give the control points of equal pieces of a curve: (n_pieces, degree + 1, degree + 1).

    Piece i runs over [i, i + 1] / n_pieces.
    """
    return np.stack([make_cut(degree, i / n_pieces, (i + 1) / n_pieces) for i in range(n_pieces)])


def make_cut(degree: int, low: float, high: float) -> Float64Array:
    """Return the matrix that gives the control points of a part of a curve: (degree + 1, degree + 1).

    The part up to `high` is cut off first, from whose curve the part from `low` on is cut then: row j of the first
    matrix is the basis of degree j at `high`, and row j of the second, from column j on, that of degree - j at its own
    parameter for `low`.
    """
    below, above, binomials = _list_powers(degree)
    t, s = high, low / high
    start = binomials * t**below * (1.0 - t) ** above
    end = binomials[::-1, ::-1] * s ** above[::-1, ::-1] * (1.0 - s) ** below[::-1, ::-1]
    cut: Float64Array = end @ start
    return cut


@cache
def _list_powers(degree: int) -> tuple[IndexArray, IndexArray, Float64Array]:
    """Return i, j - i and the binomial of j over i, 0 above the diagonal, in row j: three (degree + 1, degree + 1)."""
    j, i = np.indices((degree + 1, degree + 1))
    binomials = np.array([[comb(row, column) for column in range(degree + 1)] for row in range(degree + 1)], np.float64)
    return i, np.maximum(j - i, 0), binomials


def make_elevation(degree: int, raised: int) -> Float64Array:
    """Return the matrix from control points of a degree to those of the same curve at a higher one."""
    i, j = np.ogrid[: raised + 1, : degree + 1]
    spread = raised - degree
    elevation = np.zeros((raised + 1, degree + 1))
    for row, column in zip(*np.nonzero((i - j >= 0) & (i - j <= spread)), strict=True):
        row, column = int(row), int(column)
        elevation[row, column] = comb(degree, column) * comb(spread, row - column) / comb(raised, row)
    return elevation


def join_curves(blocks: Sequence[Float64Array]) -> Float64Array:
    """Return curves (k, a, 3 or 4) of several degrees as one array: all of the highest, and all rational if one is."""
    order = max(block.shape[1] for block in blocks)
    is_rational = any(block.shape[-1] == 4 for block in blocks)
    raised = []
    for block in blocks:
        if is_rational and block.shape[-1] == 3:
            block = np.concatenate([block, np.ones((*block.shape[:-1], 1))], axis=-1)
        raised.append(block if block.shape[1] == order else make_elevation(block.shape[1] - 1, order - 1) @ block)
    return raised[0] if len(raised) == 1 else np.concatenate(raised)
