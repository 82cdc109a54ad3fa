"""Reduction of many points to their bounds and their sum; all but the last step on the device."""

import numpy as np

from ..._core.types import Float64Array
from ..._core.widen import widen
from ...gpu.buffers import Buffer
from ...gpu.chunking import DispatchPlan
from ...gpu.dispatch import dispatch
from .job import Epilogue
from .reduction import Reduction
from .transform import POOL_OWNER, upload_transforms

POINTS_PER_INVOCATION = 128
NUMBERS_PER_PARTIAL = 12  # lowest, highest and sum, of four numbers each


def reduce_points(
    plan: DispatchPlan, source: Buffer, n_points: int, matrix: Float64Array | None, epilogue: Epilogue
) -> Reduction:
    """Reduce the first `n_points` > 0 of `source`, each through `matrix` (4, 4) first, if there is one."""
    device = plan.device
    n_workgroups = max(1, n_points // (POINTS_PER_INVOCATION * plan.workgroup_size))
    n_invocations = n_workgroups * plan.workgroup_size
    partial_bytes = NUMBERS_PER_PARTIAL * plan.dtype.itemsize
    with device.lock:
        pipeline = plan.pipeline("reduce_points", epilogue=epilogue, is_identity=matrix is None)
        (transforms,) = upload_transforms(plan, np.eye(4)[None] if matrix is None else matrix[None], n_points)
        partials = device.pool.scratch(POOL_OWNER, "partials", n_invocations * partial_bytes)
        with device.encode_commands(transforms.buffer, source, partials, label="reduce points") as encoder:
            bindings = device.bind_groups.bind(pipeline, transforms=transforms, source=source, partials=partials)
            dispatch(encoder, pipeline, bindings, n_workgroups)
        n_partials = min(n_invocations, n_points)
        with partials.map_read(n_partials * partial_bytes) as view:
            partial = widen(view.view(plan.dtype).reshape(n_partials, 3, 4))
    axes = slice(plan.n_components)
    poison = np.where(partial[:, :, 3].sum(axis=0) > 0, np.nan, 0.0)[axes]
    with np.errstate(invalid="ignore"):  # of signalling NaNs
        return Reduction(
            partial[:, 0, axes].min(axis=0) + poison,
            partial[:, 1, axes].max(axis=0) + poison,
            partial[:, 2, axes].sum(axis=0) + poison,
            n_points,
        )
