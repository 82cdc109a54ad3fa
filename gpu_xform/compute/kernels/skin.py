"""Skinning: each point through a matrix of its own, which an index names, or through a weighted sum of several."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from ...gpu import layouts
from ...gpu.chunking import MAX_PART_BYTES, DispatchPlan, run_in_chunks
from ...gpu.device import GpuDevice, require_gpu_device
from ...gpu.dispatch import dispatch
from .job import SkinningJob
from .transform import POOL_OWNER, upload_transforms


def run_skinning(job: SkinningJob) -> None:
    """Write each point through its matrices into `job.out`; there are no more matrices than one binding holds."""
    device = require_gpu_device(job.device)
    with device.lock:
        run_in_chunks(device, MAX_PART_BYTES, partial(_run_chunks, device, job))


def _run_chunks(device: GpuDevice, job: SkinningJob, done: int, max_bytes: int) -> Iterator[int]:
    """Write the points from `done` on, and yield after each chunk how many are written."""
    indices, weights = job.influences
    n_points, n_components = job.points.shape
    n_influences, dtype, pool = indices.shape[1], job.dtype, device.pool
    plan = DispatchPlan.of(
        device,
        n_points,
        n_components,
        dtype,
        points_per_invocation=1,
        max_components=n_influences,
        max_bytes=max_bytes,
    )
    pipeline = plan.pipeline(
        "skin_points",
        epilogue=job.epilogue,
        n_influences=n_influences,
        is_weighted=weights is not None,
        is_inverse_transposed=job.inverse_transpose,
    )
    weight_bytes = 16 if weights is None else plan.chunk * n_influences * dtype.itemsize
    buffers = {
        "source": pool.scratch(POOL_OWNER, "source", plan.chunk * plan.point_bytes),
        "destination": pool.scratch(POOL_OWNER, "destination", plan.chunk * plan.point_bytes),
        "indices": pool.scratch(POOL_OWNER, "indices", plan.chunk * n_influences * 4),
        "weights": pool.scratch(POOL_OWNER, "weights", weight_bytes),
        "matrices": pool.scratch(POOL_OWNER, "matrices", len(job.matrices) * 16 * dtype.itemsize),
    }
    buffers["matrices"].upload(layouts.pack_matrices(job.matrices, dtype))
    for part in plan.chunks(n_points, done):
        n_part = part.stop - part.start
        buffers["source"].upload(np.ascontiguousarray(job.points[part], dtype))
        buffers["indices"].upload(np.ascontiguousarray(indices[part], np.uint32))
        if weights is not None:
            buffers["weights"].upload(np.ascontiguousarray(weights[part], dtype))
        (transforms,) = upload_transforms(plan, np.eye(4)[None], n_part)
        with device.encode_commands(transforms.buffer, *buffers.values(), label="skin points") as encoder:
            bindings = device.bind_groups.bind(pipeline, transforms=transforms, **buffers)
            dispatch(encoder, pipeline, bindings, -(-n_part // plan.workgroup_size))
        with buffers["destination"].map_read(n_part * plan.point_bytes) as view:
            job.out[part] = view.view(dtype).reshape(n_part, n_components)
        yield part.stop
