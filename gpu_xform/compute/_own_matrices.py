"""The short way of many points through a matrix each on the host: matrices are checked by the loop that uses them.

Elsewhere they are converted to float64 and looked through several times, which takes ten times as long as the loop.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from ..device import Device, opened_device
from ..host import HostDevice
from ._precision import DOUBLE, SINGLE, warn_if_coarse
from .host.choose import MIN_COMPILED_POINTS
from .host.own_matrices import transform_each
from .kernels.job import Epilogue


def transform_by_own_matrices(
    points: Any, matrix: Any, index: Any, epilogue: Epilogue, out: Any, device: Device | None
) -> npt.NDArray[Any] | None:
    """Return points (n, 3) through those of `matrix` (k, 4, 4) that `index` (n,) names, if that is what came.

    None for the long way: what is wrong is refused there, and `out` is written only if nothing is.
    """
    for array, kind in ((points, "f"), (matrix, "f"), (index, "i")):
        if type(array) is not np.ndarray or array.dtype.kind != kind or not array.flags.c_contiguous:
            return None
    types = {points.dtype, matrix.dtype}
    if not types <= {SINGLE, DOUBLE} or index.dtype != np.int64:
        return None
    n_points = len(points) if points.ndim else 0
    if points.shape != (n_points, 3) or matrix.shape[1:] != (4, 4) or index.shape != (n_points,):
        return None
    if min(n_points, len(matrix)) < MIN_COMPILED_POINTS:
        return None
    if out is not None and not (
        type(out) is np.ndarray and out.shape == points.shape and out.dtype == points.dtype and out.flags.writeable
    ):
        return None
    chosen = opened_device() if device is None else device
    if type(chosen) is not HostDevice or chosen.is_closed:
        return None
    if points.dtype == SINGLE:
        warn_if_coarse(points)
    result: npt.NDArray[Any] = np.empty_like(points)
    if not transform_each(points, index, matrix, result, epilogue):
        return None
    if out is None:
        return result
    np.copyto(out, result)
    written: npt.NDArray[Any] = out
    return written
