"""`gpu-xform explain`: matrices, printed without a device."""

import shlex
import subprocess
import sys

import pytest

from gpu_xform import matrices
from gpu_xform.cli import main


def test_explain_prints_what_the_library_explains(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(shlex.split("explain --scale 0.3 --rotate-z 90 --translate -0.5,2,0 --point -1,1,0")) == 0
    steps = matrices.scale(0.3), matrices.rotate_z(90, degrees=True), matrices.translate(-0.5, 2, 0)
    printed = capsys.readouterr()
    assert printed.out == matrices.explain(*steps, point=(-1, 1, 0)) + "\n"
    assert "[ 0    -0.3  0    -0.5 ]" in printed.out
    assert printed.err == ""


def test_explaining_needs_no_device() -> None:
    code = (
        'import sys; from gpu_xform.cli import main; main(["explain", "--scale", "2"]); sys.exit("wgpu" in sys.modules)'
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=False).returncode == 0
