"""What buffers of a device hold, and how much they are."""

import numpy as np

from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.context import GpuContext
from gpu_xform.gpu.deletion_queue import list_living


def read_uint32(buffer: Buffer, n_bytes: int) -> np.ndarray[tuple[int], np.dtype[np.uint32]]:
    """Return a copy of the first `n_bytes`."""
    with buffer.map_read(n_bytes) as view:
        return view.view(np.uint32).copy()


def list_buffers(context: GpuContext) -> list[Buffer]:
    """Return the buffers of a context that are alive and not released."""
    return [each for each in list_living(Buffer) if each.context is context and not each.is_released]


def count_bytes(context: GpuContext) -> int:
    """Return how many bytes they are."""
    return sum(buffer.n_bytes for buffer in list_buffers(context))
