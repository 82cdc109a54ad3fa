"""Points through matrices, in chunks that the device can hold."""

from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.memmap import release_pages
from ...gpu import layouts
from ...gpu.buffers import READBACK, UNIFORM, Buffer
from ...gpu.chunking import POINTS_PER_INVOCATION, DispatchPlan
from ...gpu.device import Device
from ...gpu.dispatch import Binding, dispatch

POOL_OWNER = "compute"  # the kernels run one at a time and share their buffers
ROWS_AT_ONCE = 8  # matrices that one dispatch applies; the length of the WGSL array
UNIFORM_ALIGNMENT = 256  # of a binding's offset: the most that WebGPU lets an adapter ask for

BATCH_BYTES = 64 << 20  # of the results of several matrices that come back at once
STAGED_BYTES = 16 << 20  # of a chunk that goes there and back over a bus, one of two under way
# On a CPU a chunk should still be in its caches when it is copied back: 8 MiB take a quarter less than all at once, and
# smaller ones lose that to the calls.
CACHED_BYTES = 8 << 20


class Finish(IntEnum):
    """What a stage does with a homogeneous result; the numbers are the WGSL constants."""

    AS_IT_IS = 0
    DIVIDED_BY_W = 1
    NORMALIZED = 2


def transform(
    device: Device,
    points: npt.NDArray[Any],
    matrices: npt.NDArray[np.float64],
    out: npt.NDArray[Any],
    dtype: np.dtype[Any],
    finish: Finish,
) -> None:
    """Write each of `matrices` applied to all of `points` into `out`, computed in `dtype`.

    points : (n, 2) or (n, 3), n > 0
    matrices : (k, 4, 4), k > 0; for points of R^2 with an idle z
    out : (k, n, 2) or (k, n, 3); may share memory with `points` where k is 1
    """
    n_points, n_components = points.shape
    if len(matrices) == 1:
        transform_once(device, points, matrices[0], out[0], dtype, finish)
        return
    plan = DispatchPlan.of(device, n_points, n_components, dtype, most_bytes=BATCH_BYTES)
    rows = min(max_rows(plan, BATCH_BYTES), len(matrices))
    with device.lock:
        source = device.pool.scratch(POOL_OWNER, "source", plan.chunk * plan.point_bytes)
        destination = device.pool.scratch(POOL_OWNER, "destination", rows * plan.chunk * plan.point_bytes)
        for part in plan.chunks(n_points):
            upload_part(plan, source, points, part)
            for first in range(0, len(matrices), rows):
                several = matrices[first : first + rows]
                apply(plan, several, source, destination, part.stop - part.start, finish)
                download_rows(plan, destination, out[first : first + rows, part])


def transform_once(
    device: Device,
    points: npt.NDArray[Any],
    matrix: npt.NDArray[np.float64],
    out: npt.NDArray[Any],
    dtype: np.dtype[Any],
    finish: Finish,
) -> None:
    """Write one `matrix` (4, 4) applied to `points` (n, 2 or 3) into `out`, which may be `points` itself."""
    once, most_bytes = (mapped_once, CACHED_BYTES) if device.host_mappable else (staged_once, STAGED_BYTES)
    plan = DispatchPlan.of(device, len(points), points.shape[1], dtype, most_bytes=most_bytes)
    with device.lock:
        once(plan, points, matrix, out, finish)


def mapped_once(
    plan: DispatchPlan, points: npt.NDArray[Any], matrix: npt.NDArray[np.float64], out: npt.NDArray[Any], finish: Finish
) -> None:
    """Do it where the host maps the device's memory: a chunk in, through the shader and out, while it is cached."""
    buffer = plan.device.pool.scratch(POOL_OWNER, "source", plan.chunk * plan.point_bytes)
    for part in plan.chunks(len(points)):
        upload_part(plan, buffer, points, part)
        apply_in_place(plan, matrix, buffer, part.stop - part.start, finish)
        download_rows(plan, buffer, out[None, part])
        release_pages(out[part])


def staged_once(
    plan: DispatchPlan, points: npt.NDArray[Any], matrix: npt.NDArray[np.float64], out: npt.NDArray[Any], finish: Finish
) -> None:
    """Do it over a bus, with two chunks under way: while the device has one, the host reads the one before it."""
    pool, n_bytes = plan.device.pool, plan.chunk * plan.point_bytes
    parts = list(plan.chunks(len(points)))
    turns = range(min(2, len(parts)))
    buffers = [pool.scratch(POOL_OWNER, f"source {turn}", n_bytes) for turn in turns]
    ways_back = [pool.scratch(POOL_OWNER, f"way back {turn}", n_bytes, READBACK) for turn in turns]

    def collect(k: int) -> None:
        download_rows(plan, ways_back[k % 2], out[None, parts[k]])
        release_pages(out[parts[k]])

    for k, part in enumerate(parts):
        upload_part(plan, buffers[k % 2], points, part)
        apply_in_place(plan, matrix, buffers[k % 2], part.stop - part.start, finish, way_back=ways_back[k % 2])
        if k > 0:
            collect(k - 1)
    collect(len(parts) - 1)


def upload_part(plan: DispatchPlan, source: Buffer, points: npt.NDArray[Any], part: slice) -> None:
    """Copy a part of `points` to the start of `source`."""
    source.upload(np.ascontiguousarray(points[part], plan.dtype))
    release_pages(points[part])


def max_rows(plan: DispatchPlan, most_bytes: int) -> int:
    """Return how many matrices are applied at once: as many results of a chunk as one buffer takes, in whole groups."""
    limits = plan.device.limits
    n_bytes = min(limits.max_bound_bytes, most_bytes)
    rows = n_bytes // (plan.chunk * plan.point_bytes)
    return max(1, rows if rows < ROWS_AT_ONCE else rows - rows % ROWS_AT_ONCE)


def apply_in_place(
    plan: DispatchPlan,
    matrix: npt.NDArray[np.float64],
    points: Buffer,
    n_points: int,
    finish: Finish,
    *,
    way_back: Buffer | None = None,
) -> None:
    """Dispatch `matrix` (4, 4) on the first `n_points` of `points`; copy the result to `way_back`, if there is one."""
    pipeline = plan.pipeline("transform_in_place", epilogue=finish)
    (transforms,) = upload_transforms(plan, matrix[None], n_points)
    used = [transforms.buffer, points, *([way_back] if way_back else [])]
    with plan.device.encode_commands(*used, label="transform points in place") as encoder:
        bindings = plan.device.bind_groups.bind(pipeline, transforms=transforms, points=points)
        dispatch(encoder, pipeline, bindings, plan.n_workgroups(n_points))
        if way_back:
            encoder.copy_buffer(points, way_back, n_points * plan.point_bytes)


def apply(
    plan: DispatchPlan,
    matrices: npt.NDArray[np.float64],
    source: Buffer,
    destination: Buffer,
    n_points: int,
    finish: Finish,
) -> None:
    """Dispatch each of `matrices` (k, 4, 4), k > 0, on the first `n_points` of `source`.

    The results follow one another in `destination`, each padded to whole workgroups, as `source` is.
    """
    groups = upload_transforms(plan, matrices, n_points)
    with plan.device.encode_commands(groups[0].buffer, source, destination, label="transform points") as encoder:
        for first, transforms in zip(range(0, len(matrices), ROWS_AT_ONCE), groups, strict=True):
            n_rows = min(ROWS_AT_ONCE, len(matrices) - first)
            pipeline = plan.pipeline("transform_points", epilogue=finish, n_matrices=n_rows)
            bindings = plan.device.bind_groups.bind(
                pipeline, transforms=transforms, source=source, destination=destination
            )
            dispatch(encoder, pipeline, bindings, plan.n_workgroups(n_points))


def upload_transforms(plan: DispatchPlan, matrices: npt.NDArray[np.float64], n_points: int) -> list[Binding]:
    """Return the WGSL arrays of `Transform` structs for `matrices` (k, 4, 4), each array of `ROWS_AT_ONCE`."""
    n_packets = plan.padded(n_points) // POINTS_PER_INVOCATION
    struct_bytes = layouts.TRANSFORM[plan.dtype].itemsize
    array_bytes = ROWS_AT_ONCE * struct_bytes
    n_groups = -(-len(matrices) // ROWS_AT_ONCE)
    spacing = -(-array_bytes // UNIFORM_ALIGNMENT) * UNIFORM_ALIGNMENT
    structs = np.zeros((n_groups * ROWS_AT_ONCE, struct_bytes), np.uint8)
    structs[: len(matrices)] = layouts.transform_structs(
        matrices, plan.dtype, n_points, first_packets=n_packets * np.arange(len(matrices))
    )
    groups = np.zeros((n_groups, spacing), np.uint8)
    groups[:, :array_bytes] = structs.reshape(n_groups, array_bytes)
    buffer = plan.device.pool.scratch(POOL_OWNER, "transforms", groups.nbytes, UNIFORM)
    buffer.upload(groups)
    return [Binding(buffer, group * spacing, array_bytes) for group in range(n_groups)]


def download_rows(plan: DispatchPlan, destination: Buffer, out: npt.NDArray[Any]) -> None:
    """Copy `destination` into `out` (k, n, 2 or 3), leaving out what pads each row to whole workgroups."""
    n_rows, n_points, n_components = out.shape
    padded = plan.padded(n_points)
    n_used = (n_rows - 1) * padded + n_points
    with destination.map_read(n_used * plan.point_bytes) as view:
        flat = view.view(plan.dtype).reshape(n_used, n_components)
        for row in range(n_rows):
            out[row] = flat[row * padded : row * padded + n_points]
