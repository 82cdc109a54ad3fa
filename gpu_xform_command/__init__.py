"""The command's first lines, outside of the package, so that signals end it in one line while that is imported."""

import os
import signal
from types import FrameType

_HANDLERS_OF_PYTHON = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
_ENDS = {signal.SIGINT: (130, b"interrupted"), signal.SIGTERM: (143, b"terminated")}


def main() -> int:
    """Run the command `gpu-xform`, and return its exit code."""
    guarded = [number for number, handler in _HANDLERS_OF_PYTHON.items() if signal.getsignal(number) is handler]
    for number in guarded:
        signal.signal(number, _end)
    from gpu_xform.__main__ import main as run

    return run(guarded)


def _end(signum: int, frame: FrameType | None) -> None:  # noqa: ARG001
    """End at once: what an exception would come out of are half imported modules, and Python's own import system."""
    code, word = _ENDS[signal.Signals(signum)]
    try:
        os.write(2, b"gpu-xform: %b\n" % word)
    finally:
        os._exit(code)
