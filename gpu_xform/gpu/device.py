"""The device: an opened adapter with its buffers, caches and compiled shaders."""

import contextlib
import threading
from collections.abc import Iterator
from types import TracebackType
from typing import Self

from .._core.public import public
from ..errors import ArgumentTypeError
from . import self_test
from .adapters import Adapter, Limits
from .buffer_pool import BufferPool
from .context import CommandEncoder, GpuContext, Submittable
from .dispatch import BindGroupCache
from .resource_cache import ResourceCache
from .shaders import Pipelines
from .textures import TexturePool
from .timestamps import DispatchTimer, create_timer
from .trace import Tracer, trace_from_environment


@public
class Device:
    """A graphics adapter, opened; every transform and picture runs on one.

    Opening runs a self-test, so that a driver that computes wrongly is refused at once. Work of several threads runs
    one piece at a time. A Device is a context manager that closes itself.

    Parameters
    ----------
    adapter : str, optional
        Part of an adapter's name, in any case; by default GPU_XFORM_ADAPTER, else the fastest adapter.
    limits : Limits, optional
        Limits to plan by, stricter than the adapter's own.

    Raises
    ------
    NoAdapterError
        If there is no adapter, or none of that name.
    DeviceError
        If the self-test fails, or if the process is a fork of one that has opened a device.
    """

    def __init__(self, adapter: str | None = None, *, limits: Limits | None = None) -> None:
        self._compose(GpuContext(adapter, limits=limits))

    @classmethod
    def from_context(cls, context: GpuContext) -> Self:
        """Return the device of a context, which may have been opened with fewer features or stricter limits."""
        device = cls.__new__(cls)
        device._compose(context)
        return device

    def _compose(self, context: GpuContext) -> None:
        self.context = context
        self.adapter: Adapter = context.adapter
        self.limits: Limits = context.limits
        self.features: frozenset[str] = context.features
        self.host_mappable: bool = context.host_mappable
        self.lock = context.lock
        self.pipelines = Pipelines(context)
        self.bind_groups = BindGroupCache(context)
        self.pool = BufferPool(context)
        self.textures = TexturePool(context)
        self.resource_cache = ResourceCache(context)
        self._trace = trace_from_environment()
        self._tracer = Tracer(context, self._trace) if self._trace else None
        if self._tracer:
            context.observers.append(self._tracer)
        self_test.require(context, self.pipelines)

    @property
    def name(self) -> str:
        """The adapter's name."""
        return self.adapter.name

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

    def close(self) -> None:
        """Give the device's memory back; it takes no more work. Closing twice does nothing."""
        with self.lock:
            if not self.context.is_closed:
                self.bind_groups.clear()
                self.pool.clear()
                self.textures.clear()
                self.resource_cache.clear()
                self.context.close()
                if self._trace:
                    self._trace.write()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return repr(self.context)


_default: Device | None = None
_default_lock = threading.Lock()


def default_device() -> Device:
    """Return the process's own device, opened at the first call."""
    global _default
    with _default_lock:
        if _default is None or _default.context.is_closed:
            _default = Device()
        return _default


def resolve_device(device: Device | None) -> Device:
    """Return `device`, or by default the process's own; raise `ArgumentTypeError` for what is no Device."""
    if device is None:
        return default_device()
    if not isinstance(device, Device):
        raise ArgumentTypeError.expecting("device", "be a Device", repr(device))
    return device
