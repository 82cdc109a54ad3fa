"""Which matrices each point takes, and how much of each: `index` and `weights`, checked."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError, ArgumentTypeError
from ._arrays import as_host_array

# Weights of a point are used as they are; a sum further from 1 than this is taken for a mistake.
WEIGHT_TOLERANCE = 1e-3


class Influences(NamedTuple):
    """picks : (n, b) integers into the matrices; shares : (n, b), or None where b is 1."""

    picks: npt.NDArray[Any]
    shares: npt.NDArray[Any] | None


def influences(
    per_point: tuple[int, ...], n_matrices: int, index: npt.ArrayLike, weights: npt.ArrayLike | None
) -> Influences:
    """Return `index` and `weights` for points of shape `per_point`; raise where they do not fit."""
    picks = as_host_array(index, "index")
    if picks.dtype.kind not in "iu":
        raise ArgumentTypeError.expecting("index", "hold integers", f"dtype {picks.dtype}")
    _require_shape(picks, per_point, "index", blended=weights is not None)
    if picks.size:
        for worst in (int(picks.min()), int(picks.max())):
            if not 0 <= worst < n_matrices:
                raise ArgumentError.expecting("index", f"lie in 0..{n_matrices - 1}", worst)
    n_points = int(np.prod(per_point))
    if weights is None:
        return Influences(picks.reshape(n_points, 1), None)
    shares = as_host_array(weights, "weights")
    if shares.dtype.kind not in "fiu":
        raise ArgumentTypeError.expecting("weights", "hold real numbers", f"dtype {shares.dtype}")
    if shares.shape != picks.shape:
        raise ArgumentError.expecting("weights", f"have the shape of index, {picks.shape}", shares.shape)
    shares = shares.reshape(n_points, picks.shape[-1])
    sums = shares.sum(axis=1, dtype=np.float64)
    off = ~(np.abs(sums - 1.0) <= WEIGHT_TOLERANCE)  # so that a NaN is off
    if off.any():
        point = int(np.argmax(off))
        raise ArgumentError.expecting(
            "weights", f"sum to 1 within {WEIGHT_TOLERANCE:g}", f"{sums[point]:g} for point {point}"
        )
    return Influences(picks.reshape(shares.shape), shares)


def _require_shape(picks: npt.NDArray[Any], per_point: tuple[int, ...], name: str, *, blended: bool) -> None:
    fits = picks.shape[:-1] == per_point and picks.shape[-1] > 0 if blended else picks.shape == per_point
    if not fits:
        sides = [str(side) for side in per_point] + ["b"] * blended
        raise ArgumentError.expecting(name, f"have shape ({', '.join(sides)}{',' * (len(sides) == 1)})", picks.shape)
