"""The process of the command `gpu-xform`, or `python -m gpu_xform`: how it ends, from the first import on."""

import signal
import sys

from ._core.interrupts import describe_interrupt, raise_terminated


def main() -> int:
    """Run the command line of this process, and return the exit code; Ctrl+C and SIGTERM end it in one line."""
    try:
        if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, raise_terminated)
        from .cli import main as run

        code = run()
    except KeyboardInterrupt as interrupt:  # while modules are imported; later, the command itself says so
        _ignore_signals()
        code, line = describe_interrupt(interrupt)
        if sys.stderr is not None:
            sys.stderr.write(line)
    _ignore_signals()
    return code


def _ignore_signals() -> None:
    """Ignore both signals from here on: Python would print a traceback out of its own end."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(main())
