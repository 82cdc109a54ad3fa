"""The command's first lines, outside of the package, so that Ctrl+C ends it in one line while that is imported."""

import os
import signal
from types import FrameType


def main() -> int:
    """Run the command `gpu-xform`, and return its exit code."""
    handler = signal.getsignal(signal.SIGINT)
    if handler is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)
    from gpu_xform.__main__ import main as run

    return run(handler)


def _end(signum: int, frame: FrameType | None) -> None:  # noqa: ARG001
    """End at once: what an exception would come out of are half imported modules, and Python's own import system."""
    try:
        os.write(2, b"gpu-xform: interrupted\n")
    finally:
        os._exit(130)
