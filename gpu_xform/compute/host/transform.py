"""Each matrix applied to all points, on the host."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.memmap import release_pages
from ..kernels.job import Epilogue, Job
from . import blas, vectorized
from .choose import MIN_COMPILED_MATRICES, MIN_COMPILED_POINTS, MIN_COMPILED_PRODUCTS, run_loop

# Of a file that is mapped into memory, or of a copy in another number type.
POINTS_PER_PART = 1 << 21


@np.errstate(over="ignore", invalid="ignore")
def run_transform(job: Job) -> None:
    """Write each matrix applied to all points into `job.out`, which may share memory with the points if k is 1."""
    matrices = job.matrices.astype(job.dtype)
    if _needs_no_copy(job.points, job.dtype) and _needs_no_copy(job.out, job.dtype):
        apply_matrices(job.points, matrices, job.out, job.epilogue)
        return
    for part in iterate_parts(len(job.points)):
        points = np.asarray(job.points[part], job.dtype)
        target = job.out[:, part]
        out = target if target.dtype == job.dtype and target.dtype.isnative else np.empty(target.shape, job.dtype)
        apply_matrices(points, matrices, out, job.epilogue)
        if out is not target:
            target[...] = out
        release_pages(job.points[part])
        release_pages(job.out[0][part])


def _needs_no_copy(array: npt.NDArray[Any], dtype: np.dtype[Any]) -> bool:
    """Say whether loops take an array as it is: of their number type, and not a file that is mapped into memory."""
    return array.dtype == dtype and not isinstance(array, np.memmap)


def apply_matrices(
    points: npt.NDArray[Any], matrices: npt.NDArray[Any], out: npt.NDArray[Any], epilogue: Epilogue
) -> None:
    """Write each of `matrices` (k, 4, 4) applied to points (n, 2 or 3) into `out` (k, n, 2 or 3), all of one dtype."""
    n_points, n_components = points.shape
    is_much = n_points * len(matrices) >= MIN_COMPILED_PRODUCTS or len(matrices) >= MIN_COMPILED_MATRICES
    if is_much:
        is_packed = points.flags.c_contiguous and out.flags.c_contiguous and n_components == 3
        if is_packed and epilogue is Epilogue.NONE:
            is_done = run_loop("transform_packed", (points, matrices), out)
        else:
            is_done = run_loop(f"transform_{n_components}d", (points, matrices), out, int(epilogue))
        if is_done:
            return
    for m, target in zip(matrices, out, strict=True):
        if epilogue is Epilogue.NONE and n_points >= MIN_COMPILED_PRODUCTS:
            blas.transform_affine(points, m, target)
        else:
            for part in iterate_small_parts(n_points):
                vectorized.transform(points[part], m, target[part], epilogue)


def iterate_parts(n_points: int) -> Iterator[slice]:
    """Return the parts of an array that are worked on one after the other."""
    return (slice(start, start + POINTS_PER_PART) for start in range(0, n_points, POINTS_PER_PART))


def iterate_small_parts(n_points: int) -> Iterator[slice]:
    """Return the parts of an array that NumPy works on one after the other, so that what it makes stays in a cache."""
    return (slice(start, start + MIN_COMPILED_POINTS) for start in range(0, n_points, MIN_COMPILED_POINTS))
