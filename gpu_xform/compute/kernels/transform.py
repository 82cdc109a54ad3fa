"""Each matrix applied to all points, in chunks that the device can hold."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.memmap import release_pages
from ..._core.types import Float64Array
from ...gpu import layouts, uniforms
from ...gpu.buffers import READBACK, Buffer
from ...gpu.chunking import POINTS_PER_INVOCATION, DispatchPlan, run_in_chunks
from ...gpu.device import GpuDevice, require_gpu_device
from ...gpu.dispatch import Binding, dispatch
from .job import Epilogue, Job

POOL_OWNER = "compute"  # the kernels run one at a time and share their buffers
MATRICES_PER_DISPATCH = 8  # the length of the WGSL array

MAX_BATCH_BYTES = 64 << 20  # of the results of several matrices that are read back at once
MAX_STAGED_BYTES = 16 << 20  # of a chunk that crosses a bus and comes back, one of two under way
# On a CPU a chunk should still be in its caches when it is copied back: of a million points to ten, 12 to 24 MiB take
# least, 5 to 6 ns per point, and smaller ones lose a fifth to the calls.
MAX_CACHED_BYTES = 16 << 20


def run_transform(job: Job) -> None:
    """Write each matrix applied to all points into `job.out`, which may share memory with the points if k is 1."""
    device = require_gpu_device(job.device)
    if len(job.matrices) == 1:
        _run_one_matrix(device, job)
        return
    with device.lock:
        run_in_chunks(device, MAX_BATCH_BYTES, partial(_run_several_matrices, device, job))


def _plan(device: GpuDevice, job: Job, max_bytes: int) -> DispatchPlan:
    return DispatchPlan.of(device, len(job.points), job.points.shape[1], job.dtype, max_bytes=max_bytes)


def _run_several_matrices(device: GpuDevice, job: Job, done: int, max_bytes: int) -> Iterator[int]:
    plan = _plan(device, job, max_bytes)
    step = min(max_matrices(plan, min(max_bytes, MAX_BATCH_BYTES)), len(job.matrices))
    source = device.pool.scratch(POOL_OWNER, "source", plan.chunk * plan.point_bytes)
    destination = device.pool.scratch(POOL_OWNER, "destination", step * plan.chunk * plan.point_bytes)
    for part in plan.chunks(len(job.points), done):
        upload_part(plan, source, job.points, part)
        for first in range(0, len(job.matrices), step):
            several = job.matrices[first : first + step]
            dispatch_transform(plan, several, source, destination, part.stop - part.start, job.epilogue)
            read_results(plan, destination, job.out[first : first + step, part])
        yield part.stop


def _run_one_matrix(device: GpuDevice, job: Job) -> None:
    is_mapped = device.host_mappable
    run = run_mapped if is_mapped else run_double_buffered
    with device.lock:
        run_in_chunks(
            device,
            MAX_CACHED_BYTES if is_mapped else MAX_STAGED_BYTES,
            lambda done, max_bytes: run(_plan(device, job, max_bytes), job, done),
        )


def run_mapped(plan: DispatchPlan, job: Job, done: int = 0) -> Iterator[int]:
    """Apply one matrix in memory that the host maps: a chunk in, through the shader and out, while it is cached.

    Yields after each chunk how many points are done.
    """
    buffer = plan.device.pool.scratch(POOL_OWNER, "source", plan.chunk * plan.point_bytes)
    matrix, out = job.matrices[0], job.out[0]
    for part in plan.chunks(len(job.points), done):
        upload_part(plan, buffer, job.points, part)
        dispatch_transform_in_place(plan, matrix, buffer, part.stop - part.start, job.epilogue)
        read_results(plan, buffer, out[None, part])
        release_pages(out[part])
        yield part.stop


def run_double_buffered(plan: DispatchPlan, job: Job, done: int = 0) -> Iterator[int]:
    """Apply one matrix over a bus, with two chunks under way: while the device has one, the host reads the other.

    Yields after each chunk how many points are done.
    """
    pool, n_bytes = plan.device.pool, plan.chunk * plan.point_bytes
    parts = list(plan.chunks(len(job.points), done))
    turns = range(min(2, len(parts)))
    buffers = [pool.scratch(POOL_OWNER, f"source {turn}", n_bytes) for turn in turns]
    readbacks = [pool.scratch(POOL_OWNER, f"readback {turn}", n_bytes, READBACK) for turn in turns]
    matrix, out = job.matrices[0], job.out[0]

    def read_part(k: int) -> None:
        read_results(plan, readbacks[k % 2], out[None, parts[k]])
        release_pages(out[parts[k]])

    for k, part in enumerate(parts):
        buffer, readback = buffers[k % 2], readbacks[k % 2]
        upload_part(plan, buffer, job.points, part)
        dispatch_transform_in_place(plan, matrix, buffer, part.stop - part.start, job.epilogue, readback=readback)
        if k > 0:
            read_part(k - 1)
            yield parts[k - 1].stop
    read_part(len(parts) - 1)
    yield parts[-1].stop


def upload_part(plan: DispatchPlan, source: Buffer, points: npt.NDArray[Any], part: slice) -> None:
    """Copy a part of `points` to the start of `source`."""
    source.upload(np.ascontiguousarray(points[part], plan.dtype))
    release_pages(points[part])


def max_matrices(plan: DispatchPlan, max_bytes: int = MAX_BATCH_BYTES) -> int:
    """Return how many matrices are applied at once: what a batch of results holds, in whole dispatches."""
    n_bytes = min(plan.device.limits.max_bound_bytes, max_bytes)
    n_matrices = n_bytes // (plan.chunk * plan.point_bytes)
    if n_matrices > MATRICES_PER_DISPATCH:
        n_matrices -= n_matrices % MATRICES_PER_DISPATCH
    return max(1, n_matrices)


def dispatch_transform_in_place(
    plan: DispatchPlan,
    matrix: Float64Array,
    points: Buffer,
    n_points: int,
    epilogue: Epilogue,
    *,
    readback: Buffer | None = None,
) -> None:
    """Dispatch `matrix` (4, 4) on the first `n_points` of `points`; copy the results to `readback`, if there is one."""
    pipeline = plan.pipeline("transform_in_place", epilogue=epilogue)
    (transforms,) = upload_transforms(plan, matrix[None], n_points)
    used = [transforms.buffer, points, *([readback] if readback else [])]
    with plan.device.encode_commands(*used, label="transform points in place") as encoder:
        bindings = plan.device.bind_groups.bind(pipeline, transforms=transforms, points=points)
        dispatch(encoder, pipeline, bindings, plan.n_workgroups(n_points))
        if readback:
            encoder.copy_buffer(points, readback, n_points * plan.point_bytes)


def dispatch_transform(
    plan: DispatchPlan,
    matrices: Float64Array,
    source: Buffer,
    destination: Buffer,
    n_points: int,
    epilogue: Epilogue,
) -> None:
    """Dispatch each of `matrices` (k, 4, 4), k > 0, on the first `n_points` of `source`.

    The results follow one another in `destination`, each padded to whole workgroups, as `source` is.
    """
    groups = upload_transforms(plan, matrices, n_points)
    with plan.device.encode_commands(groups[0].buffer, source, destination, label="transform points") as encoder:
        for first, transforms in zip(range(0, len(matrices), MATRICES_PER_DISPATCH), groups, strict=True):
            n_matrices = min(MATRICES_PER_DISPATCH, len(matrices) - first)
            pipeline = plan.pipeline("transform_points", epilogue=epilogue, n_matrices=n_matrices)
            bindings = plan.device.bind_groups.bind(
                pipeline, transforms=transforms, source=source, destination=destination
            )
            dispatch(encoder, pipeline, bindings, plan.n_workgroups(n_points))


def upload_transforms(plan: DispatchPlan, matrices: Float64Array, n_points: int) -> list[Binding]:
    """Upload `Transform` structs of `matrices` (k, 4, 4) as WGSL arrays of `MATRICES_PER_DISPATCH`; return where."""
    n_packets = plan.aligned_count(n_points) // POINTS_PER_INVOCATION
    structs = layouts.pack_transforms(
        matrices, plan.dtype, n_points, first_packets=n_packets * np.arange(len(matrices))
    )
    n_groups = -(-len(matrices) // MATRICES_PER_DISPATCH)
    groups = np.zeros((n_groups * MATRICES_PER_DISPATCH, structs.shape[1]), np.uint8)
    groups[: len(matrices)] = structs
    return uniforms.upload(plan.device, POOL_OWNER, "transforms", list(groups.reshape(n_groups, -1)))


def read_results(plan: DispatchPlan, destination: Buffer, out: npt.NDArray[Any]) -> None:
    """Copy `destination` into `out` (k, n, 2 or 3), without what pads each matrix's results to whole workgroups."""
    n_matrices, n_points, n_components = out.shape
    stride = plan.aligned_count(n_points)
    n_used = (n_matrices - 1) * stride + n_points
    with destination.map_read(n_used * plan.point_bytes) as view:
        flat = view.view(plan.dtype).reshape(n_used, n_components)
        for k in range(n_matrices):
            out[k] = flat[k * stride : k * stride + n_points]
