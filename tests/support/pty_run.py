"""Commands run on a pseudo-terminal of their own."""

import os
import sys
import threading

import pytest

from gpu_xform._core import progress
from gpu_xform.cli import main


def run_on_terminal(*arguments: str, columns: int = 80, rows: int = 24) -> tuple[int, str]:
    """Run the command with a terminal of a size as standard error, progress bars at once.

    Return the exit code and the text shown.
    """
    import fcntl
    import pty
    import struct
    import termios

    own_end, command_end = pty.openpty()
    fcntl.ioctl(command_end, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    shown = bytearray()

    def read() -> None:
        try:
            while data := os.read(own_end, 4096):
                shown.extend(data)
        except OSError:  # Linux raises this once the other end is closed
            pass

    reader = threading.Thread(target=read)
    reader.start()
    with pytest.MonkeyPatch.context() as patch, os.fdopen(command_end, "w", encoding="utf-8") as terminal:
        patch.setattr(sys, "stderr", terminal)
        patch.setattr(progress, "DELAY_S", 0)
        code = main(list(arguments))
    reader.join()
    os.close(own_end)
    return code, shown.decode()
