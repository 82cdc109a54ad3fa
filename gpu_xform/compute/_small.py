"""The short way of few points: the usual call, checked once, without what it does not need."""

from functools import cache
from math import hypot
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..device import Device, opened_device
from ..host import HostDevice
from ._precision import DOUBLE, MIN_EXTENT_PER_COORDINATE, SINGLE
from .host.choose import MIN_COMPILED_PRODUCTS
from .host.vectorized import MIN_COPIED_POINTS, MIN_POINTS_BY_ROW, transform, transform_by_row
from .host.vectorized import transform_few as apply_to_few
from .kernels.job import Epilogue

# No entry of a matrix of a smaller norm is infinite, or beyond what float32 holds.
_MAX_NORM = float(np.finfo(np.float32).max)


def transform_few(points: Any, matrix: Any, epilogue: Epilogue, device: Device | None) -> npt.NDArray[Any] | None:
    """Return few points (n, 3) through one matrix (4, 4), if that is what came; None for the long way.

    What is left to check, or to be warned of, is checked there: no argument is refused here.
    """
    if type(points) is not np.ndarray or type(matrix) is not np.ndarray:
        return None
    shape = points.shape
    if len(shape) != 2 or shape[1] != 3 or not 0 < shape[0] < MIN_COMPILED_PRODUCTS or matrix.shape != (4, 4):
        return None
    dtype = points.dtype
    if (dtype is not SINGLE and dtype is not DOUBLE) or matrix.dtype is not DOUBLE:
        return None
    chosen = opened_device() if device is None else device
    if type(chosen) is HostDevice:
        if chosen.is_closed:
            return None
    elif not isinstance(chosen, Device) or not _import_few().takes(chosen, shape[0], dtype):
        return None
    entries = matrix.ravel().tolist()
    if not hypot(*entries) < _MAX_NORM:  # true for NaN
        return None
    if epilogue is Epilogue.NONE and (entries[12] or entries[13] or entries[14] or entries[15] != 1.0):
        return None
    if dtype is SINGLE and shape[0] > 1:  # as `may_be_coarse`, without a call of it
        (x, y, z), (a, b, c) = points[0].tolist(), points[-1].tolist()
        limit = (abs(x) + abs(y) + abs(z)) * MIN_EXTENT_PER_COORDINATE
        if not (abs(x - a) > limit or abs(y - b) > limit or abs(z - c) > limit):
            return None
    out: npt.NDArray[Any] = np.empty(shape, dtype)
    run = _transform_on_host if type(chosen) is HostDevice else _import_few().transform_few
    run(chosen, points, matrix, out, epilogue)
    return out


@np.errstate(over="ignore", invalid="ignore")
def _transform_on_host(
    device: Device,  # noqa: ARG001
    points: npt.NDArray[Any],
    matrix: npt.NDArray[Any],
    out: npt.NDArray[Any],
    epilogue: Epilogue,
) -> None:
    is_plain = epilogue is Epilogue.NONE  # each call on the way shows
    if is_plain and len(points) >= MIN_POINTS_BY_ROW:
        transform_by_row(points, matrix, out)
        return
    m = matrix if out.dtype is DOUBLE else matrix.astype(out.dtype)
    if is_plain and len(points) < MIN_COPIED_POINTS:
        apply_to_few(points, m, out)
    else:
        transform(points, m, out, epilogue)


@cache
def _import_few() -> ModuleType:
    """Return the short way on adapters, whose import is that of wgpu: the host has none."""
    from .kernels import few

    return few
