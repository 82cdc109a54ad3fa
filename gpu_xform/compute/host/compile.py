"""Compilation of loops by numba, and the one lock under which they run."""

import contextlib
import os
import threading
from collections.abc import Callable, Iterator
from typing import Any, TypeVar, cast

import numba

from ...errors import DeviceError
from ...host import count_threads

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
        # Before the lock, which another thread of the parent may have held when it forked.
        if _first_process not in (None, os.getpid()):
            raise DeviceError(
                f"process {os.getpid()} is a fork of process {_first_process}, which has computed on the host device: "
                "numba's threads are not in such a child; start workers with multiprocessing.get_context('spawn')"
            )
        with _lock, _limit_threads(count_threads()):
            _first_process = os.getpid()
            compiled(*arguments)

    return cast("_Loop", run)


@contextlib.contextmanager
def _limit_threads(n_threads: int) -> Iterator[None]:
    """Let numba use up to `n_threads` for a block; what the caller has set for loops of their own comes back."""
    before = numba.get_num_threads()
    numba.set_num_threads(min(n_threads, numba.config.NUMBA_NUM_THREADS))
    try:
        yield
    finally:
        numba.set_num_threads(before)
