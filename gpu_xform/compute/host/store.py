"""Store of points in the host's memory, behind one `PointBuffer` and all that came from it."""

from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from ..._core.types import Float64Array
from ...device import Device
from ...errors import DeviceError
from ..kernels.job import Epilogue, Job
from ..kernels.reduction import Reduction
from .reduce import reduce_points
from .transform import run_transform


class HostStore:
    """Points (n, 2 or 3) of `dtype`, copied."""

    def __init__(self, device: Device, points: npt.NDArray[Any], dtype: np.dtype[Any]) -> None:
        self.device = device
        self.shape: tuple[int, int] = points.shape
        self.dtype = dtype
        self._points: npt.NDArray[Any] | None = np.array(points, dtype, order="C")

    def download(self, matrix: Float64Array | None, epilogue: Epilogue, out: npt.NDArray[Any]) -> None:
        """Write the points through `matrix`, if there is one, into `out`."""
        points = self._require_open()
        if matrix is None or not points.size:
            out[...] = points
        else:
            run_transform(Job(self.device, points, matrix[None], out[None], self.dtype, epilogue))

    def reduce(self, matrix: Float64Array | None, epilogue: Epilogue) -> Reduction:
        """Reduce the points, each through `matrix` first, if there is one."""
        return reduce_points(self._require_open(), matrix, epilogue)

    def device_points(self) -> NoReturn:
        """Raise: nothing draws on the host."""
        raise DeviceError("the host device draws no pictures: make the PointBuffer on a graphics adapter")

    def release(self) -> None:
        """Give the memory back."""
        self._points = None

    def _require_open(self) -> npt.NDArray[Any]:
        if self._points is None:
            raise DeviceError("the PointBuffer is closed")
        self.device.require_usable()
        return self._points
