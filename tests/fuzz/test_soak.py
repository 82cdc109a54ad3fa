"""A short form of `make soak`, in a process of its own."""

import subprocess
import sys

import pytest

from tests.support.python_run import linux_only


@linux_only
@pytest.mark.slow
def test_nothing_grows() -> None:
    command = [sys.executable, "-m", "tests.fuzz.soak", "--share", "0.01"]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert ran.stdout.count(" GPU objects\n") == 4
