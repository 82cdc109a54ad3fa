"""Origin rebasing (relative-to-center, RTC): double-precision coordinates through single-precision shaders.

For each block of `POINTS_PER_BLOCK` points the host subtracts the middle of the block's bounds in float64; the device
transforms the offsets in float32; the host adds the transformed origin back in float64. With r the largest offset in
the block and A the linear part, every component lies within 4 * 2^-24 * sqrt(3) * ||A|| * r of the exact one, beside
float64's own rounding. Blocks are the same for every device: a result does not depend on how much of it fits there.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..gpu.device import Device
from ._precision import SINGLE
from ._skinning import Influences
from .kernels.job import Epilogue, Job, SkinningJob
from .kernels.skin import max_matrices, run_skinning
from .kernels.transform import run_transform

POINTS_PER_BLOCK = 4096
MAX_BLOCKS_PER_PART = 1024


def run_rebased(job: Job) -> None:
    """Write each matrix applied to all points into `job.out`."""
    step = _blocks_per_part(job.device) * POINTS_PER_BLOCK
    for start in range(0, len(job.points), step):
        points = job.points[start : start + step]
        out = job.out[:, start : start + step]
        origins, block = _find_origins(points), np.arange(len(points)) // POINTS_PER_BLOCK
        offsets = (points - origins[block]).astype(np.float32)
        part = replace(job, points=offsets, out=out, dtype=SINGLE)
        if job.epilogue is Epilogue.NONE:
            _transform_affine(part, origins, block)
        else:
            _transform_projective(part, origins, block)


def _transform_affine(job: Job, origins: Float64Array, block: npt.NDArray[np.int64]) -> None:
    linear = job.matrices.copy()
    linear[:, :3, 3] = 0.0
    moved = np.empty(job.out.shape, np.float32)
    run_transform(replace(job, matrices=linear, out=moved))
    axes = [0, 1, 2][: job.points.shape[1]]
    for matrix, offsets, target in zip(job.matrices, moved, job.out, strict=True):
        moved_origins = origins @ matrix[np.ix_(axes, axes)].T + matrix[axes, 3]
        target[...] = moved_origins[block] + offsets


def _transform_projective(job: Job, origins: Float64Array, block: npt.NDArray[np.int64]) -> None:
    from_offsets = np.broadcast_to(np.eye(4), (len(origins), 4, 4)).copy()
    from_offsets[:, : origins.shape[1], 3] = origins
    for matrix, out in zip(job.matrices, job.out, strict=True):
        run_skinning(
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


def _find_origins(points: npt.NDArray[Any]) -> Float64Array:
    """Return the middle of each block's bounds, what is not finite left out: (n_blocks, 2 or 3)."""
    starts = np.arange(0, len(points), POINTS_PER_BLOCK)
    finite = np.where(np.isfinite(points), points, np.nan)
    low = np.fmin.reduceat(finite, starts, axis=0)
    high = np.fmax.reduceat(finite, starts, axis=0)
    return np.nan_to_num(0.5 * low + 0.5 * high)


def _blocks_per_part(device: Device) -> int:
    return max(1, min(MAX_BLOCKS_PER_PART, max_matrices(device, SINGLE)))
