"""Backends: what computes on each kind of device, imported when the first of its kind is used."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..device import Device
from ..host import HostDevice
from .kernels.convolution_job import ConvolutionJob
from .kernels.job import Epilogue, Job, SkinningJob
from .kernels.reduction import Reduction

if TYPE_CHECKING:
    from ..gpu.device_points import DevicePoints


class PointStore(Protocol):
    """Points (n, 2 or 3) of a dtype in the memory of a device."""

    @property
    def device(self) -> Device:
        """Where they are."""

    shape: tuple[int, int]
    dtype: np.dtype[Any]

    def download(self, matrix: Float64Array | None, epilogue: Epilogue, out: npt.NDArray[Any]) -> None:
        """Write the points through `matrix`, if there is one, into `out`."""

    def reduce(self, matrix: Float64Array | None, epilogue: Epilogue) -> Reduction:
        """Reduce the points, each through `matrix` first, if there is one."""

    def device_points(self) -> "DevicePoints":
        """Return the points as they lie on the device, for a stage that draws them there."""

    def release(self) -> None:
        """Give the memory back."""


@dataclass(frozen=True)
class Backend:
    """What computes on one kind of device.

    run_transform : writes each matrix applied to all points
    run_skinning : writes each point through the matrices that it names
    run_convolution : writes images through stencils
    store_points : keeps points in the device's memory
    min_points_per_matrix : fewer points of a stack are better run by skinning, each copy as points of its own
    """

    run_transform: Callable[[Job], None]
    run_skinning: Callable[[SkinningJob], None]
    run_convolution: Callable[[ConvolutionJob], None]
    store_points: Callable[[Device, npt.NDArray[Any], np.dtype[Any]], PointStore]
    min_points_per_matrix: int


# Fewer points do not fill a dispatch: then one dispatch does the work of many matrices.
MIN_POINTS_PER_DISPATCH = 4096


def find_backend(device: Device) -> Backend:
    """Return what computes on `device`; raise `DeviceError` if it takes no more work."""
    device.require_usable()
    return _host_backend() if isinstance(device, HostDevice) else _gpu_backend()


@cache
def _host_backend() -> Backend:
    from .host.convolve import run_convolution
    from .host.skin import run_skinning
    from .host.store import HostStore
    from .host.transform import run_transform

    return Backend(run_transform, run_skinning, run_convolution, HostStore, min_points_per_matrix=1)


@cache
def _gpu_backend() -> Backend:
    from .kernels.convolve import run_convolution
    from .kernels.skin import run_skinning
    from .kernels.store import GpuStore
    from .kernels.transform import run_transform

    return Backend(
        run_transform, run_skinning, run_convolution, GpuStore, min_points_per_matrix=MIN_POINTS_PER_DISPATCH
    )
