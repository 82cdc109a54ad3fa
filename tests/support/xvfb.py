"""Xvfb: an X server without a monitor, for tests of windows."""

import os
import shutil
import subprocess
import time
from collections.abc import Callable
from types import TracebackType

import numpy as np
import numpy.typing as npt
import pytest
from PIL import ImageGrab

from gpu_xform.gpu.drivers import find_instance_extensions
from gpu_xform.viewer.window import X11_EXTENSION

SIZE = (800, 600)


def require_windows() -> None:
    """Skip a test that draws into windows if the driver does not, as SwiftShader of Debian's Chromium."""
    extensions = find_instance_extensions()
    if extensions is not None and X11_EXTENSION not in extensions:
        pytest.skip(f"no driver here has {X11_EXTENSION}, to draw into windows of X11")


class Screen:
    """A screen of 800 x 600 pixels that no other program uses, closed at the end of a `with` block.

    display : the value of DISPLAY for programs that open windows on it
    """

    def __init__(self) -> None:
        server, self._xdotool = (_find_program(program) for program in ("Xvfb", "xdotool"))
        reading, writing = os.pipe()
        width, height = SIZE
        command = [
            server,
            "-displayfd",
            str(writing),
            "-screen",
            "0",
            f"{width}x{height}x24",
            "-nolisten",
            "tcp",
            "-noreset",
        ]
        self._server = subprocess.Popen(command, pass_fds=[writing], stderr=subprocess.DEVNULL)
        os.close(writing)
        with os.fdopen(reading) as ready:
            self.display = f":{int(ready.readline())}"

    def screenshot(self) -> npt.NDArray[np.uint8]:
        """Return the pixels of the screen (600, 800, 3)."""
        return np.asarray(ImageGrab.grab(xdisplay=self.display).convert("RGB"))

    def xdotool(self, *arguments: str) -> str:
        """Run xdotool, which presses keys and moves the mouse; return its output."""
        environment = {**os.environ, "DISPLAY": self.display}
        done = subprocess.run(
            [self._xdotool, *arguments], env=environment, capture_output=True, text=True, timeout=60, check=True
        )
        return done.stdout

    def wait_for(self, condition: Callable[[], bool], seconds: float = 60.0) -> None:
        """Wait until `condition` holds; raise `TimeoutError` if it does not."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"after {seconds:g} s the screen still does not show what it should")
            time.sleep(0.05)

    def __enter__(self) -> "Screen":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._server.terminate()
        self._server.wait()


def _find_program(program: str) -> str:
    path = shutil.which(program)
    if path is None:
        raise RuntimeError(f"{program} is not installed: 'make screen' installs it, or says what to do")
    return path
