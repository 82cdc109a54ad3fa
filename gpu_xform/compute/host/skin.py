"""Each point through the matrix that its index names, or through a weighted sum of several, on the host."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ..kernels.job import Epilogue, SkinningJob
from . import vectorized
from .choose import MIN_COMPILED_POINTS, run_loop
from .transform import iterate_parts, iterate_small_parts

Array = npt.NDArray[Any]


@np.errstate(over="ignore", invalid="ignore")
def run_skinning(job: SkinningJob) -> None:
    """Write each point through its matrices into `job.out`."""
    matrices = job.matrices.astype(job.dtype)
    for part in iterate_parts(len(job.points)):
        points = np.asarray(job.points[part], job.dtype)
        indices = np.ascontiguousarray(job.influences.indices[part], np.int64)
        weights = job.influences.weights
        out = np.empty(points.shape, job.dtype)
        if weights is None:
            _transform_by_index(points, indices[:, 0], matrices, out, job.epilogue)
        else:
            _skin(points, indices, np.ascontiguousarray(weights[part], job.dtype), matrices, out, job)
        job.out[part] = out


def _transform_by_index(points: Array, indices: Array, matrices: Array, out: Array, epilogue: Epilogue) -> None:
    inputs = points, indices, matrices
    if len(points) >= MIN_COMPILED_POINTS and run_loop("transform_by_index", inputs, out, int(epilogue)):
        return
    for part in iterate_small_parts(len(points)):
        vectorized.transform_by_index(points[part], indices[part], matrices, out[part], epilogue)


def _skin(points: Array, indices: Array, weights: Array, matrices: Array, out: Array, job: SkinningJob) -> None:
    is_inverse_transposed = job.inverse_transpose
    inputs, options = (points, indices, weights, matrices), (int(job.epilogue), is_inverse_transposed)
    if len(points) >= MIN_COMPILED_POINTS and run_loop("skin", inputs, out, *options):
        return
    for part in iterate_small_parts(len(points)):
        arrays = points[part], indices[part], weights[part], matrices, out[part]
        vectorized.skin(*arrays, job.epilogue, is_inverse_transposed)
