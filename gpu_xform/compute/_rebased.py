"""Origin rebasing (relative-to-center, RTC): double-precision coordinates through single-precision shaders.

For each block of points the host subtracts the middle of the block's bounds in float64; the device
transforms the offsets in float32; the host adds the transformed origin back in float64. With r the largest offset in
the block and A the linear part, every component lies within 4 * 2^-24 * sqrt(3) * ||A|| * r of the exact one, beside
float64's own rounding. A block has `POINTS_PER_BLOCK` points. If they are sorted in space, it is a cell of equal size
that holds `POINTS_PER_CELL` on average: r is bounded by the cell's diagonal wherever the points lie. The host computes
blocks whose products float32 may not hold.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..device import Device
from ._precision import DOUBLE, SINGLE
from ._skinning import Influences
from .backend import find_backend
from .kernels.job import Epilogue, Job, SkinningJob

POINTS_PER_BLOCK = 4096
POINTS_PER_CELL = 8
MAX_BLOCKS_PER_PART = 1024
MAX_PRODUCT = 2.0**124  # of a coordinate and an entry of a matrix: float32 holds the sums of eight, and more
_MAX_SORTED = 2.0**1022  # the extent of coordinates up to this is finite
_MORTON_CELLS = 1 << 21  # per axis
# Shifts and masks that move the bits of a number of 21 bits to every third place.
_SPREADS = (
    (32, 0x001F00000000FFFF),
    (16, 0x001F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)


def run_rebased(job: Job) -> None:
    """Write each matrix applied to all points into `job.out`."""
    if job.epilogue is not Epilogue.NORMALIZE and (job.matrices == np.eye(4)).all():
        np.copyto(job.out, job.points)  # what is only stored in another format keeps its coordinates
        return
    step = _blocks_per_part(job.device) * POINTS_PER_BLOCK
    for start in range(0, len(job.points), step):
        points = job.points[start : start + step]
        out = job.out[:, start : start + step]
        if job.is_sorted_in_space:
            order, starts = _sort_into_cells(points, _max_matrices(job.device))
            moved = np.empty(out.shape, out.dtype)
            _run_part(replace(job, points=points[order], out=moved), starts)
            out[:, order] = moved
        else:
            _run_part(replace(job, points=points, out=out), np.arange(0, len(points), POINTS_PER_BLOCK))


def _run_part(job: Job, starts: npt.NDArray[np.intp]) -> None:
    """Do what `run_rebased` does, for as many points as one dispatch takes; `starts` are the first points of blocks."""
    points = job.points
    is_zero = np.asarray(~points.any(axis=1))  # before anything is written, which may be over the points
    low, high = _find_bounds(points, starts)
    block = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(points)))
    largest = MAX_PRODUCT / max(1.0, np.abs(job.matrices).max())
    is_far = ((low < -largest) | (high > largest)).any(axis=1)
    origins = np.nan_to_num(np.where(is_far[:, np.newaxis], 0.0, 0.5 * low + 0.5 * high))
    far_rows = np.flatnonzero(is_far[block]) if is_far.any() else np.zeros(0, np.intp)
    far = np.asarray(points[far_rows], DOUBLE)
    if len(far):
        points = points.copy()
        points[far_rows] = 0.0
    offsets = (points - origins[block]).astype(np.float32)
    part = replace(job, points=offsets, dtype=SINGLE)
    if job.epilogue is Epilogue.NONE:
        _transform_affine(part, origins, block)
    else:
        _transform_projective(part, origins, block)
    if is_zero.any():
        _place_zeros(job, is_zero)
    if len(far):
        _place_far(job, far_rows, far)


def _place_zeros(job: Job, is_zero: npt.NDArray[np.bool_]) -> None:
    """Write the results of points at zero, which float64 knows exactly: the last column of each matrix."""
    for matrix, out in zip(job.matrices, job.out, strict=True):
        result = matrix[[0, 1, 2][: job.points.shape[1]], 3]
        if job.epilogue is Epilogue.PERSPECTIVE_DIVIDE:
            result = result / matrix[3, 3] if matrix[3, 3] else np.full_like(result, np.nan)
        out[is_zero] = result


def _place_far(job: Job, rows: npt.NDArray[np.intp], points: Float64Array) -> None:
    """Write the results of points beyond the range of float32, which the host computes."""
    from .host.transform import run_transform

    moved = np.empty((len(job.matrices), *points.shape))
    run_transform(replace(job, points=points, out=moved, dtype=DOUBLE))
    job.out[:, rows] = moved


def _sort_into_cells(points: npt.NDArray[Any], max_cells: int) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the order of points (n, 2 or 3) along a Morton curve through their bounds, and where each cell starts.

    Cells are boxes of equal size, the smallest that are not more than `max_cells` and than the points allow.
    """
    finite = np.where(np.abs(points) <= _MAX_SORTED, points, 0.0)
    low, high = finite.min(axis=0), finite.max(axis=0)
    extent = np.where(high > low, high - low, 1.0)
    cells = np.minimum((finite - low) / extent * _MORTON_CELLS, _MORTON_CELLS - 1).astype(np.uint64)
    keys = np.zeros(len(points), np.uint64)
    for axis in range(points.shape[1]):
        keys |= _spread_bits(cells[:, axis]) << np.uint64(axis)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    # The highest bit in which neighbours differ, from 1: cells of 2^b along the curve part those with a higher one.
    highest = np.frexp((keys[1:] ^ keys[:-1]).astype(np.float64))[1]
    n_cells = 1 + np.cumsum(np.bincount(highest, minlength=65)[::-1])[::-1]
    limit = max(1, min(max_cells, len(points) // POINTS_PER_CELL))
    smallest = np.flatnonzero(np.append(n_cells[1:], 1) <= limit)[0]
    return order, np.flatnonzero(np.concatenate([[True], highest > smallest]))


def _spread_bits(values: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """Return numbers of 21 bits with two zeros behind each bit."""
    for shift, mask in _SPREADS:
        values = (values | (values << np.uint64(shift))) & np.uint64(mask)
    return values


def _transform_affine(job: Job, origins: Float64Array, block: npt.NDArray[np.int64]) -> None:
    linear = job.matrices.copy()
    linear[:, :3, 3] = 0.0
    moved = np.empty(job.out.shape, np.float32)
    find_backend(job.device).run_transform(replace(job, matrices=linear, out=moved))
    axes = [0, 1, 2][: job.points.shape[1]]
    for matrix, offsets, target in zip(job.matrices, moved, job.out, strict=True):
        moved_origins = origins @ matrix[np.ix_(axes, axes)].T + matrix[axes, 3]
        target[...] = moved_origins[block] + offsets


def _transform_projective(job: Job, origins: Float64Array, block: npt.NDArray[np.int64]) -> None:
    from_offsets = np.broadcast_to(np.eye(4), (len(origins), 4, 4)).copy()
    from_offsets[:, : origins.shape[1], 3] = origins
    for matrix, out in zip(job.matrices, job.out, strict=True):
        find_backend(job.device).run_skinning(
            SkinningJob(
                job.device,
                job.points,
                matrix @ from_offsets,
                out,
                SINGLE,
                job.epilogue,
                influences=Influences(block[:, None], None),
            )
        )


def _find_bounds(points: npt.NDArray[Any], starts: npt.NDArray[np.intp]) -> tuple[Float64Array, Float64Array]:
    """Return the bounds of each block (n_blocks, 2 or 3), what is not finite left out; NaN if there is nothing else."""
    finite = np.where(np.isfinite(points), points, np.nan)
    return np.fmin.reduceat(finite, starts, axis=0), np.fmax.reduceat(finite, starts, axis=0)


def _blocks_per_part(device: Device) -> int:
    return max(1, min(MAX_BLOCKS_PER_PART, _max_matrices(device)))


def _max_matrices(device: Device) -> int:
    """Return how many matrices one dispatch can hold."""
    return device.limits.max_bound_bytes // (16 * SINGLE.itemsize)
