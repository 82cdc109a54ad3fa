"""An opened adapter, and the one place that submits work to it."""

import contextlib
import os
import threading
from collections.abc import Iterator
from types import TracebackType
from typing import Any, Self

import wgpu

from .._core.interrupts import uninterrupted
from ..errors import ArgumentTypeError, DeviceError
from . import buffers, self_test
from .adapters import Adapter, Limits, described, find_adapter, quiet_runtime_dir
from .buffer_pool import Pool
from .errors import device_errors
from .resource_cache import Residents
from .shaders import Pipelines

# Memory that the host can map is as good as the device's own on these kinds. On discrete adapters a copy over the bus
# is faster; on integrated ones wgpu makes what the host may write write-combined, from which it reads at a crawl.
HOST_MAPPABLE_KINDS = {"CPU"}
WANTED_FEATURES = {"shader-f64", "timestamp-query"}
WANTED_LIMITS = (
    "max-buffer-size",
    "max-storage-buffer-binding-size",
    "max-compute-workgroups-per-dimension",
    "max-compute-workgroup-size-x",
    "max-compute-invocations-per-workgroup",
)

_process_of_first_device: int | None = None


class Device:
    """A graphics adapter, opened; every transform and picture runs on one.

    Opening runs the self-test, so that a driver that computes wrongly is refused at once. Work from several threads is
    taken one piece at a time.

    adapter : part of an adapter's name, in any case; by default GPU_XFORM_ADAPTER, else the fastest
    limits : stricter limits than the adapter's own to plan by

    Raises `NoAdapterError`, and `DeviceError` where the self-test fails or the process is a fork of one with a device.
    """

    def __init__(self, adapter: str | None = None, *, limits: Limits | None = None) -> None:
        _refuse_fork()
        chosen = find_adapter(adapter or os.environ.get("GPU_XFORM_ADAPTER") or None)
        self.adapter: Adapter = described(chosen)
        self.limits: Limits = limits or self.adapter.limits
        self.host_mappable: bool = (
            self.adapter.kind in HOST_MAPPABLE_KINDS and "mappable-primary-buffers" in self.adapter.features
        )
        self.features: frozenset[str] = frozenset(
            (WANTED_FEATURES & self.adapter.features) | ({"mappable-primary-buffers"} if self.host_mappable else set())
        )
        self.handle: wgpu.GPUDevice = _opened(chosen, self.features)
        global _process_of_first_device
        _process_of_first_device = os.getpid()
        self.lock = threading.RLock()
        self.pipelines = Pipelines(self)
        self.pool = Pool(self)
        self.residents = Residents(self)
        self.bind_groups: dict[tuple[Any, ...], wgpu.GPUBindGroup] = {}  # of buffers that stay, by pipeline and parts
        self._closed = False
        self_test.require(self)

    @property
    def name(self) -> str:
        """The adapter's name."""
        return self.adapter.name

    @property
    def has_float64(self) -> bool:
        """Whether shaders here compute in double precision."""
        return "shader-f64" in self.features

    @contextlib.contextmanager
    def recording(self, *used: "buffers.Buffer") -> Iterator[wgpu.GPUCommandEncoder]:
        """Record commands that touch the buffers `used`; they are submitted where the block ends, once.

        wgpu aborts the process when a submission is not valid, so what could make it so is checked here.
        """
        with self.lock, uninterrupted():
            self.require_usable()
            encoder = self.handle.create_command_encoder()
            yield encoder
            for buffer in used:
                buffer.require_submittable(self)
            with device_errors("record the commands"):
                commands = encoder.finish()
            self.handle.queue.submit([commands])

    def require_usable(self) -> None:
        """Raise `DeviceError` where the device is closed, or this process is a fork of the one that opened it."""
        _refuse_fork()
        if self._closed:
            raise DeviceError(f"the device {self.name!r} is closed")

    def close(self) -> None:
        """Give the device's memory back; it takes no more work. Closing twice does nothing."""
        with self.lock:
            if not self._closed:
                self._closed = True
                self.bind_groups.clear()
                self.pool.clear()
                self.residents.clear()
                self.handle.destroy()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Device({self.name!r}, {self.adapter.backend}, {self.adapter.driver})"


_default: Device | None = None
_default_lock = threading.Lock()


def default_device() -> Device:
    """Return the process's own device, opened at the first call."""
    global _default
    with _default_lock:
        if _default is None or _default._closed:
            _default = Device()
        return _default


def chosen_device(device: Device | None) -> Device:
    """Return `device`, or by default the process's own. Raises `ArgumentTypeError` for what is no Device."""
    if device is None:
        return default_device()
    if not isinstance(device, Device):
        raise ArgumentTypeError(f"device must be a Device, got {device!r}")
    return device


def _opened(adapter: wgpu.GPUAdapter, features: frozenset[str]) -> wgpu.GPUDevice:
    limits = {name: adapter.limits[name] for name in WANTED_LIMITS}
    with quiet_runtime_dir(), device_errors(f"open the adapter {adapter.info['device']!r}"):
        try:
            return adapter.request_device_sync(required_features=sorted(features), required_limits=limits)
        except RuntimeError as error:  # as wgpu says that a driver refuses, but nothing else
            raise wgpu.GPUError(str(error)) from error


def _refuse_fork() -> None:
    if _process_of_first_device not in (None, os.getpid()):
        raise DeviceError(
            f"process {os.getpid()} is a fork of process {_process_of_first_device}, which has opened a graphics "
            "device: drivers hang in such a child; start workers with multiprocessing.get_context('spawn')"
        )
