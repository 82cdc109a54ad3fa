"""Device memory, and the way in and out of it for NumPy arrays.

Where the host can map the device's own memory (CPU adapters), an array is copied once each way; elsewhere the queue
stages it.
"""

import contextlib
import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import wgpu

from .._core.interrupts import uninterrupted
from ..errors import DeviceError
from .errors import device_errors

if TYPE_CHECKING:
    from .device import Device

Usage = wgpu.BufferUsage
STORAGE = Usage.STORAGE | Usage.COPY_SRC | Usage.COPY_DST
UNIFORM = Usage.UNIFORM | Usage.COPY_DST
READBACK = Usage.MAP_READ | Usage.COPY_DST
MAPPED = Usage.MAP_READ | Usage.MAP_WRITE

_numbers = itertools.count()  # no two buffers of a process have the same

QUEUED_BYTES = 1 << 18  # up to here the queue's own copy costs less than mapping and unmapping


class Buffer:
    """`n_bytes` of device memory (a multiple of 4), for storage unless `usage` says otherwise.

    stays : it is used again and again, and released in the end: what binds it is kept meanwhile
    """

    def __init__(self, device: "Device", n_bytes: int, usage: int = STORAGE, *, stays: bool = False) -> None:
        device.require_usable()
        self.device = device
        self.n_bytes = n_bytes
        self.number = next(_numbers)
        self.stays = stays
        self.holds: bytes | None = None  # where whoever fills it leaves word, so as not to do it again
        self._host_mappable = bool(usage & Usage.STORAGE) and device.host_mappable
        if self._host_mappable:
            usage |= MAPPED
        with uninterrupted(), device_errors(f"allocate {n_bytes:,} bytes"):
            self.handle: wgpu.GPUBuffer = device.handle.create_buffer(size=n_bytes, usage=usage)
        self._released = False
        self._has_arrived = False

    def upload(self, array: npt.NDArray[Any]) -> None:
        """Copy `array` (C-ordered) to the buffer's start."""
        with self.device.lock, device_errors(f"upload {array.nbytes:,} bytes"):
            self.require_submittable(self.device)
            if self._host_mappable and array.nbytes > QUEUED_BYTES:
                self.handle.map_sync(wgpu.MapMode.WRITE, 0, array.nbytes)
                try:
                    self.handle.write_mapped(array)
                finally:
                    self.handle.unmap()
            else:
                self.device.handle.queue.write_buffer(self.handle, 0, array)

    def arrive(self, n_bytes: int) -> None:
        """Wait until the device is done with the first `n_bytes`; `downloaded` then lends them without waiting.

        Only where the host can map the buffer. Till it has been downloaded, no submission may use it.
        """
        if self._has_arrived:
            return
        with self.device.lock, uninterrupted(), device_errors(f"read {n_bytes:,} bytes back"):
            self.require_submittable(self.device)
            self.handle.map_sync(wgpu.MapMode.READ, 0, n_bytes)
            self._has_arrived = True

    def forget(self) -> None:
        """Let submissions use it again where it has arrived and will not be downloaded."""
        with self.device.lock:
            if self._has_arrived:
                self._has_arrived = False
                self.handle.unmap()

    @contextlib.contextmanager
    def downloaded(self, n_bytes: int) -> Iterator[npt.NDArray[np.uint8]]:
        """Lend the first `n_bytes` as an array, valid inside the block only."""
        with self.device.lock:
            if self.can_map:
                with self._mapped(n_bytes) as view:
                    yield view
            else:
                staging = Buffer(self.device, n_bytes, READBACK)
                try:
                    with self.device.recording(self, staging) as encoder:
                        encoder.copy_buffer_to_buffer(self.handle, 0, staging.handle, 0, n_bytes)
                    with staging._mapped(n_bytes) as view:
                        yield view
                finally:
                    staging.release()

    @contextlib.contextmanager
    def _mapped(self, n_bytes: int) -> Iterator[npt.NDArray[np.uint8]]:
        self.device.require_usable()
        self.arrive(n_bytes)
        self._has_arrived = False
        try:
            yield np.frombuffer(self.handle.read_mapped(0, n_bytes, copy=False), np.uint8)
        finally:
            self.handle.unmap()

    @property
    def can_map(self) -> bool:
        """Whether the host can read it where it lies."""
        return self._host_mappable or bool(self.handle.usage & Usage.MAP_READ)

    def require_submittable(self, device: "Device") -> None:
        """Raise `DeviceError` where a submission that uses this buffer on `device` would abort the process."""
        device.require_usable()
        if self.device is not device:
            raise DeviceError(f"a buffer of {self.device!r} cannot be used on {device!r}")
        if self._released:
            raise DeviceError("the buffer has been released")
        if self.handle.map_state != "unmapped":
            raise DeviceError("the buffer is mapped by the host: finish reading it first")

    def release(self) -> None:
        """Give the memory back; releasing twice does nothing."""
        if not self._released:
            self._released = True
            self.handle.destroy()
