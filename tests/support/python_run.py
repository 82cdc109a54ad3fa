"""Python code in a process of its own."""

import os
import subprocess
import sys
import textwrap

import pytest

linux_only = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="concerns Linux's driver loader and fork")


def run_python(code: str, **environment: str | None) -> subprocess.CompletedProcess[str]:
    """Run code, with warnings as errors; None takes a variable out of its environment."""
    changed = {**os.environ, **environment}
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", textwrap.dedent(code)],
        env={name: value for name, value in changed.items() if value is not None},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def python_output(code: str, **environment: str | None) -> str:
    """Return what code prints; it must succeed, and print nothing on standard error."""
    result = run_python(code, **environment)
    assert (result.returncode, result.stderr) == (0, "")
    return result.stdout
