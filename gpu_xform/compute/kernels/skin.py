"""Points through matrices of their own: one that an index picks, or a weighted sum of several."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ...gpu import layouts
from ...gpu.chunking import DispatchPlan
from ...gpu.device import Device
from ...gpu.dispatch import dispatch
from .transform import POOL_OWNER, Finish, upload_transforms


def blend(
    device: Device,
    points: npt.NDArray[Any],
    matrices: npt.NDArray[np.float64],
    index: npt.NDArray[Any],
    weights: npt.NDArray[Any] | None,
    out: npt.NDArray[Any],
    dtype: np.dtype[Any],
    finish: Finish,
    *,
    inverse_transposed: bool = False,
) -> None:
    """Write each point through its matrix into `out`, computed in `dtype`.

    points, out : (n, 2) or (n, 3), n > 0
    matrices : (k, 4, 4), no more than `max_matrices(device, dtype)`
    index : (n, b) integers in 0..k-1
    weights : (n, b), or None where b is 1
    """
    n_points, n_components = points.shape
    n_influences = index.shape[1]
    plan = DispatchPlan.of(device, n_points, n_components, dtype, points_per_invocation=1, widest=n_influences)
    pipeline = plan.pipeline(
        "skin_points",
        epilogue=finish,
        n_influences=n_influences,
        is_weighted=weights is not None,
        is_inverse_transposed=inverse_transposed,
    )
    with device.lock:
        source = device.pool.scratch(POOL_OWNER, "source", plan.chunk * plan.point_bytes)
        destination = device.pool.scratch(POOL_OWNER, "destination", plan.chunk * plan.point_bytes)
        picks = device.pool.scratch(POOL_OWNER, "picks", plan.chunk * n_influences * 4)
        shares = device.pool.scratch(
            POOL_OWNER, "shares", plan.chunk * n_influences * dtype.itemsize if weights is not None else 16
        )
        stack = device.pool.scratch(POOL_OWNER, "matrices", len(matrices) * 16 * dtype.itemsize)
        stack.upload(layouts.matrix_array(matrices, dtype))
        buffers = {
            "source": source,
            "destination": destination,
            "indices": picks,
            "weights": shares,
            "matrices": stack,
        }
        for part in plan.chunks(n_points):
            n_part = part.stop - part.start
            source.upload(np.ascontiguousarray(points[part], dtype))
            picks.upload(np.ascontiguousarray(index[part], np.uint32))
            if weights is not None:
                shares.upload(np.ascontiguousarray(weights[part], dtype))
            (transforms,) = upload_transforms(plan, np.eye(4)[None], n_part)
            with device.encode_commands(transforms.buffer, *buffers.values(), label="skin points") as encoder:
                bindings = device.bind_groups.bind(pipeline, transforms=transforms, **buffers)
                dispatch(encoder, pipeline, bindings, -(-n_part // plan.workgroup_size))
            with destination.map_read(n_part * plan.point_bytes) as view:
                out[part] = view.view(dtype).reshape(n_part, n_components)


def max_matrices(device: Device, dtype: np.dtype[Any]) -> int:
    """Return how many matrices one dispatch can hold."""
    return device.limits.max_bound_bytes // (16 * dtype.itemsize)
