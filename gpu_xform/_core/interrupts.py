"""Ctrl+C, held back while it would do harm."""

import contextlib
import signal
import threading
from collections.abc import Iterator


@contextlib.contextmanager
def defer_sigint() -> Iterator[None]:
    """Raise `KeyboardInterrupt` only where the block ends, if Ctrl+C is pressed in it.

    Raised while an object of wgpu is made or dropped, it would leave half an object behind, or be lost; while files are
    moved, some of them here and some there. Nothing is held back in threads other than the main one, which are not
    interrupted, or where the program minds Ctrl+C itself.
    """
    if threading.current_thread() is not threading.main_thread() or (
        signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
        yield
        return
    pressed: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if pressed:
            raise KeyboardInterrupt
