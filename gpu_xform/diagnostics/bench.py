"""Benchmark of bulk transforms on a device, beside copies of the same bytes and beside NumPy."""

import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import matrices
from ..compute.kernels import transform as transform_kernel
from ..compute.kernels.job import Epilogue
from ..compute.transform import transform_points
from ..device import HOST, Device
from ..errors import DeviceError
from ..gpu.buffers import Buffer
from ..gpu.chunking import DispatchPlan
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Binding
from ..gpu.shaders import ComputePipeline
from ..gpu.timing import time_kernel

ROUNDS = 7


@dataclass(frozen=True)
class Timing:
    """Medians in milliseconds for one size; rates count `n_bytes` twice, once in and once out.

    The host device copies nothing and has no kernel of its own: its parts are None.
    """

    n_points: int
    n_bytes: int
    cold_ms: float
    warm_ms: float
    upload_ms: float | None
    kernel_ms: float | None
    download_ms: float | None
    device_copy_ms: float | None
    copyto_ms: float
    numpy_ms: float
    host_ms: float

    @property
    def kernel_gb_s(self) -> float | None:
        """Gigabytes that the kernel loads and stores per second."""
        return None if self.kernel_ms is None else 2 * self.n_bytes / self.kernel_ms / 1e6

    @property
    def warm_gb_s(self) -> float:
        """Gigabytes in and out of a whole call per second."""
        return 2 * self.n_bytes / self.warm_ms / 1e6

    @property
    def percent_of_device_copy(self) -> float | None:
        """Speed of the kernel in percent of a kernel that only copies."""
        if self.kernel_ms is None or self.device_copy_ms is None:
            return None
        return 100 * self.device_copy_ms / self.kernel_ms

    @property
    def percent_of_copyto(self) -> float:
        """Speed of a whole call in percent of `numpy.copyto`."""
        return 100 * self.copyto_ms / self.warm_ms

    @property
    def times_numpy(self) -> float:
        """Speed of a whole call as a multiple of the fastest NumPy idiom."""
        return self.numpy_ms / self.warm_ms

    @property
    def times_host(self) -> float:
        """Speed of a whole call as a multiple of the host device's."""
        return self.host_ms / self.warm_ms

    def as_dict(self) -> dict[str, float | None]:
        """Return the measured and the derived figures."""
        derived = (
            "kernel_gb_s",
            "warm_gb_s",
            "percent_of_device_copy",
            "percent_of_copyto",
            "times_numpy",
            "times_host",
        )
        return asdict(self) | {name: getattr(self, name) for name in derived}


def measure(device: Device, n_points: int, dtype: npt.DTypeLike = np.float32) -> Timing:
    """Time one affine matrix on `n_points` > 0 random points (n, 3); raise `DeviceError` if the result is wrong.

    On a graphics adapter n_points is cut to what one dispatch takes, so that one kernel is timed.
    """
    dtype = np.dtype(dtype)
    plan = DispatchPlan.of(device, n_points, 3, dtype) if isinstance(device, GpuDevice) else None
    if plan is not None:
        n_points = min(n_points, plan.chunk)
    points = np.random.default_rng(0).standard_normal((n_points, 3)).astype(dtype)
    matrix = matrices.chain(
        matrices.scale(0.3, 0.5, 2), matrices.rotate((1, 2, 3), 0.7), matrices.translate(-0.5, 2, 1)
    )
    out = np.empty_like(points)

    start = time.perf_counter()
    transform_points(points, matrix, out=out, device=device)
    cold = time.perf_counter() - start
    expected = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    largest_error = float(np.abs(out - expected).max())
    if not largest_error < 64 * np.finfo(dtype).eps * np.abs(expected).max():
        raise DeviceError(f"{device!r} computes wrong results: off by {largest_error:g}")

    host = device if device.name == HOST else Device(HOST)
    contenders: dict[str, Callable[[], object]] = {
        "warm": lambda: transform_points(points, matrix, out=out, device=device),
        "copyto": lambda: np.copyto(out, points),
        "host": lambda: transform_points(points, matrix, out=out, device=host),
    }
    kernel = copy = None
    if plan is not None:
        kernel, copy = _time_kernels(plan, points, matrix)
        contenders |= _make_copies(plan, points, out)
    seconds = _time_medians(contenders | _make_numpy_idioms(points, matrix, out))
    best_numpy = min(value for name, value in seconds.items() if name.startswith("NumPy"))
    return Timing(
        n_points=n_points,
        n_bytes=points.nbytes,
        cold_ms=1e3 * cold,
        warm_ms=1e3 * seconds["warm"],
        upload_ms=_in_ms(seconds.get("upload")),
        kernel_ms=_in_ms(kernel),
        download_ms=_in_ms(seconds.get("download")),
        device_copy_ms=_in_ms(copy),
        copyto_ms=1e3 * seconds["copyto"],
        numpy_ms=1e3 * best_numpy,
        host_ms=1e3 * seconds["host"],
    )


def _in_ms(seconds: float | None) -> float | None:
    return None if seconds is None else 1e3 * seconds


def _make_copies(
    plan: DispatchPlan, points: npt.NDArray[Any], out: npt.NDArray[Any]
) -> dict[str, Callable[[], object]]:
    """Return what brings the points to the device, and results back."""
    buffer = plan.device.pool.scratch("bench", "source", points.nbytes)
    return {
        "upload": lambda: buffer.upload(points),
        "download": lambda: transform_kernel.read_results(plan, buffer, out[None]),
    }


def _time_kernels(plan: DispatchPlan, points: npt.NDArray[Any], matrix: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Return the median seconds of the transform kernel and of a kernel that only copies, run alternately."""
    device = plan.device
    with device.lock:
        source = device.pool.scratch("bench", "source", plan.chunk * plan.point_bytes)
        destination = device.pool.scratch("bench", "destination", plan.chunk * plan.point_bytes)
        source.upload(points)
        (transforms,) = transform_kernel.upload_transforms(plan, matrix[None], len(points))
        n_workgroups = plan.n_workgroups(len(points))
        stages: list[tuple[ComputePipeline, dict[str, Buffer | Binding]]] = [
            (
                plan.pipeline("transform_points", epilogue=Epilogue.NONE, n_matrices=1),
                {"transforms": transforms, "source": source, "destination": destination},
            ),
            (plan.pipeline("copy_points"), {"source": source, "destination": destination}),
        ]
        rounds = [[time_kernel(device, *stage, n_workgroups) for stage in stages] for _ in range(ROUNDS + 1)]
    kernel, copy = (statistics.median(column) for column in zip(*rounds[1:], strict=True))
    return kernel, copy


def _make_numpy_idioms(
    points: npt.NDArray[Any], matrix: npt.NDArray[np.float64], out: npt.NDArray[Any]
) -> dict[str, Callable[[], object]]:
    linear, offset = np.ascontiguousarray(matrix[:3, :3].T, points.dtype), matrix[:3, 3].astype(points.dtype)
    return {
        "NumPy": lambda: points @ linear + offset,
        "NumPy out=": lambda: np.add(np.matmul(points, linear, out=out), offset, out=out),
        "NumPy einsum": lambda: np.einsum("ni,ij->nj", points, linear) + offset,
    }


def _time_medians(contenders: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the median seconds of each contender, run alternately after a warm-up round."""
    seconds: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(ROUNDS + 1):
        for name, run in contenders.items():
            start = time.perf_counter()
            run()
            seconds[name].append(time.perf_counter() - start)
    return {name: statistics.median(values[1:]) for name, values in seconds.items()}
