"""Deferral of SIGINT (Ctrl+C) and SIGTERM while an exception would leave things half done."""

import contextlib
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

INTERRUPTED, TERMINATED = 130, 143  # what a shell reports of a program that SIGINT or SIGTERM has ended


class Terminated(KeyboardInterrupt):
    """The process has been asked to end, by SIGTERM."""


def raise_terminated(signum: int, frame: FrameType | None) -> None:  # noqa: ARG001
    """Raise `Terminated`: the handler of SIGTERM in the command, which then ends through the door of Ctrl+C."""
    raise Terminated


def describe_interrupt(interrupt: KeyboardInterrupt) -> tuple[int, str]:
    """Return the exit code, and the line to print, of a command that an interrupt has ended; its notes say more."""
    is_terminated = isinstance(interrupt, Terminated)
    notes = "".join(f"; {note}" for note in getattr(interrupt, "__notes__", ()))
    line = f"gpu-xform: {'terminated' if is_terminated else 'interrupted'}{notes}\n"
    return TERMINATED if is_terminated else INTERRUPTED, line


# What `signal` calls, without conversion to enumerations and back, which takes ten times as long: 10 us of each call of
# a device.
_signal = sys.modules.get("_signal", signal)

_came: list[int] | None = None  # the signals that came in the outermost block, which the main thread is in

# What raises out of the middle of anything. A program that handles a signal in another way knows what it does.
_RAISING_HANDLERS = ((signal.SIGINT, signal.default_int_handler), (signal.SIGTERM, raise_terminated))


@contextlib.contextmanager
def defer_interrupts() -> Iterator[list[int]]:
    """Raise at the end of the block what Ctrl+C or SIGTERM would raise within it; work that takes long ends early then.

    Yields the signals that have come, a list that grows.

    Raised earlier, it could leave a wgpu object half made or a buffer mapped, be lost in a destructor, or leave only
    some files moved. Nothing is deferred in threads other than the main one, which are never interrupted, or if the
    program handles the signals itself.
    """
    global _came
    deferred: list[tuple[signal.Signals, Callable[[int, FrameType | None], Any]]] = []
    # In a block within another there is nothing to do: asking for handlers takes as long as many calls of a driver.
    is_main = threading.current_thread() is threading.main_thread()
    if _came is None and is_main:
        deferred = [(number, handler) for number, handler in _RAISING_HANDLERS if _signal.getsignal(number) is handler]
    if not deferred:
        yield _came if _came is not None and is_main else []
        return
    came: list[int] = []
    try:
        for number, _ in deferred:
            _signal.signal(number, lambda number, _: came.append(number))
        _came = came
        yield came
    finally:
        _came = None
        _restore(deferred)
        for number, handler in deferred:
            if number in came:
                handler(number, None)


def _restore(handlers: list[tuple[signal.Signals, Callable[[int, FrameType | None], Any]]]) -> None:
    """Set each handler, even if the one before it raises at once."""
    if handlers:
        try:
            _signal.signal(*handlers[0])
        finally:
            _restore(handlers[1:])
