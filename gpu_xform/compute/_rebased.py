"""Double-precision coordinates through single-precision shaders: what travels is the offset from a nearby origin.

For each block of `BLOCK` points the host subtracts the middle of the block's bounds in float64; the device transforms
the offsets in float32; the host adds the transformed origin back in float64. With r the largest offset in the block and
A the linear part, every component lies within 4 * 2^-24 * sqrt(3) * ||A|| * r of the exact one, beside float64's own
rounding. Blocks are the same for every device, so a result does not depend on how much of it fits there.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..gpu.device import Device
from ._precision import SINGLE
from .kernels import skin as blend_pass
from .kernels import transform as transform_pass
from .kernels.transform import Finish

BLOCK = 4096
BLOCKS_AT_ONCE = 1024


def transform(
    device: Device, points: npt.NDArray[Any], matrices: Float64Array, out: npt.NDArray[Any], finish: Finish
) -> None:
    """Write each of `matrices` (k, 4, 4) applied to `points` (n, 2 or 3) into `out` (k, n, 2 or 3)."""
    step = _blocks_at_once(device) * BLOCK
    for start in range(0, len(points), step):
        part = points[start : start + step]
        origins, index = _origins(part), np.arange(len(part)) // BLOCK
        offsets = (part - origins[index]).astype(np.float32)
        own = out[:, start : start + step]
        if finish is Finish.AS_IT_IS:
            _affine(device, offsets, origins, index, matrices, own)
        else:
            for matrix, row in zip(matrices, own, strict=True):
                _divided(device, offsets, origins, index, matrix, row, finish)


def _affine(
    device: Device,
    offsets: npt.NDArray[np.float32],
    origins: Float64Array,
    index: npt.NDArray[np.int64],
    matrices: Float64Array,
    out: npt.NDArray[Any],
) -> None:
    linear = matrices.copy()
    linear[:, :3, 3] = 0.0
    moved = np.empty(out.shape, np.float32)
    transform_pass.transform(device, offsets, linear, moved, SINGLE, Finish.AS_IT_IS)
    axes = [0, 1, 2][: offsets.shape[1]]
    for matrix, row, target in zip(matrices, moved, out, strict=True):
        bases = origins @ matrix[np.ix_(axes, axes)].T + matrix[axes, 3]
        target[...] = bases[index] + row


def _divided(
    device: Device,
    offsets: npt.NDArray[np.float32],
    origins: Float64Array,
    index: npt.NDArray[np.int64],
    matrix: Float64Array,
    out: npt.NDArray[Any],
    finish: Finish,
) -> None:
    to_origins = np.broadcast_to(np.eye(4), (len(origins), 4, 4)).copy()
    to_origins[:, : origins.shape[1], 3] = origins
    blend_pass.blend(device, offsets, matrix @ to_origins, index[:, None], None, out, SINGLE, finish)


def _origins(points: npt.NDArray[Any]) -> Float64Array:
    """Return the middle of each block's bounds, whatever in it is not finite left out: (blocks, 2 or 3)."""
    starts = np.arange(0, len(points), BLOCK)
    finite = np.where(np.isfinite(points), points, np.nan)
    low = np.fmin.reduceat(finite, starts, axis=0)
    high = np.fmax.reduceat(finite, starts, axis=0)
    return np.nan_to_num(0.5 * low + 0.5 * high)


def _blocks_at_once(device: Device) -> int:
    return max(1, min(BLOCKS_AT_ONCE, blend_pass.max_matrices(device, SINGLE)))
