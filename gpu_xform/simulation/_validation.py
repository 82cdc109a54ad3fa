"""Validation of numbers that a simulation takes one of, or one per spring or point."""

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_real_array, as_vector
from .._core.masked import require_whole
from .._core.types import BoolArray, Float64Array, IndexArray
from ..errors import ArgumentError, ArgumentTypeError

Checked = TypeVar("Checked")

MAX_NUMBER = 3.4e38  # that float32 holds
MAX_SQUARED = 1e18  # of what is squared as float32: coordinates and speeds


def require_at_most(array: npt.ArrayLike, name: str, most: float = MAX_NUMBER) -> None:
    """Raise ArgumentError if a number is larger than `most`, or smaller than its negative."""
    size = np.abs(np.asarray(array, np.float64))
    if size.size and size.max() > most:
        expected = f"be at most {most:g}" if size.ndim == 0 else f"hold numbers of at most {most:g} in size"
        raise ArgumentError.expecting(name, expected, f"{np.ravel(array)[size.argmax()]:g}")


def as_small_vector(value: npt.ArrayLike, name: str) -> Float64Array:
    """Return a point, a velocity or an acceleration as (3,) float64."""
    vector = as_vector(value, name, 3)
    require_at_most(vector, name, MAX_SQUARED)
    return vector


def as_index_array(value: npt.ArrayLike, name: str) -> npt.NDArray[Any]:
    """Return what should hold indices as an array."""
    require_whole(value, name)
    try:
        return np.asarray(value)
    except ValueError as error:  # a ragged list
        raise ArgumentError.expecting(name, "be a rectangular array of indices", reason=error) from None


def as_nonnegative_float(value: float, name: str, most: float = MAX_NUMBER) -> float:
    """Return `value` as a finite float that is not negative."""
    number = as_float(value, name)
    if number < 0.0:
        raise ArgumentError.expecting(name, "not be negative", f"{number:g}")
    require_at_most(number, name, most)
    return number


def as_positive_float(value: float, name: str, most: float = MAX_NUMBER) -> float:
    """Return `value` as a finite float above 0."""
    number = as_float(value, name)
    if number <= 0.0:
        raise ArgumentError.expecting(name, "be positive", f"{number:g}")
    require_at_most(number, name, most)
    return number


def as_column(value: npt.ArrayLike, name: str, n: int, of: str) -> Float64Array:
    """Return one finite number, or one per item, as (n,) float64; `of` names the items."""
    array = as_real_array(value, name)
    if array.shape not in ((), (n,)):
        raise ArgumentError.expecting(name, f"be one number or have shape ({n},), one per {of}", array.shape)
    require_at_most(array, name)
    return np.broadcast_to(array, (n,)).copy()


def require_each(good: BoolArray, name: str, expected: str, values: npt.NDArray[Any], of: str) -> None:
    """Raise ArgumentError that names the first item for which `good` (n,) is false."""
    if not good.all():
        first = int(np.argmin(good))
        raise ArgumentError.expecting(name, expected, f"{values[first]:g} for {of} {first}")


def as_points(value: npt.ArrayLike, name: str, n: int | None = None, most: float = MAX_SQUARED) -> Float64Array:
    """Return finite points or vectors as (n, 3) float64."""
    array = as_real_array(value, name)
    if array.ndim != 2 or array.shape[1] != 3 or (n is not None and len(array) != n):
        raise ArgumentError.expecting(name, f"have shape ({'n' if n is None else n}, 3)", array.shape)
    require_at_most(array, name, most)
    return array


def as_point_indices(value: npt.ArrayLike, name: str, n_points: int) -> IndexArray:
    """Return indices of points (k,), each once and in order; a mask of the points (n,) bool stands for those it has."""
    array = as_index_array(value, name)
    if array.dtype == np.bool_:
        if array.shape != (n_points,):
            raise ArgumentError.expecting(name, f"be a mask of shape ({n_points},), or indices", array.shape)
        return np.flatnonzero(array)
    if array.size == 0:
        return np.empty(0, np.int64)
    if array.dtype.kind not in "iu":
        raise ArgumentTypeError.expecting(name, "hold indices of points", f"dtype {array.dtype}")
    if array.ndim != 1:
        raise ArgumentError.expecting(name, "have shape (k,)", array.shape)
    outside = (array < 0) | (array >= n_points)
    if outside.any():
        raise ArgumentError.expecting(name, f"lie in 0..{n_points - 1}", array[int(np.argmax(outside))])
    return np.unique(array.astype(np.int64))


def call_at(
    function: Callable[..., Any], name: str, time: float, *arguments: object, check: Callable[[Any], Checked]
) -> Checked:
    """Return what `check` makes of what a function of the time gives; errors name the function and the time."""
    try:
        value = function(time, *arguments)
    except Exception as error:
        what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise ArgumentError(f"{name} raised at {time:g} s: {what}", argument=name) from error
    if value is None:
        raise ArgumentTypeError(f"{name} returned None at {time:g} s", argument=name)
    try:
        return check(value)
    except (ArgumentError, ArgumentTypeError) as error:
        raise type(error)(f"{error}, returned at {time:g} s", argument=name, expected=error.expected) from None
