"""Buffers: device memory, and how NumPy arrays get into it and out of it.

On devices whose memory the host can map (CPU adapters) an array is copied once each way. On others the queue copies it
through memory of its own.
"""

import contextlib
import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.forks import is_fork
from .._core.interrupts import defer_interrupts
from ..errors import DeviceError
from .binding import wgpu
from .context import GpuContext
from .deletion_queue import flush, own

Usage = wgpu.BufferUsage
STORAGE: int = Usage.STORAGE | Usage.COPY_SRC | Usage.COPY_DST
INDIRECT: int = STORAGE | Usage.INDIRECT
UNIFORM: int = Usage.UNIFORM | Usage.COPY_DST
READBACK: int = Usage.MAP_READ | Usage.COPY_DST
MAPPED: int = Usage.MAP_READ | Usage.MAP_WRITE

_ids = itertools.count()  # no two buffers of a process have the same

# wgpu submits an empty command buffer before it maps for reading, which takes 0.1 ms, as writes that nothing has been
# submitted since could be lost (wgpu-native, issue 305). Its own name for doing without:
READ_WITHOUT_SUBMITTING = "READ_NOSYNC"
MAX_QUEUED_BYTES = 1 << 18  # up to here the queue's own copy costs less than mapping and unmapping


class Buffer:
    """`n_bytes` of device memory (a multiple of 4), for storage unless `usage` says otherwise.

    label : what wgpu's messages and the debug tools call it
    persistent : it is used again and again, and released in the end; bind groups of it are kept meanwhile
    """

    def __init__(
        self, context: GpuContext, n_bytes: int, usage: int = STORAGE, *, label: str, persistent: bool = False
    ) -> None:
        context.require_usable()
        self.context = context
        self.n_bytes = n_bytes
        self.usage = usage
        self.label = label
        self.id = next(_ids)
        self.persistent = persistent
        self.content_key: bytes | None = None  # set by whoever fills it, so as not to send the same again
        self._host_mappable = bool(usage & Usage.STORAGE) and context.host_mappable
        if self._host_mappable:
            usage |= MAPPED
        with defer_interrupts(), context.translate_errors(f"allocate {n_bytes:,} bytes", label):
            flush()
            self.handle: wgpu.GPUBuffer = context.handle.create_buffer(label=label, size=n_bytes, usage=usage)
            own(self, self.handle)
        self._released = False
        self._is_mapped = False  # by `wait_mapped`, for whoever reads or unmaps it
        self._is_lent = False  # to a block, which unmaps it
        self._n_submissions_at_write = context.n_submissions

    def upload(self, array: npt.NDArray[Any]) -> None:
        """Copy `array` (C-ordered) to the buffer's start."""
        with self._work(f"upload {array.nbytes:,} bytes"):
            self._begin_write()
            if self._host_mappable and array.nbytes > MAX_QUEUED_BYTES:
                with self._lend(wgpu.MapMode.WRITE, array.nbytes):
                    self.handle.write_mapped(array)
            else:
                self.context.handle.queue.write_buffer(self.handle, 0, array)

    def upload_changed(self, array: npt.NDArray[Any]) -> None:
        """Copy `array` (C-ordered) to the buffer's start, unless it is small and there already, as in an animation."""
        content = array.tobytes() if array.nbytes <= MAX_QUEUED_BYTES else None
        if content is None or content != self.content_key:
            self.upload(array)
            self.content_key = content

    @contextlib.contextmanager
    def map_write(self, n_bytes: int) -> Iterator[npt.NDArray[np.uint8]]:
        """Lend the first `n_bytes` (a multiple of 4) as an array to fill, valid inside the block only.

        What it holds at first is undefined, and so is the buffer if the block raises.
        """
        with self._work(f"upload {n_bytes:,} bytes"):
            self._begin_write()
            if not self._host_mappable:
                staging = np.empty(n_bytes, np.uint8)
                yield staging
                self.context.handle.queue.write_buffer(self.handle, 0, staging)
                return
            with self._lend(wgpu.MapMode.WRITE, n_bytes):
                # wgpu has no other way to lend memory for writing: `write_mapped` copies.
                yield np.frombuffer(self.handle._experimental_get_mapped_range(0, n_bytes), np.uint8)

    def wait_mapped(self, n_bytes: int) -> None:
        """Wait until the device is done with the first `n_bytes`, and map them; `map_read` then lends them at once.

        Only if `can_map`. Until the buffer has been read or unmapped, no submission may use it.
        """
        if self._is_mapped:
            return
        with self._work(f"read {n_bytes:,} bytes back"):
            self.require_submittable(self.context)
            self.handle.map_sync(self._read_mode, 0, n_bytes)
            self._is_mapped = True

    def unmap(self) -> None:
        """Let submissions use a buffer again that `wait_mapped` has mapped and nobody will read."""
        with defer_interrupts(), self.context.lock:
            if not self._is_lent:
                self._end_mapping()

    def lend_shared(self, n_bytes: int, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
        """Wait until the device is done with the first `n_bytes`, and lend them to read and write.

        Only for memory that the host maps. The array is valid until `end_sharing`, which must come before a submission
        uses the buffer; it may stay lent from one to the next: who finds it at rest unmaps it.
        """
        if self.handle.map_state != "mapped":
            self.require_submittable(self.context)
            # What is mapped for writing is the device's own memory, and so holds what the device has written.
            self.handle.map_sync(wgpu.MapMode.WRITE, 0, n_bytes)
        return np.frombuffer(self.handle._experimental_get_mapped_range(0, n_bytes), dtype)

    def end_sharing(self) -> None:
        """Give what `lend_shared` has lent to the device."""
        self.content_key = None
        if self.handle.map_state == "mapped":
            self.handle.unmap()

    @contextlib.contextmanager
    def map_read(self, n_bytes: int) -> Iterator[npt.NDArray[np.uint8]]:
        """Lend the first `n_bytes` as an array, valid inside the block only."""
        with self._work(f"read {n_bytes:,} bytes back"):
            if self.can_map:
                with self._lend_for_reading(n_bytes) as view:
                    yield view
            else:
                staging = Buffer(self.context, n_bytes, READBACK, label="readback")
                try:
                    with self.context.encode_commands(self, staging, label="readback") as encoder:
                        encoder.copy_buffer(self, staging, n_bytes)
                    with staging._lend_for_reading(n_bytes) as view:
                        yield view
                finally:
                    staging.release()

    @contextlib.contextmanager
    def _work(self, action: str) -> Iterator[None]:
        """Hold the device's lock, put Ctrl+C off, and name the buffer in errors of wgpu."""
        # Ctrl+C first: between a lock that is taken and the block that gives it back, nothing may be raised.
        with defer_interrupts(), self.context.lock, self.context.translate_errors(action, self.label):
            yield

    def _begin_write(self) -> None:
        self.require_submittable(self.context)
        self.content_key = None  # whatever is known of the content ends here, even if the rest fails
        self._n_submissions_at_write = self.context.n_submissions

    @property
    def _read_mode(self) -> str | int:
        is_submitted = self.context.n_submissions > self._n_submissions_at_write
        return READ_WITHOUT_SUBMITTING if is_submitted else wgpu.MapMode.READ

    @contextlib.contextmanager
    def _lend_for_reading(self, n_bytes: int) -> Iterator[npt.NDArray[np.uint8]]:
        with self._lend(self._read_mode, n_bytes):
            yield np.frombuffer(self.handle.read_mapped(0, n_bytes, copy=False), np.uint8)

    @contextlib.contextmanager
    def _lend(self, mode: str | int, n_bytes: int) -> Iterator[None]:
        """Map the first `n_bytes` for the block, unless `wait_mapped` has; they are unmapped whatever is raised.

        Two steps end it, so that an exception in one of them leaves what `is_at_rest` can tell and mend.
        """
        self.context.require_usable()
        if not self._is_mapped:
            self.require_submittable(self.context)
        try:
            try:
                self._is_lent = True
                if not self._is_mapped:
                    self.handle.map_sync(mode, 0, n_bytes)
                yield
            finally:
                self._is_lent = False
        finally:
            self._end_mapping()

    def _end_mapping(self) -> None:
        """Unmap the buffer or, where wgpu cannot, throw it away."""
        self._is_mapped = self._is_lent = False
        if self.handle.map_state == "mapped":
            self.handle.unmap()
        elif self.handle.map_state != "unmapped":
            self.release()

    def is_at_rest(self) -> bool:
        """Return whether it can be used, after mending what an exception has left mapped; not if it is being read."""
        if self._released or self._is_lent or self._is_mapped:
            return False
        if self.handle.map_state != "unmapped":
            try:
                self._end_mapping()
            except wgpu.GPUError:  # of a device that is lost
                self.release()
        return not self._released

    @property
    def is_released(self) -> bool:
        """Whether its memory has been given back."""
        return self._released

    @property
    def can_map(self) -> bool:
        """Whether the host can map it."""
        return self._host_mappable or bool(self.handle.usage & Usage.MAP_READ)

    def require_submittable(self, context: GpuContext) -> None:
        """Raise `DeviceError` if a submission on `context` that uses this buffer would abort the process."""
        context.require_usable()
        if self.context is not context:
            raise DeviceError(f"the buffer {self.label!r} of {self.context!r} cannot be used on {context!r}")
        if not self.is_at_rest():
            state = "has been released" if self._released else "is mapped by the host: finish reading it first"
            raise DeviceError(f"the buffer {self.label!r} {state}")

    def release(self) -> None:
        """Give the memory back; releasing twice does nothing."""
        if not self._released:
            self._released = True
            if not is_fork():
                self.handle.destroy()
