"""Control points: arguments checked, and numbered by which are equal."""

from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array
from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError

# Of the model's size. Control points this close are equal: rotating them may have rounded them apart.
_MAX_ROUNDING = 2.0**-40


def require_control_points(array: Float64Array, name: str, axes: str) -> None:
    """Raise ArgumentError unless every axis holds what it must: (k, ..., 3) points or (k, ..., 4) homogeneous ones.

    axes : the names of all axes but the last, such as "k, a, b"
    """
    n_axes = axes.count(",") + 2
    if array.ndim != n_axes or array.shape[-1] not in (3, 4):
        raise ArgumentError.expecting(name, f"have shape ({axes}, 3) or ({axes}, 4)", array.shape)
    if array.shape[0] < 1 or min(array.shape[1:-1]) < 2:
        orders = " and ".join(axes.split(", ")[1:])
        raise ArgumentError.expecting(name, f"have at least one row, and {orders} of at least 2", array.shape)
    if array.shape[-1] == 4 and not (array[..., 3] > 0).all():
        raise ArgumentError.expecting(name, "have positive weights", f"a weight of {array[..., 3].min():g}")


def as_patches(value: npt.ArrayLike, name: str) -> Float64Array:
    """Return control points of patches as (k, a, b, 3) or (k, a, b, 4); one patch may come without its first axis."""
    patches = as_real_array(value, name)
    if patches.ndim == 3:
        patches = patches[np.newaxis]
    require_control_points(patches, name, "k, a, b")
    return patches


def number_points(control_points: Float64Array) -> IndexArray:
    """Return one number for each control point (..., 3 or 4), the same for equal ones: (...).

    Weights do not count, nor what rounding may have changed.
    """
    points = divide_by_weights(control_points).reshape(-1, 3)
    max_gap = _MAX_ROUNDING * float(np.abs(points).max())
    numbers = np.stack([_cluster(column, max_gap) for column in points.T])
    return number_columns(numbers).reshape(control_points.shape[:-1])


def _cluster(values: Float64Array, max_gap: float) -> IndexArray:
    """Return one number for each value (n,), the same for neighbours up to `max_gap` apart.

    Rounding to a grid would part equal values that happen to lie on both sides of a limit between two of its cells.
    """
    order = np.argsort(values, kind="stable")  # for so few in half the time
    ordered = values[order]
    numbers = np.zeros(len(values), np.int64)
    numbers[order[1:]] = np.cumsum(ordered[1:] - ordered[:-1] > max_gap)
    return numbers


def number_columns(columns: npt.NDArray[Any]) -> IndexArray:
    """Return one number for each column (d, n), from 0, the same for equal ones; faster than `np.unique`."""
    order = np.lexsort(columns)
    ordered = columns.take(order, axis=1)
    numbers = np.zeros(len(order), np.int64)
    numbers[order[1:]] = (ordered[:, 1:] != ordered[:, :-1]).any(axis=0).cumsum()
    return numbers


def number_weights(control_points: Float64Array) -> IndexArray:
    """Return one number per weight of curves (m, a, 4), the same for equal ratios: (m, a)."""
    weights = control_points[..., 3]
    ratios = weights / weights.max(axis=1, keepdims=True)
    return _cluster(ratios.reshape(-1), _MAX_ROUNDING).reshape(ratios.shape)


def divide_by_weights(points: Float64Array) -> Float64Array:
    """Return homogeneous points (..., 4) as points (..., 3); points (..., 3) as they are."""
    return points if points.shape[-1] == 3 else points[..., :3] / points[..., 3:]
