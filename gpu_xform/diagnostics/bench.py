"""How fast bulk transforms are on a device, beside copies of the same bytes and beside NumPy."""

import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import matrices
from ..compute.kernels import transform as transform_pass
from ..compute.kernels.transform import Finish
from ..compute.transform import transform_points
from ..errors import DeviceError
from ..gpu.chunking import DispatchPlan
from ..gpu.device import Device
from ..gpu.timing import time_kernel

ROUNDS = 7


@dataclass(frozen=True)
class Timing:
    """Medians in milliseconds for one size; what moves the array once in and once out counts `n_bytes` twice."""

    n_points: int
    n_bytes: int
    cold_ms: float
    warm_ms: float
    upload_ms: float
    kernel_ms: float
    download_ms: float
    device_copy_ms: float
    copyto_ms: float
    numpy_ms: float

    @property
    def kernel_gb_s(self) -> float:
        """Bytes that the kernel loads and stores, per second."""
        return 2 * self.n_bytes / self.kernel_ms / 1e6

    @property
    def warm_gb_s(self) -> float:
        """Bytes in and out of a whole call, per second."""
        return 2 * self.n_bytes / self.warm_ms / 1e6

    @property
    def percent_of_device_copy(self) -> float:
        """The kernel's speed in percent of a kernel that only copies."""
        return 100 * self.device_copy_ms / self.kernel_ms

    @property
    def percent_of_copyto(self) -> float:
        """A whole call's speed in percent of `numpy.copyto`."""
        return 100 * self.copyto_ms / self.warm_ms

    @property
    def times_numpy(self) -> float:
        """A whole call's speed as a multiple of the best NumPy."""
        return self.numpy_ms / self.warm_ms

    def as_dict(self) -> dict[str, float]:
        """Return the measured and the derived figures."""
        derived = ("kernel_gb_s", "warm_gb_s", "percent_of_device_copy", "percent_of_copyto", "times_numpy")
        return asdict(self) | {name: getattr(self, name) for name in derived}


def measure(device: Device, n_points: int, dtype: npt.DTypeLike = np.float32) -> Timing:
    """Time one affine matrix on `n_points` > 0 random points (n, 3); raise `DeviceError` where the result is wrong.

    n_points is cut to what one dispatch takes, so that a kernel is one kernel.
    """
    number = np.dtype(dtype)
    plan = DispatchPlan.of(device, n_points, 3, number)
    n_points = min(n_points, plan.chunk)
    points = np.random.default_rng(0).standard_normal((n_points, 3)).astype(number)
    matrix = matrices.chain(
        matrices.scale(0.3, 0.5, 2), matrices.rotate((1, 2, 3), 0.7), matrices.translate(-0.5, 2, 1)
    )
    out = np.empty_like(points)

    start = time.perf_counter()
    transform_points(points, matrix, out=out, device=device)
    cold = time.perf_counter() - start
    expected = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    worst = float(np.abs(out - expected).max())
    if not worst < 64 * np.finfo(number).eps * np.abs(expected).max():
        raise DeviceError(f"{device!r} computes wrongly: off by {worst:g}")

    kernel, copy = _kernels(device, plan, points, matrix)
    buffer = device.pool.scratch("bench", "source", points.nbytes)
    seconds = _medians(
        {
            "warm": lambda: transform_points(points, matrix, out=out, device=device),
            "upload": lambda: buffer.upload(points),
            "download": lambda: transform_pass.download_rows(plan, buffer, out[None]),
            "copyto": lambda: np.copyto(out, points),
        }
        | _numpy_idioms(points, matrix, out)
    )
    best_numpy = min(value for name, value in seconds.items() if name.startswith("NumPy"))
    return Timing(
        n_points=n_points,
        n_bytes=points.nbytes,
        cold_ms=1e3 * cold,
        warm_ms=1e3 * seconds["warm"],
        upload_ms=1e3 * seconds["upload"],
        kernel_ms=1e3 * kernel,
        download_ms=1e3 * seconds["download"],
        device_copy_ms=1e3 * copy,
        copyto_ms=1e3 * seconds["copyto"],
        numpy_ms=1e3 * best_numpy,
    )


def report(device: Device, dtype: str, timings: list[Timing]) -> str:
    """Return the figures as a text for people."""
    lines = [f"{device.name}, {device.adapter.driver}; one affine matrix on {dtype} points (n, 3), medians of {ROUNDS}"]
    if device.adapter.kind == "CPU":
        lines.append("This device is a CPU, not a GPU: these are a CPU's figures.")
    rows: list[tuple[str, Callable[[Timing], str]]] = [
        ("points", lambda t: f"{t.n_points:,}"),
        ("first call, ms", lambda t: f"{t.cold_ms:.3g}"),
        ("whole call, ms", lambda t: f"{t.warm_ms:.3g}"),
        ("  upload, ms", lambda t: f"{t.upload_ms:.3g}"),
        ("  kernel, ms", lambda t: f"{t.kernel_ms:.3g}"),
        ("  download, ms", lambda t: f"{t.download_ms:.3g}"),
        ("whole call, GB/s", lambda t: f"{t.warm_gb_s:.3g}"),
        ("kernel, GB/s", lambda t: f"{t.kernel_gb_s:.3g}"),
        ("kernel, % of a copy on the device", lambda t: f"{t.percent_of_device_copy:.0f} %"),
        ("whole call, % of numpy.copyto", lambda t: f"{t.percent_of_copyto:.0f} %"),
        ("best of NumPy's three idioms, ms", lambda t: f"{t.numpy_ms:.3g}"),
        ("whole call, times as fast as NumPy", lambda t: f"{t.times_numpy:.2f}"),
    ]
    width = max(len(name) for name, _ in rows)
    columns = [[text(timing) for _, text in rows] for timing in timings]
    widths = [max(map(len, column)) for column in columns]
    lines.append("")
    for place, (name, _) in enumerate(rows):
        cells = [column[place].rjust(cell_width) for column, cell_width in zip(columns, widths, strict=True)]
        lines.append("   ".join([name.ljust(width), *cells]))
    return "\n".join(lines) + "\n"


def _kernels(
    device: Device, plan: DispatchPlan, points: npt.NDArray[Any], matrix: npt.NDArray[np.float64]
) -> tuple[float, float]:
    """Return the median seconds of the transform's kernel and of one that only copies, in turn."""
    with device.lock:
        source = device.pool.scratch("bench", "source", plan.chunk * plan.point_bytes)
        destination = device.pool.scratch("bench", "destination", plan.chunk * plan.point_bytes)
        source.upload(points)
        (transforms,) = transform_pass.upload_transforms(plan, matrix[None], len(points))
        n_workgroups = plan.n_workgroups(len(points))
        stages = [
            (plan.pipeline("transform_points", finish=Finish.AS_IT_IS, n_rows=1), (transforms, source, destination)),
            (plan.pipeline("copy_points"), (source, destination)),
        ]
        rounds = [[time_kernel(device, *stage, n_workgroups) for stage in stages] for _ in range(ROUNDS + 1)]
    kernel, copy = (statistics.median(column) for column in zip(*rounds[1:], strict=True))
    return kernel, copy


def _numpy_idioms(
    points: npt.NDArray[Any], matrix: npt.NDArray[np.float64], out: npt.NDArray[Any]
) -> dict[str, Callable[[], object]]:
    linear, offset = np.ascontiguousarray(matrix[:3, :3].T, points.dtype), matrix[:3, 3].astype(points.dtype)
    return {
        "NumPy": lambda: points @ linear + offset,
        "NumPy out=": lambda: np.add(np.matmul(points, linear, out=out), offset, out=out),
        "NumPy einsum": lambda: np.einsum("ni,ij->nj", points, linear) + offset,
    }


def _medians(contenders: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the median seconds of each, measured in turn after a round that does not count."""
    seconds: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(ROUNDS + 1):
        for name, run in contenders.items():
            start = time.perf_counter()
            run()
            seconds[name].append(time.perf_counter() - start)
    return {name: statistics.median(values[1:]) for name, values in seconds.items()}
