"""Skinning: which matrices move each point, and with which weights; the arguments `index` and `weights`, checked."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError, ArgumentTypeError
from ._arrays import as_host_array

# The weights of a point are used as they are; a sum further from 1 than this is taken for a mistake.
WEIGHT_TOLERANCE = 1e-3


class Influences(NamedTuple):
    """The matrices of n points, b per point.

    indices : (n, b) integers into the matrices
    weights : (n, b), or None if b is 1
    """

    indices: npt.NDArray[Any]
    weights: npt.NDArray[Any] | None


def validate_influences(
    points_shape: tuple[int, ...], n_matrices: int, index: npt.ArrayLike, weights: npt.ArrayLike | None
) -> Influences:
    """Return `index` and `weights` for points of shape (*points_shape, 2 or 3); raise if they do not fit."""
    indices = as_host_array(index, "index")
    if indices.dtype.kind not in "iu":
        raise ArgumentTypeError.expecting("index", "hold integers", f"dtype {indices.dtype}")
    _require_index_shape(indices, points_shape, is_weighted=weights is not None)
    if indices.size:
        for extreme in (int(indices.min()), int(indices.max())):
            if not 0 <= extreme < n_matrices:
                raise ArgumentError.expecting("index", f"lie in 0..{n_matrices - 1}", extreme)
    n_points = int(np.prod(points_shape))
    if weights is None:
        return Influences(indices.reshape(n_points, 1), None)
    checked = as_host_array(weights, "weights")
    if checked.dtype.kind not in "fiu":
        raise ArgumentTypeError.expecting("weights", "hold real numbers", f"dtype {checked.dtype}")
    if checked.shape != indices.shape:
        raise ArgumentError.expecting("weights", f"have the shape of index, {indices.shape}", checked.shape)
    checked = checked.reshape(n_points, indices.shape[-1])
    _require_unit_sums(checked)
    return Influences(indices.reshape(checked.shape), checked)


def _require_index_shape(indices: npt.NDArray[Any], points_shape: tuple[int, ...], *, is_weighted: bool) -> None:
    if is_weighted:
        fits = indices.shape[:-1] == points_shape and indices.shape[-1] > 0
    else:
        fits = indices.shape == points_shape
    if not fits:
        sides = [str(side) for side in points_shape] + ["b"] * is_weighted
        shape = f"({', '.join(sides)}{',' * (len(sides) == 1)})"
        raise ArgumentError.expecting("index", f"have shape {shape}", indices.shape)


def _require_unit_sums(weights: npt.NDArray[Any]) -> None:
    sums = weights.sum(axis=1, dtype=np.float64)
    is_off = ~(np.abs(sums - 1.0) <= WEIGHT_TOLERANCE)  # true for NaN
    if is_off.any():
        point = int(np.argmax(is_off))
        raise ArgumentError.expecting(
            "weights", f"sum to 1 within {WEIGHT_TOLERANCE:g}", f"{sums[point]:g} for point {point}"
        )
