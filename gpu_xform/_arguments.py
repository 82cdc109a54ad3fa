"""Argument checks: each returns the value in its canonical form, or raises an error that names the argument."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from .errors import ArgumentError, ArgumentTypeError

Float64Array = npt.NDArray[np.float64]


@runtime_checkable
class SupportsAsMatrix(Protocol):
    """An object such as SciPy's `Rotation` or `RigidTransform`, which knows its own matrix."""

    def as_matrix(self) -> Any:
        """Return the 3x3 rotation or the 4x4 transform."""
        ...


MatrixLike = npt.ArrayLike | SupportsAsMatrix


def real_array(value: npt.ArrayLike, name: str) -> Float64Array:
    """Return a new C-ordered float64 array of `value`, which must hold finite real numbers."""
    try:
        array = np.asarray(value)
    except ValueError as error:  # a ragged list
        raise ArgumentError(f"{name} must be a rectangular array of numbers: {error}") from None
    if array.dtype.kind not in "fiu":
        raise ArgumentTypeError(f"{name} must hold real numbers, got dtype {array.dtype}")
    result = np.array(array, dtype=np.float64, order="C")
    if not np.isfinite(result).all():
        raise ArgumentError(f"{name} must be finite, got {first_non_finite(result)}")
    return result


def first_non_finite(array: npt.NDArray[np.floating[Any]]) -> str:
    """Describe the first NaN or infinity of `array`: its value and its index."""
    index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
    where = "" if not index else f" at index {index[0] if len(index) == 1 else index}"
    return f"{array[index]}{where}"


def number(value: npt.ArrayLike, name: str) -> float:
    """Return `value` as a finite float."""
    array = real_array(value, name)
    if array.shape != ():
        raise ArgumentError(f"{name} must be one number, got shape {array.shape}")
    return float(array)


def vector(value: npt.ArrayLike, name: str, size: int) -> Float64Array:
    """Return `value` as a finite vector of `size` components."""
    array = real_array(value, name)
    if array.shape != (size,):
        raise ArgumentError(f"{name} must have shape ({size},), got {array.shape}")
    return array


def nonzero_vector(value: npt.ArrayLike, name: str, size: int) -> Float64Array:
    """Return `value`, a vector of `size` components not all zero, with its largest component brought into [0.5, 1).

    Only a power of two is divided out: squares neither overflow nor vanish, and small integers stay exact.
    """
    array = vector(value, name, size)
    if not array.any():
        raise ArgumentError(f"{name} must not be the zero vector")
    scaled: Float64Array = np.ldexp(array, -np.frexp(np.abs(array).max())[1])
    return scaled


def direction(value: npt.ArrayLike, name: str, size: int) -> Float64Array:
    """Return `value` as a unit vector of `size` components; a zero vector has no direction and is an error."""
    array = nonzero_vector(value, name, size)
    return array / np.linalg.norm(array)


def square_matrix(value: MatrixLike, name: str, *sizes: int) -> Float64Array:
    """Return `value` as a finite float64 matrix of shape (s, s), s one of `sizes`.

    An object with `as_matrix()` speaks of R^3: where it gives a 3x3, that is carried along in a 4x4.
    """
    if isinstance(value, SupportsAsMatrix):
        matrix = real_array(value.as_matrix(), name)
        if matrix.shape == (3, 3):
            matrix, linear = np.eye(4), matrix
            matrix[:3, :3] = linear
    else:
        matrix = real_array(value, name)
    if matrix.shape not in {(size, size) for size in sizes}:
        expected = " or ".join(f"({size}, {size})" for size in sizes)
        hint = "; homogeneous(a) makes a 4x4 of it" if matrix.shape == (3, 3) and sizes == (4,) else ""
        raise ArgumentError(f"{name} must have shape {expected}, got {matrix.shape}{hint}")
    return matrix


def affine_matrix(value: MatrixLike, name: str, size: int) -> Float64Array:
    """Return `value` as a finite (size, size) matrix with the last row (0, ..., 0, 1)."""
    matrix = square_matrix(value, name, size)
    expected = np.eye(size)[-1]
    if (matrix[-1] != expected).any():
        rows = ["(" + ", ".join(f"{entry:g}" for entry in row) + ")" for row in (expected, matrix[-1])]
        raise ArgumentError(f"{name} must be affine, with the last row {rows[0]}, got {rows[1]}")
    return matrix
