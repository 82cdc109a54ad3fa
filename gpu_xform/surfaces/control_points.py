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
    step = np.ldexp(_MAX_ROUNDING, np.frexp(np.abs(points).max())[1])
    return number_rows(np.rint(points / step)).reshape(control_points.shape[:-1])


def number_rows(rows: npt.NDArray[Any]) -> IndexArray:
    """Return one number for each row (n, d), from 0, the same for equal ones; faster than `np.unique`."""
    order = np.lexsort(rows.T)
    ordered = rows[order]
    numbers = np.zeros(len(order), np.int64)
    numbers[order[1:]] = np.cumsum((ordered[1:] != ordered[:-1]).any(axis=1))
    return numbers


def snap_weights(control_points: Float64Array) -> IndexArray | None:
    """Return whole numbers, in proportion to the weights along curves (m, a, 4): (m, a); None without weights."""
    if control_points.shape[-1] == 3:
        return None
    weights = control_points[..., 3]
    ratios = weights / weights.max(axis=1, keepdims=True)
    snapped: IndexArray = np.rint(ratios / _MAX_ROUNDING).astype(np.int64)
    return snapped


def divide_by_weights(points: Float64Array) -> Float64Array:
    """Return homogeneous points (..., 4) as points (..., 3); points (..., 3) as they are."""
    return points if points.shape[-1] == 3 else points[..., :3] / points[..., 3:]
