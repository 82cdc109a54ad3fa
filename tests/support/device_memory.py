"""What buffers of a device hold."""

import numpy as np

from gpu_xform.gpu.buffers import Buffer


def read_uint32(buffer: Buffer, n_bytes: int) -> np.ndarray[tuple[int], np.dtype[np.uint32]]:
    """Return a copy of the first `n_bytes`."""
    with buffer.map_read(n_bytes) as view:
        return view.view(np.uint32).copy()
