"""An array of points through one matrix, in chunks that the device can hold."""

from typing import Any

import numpy as np
import numpy.typing as npt

from . import layouts
from .buffers import UNIFORM
from .compute import bind, dispatch
from .device import Device

POINTS_PER_INVOCATION = 4
WORKGROUP_SIZE = 256  # 64 takes half as long again on lavapipe
CHUNK_BYTES = 128 << 20


def transform(
    device: Device, points: npt.NDArray[Any], matrix: npt.NDArray[np.float64], out: npt.NDArray[Any], *, divide: bool
) -> None:
    """Write `matrix` applied to `points` into `out`, divided by w where `divide` says so.

    points, out : (n, 2) or (n, 3), n > 0; the computation is in the dtype of `out`
    matrix : (4, 4); for points of R^2 with an idle z
    """
    n_points, n_components = points.shape
    dtype = out.dtype.newbyteorder("=")
    point_bytes = n_components * dtype.itemsize
    chunk = min(chunk_points(device, point_bytes), rounded_up(n_points))
    stage = f"transform_points{'_2d' if n_components == 2 else ''}_{'f64' if dtype == np.float64 else 'f32'}"
    pipeline = device.pipelines.compute(stage, workgroup_size=workgroup_size(device), divide_by_w=divide)
    with device.lock:
        struct = device.pool.get("transform", 160, UNIFORM)
        source = device.pool.get("source", chunk * point_bytes)
        destination = device.pool.get("destination", chunk * point_bytes)
        bindings = bind(device, pipeline, (struct, source, destination))
        for start in range(0, n_points, chunk):
            part = np.ascontiguousarray(points[start : start + chunk], dtype)
            n_quads = rounded_up(len(part)) // POINTS_PER_INVOCATION
            struct.upload(layouts.transform_struct(matrix, dtype, n_quads))
            source.upload(part)
            with device.recording(struct, source, destination) as encoder:
                dispatch(encoder, pipeline, bindings, -(-n_quads // workgroup_size(device)))
            with destination.downloaded(part.nbytes) as view:
                out[start : start + chunk] = view.view(dtype).reshape(part.shape)


def workgroup_size(device: Device) -> int:
    """Return how many invocations make a workgroup."""
    return min(WORKGROUP_SIZE, device.limits.max_workgroup_size)


def chunk_points(device: Device, point_bytes: int) -> int:
    """Return how many points one dispatch takes, a multiple of `POINTS_PER_INVOCATION`."""
    limits = device.limits
    n_bytes = min(limits.max_binding_bytes, limits.max_buffer_bytes, CHUNK_BYTES)
    n_quads = min(n_bytes // (POINTS_PER_INVOCATION * point_bytes), limits.max_workgroups * workgroup_size(device))
    return max(n_quads, 1) * POINTS_PER_INVOCATION


def rounded_up(n_points: int) -> int:
    """Return `n_points` rounded up to whole invocations."""
    return -(-n_points // POINTS_PER_INVOCATION) * POINTS_PER_INVOCATION
