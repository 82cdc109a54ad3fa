"""Commands run on a pseudo-terminal of their own."""

import os
import subprocess
import sys


def run_on_terminal(*arguments: str, columns: int = 80, rows: int = 24) -> tuple[int, str]:
    """Run the command on a terminal of a size, progress bars at once; return the exit code and the text shown."""
    import fcntl
    import pty
    import struct
    import termios

    own_end, command_end = pty.openpty()
    fcntl.ioctl(command_end, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    program = "import sys, gpu_xform.cli; sys.exit(gpu_xform.cli.main())"
    at_once = f"from gpu_xform._core import progress; progress.DELAY_S = 0; {program}"
    command = [sys.executable, "-c", at_once, *arguments]
    with subprocess.Popen(command, stderr=command_end, stdout=subprocess.PIPE) as process:
        os.close(command_end)
        shown = bytearray()
        try:
            while data := os.read(own_end, 4096):
                shown += data
        except OSError:  # Linux raises this once the other end is closed
            pass
    os.close(own_end)
    return process.returncode, shown.decode()
