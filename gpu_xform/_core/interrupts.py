"""Deferral of SIGINT (Ctrl+C) while an interrupt would leave things half done."""

import contextlib
import signal
import threading
from collections.abc import Iterator


@contextlib.contextmanager
def defer_sigint() -> Iterator[None]:
    """Raise `KeyboardInterrupt` at the end of the block, if Ctrl+C is pressed within it.

    Raised earlier, it could leave a wgpu object half made, be lost in a destructor, or leave only some files moved.
    Nothing is deferred in threads other than the main one, which are never interrupted, or if the program handles
    SIGINT itself.
    """
    if threading.current_thread() is not threading.main_thread() or (
        signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
        yield
        return
    pressed: list[int] = []
    signal.signal(signal.SIGINT, lambda signum, _: pressed.append(signum))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if pressed:
            raise KeyboardInterrupt
