"""Few points through one matrix: what such calls need is kept ready, and calls of the driver are saved.

Only on devices whose memory the host maps. Points are written where the stage reads them, and results read where it
writes them: the buffer stays mapped from call to call, but for the dispatch.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.interrupts import defer_interrupts
from ..._core.types import Float64Array
from ...device import Device
from ...gpu import layouts
from ...gpu.buffers import UNIFORM, Buffer
from ...gpu.chunking import DispatchPlan
from ...gpu.device import GpuDevice
from ...gpu.dispatch import dispatch
from .job import Epilogue
from .transform import MATRICES_PER_DISPATCH, POOL_OWNER

MAX_FEW_POINTS = 1024
_MAX_BYTES = MAX_FEW_POINTS * 3 * 8


def takes(device: Device, n_points: int, dtype: np.dtype[Any]) -> bool:
    """Say whether `transform_few` takes so many points of a dtype on a device, which may be closed or lost."""
    return (
        isinstance(device, GpuDevice)
        and device.host_mappable
        and n_points <= MAX_FEW_POINTS <= device.limits.max_workgroups
        and device.limits.max_bound_bytes >= _MAX_BYTES
        and (dtype.itemsize == 4 or device.has_float64)
        and not device.is_closed
        and not device.is_lost
    )


def transform_few(
    device: GpuDevice, points: npt.NDArray[Any], matrix: Float64Array, out: npt.NDArray[Any], epilogue: Epilogue
) -> None:
    """Write `matrix` (4, 4), float64, applied to points (n, 3) that `takes` into `out` (n, 3), of their dtype."""
    device.require_usable()  # before the lock, as in `resolve_device`
    key = _FewPoints, out.dtype, epilogue
    with defer_interrupts(), device.lock, device.context.translate_errors("transform few points"):
        few = device.kept_ready.get(key)
        if few is None or few.is_outdated(device):
            few = device.kept_ready[key] = _FewPoints(device, out.dtype, epilogue)
        few.transform(device, points, matrix, out)


class _FewPoints:
    """What one dtype and one epilogue need: the pipeline, memory of points, and that of the last matrix, bound."""

    def __init__(self, device: GpuDevice, dtype: np.dtype[Any], epilogue: Epilogue) -> None:
        plan = DispatchPlan.of(device, MAX_FEW_POINTS, 3, dtype)
        n_bytes = plan.aligned_count(MAX_FEW_POINTS) * plan.point_bytes
        n_struct_bytes = MATRICES_PER_DISPATCH * layouts.TRANSFORM[dtype].itemsize
        self.dtype = dtype
        self.points_per_workgroup = plan.aligned_count(1)
        self.points = Buffer(device.context, n_bytes, label=f"{POOL_OWNER}: few points", persistent=True)
        self.matrix = Buffer(device.context, n_struct_bytes, UNIFORM, label=f"{POOL_OWNER}: a matrix", persistent=True)
        self.pipeline = plan.pipeline("transform_in_place", epilogue=epilogue)
        self.bindings = device.bind_groups.bind(self.pipeline, transforms=self.matrix, points=self.points)

    def release(self) -> None:
        """Give the memory back."""
        self.points.release()
        self.matrix.release()

    def is_outdated(self, device: GpuDevice) -> bool:
        """Say whether memory has been given back, or shaders have changed."""
        return self.points.is_released or self.matrix.is_released or device.pipelines.may_change

    def transform(
        self, device: GpuDevice, points: npt.NDArray[Any], matrix: Float64Array, out: npt.NDArray[Any]
    ) -> None:
        """Write `matrix` (4, 4) applied to points (n, 3) into `out` (n, 3)."""
        n_points = len(points)
        self.points.lend_shared(self.points.n_bytes, self.dtype).reshape(-1, 3)[:n_points] = points
        content = matrix.tobytes()
        if self.matrix.content_key != content:
            self.matrix.upload(layouts.pack_transforms(matrix[None], self.dtype, n_points=0))
            self.matrix.content_key = content
        self.points.end_sharing()
        with device.encode_commands(self.matrix, self.points, label="transform few points") as encoder:
            dispatch(encoder, self.pipeline, self.bindings, -(-n_points // self.points_per_workgroup))
        out[...] = self.points.lend_shared(self.points.n_bytes, self.dtype).reshape(-1, 3)[:n_points]
