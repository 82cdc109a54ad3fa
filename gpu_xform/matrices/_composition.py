"""Products, inverses and the decomposition of matrices."""

from math import isfinite
from typing import NamedTuple, cast

import numpy as np

from .._core.arguments import as_square_matrix
from .._core.public import public
from .._core.types import Float64Array, MatrixLike
from ..errors import ArgumentError, SingularMatrixError
from ._affine import require_finite
from ._elementary import homogeneous, scale, shear, translate

# Of the largest singular value: a matrix whose smallest is within the rounding error of a composition is singular.
SINGULAR_RTOL = 64 * np.finfo(np.float64).eps
MAX_PLAIN_CONDITION = 1e3  # above it a matrix is balanced before it is inverted


def as_factors(matrices: tuple[MatrixLike, ...]) -> list[Float64Array]:
    """Return `matrices` as arrays of one size, 3x3 or 4x4; raise an error if there are none."""
    if not matrices:
        raise ArgumentError.expecting("matrices", "hold at least one 3x3 or 4x4 matrix", "none")
    first = as_square_matrix(matrices[0], "matrices[0]", 3, 4)
    rest = (as_square_matrix(m, f"matrices[{i}]", len(first)) for i, m in enumerate(matrices[1:], 1))
    return [first, *rest]


@public
def chain(*matrices: MatrixLike) -> Float64Array:
    """Return the product that applies matrices in the order given: `chain(a, b, c)` is c @ b @ a.

    Parameters
    ----------
    *matrices : (4, 4) or (3, 3) numbers, or objects with `as_matrix()`
        One or more, all of the same size.

    Returns
    -------
    (4, 4) or (3, 3) float64

    Raises
    ------
    ArgumentError
        If there are none, if they differ in size, or if the product overflows.
    """
    plain = _chain_plain(matrices)
    if plain is not None:
        return plain
    first, *rest = as_factors(matrices)
    product = first
    with np.errstate(over="ignore", invalid="ignore"):
        for matrix in rest:
            product = matrix @ product
    return require_finite(product, "the product of matrices")


@public
def inverse(m: MatrixLike) -> Float64Array:
    """Return the inverse of a matrix; that of an affine matrix is exactly affine.

    Parameters
    ----------
    m : (4, 4) or (3, 3) numbers, or an object with `as_matrix()`
        The matrix to invert.

    Returns
    -------
    (4, 4) or (3, 3) float64

    Raises
    ------
    SingularMatrixError
        If `m` is singular within rounding error. That depends on neither units nor translation: `scale(1e-12)` has an
        inverse.
    ArgumentError
        For another shape, a number that is not finite, or an inverse that overflows.
    """
    plain = _invert_plain(m)
    if plain is not None:
        return plain
    matrix = as_square_matrix(m, "m", 3, 4)
    n = len(matrix) - 1
    if matrix[n, :n].any():
        result = _invert(matrix)
    else:
        result = np.zeros_like(matrix)
        result[:n, :n] = _invert(matrix[:n, :n])
        result[n:, n:] = _invert(matrix[n:, n:])
        with np.errstate(over="ignore", invalid="ignore"):
            result[:n, n:] = -result[:n, :n] @ matrix[:n, n:] @ result[n:, n:]
    return require_finite(result, "the inverse of m")


class Decomposition(NamedTuple):
    """The parts of an affine matrix, which applies scale, shear, rotation and translation, in this order.

    m = translate(*translation) @ homogeneous(rotation) @ shear(xy=, xz=, yz=) @ scale(*scale)

    Attributes
    ----------
    translation : (3,) float64
        The image of the origin.
    rotation : (3, 3) float64
        Proper: the determinant is +1.
    scale : (3,) float64
        All positive, or one negative if m mirrors.
    shear : (3,) float64
        The factors xy, xz, yz of `shear`.
    """

    translation: Float64Array
    rotation: Float64Array
    scale: Float64Array
    shear: Float64Array

    def as_matrix(self) -> Float64Array:
        """Return the 4x4 matrix that is composed of the parts.

        Returns
        -------
        (4, 4) float64
        """
        xy, xz, yz = self.shear
        return chain(
            scale(*self.scale), shear(xy=xy, xz=xz, yz=yz), homogeneous(self.rotation), translate(*self.translation)
        )


@public
def decompose(m: MatrixLike) -> Decomposition:
    """Decompose an affine matrix into translation, rotation, scale and shear.

    The linear part is factored as Q R, R upper triangular (Thomas, "Decomposing a matrix into simple transformations",
    Graphics Gems II, 1991). If `m` mirrors, one factor of the scale is negative: that which leaves the rotation
    closest to the identity.

    Parameters
    ----------
    m : (4, 4) numbers, or an object with `as_matrix()`
        The last row is (0, 0, 0, 1).

    Returns
    -------
    Decomposition
        The parts; `as_matrix()` composes them again.

    Raises
    ------
    SingularMatrixError
        If the columns are linearly dependent within rounding error.
    ArgumentError
        For another shape, a number that is not finite, or a matrix that is not affine.
    """
    matrix = as_square_matrix(m, "m", 4)
    if not np.array_equal(matrix[3], (0.0, 0.0, 0.0, 1.0)):
        raise ArgumentError.expecting("m", "be affine, its last row (0, 0, 0, 1)", tuple(matrix[3].tolist()))
    columns, exponents = _balance(matrix[:3, :3], axis=0)
    _require_invertible(columns)
    q, r = np.linalg.qr(columns)
    signs = np.copysign(1.0, r.diagonal())
    if np.linalg.det(q * signs) < 0.0:
        signs[np.argmin(q.diagonal() * signs)] *= -1.0
    q *= signs
    r *= signs[:, np.newaxis]
    stretch = r.diagonal()
    with np.errstate(over="ignore"):
        scale_factors = require_finite(np.ldexp(stretch, exponents), "the scale in m")
    return Decomposition(
        translation=matrix[:3, 3].copy(),
        rotation=q + 0.0,
        scale=scale_factors,
        shear=(r / stretch)[np.triu_indices(3, 1)] + 0.0,
    )


@np.errstate(over="ignore", invalid="ignore")
def _chain_plain(matrices: tuple[MatrixLike, ...]) -> Float64Array | None:
    """Return the product of at least two float64 arrays (4, 4), if it is finite; None for all else, which is checked.

    It takes a third of the time. No factor needs a check: what is not finite in one leaves no product finite.
    """
    if len(matrices) < 2:
        return None
    for matrix in matrices:
        if type(matrix) is not np.ndarray or matrix.dtype.char != "d" or matrix.shape != (4, 4):
            return None
    first, *rest = cast("tuple[Float64Array, ...]", matrices)
    product = first
    for matrix in rest:
        product = matrix.dot(product)
    return product if isfinite(sum(map(abs, product.ravel().tolist()))) else None


@np.errstate(over="ignore", invalid="ignore")
def _invert_plain(m: MatrixLike) -> Float64Array | None:
    """Return the inverse of an affine float64 array (4, 4) that is well conditioned; None for all else.

    It takes a fifth of the time. A matrix whose condition number, by Frobenius norms, is small is not singular.
    """
    if type(m) is not np.ndarray or m.dtype.char != "d" or m.shape != (4, 4) or m[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        return None
    linear = m[:3, :3]
    try:
        inverted = np.linalg.inv(linear)
    except np.linalg.LinAlgError:
        return None
    squares = sum([entry * entry for entry in linear.ravel().tolist()])
    inverse_squares = sum([entry * entry for entry in inverted.ravel().tolist()])
    if not squares * inverse_squares < MAX_PLAIN_CONDITION**2:  # true for NaN
        return None
    result = np.zeros((4, 4))
    result[:3, :3] = inverted
    result[:3, 3] = inverted.dot(-m[:3, 3])
    result[3, 3] = 1.0
    return result if isfinite(sum(map(abs, result[:3, 3].tolist()))) else None


def _invert(a: Float64Array) -> Float64Array:
    columns, column_exponents = _balance(a, axis=0)
    balanced, row_exponents = _balance(columns, axis=1)
    _require_invertible(balanced)
    exponents = column_exponents[:, np.newaxis] + row_exponents
    with np.errstate(over="ignore"):
        result: Float64Array = np.ldexp(np.linalg.inv(balanced), -exponents)
    return result


def _balance(a: Float64Array, axis: int) -> tuple[Float64Array, np.ndarray[tuple[int, ...], np.dtype[np.int32]]]:
    """Return `a`, divided by powers of 2 so that the largest entry along `axis` is in [0.5, 1), and their exponents."""
    exponents = np.frexp(np.abs(a).max(axis=axis))[1]
    return np.ldexp(a, -np.expand_dims(exponents, axis)), exponents


def _require_invertible(balanced: Float64Array) -> None:
    singular_values = np.linalg.svd(balanced, compute_uv=False)
    largest, smallest = singular_values[0], singular_values[-1]
    if smallest <= SINGULAR_RTOL * largest:
        raise SingularMatrixError.expecting(
            "m",
            "have an inverse",
            "a singular matrix",
            reason=f"balanced, its singular values reach from {largest:.2g} down to {smallest:.2g}",
        )
