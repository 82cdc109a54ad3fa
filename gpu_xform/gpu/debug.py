"""Debug tools: buffers of a device, read back by their labels after all work or after each dispatch of one stage.

>>> from gpu_xform.gpu import debug, device
>>> gpu = device.default_gpu_device()
>>> with debug.capture(gpu, "raster: face depths", after="depth_small_triangles") as depths:
...     gpu_xform.render(mesh, device=gpu, hidden="remove")

What else helps: GPU_XFORM_TRACE=out.json writes a trace (`gpu.trace`), GPU_XFORM_DEBUG=1 dumps the WGSL and
GPU_XFORM_WGSL=folder reloads it (`gpu.shaders`).
"""

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError
from .buffers import READBACK, Buffer
from .context import CommandEncoder, DispatchObserver
from .deletion_queue import list_living
from .device import GpuDevice


def list_buffers(device: GpuDevice) -> dict[str, int]:
    """Return the bytes of every buffer that is alive, by label; of several with one label, those of the newest."""
    return {label: buffer.n_bytes for label, buffer in sorted(_newest(device).items())}


def read_buffer(device: GpuDevice, label: str, dtype: npt.DTypeLike = np.uint8) -> npt.NDArray[Any]:
    """Return what the newest buffer with `label` holds, after all work submitted so far.

    Raises `ArgumentError` if there is no such buffer, with the labels of those there are.
    """
    with device.lock:
        buffer = _find(device, label)
        with buffer.map_read(buffer.n_bytes) as view:
            return view.view(dtype).copy()


@contextlib.contextmanager
def capture(
    device: GpuDevice, label: str, *, after: str, dtype: npt.DTypeLike = np.uint8
) -> Iterator[list[npt.NDArray[Any]]]:
    """Lend a list that receives what a buffer holds after each dispatch of one stage in the block.

    after : the label of the stage's pipeline, as a trace shows it: "skin_points_f32"
    """
    observer = _Capture(device, label, after, np.dtype(dtype))
    with device.lock:
        device.context.observers.append(observer)
    try:
        yield observer.arrays
    finally:
        with device.lock:
            device.context.observers.remove(observer)


class _Capture(DispatchObserver):
    def __init__(self, device: GpuDevice, label: str, stage: str, dtype: np.dtype[Any]) -> None:
        self.arrays: list[npt.NDArray[Any]] = []
        self._device = device
        self._label = label
        self._stage = stage
        self._dtype = dtype
        self._readbacks: list[Buffer] = []

    def end_dispatch(self, encoder: CommandEncoder, label: str) -> None:
        if label == self._stage:
            buffer = _find(self._device, self._label)
            readback = Buffer(self._device.context, buffer.n_bytes, READBACK, label="capture")
            encoder.copy_buffer(buffer, readback, buffer.n_bytes)
            self._readbacks.append(readback)

    def end_submission(self) -> None:
        for readback in self._readbacks:
            with readback.map_read(readback.n_bytes) as view:
                self.arrays.append(view.view(self._dtype).copy())
            readback.release()
        self._readbacks.clear()


def _newest(device: GpuDevice) -> dict[str, Buffer]:
    alive = [each for each in list_living(Buffer) if each.context is device.context and not each.is_released]
    return {buffer.label: buffer for buffer in sorted(alive, key=lambda each: each.id)}


def _find(device: GpuDevice, label: str) -> Buffer:
    buffers = _newest(device)
    if label not in buffers:
        raise ArgumentError(f"label must be that of a buffer, got {label!r}; there are: {', '.join(sorted(buffers))}")
    return buffers[label]
