"""A report on this machine: its adapters, the one in use and why, and whether its results are right."""

import dataclasses
import json
import os
import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from ..compute.kernels import transform as transform_pass
from ..drawing.draw_list import Drawable, DrawList, Lines
from ..drawing.view import View
from ..errors import GpuXformError, NoAdapterError
from ..gpu import chunking as plans
from ..gpu import self_test
from ..gpu.adapters import Adapter, adapters, describe_adapter, find_adapter
from ..gpu.buffers import Buffer
from ..gpu.context import HOST_MAPPABLE_KINDS
from ..gpu.device import Device
from ..gpu.device_points import DevicePoints
from ..raster.choose import rasterizer_for

N_POINTS = 1_000
# Fifteen different entries and translation far from the rotation's size: a transposed or shifted matrix must fail.
MATRIX = np.array([[0.5, -1.25, 2.0, 30.0], [1.5, 0.75, -0.25, -7.0], [-3.0, 0.125, 1.0, 11.0], [0.0, 0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Check:
    """One thing tried on the device: whether it came out right, and what was seen."""

    name: str
    passed: bool
    detail: str


@dataclass(frozen=True)
class Report:
    """What `examine` found."""

    versions: dict[str, str]
    adapters: tuple[Adapter, ...]
    device: Adapter | None
    """The adapter in use, or None where there is none."""
    reason: str
    """Why that adapter, or why none."""
    checks: tuple[Check, ...]

    @property
    def passed(self) -> bool:
        """Whether there is a device and every check came out right."""
        return self.device is not None and bool(self.checks) and all(check.passed for check in self.checks)

    def text(self) -> str:
        """Return the report for people to read."""
        return "\n".join([*_versions(self), "", *_adapters(self), "", *_device(self), *_checks(self)]) + "\n"

    def json(self) -> str:
        """Return the report as a JSON object, with `passed` beside the fields."""
        fields = dataclasses.asdict(self) | {"passed": self.passed}
        return json.dumps(fields, indent=2, default=sorted) + "\n"


def examine(adapter: str | None = None) -> Report:
    """Try the device that `Device(adapter)` opens; what goes wrong is in the report, not raised.

    adapter : part of an adapter's name; by default GPU_XFORM_ADAPTER, else the fastest
    """
    found = tuple(adapters())
    device: Adapter | None = None
    checks: tuple[Check, ...] = ()
    try:
        device = describe_adapter(find_adapter(adapter or os.environ.get("GPU_XFORM_ADAPTER") or None))
        reason = _reason(adapter, len(found))
        checks = _tried(adapter)
    except NoAdapterError as error:
        reason = str(error)
    return Report(_installed(), found, device, reason, checks)


def _installed() -> dict[str, str]:
    return {
        "gpu_xform": version("gpu_xform"),
        "wgpu": version("wgpu"),
        "numpy": np.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
    }


def _reason(adapter: str | None, n_adapters: int) -> str:
    if adapter:
        return f"{adapter!r} is asked for"
    if os.environ.get("GPU_XFORM_ADAPTER"):
        return f"GPU_XFORM_ADAPTER is {os.environ['GPU_XFORM_ADAPTER']!r}"
    return (
        "it is the only one"
        if n_adapters == 1
        else f"it is the fastest kind of {n_adapters}; GPU_XFORM_ADAPTER can name another"
    )


def _tried(adapter: str | None) -> tuple[Check, ...]:
    try:
        device = Device(adapter)
    except NoAdapterError:
        raise
    except GpuXformError as error:
        return (Check("open the device", False, str(error)),)
    with device:
        checks = [Check(*result) for result in self_test.run(device.context, device.pipelines)]
        checks.append(_check("float32 transform", lambda: _transform(device, np.dtype(np.float32))))
        if device.has_float64:
            checks.append(_check("float64 transform", lambda: _transform(device, np.dtype(np.float64))))
        checks.append(_check("picture", lambda: _picture(device)))
    return tuple(checks)


def _check(name: str, attempt: Callable[[], tuple[bool, str]]) -> Check:
    try:
        return Check(name, *attempt())
    except GpuXformError as error:
        return Check(name, False, str(error))


def _transform(device: Device, dtype: np.dtype[Any]) -> tuple[bool, str]:
    """Compare a transform with NumPy's in float64, to within the library's accuracy contract."""
    points = np.random.default_rng(0).uniform(-100.0, 100.0, (N_POINTS, 3)).astype(dtype)
    result = np.full_like(points, np.nan)
    transform_pass.transform(device, points, MATRIX[None], result[None], dtype, transform_pass.Finish.AS_IT_IS)
    homogeneous = np.column_stack([points.astype(np.float64), np.ones(N_POINTS)])
    error = np.abs(result - (homogeneous @ MATRIX.T)[:, :3])
    rounding = float(np.finfo(dtype).eps) / 2.0
    allowed = 5.0 * rounding * (np.abs(homogeneous) @ np.abs(MATRIX).T)[:, :3]
    n_wrong = int((~(error <= allowed)).any(axis=1).sum())
    return n_wrong == 0, f"{N_POINTS - n_wrong:,} of {N_POINTS:,} points agree with NumPy's"


def _picture(device: Device) -> tuple[bool, str]:
    """Draw a line two pixels wide, left of and above the middle, and look at the pixels on it and away from it."""
    ends = np.array([(-0.75, 0.5, 0.5), (0.25, 0.5, 0.5)], np.float32)
    buffer = Buffer(device.context, plans.align_points(len(ends)) * 12, label="doctor: points")
    edges = Buffer(device.context, 8, label="doctor: edges")
    try:
        buffer.upload(ends)
        edges.upload(np.array([0, 1], np.uint32))
        lines = Lines(edges, 1, line_width=2.0, color=(1.0, 1.0, 1.0, 1.0))
        drawable = Drawable(DevicePoints(buffer, len(ends), ends.dtype), np.eye(4)[None], None, (lines,))
        draw_list = DrawList([drawable], [0], np.empty(0, np.uint32))
        view = View((32, 32), np.eye(4))
        pixels = rasterizer_for(device).draw(draw_list, view, (0.0, 0.0, 0.0, 1.0)).result()
    finally:
        buffer.release()
        edges.release()
    on_line = np.zeros((32, 32), bool)
    on_line[7:9, 4:20] = True
    near_line = np.zeros((32, 32), bool)
    near_line[5:11, 2:22] = True
    lit = int((pixels[on_line] == 255).all(axis=1).sum())
    unlit = int((pixels[~near_line] == (0, 0, 0, 255)).all(axis=1).sum())
    n_lit, n_unlit = int(on_line.sum()), int((~near_line).sum())
    passed = lit == n_lit and unlit == n_unlit
    return passed, f"{lit} of {n_lit} pixels lit, {unlit} of {n_unlit} unlit"


def _versions(report: Report) -> list[str]:
    return [f"{name:10} {value}" for name, value in report.versions.items()]


def _adapters(report: Report) -> list[str]:
    if not report.adapters:
        return ["No adapters."]
    lines = [f"Adapters ({len(report.adapters)}):"]
    for adapter in report.adapters:
        lines += [f"  {adapter.name}", f"    {adapter.kind}, {adapter.backend}, {adapter.driver}"]
    return lines


def _device(report: Report) -> list[str]:
    device = report.device
    if device is None:
        return [f"No device: {report.reason}"]
    limits = device.limits
    mappable = device.kind in HOST_MAPPABLE_KINDS and "mappable-primary-buffers" in device.features
    rows = {
        "chosen because": report.reason,
        "largest buffer": _human_bytes(limits.max_buffer_bytes),
        "largest binding": _human_bytes(limits.max_binding_bytes),
        "workgroups": f"{limits.max_workgroups:,} a dimension, of up to {limits.max_workgroup_size:,} invocations",
        "float64": _yes("shader-f64" in device.features),
        "memory that the host maps": _yes(mappable),
        "timestamps": _yes("timestamp-query" in device.features),
    }
    lines = [f"In use: {device.name}", *(f"  {name:26} {value}" for name, value in rows.items())]
    if device.kind == "CPU":
        lines += ["", "This device is a CPU, not a GPU: its results are right, at a CPU's speed."]
    return [*lines, ""]


def _checks(report: Report) -> list[str]:
    if report.device is None:
        return []
    rows = [
        f"  {'ok' if check.passed else 'WRONG':6} {check.name:17} {' '.join(check.detail.split())}"
        for check in report.checks
    ]
    return ["Checks:", *rows, "", "Everything works." if report.passed else "This device cannot be relied on."]


def _yes(has: bool) -> str:
    return "yes" if has else "no"


def _human_bytes(n_bytes: int) -> str:
    """Return a size in the largest binary unit that leaves at least 1, to a tenth."""
    size, unit = float(n_bytes), "bytes"
    for larger in ("KiB", "MiB", "GiB", "TiB", "PiB", "EiB"):
        if size < 1023.95:
            break
        size, unit = size / 1024.0, larger
    return f"{size:.1f}".removesuffix(".0") + f" {unit}"
