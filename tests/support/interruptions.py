"""Interruptions: an exception raised at a chosen line of the package, wherever the program is by then."""

import linecache
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

import gpu_xform
from gpu_xform.gpu.device import GpuDevice

PACKAGE = str(Path(gpu_xform.__file__).parent)
# No signal raises within it: that is what it is for.
DEFERRAL = str(Path(PACKAGE) / "_core" / "interrupts.py")


class LineCounter:
    """Counts the lines that this thread runs of the package, and raises `error` before line `at`, or soon after."""

    def __init__(self, at: int | None = None, error: BaseException | None = None) -> None:
        self.n_lines = 0
        self._at = at
        self._error = error or KeyboardInterrupt()
        # CPython 3.11 uses them once more after they have raised, and keeps no reference then.
        self.trace, self._trace_lines = self._enter, self._step

    def _enter(self, frame: FrameType, event: str, argument: object) -> Any:  # noqa: ARG002
        """Look into a function that is called, if it is of the package."""
        name = frame.f_code.co_filename
        return self._trace_lines if name.startswith(PACKAGE) and name != DEFERRAL else None

    def _step(self, frame: FrameType, event: str, argument: object) -> Any:  # noqa: ARG002
        if event == "line" and not _is_silent(frame):
            self.n_lines += 1
            if self._at is not None and self.n_lines >= self._at and not _is_finalizing(frame):
                raise self._error
        return self._trace_lines


def _is_silent(frame: FrameType) -> bool:
    """Return whether a line only begins or ends a block: Python handles no signal between a block and its end."""
    return linecache.getline(frame.f_code.co_filename, frame.f_lineno).lstrip().startswith(("with ", "try:"))


def _is_finalizing(frame: FrameType | None) -> bool:
    """Return whether the program is in a finalizer, in which Python prints what is raised and forgets it."""
    while frame is not None:
        if frame.f_code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False


@contextmanager
def traced(counter: LineCounter) -> Iterator[None]:
    """Trace this thread by `counter` in the block."""
    before = sys.gettrace()
    sys.settrace(counter.trace)
    try:
        yield
    finally:
        sys.settrace(before)


def count_lines(run: Callable[[], object]) -> int:
    """Return how many lines of the package `run` takes."""
    counter = LineCounter()
    with traced(counter):
        run()
    return counter.n_lines


def interrupt_at(run: Callable[[], object], line: int, error: BaseException | None = None) -> None:
    """Call `run`, and raise `error`, by default `KeyboardInterrupt`, before a line of it."""
    error = error or KeyboardInterrupt()
    try:
        with traced(LineCounter(line, error)):
            run()
    except BaseException as raised:
        if raised is not error and not isinstance(raised, KeyboardInterrupt):
            raise


def sample_lines(n_lines: int, n_samples: int, seed: int) -> list[int]:
    """Return some of the line numbers from 1 to `n_lines`, all if there are few."""
    lines = np.arange(1, n_lines + 1)
    return sorted(np.random.default_rng(seed).permutation(lines)[:n_samples].tolist())


def require_healthy(device: GpuDevice) -> None:
    """Fail if the device's lock is held, or if its pool would hand out a buffer that the host has mapped."""
    taken: list[bool] = []

    def take() -> None:
        taken.append(device.lock.acquire(timeout=10))
        if taken[0]:
            device.lock.release()

    other = threading.Thread(target=take)
    other.start()
    other.join()
    assert taken == [True], "the device's lock is still held"
    for (owner, key, usage), buffer in list(device.pool._scratch.items()):
        given = device.pool.scratch(owner, key, buffer.n_bytes, usage)
        assert given.handle.map_state == "unmapped", given.label
    for spare in device.pool._spare.values():
        for buffer in spare:
            assert buffer.handle.map_state == "unmapped", buffer.label
