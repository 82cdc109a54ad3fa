"""The host device: the machine's own processors."""

import os
import sys
from functools import cached_property
from typing import SupportsIndex

from ._core.forks import refuse_fork
from .device import HOST, Adapter, Device, Limits
from .errors import ArgumentError, DeviceError

THREADS_VARIABLE = "GPU_XFORM_THREADS"


class HostDevice(Device):
    """The machine's own processors, as a device: it takes points in both precisions and springs, and draws nothing."""

    def __init__(
        self,
        adapter: str | None = None,  # noqa: ARG002
        *,
        limits: Limits | None = None,
        index: SupportsIndex | None = None,  # noqa: ARG002
    ) -> None:
        self.limits = limits or Limits(sys.maxsize, sys.maxsize, sys.maxsize, 1)
        self._is_closed = False
        refuse_fork()  # where a graphics driver waits, at the end, for threads that begin there
        count_threads()  # raises

    @cached_property
    def adapter(self) -> Adapter:  # type: ignore[override]
        """Describe the processors as an adapter, when first asked: metadata of packages take 20 ms to import."""
        return Adapter(HOST, "CPU", HOST, _describe_loops(), self.limits, frozenset({"shader-f64"}))

    @property
    def name(self) -> str:
        """The word `host`."""
        return HOST

    @property
    def has_float64(self) -> bool:
        """True."""
        return True

    @property
    def is_closed(self) -> bool:
        """Whether `close` was called."""
        return self._is_closed

    def require_usable(self) -> None:
        """Raise `DeviceError` if the device is closed, or in a fork of a process that has opened a graphics device."""
        refuse_fork()
        if self._is_closed:
            raise DeviceError("the device 'host' is closed")

    def close(self) -> None:
        """Take no more work. Closing twice does nothing."""
        self._is_closed = True

    def __repr__(self) -> str:
        return f"Device({HOST!r}, {self.adapter.driver}, {count_threads()} threads)"


def count_threads() -> int:
    """Return how many threads compute: GPU_XFORM_THREADS, a positive whole number; by default one per processor."""
    text = os.environ.get(THREADS_VARIABLE, "").strip()
    if not text:
        return _count_processors()
    if not (text.isdecimal() and int(text) > 0):
        raise ArgumentError.expecting(THREADS_VARIABLE, "be a positive whole number", repr(text))
    return int(text)


def suggest_host(kind: str) -> str:
    """Say in one line what the host device is good for, beside a graphics adapter of a kind."""
    if kind == "CPU":
        return "The host device (--adapter host) is faster for arrays here; it draws nothing."
    return "gpu-xform bench compares it with the host device (--adapter host)."


def _count_processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _describe_loops() -> str:
    """Return what makes the loops, without importing it."""
    from importlib import metadata

    for package in ("numba", "numpy"):
        try:
            return f"{package} {metadata.version(package)}"
        except metadata.PackageNotFoundError:
            continue
    return ""
