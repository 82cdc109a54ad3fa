"""Reduction of many points to their bounds and their sum, on the host."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.types import Float64Array
from ..kernels.job import Epilogue
from ..kernels.reduction import Reduction
from . import vectorized
from .choose import MIN_COMPILED_POINTS, find_block_starts, run_loop


@np.errstate(over="ignore", invalid="ignore")
def reduce_points(points: npt.NDArray[Any], matrix: Float64Array | None, epilogue: Epilogue) -> Reduction:
    """Reduce points (n, 2 or 3), n > 0, each through `matrix` (4, 4) first, if there is one.

    Each block is summed in float64, point by point, and then the blocks are: the bytes are the same for any number of
    threads.
    """
    n_points, n_components = points.shape
    starts = find_block_starts(n_points)
    partials = np.zeros((len(starts) - 1, 4, 3))
    m = None if matrix is None else matrix.astype(points.dtype)
    inputs = points, np.eye(4, dtype=points.dtype) if m is None else m
    if n_points < MIN_COMPILED_POINTS or not run_loop("reduce_blocks", inputs, partials, int(epilogue), m is not None):
        for partial, first, end in zip(partials, starts[:-1], starts[1:], strict=True):
            vectorized.reduce(points[first:end], m, epilogue, partial)
    axes = slice(n_components)
    poison = np.where(partials[:, 3, axes].sum(axis=0) > 0, np.nan, 0.0)
    return Reduction(
        partials[:, 0, axes].min(axis=0) + poison,
        partials[:, 1, axes].max(axis=0) + poison,
        partials[:, 2, axes].sum(axis=0) + poison,
        n_points,
    )
