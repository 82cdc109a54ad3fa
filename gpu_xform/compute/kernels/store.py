"""Store of points in the memory of a graphics adapter, behind one `PointBuffer` and all that came from it."""

from typing import Any, Self

import numpy as np
import numpy.typing as npt

from ..._core.types import Float64Array
from ...device import Device
from ...errors import ArgumentError, DeviceError
from ...gpu.buffers import Buffer
from ...gpu.chunking import DispatchPlan
from ...gpu.device import GpuDevice, require_gpu_device
from ...gpu.device_points import DevicePoints
from .job import Epilogue
from .reduce import reduce_points
from .reduction import Reduction
from .transform import POOL_OWNER, dispatch_transform, read_results


class GpuStore:
    """Points (n, 2 or 3) of `dtype` on a graphics adapter."""

    def __init__(self, device: Device, points: npt.NDArray[Any], dtype: np.dtype[Any]) -> None:
        self._allocate(device, points.shape, dtype)
        try:
            for part, buffer in self.parts:
                buffer.upload(np.ascontiguousarray(points[part], dtype))
        except BaseException:
            self.release()
            raise

    @classmethod
    def allocate(cls, device: Device, shape: tuple[int, int], dtype: np.dtype[Any]) -> Self:
        """Return room for points, to be filled by a stage; only those of one part have `device_points`."""
        store = cls.__new__(cls)
        store._allocate(device, shape, dtype)
        return store

    def _allocate(self, device: Device, shape: tuple[int, int], dtype: np.dtype[Any]) -> None:
        self.device = require_gpu_device(device)
        self.shape = shape
        self.dtype = dtype
        n_points, n_components = shape
        self.plan = DispatchPlan.of(self.device, max(n_points, 1), n_components, dtype)
        self.parts: list[tuple[slice, Buffer]] = []
        self._released = False
        try:
            for part in self.plan.chunks(n_points):
                n_bytes = self.plan.aligned_count(part.stop - part.start) * self.plan.point_bytes
                self.parts.append((part, Buffer(self.device.context, n_bytes, label="PointBuffer")))
        except BaseException:
            self.release()
            raise

    def download(self, matrix: Float64Array | None, epilogue: Epilogue, out: npt.NDArray[Any]) -> None:
        """Write the points through `matrix`, if there is one, into `out`."""
        device = self.require_open()
        for part, source in self.parts:
            with device.lock:
                result = source
                if matrix is not None:
                    result = device.pool.scratch(POOL_OWNER, "destination", source.n_bytes)
                    dispatch_transform(self.plan, matrix[None], source, result, part.stop - part.start, epilogue)
                read_results(self.plan, result, out[None, part])

    def reduce(self, matrix: Float64Array | None, epilogue: Epilogue) -> Reduction:
        """Reduce the points, each through `matrix` first, if there is one."""
        self.require_open()
        parts = [
            reduce_points(self.plan, source, part.stop - part.start, matrix, epilogue) for part, source in self.parts
        ]
        whole = parts[0]
        for part in parts[1:]:
            whole = whole.merged(part)
        return whole

    def device_points(self) -> DevicePoints:
        """Return the points as they lie on the device, for a stage that draws them there."""
        device = self.require_open()
        if len(self.parts) != 1:
            raise ArgumentError.expecting(
                "points", f"be one to {self.plan.chunk:,} to be drawn from {device.name!r}", f"{self.shape[0]:,}"
            )
        return DevicePoints(self.parts[0][1], self.shape[0], self.dtype)

    def require_open(self) -> GpuDevice:
        """Return the device; raise `DeviceError` if the points or the device are closed."""
        if self._released:
            raise DeviceError("the PointBuffer is closed")
        self.device.require_usable()
        return self.device

    def release(self) -> None:
        """Give the memory back."""
        self._released = True
        for _, buffer in self.parts:
            buffer.release()
