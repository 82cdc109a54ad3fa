"""Compilation of loops by numba, and the one lock under which they run."""

import os
import threading
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from ...errors import DeviceError

_Loop = TypeVar("_Loop", bound=Callable[..., Any])

# Numba's default thread layer ends the process if two threads enter parallel loops at the same time.
_lock = threading.Lock()
_first_process: int | None = None


def compile_function(function: _Loop) -> _Loop:
    """Return `function` compiled as a part of the loops that call it."""
    return cast("_Loop", numba.njit(error_model="numpy", inline="never")(function))


def compile_loop(loop: _Loop) -> _Loop:
    """Return `loop` compiled for all processors, when it is first called; on later runs it comes from numba's cache.

    Products and sums are not contracted, so that NumPy computes the same bytes.
    """
    options: dict[str, Any] = {"parallel": True, "error_model": "numpy", "nogil": True}
    try:
        compiled = numba.njit(cache=True, **options)(loop)
    except RuntimeError:  # no folder to cache in can be written: each process compiles for itself
        compiled = numba.njit(**options)(loop)

    def run(*arguments: Any) -> None:
        global _first_process
        with _lock:
            if _first_process is None:
                _first_process = os.getpid()
            elif _first_process != os.getpid():
                raise DeviceError(
                    "this process is a fork of one that has computed on the host device: start it by 'spawn' instead"
                )
            compiled(*arguments)

    return cast("_Loop", run)
