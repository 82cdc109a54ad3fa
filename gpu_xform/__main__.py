"""The process of the command `gpu-xform`, or `python -m gpu_xform`: how it ends, from the first import on."""

import _thread
import signal
import sys
import time
from collections.abc import Sequence
from typing import Any

from ._core.interrupts import Terminated, describe_interrupt, raise_terminated

MOMENT_S = 0.005  # long enough for a finalizer to end


def main(guarded: Sequence[signal.Signals] = ()) -> int:
    """Run the command line of this process, and return the exit code; Ctrl+C and SIGTERM end it in one line.

    guarded : signals that have ended the process at once so far, and raise an exception from here on
    """
    try:
        if signal.SIGINT in guarded:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        sys.unraisablehook = _raise_again
        if signal.SIGTERM in guarded or signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, raise_terminated)
        from .cli import main as run

        code = run()
    except KeyboardInterrupt as interrupt:  # while modules are imported; later, the command itself says so
        _ignore_signals()
        code, line = describe_interrupt(interrupt)
        if sys.stderr is not None:
            sys.stderr.write(line)
    _ignore_signals()
    # If an interrupt comes while `exec` runs a text, as for a dataclass, Python 3.11 kills a program of `python -m` by
    # SIGINT at its end, although the interrupt was caught. The next text that runs takes that back.
    exec("")  # noqa: S102
    return code


def _raise_again(unraisable: Any) -> None:
    """Raise again an interrupt that came while a finalizer ran, out of which Python cannot raise it."""
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
        return
    number = signal.SIGTERM if issubclass(unraisable.exc_type, Terminated) else signal.SIGINT
    # By another thread, and later: at once, it would be raised in here, and forgotten again.
    _thread.start_new_thread(_interrupt_main_later, (number,))


def _interrupt_main_later(number: signal.Signals) -> None:
    time.sleep(MOMENT_S)
    _thread.interrupt_main(number)


def _ignore_signals() -> None:
    """Ignore both signals from here on: Python would print a traceback out of its own end."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(main())
