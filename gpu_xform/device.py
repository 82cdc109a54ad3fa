"""Devices: where transforms are computed, a graphics adapter or the host's own processors."""

import operator
import os
import threading
from dataclasses import dataclass
from importlib import import_module
from types import TracebackType
from typing import Any, Self, SupportsIndex

from ._core.interrupts import defer_interrupts
from ._core.public import public
from .errors import ArgumentError, ArgumentTypeError

HOST = "host"
ADAPTER_VARIABLE = "GPU_XFORM_ADAPTER"


@dataclass(frozen=True)
class Limits:
    """What one adapter can hold and dispatch.

    Parameters
    ----------
    max_buffer_bytes : int
        Bytes per buffer.
    max_binding_bytes : int
        Bytes of a buffer that one storage binding can show.
    max_workgroups : int
        Workgroups per dispatch, in each dimension.
    max_workgroup_size : int
        Invocations per workgroup.
    max_texture_side : int
        Texels across a texture, and down.
    """

    max_buffer_bytes: int
    max_binding_bytes: int
    max_workgroups: int
    max_workgroup_size: int
    max_texture_side: int = 8192

    @property
    def max_bound_bytes(self) -> int:
        """The bytes of the largest buffer that one binding can show."""
        return min(self.max_binding_bytes, self.max_buffer_bytes)


@dataclass(frozen=True)
class Adapter:
    """A graphics adapter, or the host's processors.

    Parameters
    ----------
    name : str
        What its driver calls it; a part of it chooses the adapter in `Device`.
    kind : str
        "DiscreteGPU", "IntegratedGPU", "VirtualGPU", "CPU" or "Unknown".
    backend : str
        "Vulkan", "Metal" or "D3D12"; "host" for the host's processors.
    driver : str
        The driver's name and version; for the host, what its loops are made by.
    limits : Limits
        What it can hold and dispatch.
    features : frozenset of str
        Names of the optional features of WebGPU that it has, such as "shader-f64".
    """

    name: str
    kind: str
    backend: str
    driver: str
    limits: Limits
    features: frozenset[str]


@public
class Device:
    """What computes transforms and, if it is a graphics adapter, pictures.

    `Device("host")` is the machine's own processors: it needs no graphics driver, transforms the same arrays and images
    by the same rules, and draws nothing. With the extra `host` its loops are compiled by numba; without, it uses NumPy.
    Any other name opens a graphics adapter, which runs a self-test, so that a driver that computes wrongly is refused
    at once. Work of several threads runs one piece at a time. A Device is a context manager that closes itself.

    Parameters
    ----------
    adapter : str, optional
        "host", a part of an adapter's name, in any case, or "#1" for a place in `adapters()`; by default
        GPU_XFORM_ADAPTER, which is one of these, else the fastest adapter.
    limits : Limits, optional
        Limits to plan by, stricter than the adapter's own; the host has none.
    index : int, optional
        The place in `adapters()`, from 0, instead of a name: identical adapters differ in nothing else.

    Raises
    ------
    NoAdapterError
        If there is no adapter, or none of that name.
    DeviceError
        If the self-test fails, or if the process is a fork of one that has opened a device.
    """

    adapter: Adapter
    limits: Limits

    def __new__(
        cls, adapter: str | None = None, *, limits: Limits | None = None, index: SupportsIndex | None = None
    ) -> Self:
        """Make a device of the class that `adapter` asks for."""
        adapter = choose_adapter(adapter, index)
        if limits is not None and not isinstance(limits, Limits):
            raise ArgumentTypeError.expecting("limits", "be Limits", type(limits).__name__)
        chosen: type[Self] = cls if cls is not Device else _find_class(adapter)
        return super().__new__(chosen)

    def __init__(
        self, adapter: str | None = None, *, limits: Limits | None = None, index: SupportsIndex | None = None
    ) -> None:
        raise NotImplementedError

    @property
    def name(self) -> str:
        """The adapter's name, or "host"."""
        return self.adapter.name

    @property
    def has_float64(self) -> bool:
        """Whether it computes in double precision."""
        raise NotImplementedError

    def require_usable(self) -> None:
        """Raise `DeviceError` if the device is closed, or if this process is a fork of the one that used it."""
        raise NotImplementedError

    def close(self) -> None:
        """Give the device's memory back; it takes no more work. Closing twice does nothing."""
        raise NotImplementedError

    @property
    def is_closed(self) -> bool:
        """Whether `close` was called."""
        raise NotImplementedError

    @property
    def is_lost(self) -> bool:
        """Whether its driver has given it up, as far as is known; it takes no more work then."""
        return False

    def __reduce__(self) -> Any:
        """Raise ArgumentTypeError: what is on a device is there alone."""
        raise ArgumentTypeError(f"the device {self.name!r}, and what is on it, cannot be copied or pickled")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


# The classes of devices, each imported when one of its devices is opened: the host's needs no wgpu.
_CLASSES = {HOST: ("gpu_xform.host", "HostDevice")}
_GPU_CLASS = ("gpu_xform.gpu.device", "GpuDevice")


def choose_adapter(adapter: str | None, index: SupportsIndex | None) -> str | None:
    """Return the one way in which an adapter is asked for: a part of its name, or "#" and its place."""
    if index is None:
        return adapter
    if adapter is not None:
        raise ArgumentError("adapter and index exclude each other: both say which adapter", argument="index")
    try:
        place = operator.index(index)
    except TypeError:
        raise ArgumentTypeError.expecting("index", "be a whole number", repr(index)) from None
    if place < 0:
        raise ArgumentError.expecting("index", "be 0 or more", place)
    return f"#{place}"


def _find_class(adapter: str | None) -> Any:
    if adapter is not None and not isinstance(adapter, str):
        raise ArgumentTypeError.expecting("adapter", "be a text", type(adapter).__name__)
    name = adapter if adapter is not None else os.environ.get(ADAPTER_VARIABLE)
    module, attribute = _CLASSES.get(str(name).casefold(), _GPU_CLASS)
    with defer_interrupts():
        return getattr(import_module(module), attribute)


_default: Device | None = None
_default_lock = threading.Lock()


@public
def default_device(adapter: str | None = None) -> Device:
    """Return the process's own device, which all functions use that are given none; set it first, if it is named.

    Parameters
    ----------
    adapter : str, optional
        "host", a part of an adapter's name, or "#1": that device becomes the process's own. By default the one that is,
        opened at the first call, and again after it was closed or lost: GPU_XFORM_ADAPTER, else the fastest adapter.

    Returns
    -------
    Device

    Raises
    ------
    NoAdapterError, DeviceError
        As `Device` does; the process's own device is then the one that it was.
    """
    global _default
    with _default_lock:
        if adapter is not None:
            _default = Device(adapter)
        elif _default is None or _default.is_closed or _default.is_lost:
            _default = Device()
        _default.require_usable()  # in a fork
        return _default


def _renew_lock() -> None:
    """Let the child of a fork wait for no thread of its parent."""
    global _default_lock
    _default_lock = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew_lock)


def opened_device() -> Device | None:
    """Return the process's own device, if it was opened before."""
    return _default


def resolve_device(device: Device | None) -> Device:
    """Return `device`, or by default the process's own; raise an error for what is no Device, and takes no work."""
    if device is None:
        device = default_device()
    elif not isinstance(device, Device):
        raise ArgumentTypeError.expecting("device", "be a Device", repr(device))
    device.require_usable()  # before any lock is taken: in a forked child a thread may hold it that is not there
    return device
