"""Matrices from matrices: their product, their inverse, and an affine matrix taken apart."""

from typing import NamedTuple

import numpy as np

from .._core.arguments import as_square_matrix
from .._core.public import public
from .._core.types import Float64Array, MatrixLike
from ..errors import ArgumentError, SingularMatrixError
from ._affine import require_finite
from ._elementary import homogeneous, scale, shear, translate

# A matrix counts as singular where it lies as near to one as the roundings of a composition may have moved it.
SINGULAR_RTOL = 64 * np.finfo(np.float64).eps


def as_factors(matrices: tuple[MatrixLike, ...]) -> list[Float64Array]:
    """Return `matrices` as arrays of one size, 3x3 or 4x4; none at all is an error."""
    if not matrices:
        raise ArgumentError.expecting("matrices", "hold at least one 3x3 or 4x4 matrix", "none")
    first = as_square_matrix(matrices[0], "matrices[0]", 3, 4)
    rest = (as_square_matrix(m, f"matrices[{i}]", len(first)) for i, m in enumerate(matrices[1:], 1))
    return [first, *rest]


@public
def chain(*matrices: MatrixLike) -> Float64Array:
    """Return the one matrix that applies `matrices` in the order given: of a, b and c it is c @ b @ a.

    All are 4x4 or all are 3x3.
    """
    first, *rest = as_factors(matrices)
    product = first
    with np.errstate(over="ignore", invalid="ignore"):
        for matrix in rest:
            product = matrix @ product
    return require_finite(product, "the product of matrices")


@public
def inverse(m: MatrixLike) -> Float64Array:
    """Return the inverse of `m`, 4x4 or 3x3; of an affine matrix it is affine, exactly.

    SingularMatrixError is raised where `m` has none within rounding, however `m` is scaled: that depends on neither
    units nor translation, so `scale(1e-12)` has its inverse.
    """
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
    """The parts of an affine matrix in the order scale, shear, rotation, translation.

    m = translate(*translation) @ homogeneous(rotation) @ shear(xy=, xz=, yz=) @ scale(*scale)
    """

    translation: Float64Array
    """(3,): where the origin goes."""
    rotation: Float64Array
    """(3, 3): proper, its determinant is +1."""
    scale: Float64Array
    """(3,): all positive, or one negative where m mirrors."""
    shear: Float64Array
    """(3,): xy, xz, yz."""

    def as_matrix(self) -> Float64Array:
        """Return the 4x4 matrix that the parts make."""
        xy, xz, yz = self.shear
        return chain(
            scale(*self.scale), shear(xy=xy, xz=xz, yz=yz), homogeneous(self.rotation), translate(*self.translation)
        )


@public
def decompose(m: MatrixLike) -> Decomposition:
    """Take the affine 4x4 matrix `m` apart into translation, rotation, scale and shear.

    The linear part is factored as Q R, R upper triangular (Thomas, "Decomposing a matrix into simple transformations",
    Graphics Gems II, 1991). Where `m` mirrors, one axis is flipped in the scale: the one that leaves the rotation
    nearest to none. SingularMatrixError is raised where columns depend on one another within rounding.
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


def _invert(a: Float64Array) -> Float64Array:
    columns, column_exponents = _balance(a, axis=0)
    balanced, row_exponents = _balance(columns, axis=1)
    _require_invertible(balanced)
    exponents = column_exponents[:, np.newaxis] + row_exponents
    with np.errstate(over="ignore"):
        result: Float64Array = np.ldexp(np.linalg.inv(balanced), -exponents)
    return result


def _balance(a: Float64Array, axis: int) -> tuple[Float64Array, np.ndarray[tuple[int, ...], np.dtype[np.int32]]]:
    """Return `a` with the largest entry along `axis` brought into [0.5, 1), and the exponents of 2 divided out."""
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
