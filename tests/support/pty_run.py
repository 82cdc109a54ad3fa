"""A terminal of its own for a command."""

import os
import subprocess
import sys


def on_a_terminal(*typed: str, columns: int = 80, rows: int = 24) -> tuple[int, str]:
    """Return the exit code of a command, and what it shows on a terminal so wide; bars are shown at once."""
    import fcntl
    import pty
    import struct
    import termios

    here, there = pty.openpty()
    fcntl.ioctl(there, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    program = "import sys, gpu_xform.cli; sys.exit(gpu_xform.cli.main())"
    at_once = f"from gpu_xform._core import progress; progress.APPEARS_AFTER_S = 0; {program}"
    with subprocess.Popen([sys.executable, "-c", at_once, *typed], stderr=there, stdout=subprocess.PIPE) as process:
        os.close(there)
        shown = bytearray()
        try:
            while data := os.read(here, 4096):
                shown += data
        except OSError:  # how Linux says that the other end is closed
            pass
    os.close(here)
    return process.returncode, shown.decode()
