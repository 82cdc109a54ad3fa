"""Products, inverses and the decomposition of matrices."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple, cast

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrices, as_square_matrix, describe_first, require_affine
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
    *matrices : (..., 4, 4) or (..., 3, 3) numbers, or objects with `as_matrix()`
        One or more, all of the same size. Stacks broadcast as in `numpy.matmul`.

    Returns
    -------
    (..., 4, 4) or (..., 3, 3) float64

    Raises
    ------
    ArgumentError
        If there are none, if they differ in size, if stacks do not broadcast, or if the product overflows.
    """
    plain = _chain_plain(matrices)
    if plain is not None:
        return plain
    if not matrices:
        raise ArgumentError.expecting("matrices", "hold at least one 3x3 or 4x4 matrix", "none")
    product = as_square_matrices(matrices[0], "matrices[0]", 3, 4)
    size = product.shape[-1]
    with np.errstate(over="ignore", invalid="ignore"):
        for i, matrix in enumerate(matrices[1:], 1):
            factor = as_square_matrices(matrix, f"matrices[{i}]", size)
            require_broadcast(product, factor, f"matrices[{i}]")
            product = factor @ product
    return require_finite(product, "the product of matrices")


def require_broadcast(a: Float64Array, b: Float64Array, name: str) -> None:
    """Raise `ArgumentError` that names `b` if stacks of matrices (..., s, s) do not broadcast."""
    try:
        np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    except ValueError:
        raise ArgumentError.expecting(name, f"broadcast with a stack {a.shape[:-2]}", b.shape[:-2]) from None


@public
def inverse(m: MatrixLike) -> Float64Array:
    """Return the inverse of a matrix; that of an affine matrix is exactly affine.

    Parameters
    ----------
    m : (..., 4, 4) or (..., 3, 3) numbers, or an object with `as_matrix()`
        The matrix to invert, or a stack of matrices.

    Returns
    -------
    (..., 4, 4) or (..., 3, 3) float64

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
    matrix = as_square_matrices(m, "m", 3, 4)
    n = matrix.shape[-1] - 1
    is_projective = np.asarray(matrix[..., n, :n].any(axis=-1))
    result = np.zeros_like(matrix)
    result[is_projective] = _invert(matrix[is_projective], is_projective)
    # In blocks, so that the last row of an affine matrix stays as it is.
    is_affine = np.asarray(~is_projective)
    affine = matrix[is_affine]
    blocks = np.zeros_like(affine)
    blocks[:, :n, :n] = _invert(affine[:, :n, :n], is_affine)
    blocks[:, n:, n:] = _invert(affine[:, n:, n:], is_affine)
    with np.errstate(over="ignore", invalid="ignore"):
        blocks[:, :n, n:] = -blocks[:, :n, :n] @ affine[:, :n, n:] @ blocks[:, n:, n:]
    result[is_affine] = blocks
    return require_finite(result, "the inverse of m")


class Decomposition(NamedTuple):
    """The parts of an affine matrix, which applies scale, shear, rotation and translation, in this order.

    Those of a stack of matrices are stacks.

    m = translate(*translation) @ homogeneous(rotation) @ shear(xy=, xz=, yz=) @ scale(*scale)

    Attributes
    ----------
    translation : (..., 3) float64
        The image of the origin.
    rotation : (..., 3, 3) float64
        Proper: the determinant is +1.
    scale : (..., 3) float64
        All positive, or one negative if m mirrors.
    shear : (..., 3) float64
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
        (..., 4, 4) float64
        """
        scale_factors, (xy, xz, yz), offsets = (
            np.moveaxis(part, -1, 0) for part in (self.scale, self.shear, self.translation)
        )
        return chain(scale(*scale_factors), shear(xy=xy, xz=xz, yz=yz), homogeneous(self.rotation), translate(*offsets))


@public
def decompose(m: MatrixLike) -> Decomposition:
    """Decompose an affine matrix into translation, rotation, scale and shear.

    The linear part is factored as Q R, R upper triangular (Thomas, "Decomposing a matrix into simple transformations",
    Graphics Gems II, 1991). If `m` mirrors, one factor of the scale is negative: that which leaves the rotation
    closest to the identity.

    Parameters
    ----------
    m : (..., 4, 4) numbers, or an object with `as_matrix()`
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
    matrix = as_square_matrices(m, "m", 4)
    require_affine(matrix, "m")
    columns, exponents = _balance(matrix[..., :3, :3], axis=-2)
    _require_invertible(columns.reshape(-1, 3, 3), np.ones(columns.shape[:-2], bool))
    q, r = np.linalg.qr(columns)
    signs = np.copysign(1.0, _diagonals(r))
    mirrors = np.linalg.det(q * signs[..., np.newaxis, :]) < 0.0
    closest = np.argmin(_diagonals(q) * signs, axis=-1)
    signs[(closest[..., np.newaxis] == np.arange(3)) & mirrors[..., np.newaxis]] *= -1.0
    q *= signs[..., np.newaxis, :]
    r *= signs[..., np.newaxis]
    stretch = _diagonals(r)
    with np.errstate(over="ignore"):
        scale_factors = require_finite(np.ldexp(stretch, exponents), "the scale in m")
    return Decomposition(
        translation=matrix[..., :3, 3].copy(),
        rotation=q + 0.0,
        scale=scale_factors,
        shear=(r / stretch[..., np.newaxis, :])[..., [0, 0, 1], [1, 2, 2]] + 0.0,
    )


def _diagonals(matrices: Float64Array) -> Float64Array:
    return np.diagonal(matrices, axis1=-2, axis2=-1)


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


def _invert(a: Float64Array, is_chosen: npt.NDArray[np.bool_]) -> Float64Array:
    """Return the inverses of matrices (k, n, n), which are those chosen of a stack."""
    columns, column_exponents = _balance(a, axis=1)
    balanced, row_exponents = _balance(columns, axis=2)
    _require_invertible(balanced, is_chosen)
    exponents = column_exponents[:, :, np.newaxis] + row_exponents[:, np.newaxis, :]
    with np.errstate(over="ignore"):
        result: Float64Array = np.ldexp(np.linalg.inv(balanced), -exponents)
    return result


def _balance(a: Float64Array, axis: int) -> tuple[Float64Array, np.ndarray[tuple[int, ...], np.dtype[np.int32]]]:
    """Return `a`, divided by powers of 2 so that the largest entry along `axis` is in [0.5, 1), and their exponents."""
    exponents = np.frexp(np.abs(a).max(axis=axis))[1]
    return np.ldexp(a, -np.expand_dims(exponents, axis)), exponents


def _require_invertible(balanced: Float64Array, is_chosen: npt.NDArray[np.bool_]) -> None:
    """Raise `SingularMatrixError` if one of the matrices (k, n, n), which are those chosen of a stack, is singular."""
    singular_values = np.linalg.svd(balanced, compute_uv=False)
    largest, smallest = singular_values[:, 0], singular_values[:, -1]
    is_singular = smallest <= SINGULAR_RTOL * largest
    if is_singular.any():
        place = np.zeros_like(is_chosen)
        place[is_chosen] = is_singular
        k = int(np.argmax(is_singular))
        raise SingularMatrixError.expecting(
            "m",
            "have an inverse",
            f"a singular one{describe_first(place)}" if place.ndim else "a singular matrix",
            reason=f"balanced, its singular values reach from {largest[k]:.2g} down to {smallest[k]:.2g}",
        )
