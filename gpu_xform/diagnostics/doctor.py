"""Examination of this machine: its adapters, the one in use and why, and whether its results are right."""

import os
import platform
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from typing import Literal

import numpy as np

from ..compute.transform import transform_points
from ..device import ADAPTER_VARIABLE, HOST, Adapter, Device
from ..drawing.camera import Camera
from ..errors import GpuXformError, NoAdapterError
from ..geometry.mesh import Mesh
from ..gpu import self_test
from ..gpu.adapters import adapters, describe_adapter, find_adapter
from ..gpu.device import GpuDevice
from ..host import HostDevice
from ..raster.names import RASTERIZERS, RasterizerName
from ..rendering.raster import render_array
from .doctor_report import Check, Report

RENDER_CHECK = "picture (render)"
N_POINTS = 20_000  # enough for the host to compile its loops
# Fifteen different entries, and a translation much larger than the rotation: a transposed or shifted matrix must fail.
MATRIX = np.array([[0.5, -1.25, 2.0, 30.0], [1.5, 0.75, -0.25, -7.0], [-3.0, 0.125, 1.0, 11.0], [0.0, 0.0, 0.0, 1.0]])


def examine(adapter: str | None = None) -> Report:
    """Check the device that `Device(adapter)` opens; failures are in the report, not raised.

    adapter : "host", or part of an adapter's name; by default GPU_XFORM_ADAPTER, else the fastest
    """
    found = tuple(adapters())
    device: Adapter | None = None
    checks: tuple[Check, ...] = ()
    try:
        name = adapter or os.environ.get(ADAPTER_VARIABLE) or None
        is_host = name is not None and name.casefold() == HOST
        device = HostDevice().adapter if is_host else describe_adapter(find_adapter(name))
        reason = _explain_choice(adapter, len(found))
        checks = _run_checks(adapter)
    except NoAdapterError as error:
        reason = str(error)
    drawn = next((check for check in checks if check.name == RENDER_CHECK), None)
    render_passes = tuple(
        _describe_render_pass(drawn if drawn and each == device else _try_render_pass(each)) for each in found
    )
    return Report(_find_versions(), found, device, reason, checks, render_passes)


def _try_render_pass(adapter: Adapter) -> Check:
    """Draw by a render pass on an adapter that is not in use."""

    def attempt() -> tuple[bool, str]:
        with GpuDevice(adapter.name) as device:
            return _check_picture(device, "render")

    return _run_check(RENDER_CHECK, attempt)


def _describe_render_pass(check: Check) -> str:
    return f"render pass: {'ok' if check.passed else 'WRONG'}, {' '.join(check.detail.split())}"


def _find_versions() -> dict[str, str]:
    return {
        "gpu_xform": version("gpu_xform"),
        "wgpu": version("wgpu"),
        "numpy": np.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
    }


def _explain_choice(adapter: str | None, n_adapters: int) -> str:
    if adapter:
        return f"{adapter!r} is requested"
    if os.environ.get(ADAPTER_VARIABLE):
        return f"{ADAPTER_VARIABLE} is {os.environ[ADAPTER_VARIABLE]!r}"
    return (
        "it is the only one"
        if n_adapters == 1
        else f"it is the fastest kind of {n_adapters}; GPU_XFORM_ADAPTER can name another"
    )


def _run_checks(adapter: str | None) -> tuple[Check, ...]:
    try:
        device = Device(adapter)
    except NoAdapterError:
        raise
    except GpuXformError as error:
        return (Check("open the device", False, str(error)),)
    with device:
        checks = []
        if isinstance(device, GpuDevice):
            checks += [Check(*result) for result in self_test.run(device.context, device.pipelines)]
        checks.append(_run_check("float32 transform", lambda: _check_transform(device, "float32")))
        if device.has_float64:
            checks.append(_run_check("float64 transform", lambda: _check_transform(device, "float64")))
        if isinstance(device, GpuDevice):
            checks += [
                _run_check(f"picture ({rasterizer})", partial(_check_picture, device, rasterizer))
                for rasterizer in RASTERIZERS[1:]
            ]
    return tuple(checks)


def _run_check(name: str, attempt: Callable[[], tuple[bool, str]]) -> Check:
    try:
        return Check(name, *attempt())
    except GpuXformError as error:
        return Check(name, False, str(error))


def _check_transform(device: Device, dtype: Literal["float32", "float64"]) -> tuple[bool, str]:
    """Compare a transform with NumPy's in float64, within the accuracy contract of the library."""
    points = np.random.default_rng(0).uniform(-100.0, 100.0, (N_POINTS, 3)).astype(dtype)
    result = np.full_like(points, np.nan)
    transform_points(points, MATRIX, precision=dtype, out=result, device=device)
    homogeneous = np.column_stack([points.astype(np.float64), np.ones(N_POINTS)])
    error = np.abs(result - (homogeneous @ MATRIX.T)[:, :3])
    rounding = float(np.finfo(dtype).eps) / 2.0
    allowed = 5.0 * rounding * (np.abs(homogeneous) @ np.abs(MATRIX).T)[:, :3]
    n_wrong = int((~(error <= allowed)).any(axis=1).sum())
    return n_wrong == 0, f"{N_POINTS - n_wrong:,} of {N_POINTS:,} points agree with NumPy's"


def _check_picture(device: GpuDevice, rasterizer: RasterizerName) -> tuple[bool, str]:
    """Draw a line two pixels wide, left of and above the centre, and test the pixels on it and away from it."""
    line = Mesh([(-0.75, 0.5, 0.0), (0.25, 0.5, 0.0)], [(0, 1)])
    pixels = render_array(
        line,
        size=(32, 32),
        camera=Camera.window((-1.0, 1.0), (-1.0, 1.0)),
        background="black",
        device=device,
        rasterizer=rasterizer,
        color="white",
        line_width=2.0,
    )
    on_line = np.zeros((32, 32), bool)
    on_line[7:9, 4:20] = True
    near_line = np.zeros((32, 32), bool)
    near_line[5:11, 2:22] = True
    n_lit = int((pixels[on_line] == 255).all(axis=1).sum())
    n_unlit = int((pixels[~near_line] == (0, 0, 0, 255)).all(axis=1).sum())
    n_on_line, n_away = int(on_line.sum()), int((~near_line).sum())
    passed = n_lit == n_on_line and n_unlit == n_away
    return passed, f"{n_lit} of {n_on_line} pixels lit, {n_unlit} of {n_away} unlit"
