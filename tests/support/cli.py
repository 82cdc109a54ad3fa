"""The command `gpu-xform`: run in this process or in one of its own, and the pictures that it writes."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from gpu_xform.cli import main
from tests.support.types import Pixels


def run_in_process(*arguments: str, **options: Any) -> "subprocess.CompletedProcess[bytes]":
    """Run a command in a process of its own, with the options of `subprocess.run`."""
    return subprocess.run([sys.executable, "-m", "gpu_xform", *arguments], capture_output=True, check=False, **options)


def error_of(arguments: list[str], capture: pytest.CaptureFixture[str], code: int = 2) -> str:
    """Run a command that must fail with an exit code; return what it prints, one line on standard error."""
    assert main(arguments) == code
    printed = capture.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("gpu-xform: error: ")
    assert printed.err.endswith("\n")
    assert printed.err.count("\n") == 1
    assert "Traceback" not in printed.err
    return printed.err


def read_png(path: str) -> Pixels:
    """Return the pixels of a picture that a command wrote (height, width, 4)."""
    with Image.open(path) as image:
        assert (image.format, image.mode) == ("PNG", "RGBA")
        return np.asarray(image)


def list_pngs() -> list[str]:
    """Return the paths of all PNG files under the working folder, sorted."""
    return sorted(path.as_posix() for path in Path().rglob("*.png"))
