"""The device context: an opened adapter, its lock, limits and features, and the one place that submits work.

Buffers, caches, shaders and dispatches are made from a context. `Device` puts them together.
"""

import contextlib
import ctypes
import os
import threading
import weakref
from collections.abc import Iterator, Sequence
from typing import Any, Protocol

from .._core.forks import is_fork, note_device, refuse_fork
from .._core.interrupts import defer_interrupts
from ..device import Adapter, Limits
from ..errors import DeviceError
from .adapters import describe_adapter, find_adapter, lend_runtime_dir
from .binding import wgpu
from .deletion_queue import flush
from .errors import DeviceLostError, translate_wgpu_errors

# Memory that the host can map is as good as the device's own on these kinds. On discrete adapters a copy over the bus
# is faster; on integrated ones wgpu makes what the host may write write-combined, from which it reads at a crawl.
HOST_MAPPABLE_KINDS = {"CPU"}
MAPPABLE = "mappable-primary-buffers"
WANTED_FEATURES = frozenset({"shader-f64", "timestamp-query", "float32-blendable", MAPPABLE})
WANTED_LIMITS = (
    "max-buffer-size",
    "max-storage-buffer-binding-size",
    "max-compute-workgroups-per-dimension",
    "max-compute-workgroup-size-x",
    "max-compute-invocations-per-workgroup",
)

_contexts: "weakref.WeakSet[GpuContext]" = weakref.WeakSet()


class Submittable(Protocol):
    """Device memory that a submission can use."""

    @property
    def handle(self) -> Any:
        """The object that wgpu knows it by."""

    @property
    def label(self) -> str:
        """What messages and the debug tools call it."""

    def require_submittable(self, context: "GpuContext") -> None:
        """Raise `DeviceError` if a submission on `context` that uses it would abort the process."""


class DispatchObserver:
    """Looks on while commands are encoded and submitted, for a tool; the methods do nothing unless overridden."""

    def begin_submission(self, label: str) -> None:
        """Begin: no command is encoded yet."""

    def timestamp_writes(self) -> dict[str, object] | None:
        """Return where a pass about to be encoded writes its timestamps, as wgpu takes it; None for nowhere."""
        return None

    def end_dispatch(self, encoder: "CommandEncoder", label: str) -> None:
        """Look on after a dispatch or a render pass; `label` is its pipeline's."""

    def end_encoding(self, encoder: "CommandEncoder") -> None:
        """Look on after the last command; more may be encoded."""

    def end_submission(self) -> None:
        """Look on after the submission."""


class CommandEncoder:
    """The commands of one submission, in the order in which the device runs them."""

    def __init__(self, context: "GpuContext", used: Sequence[Submittable], label: str) -> None:
        self.context = context
        self._used = used
        self._label = label
        self._handle = context.handle.create_command_encoder(label=label)
        self._compute_pass: wgpu.GPUComputePassEncoder | None = None  # of the last dispatch, if nothing came after it
        self._pipeline: wgpu.GPUComputePipeline | None = None  # of that pass at present

    @property
    def handle(self) -> wgpu.GPUCommandEncoder:
        """The encoder that wgpu knows, outside of any compute pass."""
        if self._compute_pass is not None:
            self._compute_pass.end()
            self._compute_pass = None
        return self._handle

    def copy_buffer(
        self, source: Submittable, destination: Submittable, n_bytes: int, *, source_offset_bytes: int = 0
    ) -> None:
        """Copy `n_bytes` of `source` to the start of `destination`."""
        self.handle.copy_buffer_to_buffer(source.handle, source_offset_bytes, destination.handle, 0, n_bytes)

    def clear_buffer(self, buffer: Submittable, n_bytes: int) -> None:
        """Fill the first `n_bytes` of `buffer` with zeros."""
        self.handle.clear_buffer(buffer.handle, 0, n_bytes)

    def copy_buffer_to_texture(
        self, source: Submittable, destination: Submittable, extent: tuple[int, int], row_bytes: int, first_row: int = 0
    ) -> None:
        """Copy rows of `row_bytes` in `source` to `extent` texels of `destination` from its row `first_row` on."""
        width, height = extent
        rows = {"buffer": source.handle, "bytes_per_row": row_bytes, "rows_per_image": height}
        texels = {"texture": destination.handle, "origin": (0, first_row, 0)}
        self.handle.copy_buffer_to_texture(rows, texels, (width, height, 1))

    def copy_texture_to_buffer(
        self, source: Submittable, destination: Submittable, extent: tuple[int, int], row_bytes: int
    ) -> None:
        """Copy the first `extent` texels of `source` to `destination`, a row every `row_bytes`."""
        width, height = extent
        rows = {"buffer": destination.handle, "bytes_per_row": row_bytes, "rows_per_image": height}
        self.handle.copy_texture_to_buffer({"texture": source.handle}, rows, (width, height, 1))

    def copy_texture(self, source: Submittable, destination: Submittable, extent: tuple[int, int]) -> None:
        """Copy the first `extent` texels of `source` to the same place in `destination`."""
        self.handle.copy_texture_to_texture({"texture": source.handle}, {"texture": destination.handle}, (*extent, 1))

    def begin_compute_pass(self, pipeline: wgpu.GPUComputePipeline) -> wgpu.GPUComputePassEncoder:
        """Return wgpu's encoder of a pass, for one dispatch of a pipeline; `end_dispatch` follows it.

        Dispatches that follow one another share a pass: beginning one takes as long as many dispatches.
        """
        if self._compute_pass is None:
            self._compute_pass = self._handle.begin_compute_pass(timestamp_writes=self._timestamp_writes())
            self._pipeline = None
        if pipeline is not self._pipeline:
            self._compute_pass.set_pipeline(pipeline)
            self._pipeline = pipeline
        return self._compute_pass

    def end_dispatch(self, label: str) -> None:
        """Note that a dispatch is encoded; `label` is its pipeline's. What is observed has a pass of its own."""
        for observer in self.context.observers:
            _ = self.handle
            observer.end_dispatch(self, label)

    def begin_render_pass(
        self, view: wgpu.GPUTextureView, clear_color: tuple[float, float, float, float] | None = None
    ) -> wgpu.GPURenderPassEncoder:
        """Return wgpu's encoder of one pass over the texels of `view`; `end_render_pass` takes it back.

        clear_color : what the texels are before; None for what they hold
        """
        attachment = {"view": view, "load_op": "load", "store_op": "store"}
        if clear_color is not None:
            attachment |= {"load_op": "clear", "clear_value": clear_color}
        return self.handle.begin_render_pass(color_attachments=[attachment], timestamp_writes=self._timestamp_writes())

    def end_render_pass(self, render: wgpu.GPURenderPassEncoder, label: str) -> None:
        """End a pass; `label` is its pipeline's."""
        render.end()
        for observer in self.context.observers:
            observer.end_dispatch(self, label)

    def _timestamp_writes(self) -> dict[str, object] | None:
        writes = None
        for observer in self.context.observers:
            writes = writes or observer.timestamp_writes()
        return writes

    def flush(self) -> None:
        """Submit what has been encoded so far: for observers, which may split a submission."""
        self.submit()
        self._handle = self.context.handle.create_command_encoder(label=self._label)

    def submit(self) -> None:
        """Submit what has been encoded; called once, by `GpuContext.encode_commands`.

        wgpu aborts the process if a submission is not valid: what could make it so is checked here.
        """
        used = dict.fromkeys(self._used)  # each once
        for buffer in used:
            buffer.require_submittable(self.context)
        with self.context.translate_errors("record the commands", self._label, *[each.label for each in used]):
            commands = self.handle.finish()
        self.context.handle.queue.submit([commands])
        self.context.n_submissions += 1
        del self._handle  # here, where Ctrl+C waits: what a destructor raises is lost


class GpuContext:
    """An opened adapter.

    adapter : part of the adapter's name, in any case; by default GPU_XFORM_ADAPTER, else the fastest
    limits : stricter limits than the adapter's own to plan by
    wanted_features : which features of wgpu to use if the adapter has them
    """

    def __init__(
        self,
        adapter: str | None = None,
        *,
        limits: Limits | None = None,
        wanted_features: frozenset[str] = WANTED_FEATURES,
    ) -> None:
        refuse_fork()
        with defer_interrupts():
            self._open(adapter or os.environ.get("GPU_XFORM_ADAPTER") or None, limits, wanted_features)
        self.lock = threading.RLock()
        self.is_closed = False
        self.is_lost = False
        self.n_submissions = 0
        self.observers: list[DispatchObserver] = []
        _contexts.add(self)

    def _open(self, name: str | None, limits: Limits | None, wanted_features: frozenset[str]) -> None:
        chosen = find_adapter(name)
        self.adapter: Adapter = describe_adapter(chosen)
        self.limits: Limits = limits or self.adapter.limits
        useful = wanted_features if self.adapter.kind in HOST_MAPPABLE_KINDS else wanted_features - {MAPPABLE}
        self.features: frozenset[str] = useful & self.adapter.features
        self.host_mappable: bool = MAPPABLE in self.features
        self.handle: wgpu.GPUDevice = _open_adapter(chosen, self.features)
        note_device()

    @contextlib.contextmanager
    def encode_commands(self, *used: Submittable, label: str) -> Iterator[CommandEncoder]:
        """Encode commands that touch the buffers `used`; submit them once, at the end of the block.

        label : what messages and traces call the submission
        """
        with defer_interrupts(), self.lock:
            self.require_usable()
            for observer in self.observers:
                observer.begin_submission(label)
            encoder = CommandEncoder(self, used, label)
            yield encoder
            for observer in self.observers:
                observer.end_encoding(encoder)
            encoder.submit()
            for observer in self.observers:
                observer.end_submission()
            flush()

    def require_usable(self) -> None:
        """Raise `DeviceError` if the device is closed, or if this process is a fork of the one that opened it."""
        refuse_fork()
        if self.is_closed:
            raise DeviceError(f"the device {self.adapter.name!r} is closed")
        if self.is_lost:
            raise DeviceError(f"the device {self.adapter.name!r} is lost; open another, by gx.Device()")

    @contextlib.contextmanager
    def translate_errors(self, action: str, *labels: str) -> Iterator[None]:
        """Turn what wgpu raises in the block into errors of gpu_xform, and note if the device is lost."""
        with self.note_loss(), translate_wgpu_errors(action, *labels):
            yield

    @contextlib.contextmanager
    def note_loss(self) -> Iterator[None]:
        """Note if the block raises that the device is lost: then nothing more may be submitted to it."""
        try:
            yield
        except DeviceLostError:
            self.is_lost = True
            raise

    def close(self) -> None:
        """Free the device. Closing twice does nothing."""
        with defer_interrupts(), self.lock:
            if not self.is_closed:
                self.is_closed = True
                if not is_fork():
                    self.handle.destroy()
                    flush()

    def __repr__(self) -> str:
        return f"Device({self.adapter.name!r}, {self.adapter.backend}, {self.adapter.driver})"


def _open_adapter(adapter: wgpu.GPUAdapter, features: frozenset[str]) -> wgpu.GPUDevice:
    limits = {name: adapter.limits[name] for name in WANTED_LIMITS}
    name = adapter.info["device"]
    with lend_runtime_dir(), translate_wgpu_errors(f"open the adapter {name!r}"):
        try:
            return adapter.request_device_sync(label=name, required_features=sorted(features), required_limits=limits)
        except RuntimeError as error:  # as wgpu says that a driver refuses, but nothing else
            raise wgpu.GPUError(str(error)) from error


def _let_go_of_devices() -> None:
    """Let the child of a fork end without a call of wgpu, and wait for no lock that a thread of its parent holds."""
    if not is_fork():
        return
    for context in _contexts:
        context.lock = threading.RLock()
    for kind in (wgpu.GPUObjectBase, wgpu.GPUAdapter):
        kind.__del__ = lambda _: None
    _end_before_drivers()


def _end_before_drivers() -> None:
    """Let this process end when Python has, before drivers do: Mesa 26 waits for threads that a fork does not have."""
    libc = ctypes.CDLL(None)
    with contextlib.suppress(AttributeError):  # the C library of GNU has it
        libc.on_exit(ctypes.cast(libc._exit, ctypes.c_void_p), None)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_let_go_of_devices)
