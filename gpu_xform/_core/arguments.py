"""Argument validation: each function returns a value in canonical form, or raises an error that names the argument."""

import math
import operator
import re
from collections.abc import Mapping
from typing import Any, SupportsIndex

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError, ArgumentTypeError
from .masked import MAX_REPEATED_BYTES, require_whole
from .types import Float64Array, MatrixLike, SupportsAsMatrix
from .widen import widen


def as_real_array(value: npt.ArrayLike, name: str, *, finite: bool = True) -> Float64Array:
    """Return a new C-ordered float64 array of `value`, which must hold real numbers, and finite ones by default."""
    require_whole(value, name)
    try:
        array = np.asarray(value)
    except ValueError as error:  # a ragged list
        raise ArgumentError.expecting(name, "be a rectangular array of numbers", reason=error) from None
    if array.dtype.kind not in "fiu":
        raise ArgumentTypeError.expecting(name, "hold real numbers", f"dtype {array.dtype}")
    require_room(array, name)
    result = widen(array)
    if finite and not np.isfinite(result).all():
        raise ArgumentError.expecting(name, "be finite", describe_first_non_finite(result))
    return result


def require_room(array: npt.NDArray[Any], name: str) -> None:
    """Raise `ArgumentError` for what a broadcast repeats, of a shape that no memory holds, before it is written out."""
    if array.nbytes > MAX_REPEATED_BYTES and 0 in array.strides:
        raise ArgumentError.expecting(name, f"take at most {MAX_REPEATED_BYTES:,} bytes", f"shape {array.shape}")


def describe_first_non_finite(array: npt.NDArray[np.floating[Any]]) -> str:
    """Return a text with the first NaN or infinity of `array` and its index."""
    index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
    where = "" if not index else f" at index {index[0] if len(index) == 1 else index}"
    return f"{array[index]}{where}"


def as_float(value: npt.ArrayLike, name: str) -> float:
    """Return `value` as a finite float."""
    if isinstance(value, float) and math.isfinite(value):  # the usual case, much faster than an array
        return float(value)
    array = as_real_array(value, name)
    if array.shape != ():
        raise ArgumentError.expecting(name, "be one number", f"shape {array.shape}")
    return float(array)


def as_numbers(values: Mapping[str, npt.ArrayLike]) -> Mapping[str, Any]:
    """Return each value as a finite float or, if one is an array, all as arrays of one shape; the keys name them."""
    if all(isinstance(value, float | int) for value in values.values()):  # the usual case, much faster than arrays
        return {name: as_float(value, name) for name, value in values.items()}
    arrays = {name: as_real_array(value, name) for name, value in values.items()}
    if all(array.ndim == 0 for array in arrays.values()):
        return {name: float(array) for name, array in arrays.items()}
    try:
        return dict(zip(arrays, np.broadcast_arrays(*arrays.values()), strict=True))
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays.values())
        raise ArgumentError.expecting(" and ".join(arrays), "broadcast", f"shapes {shapes}") from None


def as_int(value: SupportsIndex, name: str) -> int:
    """Return `value` as an int."""
    try:
        return operator.index(value)
    except TypeError:
        raise ArgumentTypeError.expecting(name, "be a whole number", repr(value)) from None


def require_flag(value: object, name: str, *, default: bool = False) -> bool:
    """Return a flag, by default `default`; raise `ArgumentTypeError` for what is neither True nor False."""
    if value is None:
        return default
    if not isinstance(value, bool | np.bool_):
        raise ArgumentTypeError.expecting(name, "be True or False", repr(value))
    return bool(value)


def require_text(value: object, name: str) -> None:
    """Raise `ArgumentTypeError` for what is neither a text nor left out."""
    if value is not None and not isinstance(value, str):
        raise ArgumentTypeError.expecting(name, "be a text", type(value).__name__)


def require_callable(value: object, name: str) -> None:
    """Raise `ArgumentTypeError` for what can be neither called nor left out."""
    if value is not None and not callable(value):
        raise ArgumentTypeError.expecting(name, "be callable", repr(value))


def as_vector(value: npt.ArrayLike, name: str, size: int) -> Float64Array:
    """Return `value` as a finite vector of `size` components."""
    array = as_real_array(value, name)
    if array.shape != (size,):
        raise ArgumentError.expecting(name, f"have shape ({size},)", array.shape)
    return array


def as_vectors(value: npt.ArrayLike, name: str, size: int) -> Float64Array:
    """Return `value` as finite vectors (..., size)."""
    array = as_real_array(value, name)
    if array.shape[-1:] != (size,):
        raise ArgumentError.expecting(name, f"have shape ({size},)", array.shape)
    return array


def find_axis(text: str) -> Float64Array | None:
    """Return the unit vector (3,) of an axis by its name, such as "+Y", "-z" or "x"; None for any other text."""
    axis = re.fullmatch(r"\s*([+-]?)([xyz])\s*", text, re.IGNORECASE)
    if axis is None:
        return None
    unit = np.zeros(3)
    unit["xyz".index(axis[2].lower())] = -1.0 if axis[1] == "-" else 1.0
    return unit


def resolve_axis(value: npt.ArrayLike, name: str, size: int = 3) -> npt.ArrayLike:
    """Return `value`, or the unit vector of an axis that it names; raise an error for another text."""
    if not isinstance(value, str) or size != 3:
        return value
    axis = find_axis(value)
    if axis is None:
        raise ArgumentError.expecting(name, "be three numbers, or an axis such as '+Y' or '-z'", repr(value))
    return axis


def as_nonzero_vector(value: npt.ArrayLike, name: str, size: int) -> Float64Array:
    """Return `value`, a vector of `size` components not all zero, divided by a power of two; of 3, also an axis' name.

    The largest component is then in [0.5, 1), so that squares neither overflow nor vanish; small integers stay exact.
    """
    return _scale_vectors(as_vector(resolve_axis(value, name, size), name, size), name)


def _scale_vectors(vectors: Float64Array, name: str) -> Float64Array:
    """Return vectors (..., size), each divided by a power of two; none may be zero."""
    is_zero = np.asarray(~vectors.any(axis=-1))
    if is_zero.any():
        raise ArgumentError.expecting(name, f"not be the zero vector{describe_first(is_zero)}")
    scaled: Float64Array = np.ldexp(vectors, -np.frexp(np.abs(vectors).max(axis=-1, keepdims=True))[1])
    return scaled


def as_unit_vector(value: npt.ArrayLike, name: str, size: int) -> Float64Array:
    """Return `value` as a unit vector of `size` components; raise an error for the zero vector."""
    array = as_nonzero_vector(value, name, size)
    return array / np.linalg.norm(array)


def as_unit_vectors(value: npt.ArrayLike, name: str, size: int) -> Float64Array:
    """Return `value` as unit vectors (..., size); raise an error for a zero vector."""
    vectors = _scale_vectors(as_vectors(value, name, size), name)
    unit: Float64Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def describe_first(is_wrong: npt.NDArray[np.bool_]) -> str:
    """Return " in matrix INDEX" for the first of a stack that is wrong; nothing for one alone."""
    if is_wrong.ndim == 0:
        return ""
    index = tuple(int(i) for i in np.argwhere(is_wrong)[0])
    return f" in matrix {index[0] if len(index) == 1 else index}"


def as_square_matrix(value: MatrixLike, name: str, *sizes: int) -> Float64Array:
    """Return `value` as a finite float64 matrix of shape (s, s), s one of `sizes`.

    An object with `as_matrix()` is a transform of R^3: if it gives a 3x3 matrix, that is embedded in a 4x4.
    """
    matrix = as_square_matrices(value, name, *sizes)
    if matrix.ndim != 2:
        raise ArgumentError.expecting(name, f"have shape {_list_square_shapes(sizes)}", matrix.shape)
    return matrix


def as_square_matrices(value: MatrixLike, name: str, *sizes: int) -> Float64Array:
    """Return `value` as finite float64 matrices (..., s, s), s one of `sizes`; otherwise as `as_square_matrix`."""
    if not isinstance(value, np.ndarray) and isinstance(value, SupportsAsMatrix):  # checking a protocol is slow
        matrices = as_real_array(value.as_matrix(), name)
        if matrices.shape[-2:] == (3, 3):
            linear = matrices
            matrices = np.zeros((*linear.shape[:-2], 4, 4))
            matrices[..., :3, :3] = linear
            matrices[..., 3, 3] = 1.0
    else:
        matrices = as_real_array(value, name)
    if matrices.shape[-2:] not in {(size, size) for size in sizes}:
        hint = "; homogeneous(a) makes a 4x4 of it" if matrices.shape == (3, 3) and sizes == (4,) else ""
        raise ArgumentError.expecting(name, f"have shape {_list_square_shapes(sizes)}", f"{matrices.shape}{hint}")
    return matrices


def require_affine(matrices: Float64Array, name: str) -> None:
    """Raise ArgumentError if the last row of any of `matrices` (..., s, s) is not (0, ..., 0, 1)."""
    last_rows = matrices[..., -1, :]
    expected = np.eye(matrices.shape[-1])[-1]
    wrong = (last_rows != expected).any(axis=-1)
    if wrong.any():
        index = tuple(int(i) for i in np.argwhere(wrong)[0])
        where = describe_first(wrong)
        rows = [
            "(" + ", ".join(repr(entry).removesuffix(".0") for entry in row.tolist()) + ")"
            for row in (expected, last_rows[index])
        ]
        raise ArgumentError.expecting(name, f"be affine, with the last row {rows[0]}", f"{rows[1]}{where}")


def _list_square_shapes(sizes: tuple[int, ...]) -> str:
    return " or ".join(f"({size}, {size})" for size in sizes)
