"""Each point through a matrix of its own, checked while it is read."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ..kernels.job import Epilogue
from .choose import run_loop_in_blocks

# Whose matrices stay in a processor's cache from the check to the use.
POINTS_PER_BLOCK = 2048

Array = npt.NDArray[Any]


def transform_each(points: Array, indices: Array, matrices: Array, out: Array, epilogue: Epilogue) -> bool:
    """Write points (n, 3) through those of `matrices` (k, 4, 4) that `indices` (n,) names into `out`.

    Return False if numba cannot do it, or if an index or a matrix is not what it should be: finite in the type of the
    points, and affine unless results are divided.
    """
    starts = np.append(np.arange(0, len(points), POINTS_PER_BLOCK), len(points))
    is_wrong = np.zeros(len(starts) - 1, np.bool_)
    largest = matrices.dtype.type(min(np.finfo(points.dtype).max, np.finfo(matrices.dtype).max))
    is_affine = epilogue is not Epilogue.PERSPECTIVE_DIVIDE
    inputs = points, indices, matrices
    done = run_loop_in_blocks("transform_each", inputs, out, starts, int(epilogue), largest, is_affine, is_wrong)
    return done and not is_wrong.any()
