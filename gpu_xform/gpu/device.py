"""The device: an opened adapter with its buffers, caches and compiled shaders."""

import contextlib
import threading
from collections.abc import Hashable, Iterator
from typing import Any, Self, SupportsIndex

from .._core.interrupts import defer_interrupts
from ..device import Device, Limits, choose_adapter, default_device, resolve_device
from ..errors import DeviceError
from . import self_test
from .buffer_pool import BufferPool
from .context import CommandEncoder, GpuContext, Submittable
from .dispatch import BindGroupCache
from .resource_cache import ResourceCache
from .shaders import Pipelines
from .textures import TexturePool
from .timestamps import DispatchTimer, create_timer
from .trace import Tracer, trace_from_environment


class GpuDevice(Device):
    """A graphics adapter, opened, as a device: it transforms points and draws pictures."""

    def __init__(
        self, adapter: str | None = None, *, limits: Limits | None = None, index: SupportsIndex | None = None
    ) -> None:
        adapter = choose_adapter(adapter, index)
        with defer_interrupts():  # a half-opened device would only be closed when Python finds it
            self._compose(GpuContext(adapter, limits=limits))

    @classmethod
    def from_context(cls, context: GpuContext) -> Self:
        """Return the device of a context, which may have been opened with fewer features or stricter limits."""
        device = cls.__new__(cls)
        device._compose(context)
        return device

    def _compose(self, context: GpuContext) -> None:
        self.context = context
        self.adapter = context.adapter
        self.limits = context.limits
        self.features: frozenset[str] = context.features
        self.host_mappable: bool = context.host_mappable
        self.pipelines = Pipelines(context)
        self.bind_groups = BindGroupCache(context)
        self.pool = BufferPool(context)
        self.textures = TexturePool(context)
        self.resource_cache = ResourceCache(context)
        self.kept_ready: dict[Hashable, Any] = {}  # by kernels, for calls that come often; each has a `release()`
        self._trace = trace_from_environment()
        self._tracer = Tracer(context, self._trace) if self._trace else None
        if self._tracer:
            context.observers.append(self._tracer)
        self_test.require(context, self.pipelines)

    @property
    def lock(self) -> threading.RLock:
        """What its work holds, one thread at a time."""
        return self.context.lock

    @property
    def has_float64(self) -> bool:
        """Whether its shaders compute in double precision."""
        return "shader-f64" in self.features

    def encode_commands(self, *used: Submittable, label: str) -> contextlib.AbstractContextManager[CommandEncoder]:
        """Encode commands that touch the buffers `used`; submit them once, at the end of the block."""
        return self.context.encode_commands(*used, label=label)

    @contextlib.contextmanager
    def time_dispatches(self) -> Iterator[DispatchTimer]:
        """Lend a timer of all dispatches in the block, for the thread that holds the device's lock meanwhile."""
        with self.lock:
            if self._tracer:
                yield self._tracer.timer
                return
            timer = create_timer(self.context)
            self.context.observers.append(timer)
            try:
                yield timer
            finally:
                self.context.observers.remove(timer)

    def require_usable(self) -> None:
        """Raise `DeviceError` if the device is closed, or if this process is a fork of the one that opened it."""
        self.context.require_usable()

    @property
    def is_closed(self) -> bool:
        """Whether `close` was called."""
        return self.context.is_closed

    @property
    def is_lost(self) -> bool:
        """Whether its driver has given it up, as far as is known."""
        return self.context.is_lost

    def close(self) -> None:
        """Give the device's memory back; it takes no more work. Closing twice does nothing."""
        with self.lock:
            if not self.context.is_closed:
                self.bind_groups.clear()
                self.pool.clear()
                self.textures.clear()
                self.resource_cache.clear()
                for kept in self.kept_ready.values():
                    kept.release()
                self.kept_ready.clear()
                self.context.close()
                if self._trace:
                    self._trace.write()

    def __repr__(self) -> str:
        return repr(self.context)


def default_gpu_device() -> GpuDevice:
    """Return the process's own device, opened at the first call; raise `DeviceError` if it is the host."""
    return require_gpu_device(default_device())


def resolve_gpu_device(device: Device | None) -> GpuDevice:
    """Return `device`, or by default the process's own; raise `DeviceError` if it draws no pictures."""
    return require_gpu_device(resolve_device(device))


def require_gpu_device(device: Device) -> GpuDevice:
    """Return `device`, which must be a graphics adapter's."""
    if not isinstance(device, GpuDevice):
        raise DeviceError("the host device draws no pictures: that takes a graphics adapter, such as gx.Device() opens")
    return device
