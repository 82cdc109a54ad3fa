"""Many points to their bounds and their sum, on the device but for the last step."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...gpu.buffers import Buffer
from ...gpu.chunking import DispatchPlan
from ...gpu.dispatch import dispatch
from .transform import POOL_OWNER, Finish, upload_transforms

POINTS_PER_INVOCATION = 128


@dataclass(frozen=True)
class Reduction:
    """What is left of n points of 2 or 3 coordinates: all float64; NaN where any of the n is."""

    lowest: npt.NDArray[np.float64]
    highest: npt.NDArray[np.float64]
    total: npt.NDArray[np.float64]
    n_points: int

    def merged(self, other: "Reduction") -> "Reduction":
        """Return the reduction of both sets of points."""
        return Reduction(
            np.minimum(self.lowest, other.lowest),
            np.maximum(self.highest, other.highest),
            self.total + other.total,
            self.n_points + other.n_points,
        )


def reduce(
    plan: DispatchPlan, source: Buffer, n_points: int, matrix: npt.NDArray[np.float64] | None, finish: Finish
) -> Reduction:
    """Reduce the first `n_points` > 0 of `source`, each through `matrix` (4, 4) first, if there is one."""
    device = plan.device
    with device.lock:
        pipeline = plan.pipeline("reduce_points", epilogue=finish, is_identity=matrix is None)
        n_workgroups = max(1, n_points // (POINTS_PER_INVOCATION * plan.workgroup_size))
        n_partials = min(n_workgroups * plan.workgroup_size, n_points)
        (transforms,) = upload_transforms(plan, np.eye(4)[None] if matrix is None else matrix[None], n_points)
        partials = device.pool.scratch(
            POOL_OWNER, "partials", n_workgroups * plan.workgroup_size * 12 * plan.dtype.itemsize
        )
        with device.encode_commands(transforms.buffer, source, partials, label="reduce points") as encoder:
            bindings = device.bind_groups.bind(pipeline, transforms=transforms, source=source, partials=partials)
            dispatch(encoder, pipeline, bindings, n_workgroups)
        with partials.map_read(n_partials * 12 * plan.dtype.itemsize) as view:
            rows = view.view(plan.dtype).reshape(n_partials, 3, 4).astype(np.float64)
    axes = slice(plan.n_components)
    poisoned = np.where(rows[:, :, 3].sum(axis=0) > 0, np.nan, 0.0)[axes]
    return Reduction(
        rows[:, 0, axes].min(axis=0) + poisoned,
        rows[:, 1, axes].max(axis=0) + poisoned,
        rows[:, 2, axes].sum(axis=0) + poisoned,
        n_points,
    )
