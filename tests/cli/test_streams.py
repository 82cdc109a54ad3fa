"""Standard output: encodings, closed pipes, interrupts."""

import contextlib
import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest

from gpu_xform import matrices, samples, save_mesh
from gpu_xform.cli import main, streams

POINTS = np.array([[1.0, 2, 3], [-4, 5, -6], [0.125, 0, 7], [1e6, -1e-6, 3], [0, 0, 0]])


@pytest.fixture(autouse=True)
def _files() -> None:
    save_mesh(samples.house(), "house.obj")
    np.save("points.npy", POINTS)


def test_printing_survives_an_encoding_without_the_letters(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", stream)
    streams.print_stdout("Radeon\u2122\n")
    assert stream.buffer.getvalue() == b"Radeon\\u2122\n"


@pytest.mark.slow
@pytest.mark.parametrize("typed", [["explain", "--scale", "2"], ["--help"], ["transform", "points.npy", "-"]])
def test_a_closed_pipe_ends_quietly(typed: list[str]) -> None:
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "wb") as closed:
        result = subprocess.run(
            [sys.executable, "-m", "gpu_xform", *typed],
            stdout=closed,
            stderr=subprocess.PIPE,
            check=False,
            env=buffered,
            timeout=60,
        )
    assert (result.returncode, result.stderr) == (141, b"")


def open_for(process: subprocess.Popen[bytes], pipe: Path, seconds: float = 60.0) -> BinaryIO:
    """Open a named pipe to write as soon as a process has opened it to read; fail if it does not."""
    end_s = time.monotonic() + seconds
    while process.poll() is None and time.monotonic() < end_s:
        with contextlib.suppress(OSError):  # nobody reads it: without O_NONBLOCK, that would be waited for without end
            return os.fdopen(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK), "wb")
        time.sleep(0.01)
    process.kill()
    pytest.fail(f"the command ended or waited before it opened {pipe}: {process.communicate()}")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a named pipe")
def test_a_command_that_does_not_start_is_not_waited_for() -> None:
    os.mkfifo("pipe.obj")
    with subprocess.Popen([sys.executable, "-c", "raise SystemExit(3)"], stderr=subprocess.PIPE) as process:
        with pytest.raises(pytest.fail.Exception, match=r"before it opened pipe\.obj"):
            open_for(process, Path("pipe.obj"))
        assert process.returncode == 3


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a named pipe")
@pytest.mark.parametrize(
    "command",
    ["transform pipe.obj out.obj", "transform pipe.npy out.npy", "info pipe.step", "render pipe.laz -o out.svg"],
)
def test_an_interrupt_ends_in_one_line(command: str) -> None:
    pipe = Path(command.split()[1])
    os.mkfifo(pipe)
    before = sorted(Path().iterdir())
    process = subprocess.Popen([sys.executable, "-m", "gpu_xform", *command.split()], stderr=subprocess.PIPE)
    with open_for(process, pipe):  # so that the command waits for what is in it
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=20)
    assert (process.returncode, complaint) == (130, b"gpu-xform: interrupted\n")
    assert sorted(Path().iterdir()) == before


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a named pipe")
def test_an_interrupt_ends_the_wait_for_who_opens_a_fifo() -> None:
    os.mkfifo("pipe.wrl")  # which nobody does
    process = subprocess.Popen(
        [sys.executable, "-m", "gpu_xform", "info", "pipe.wrl", "--isolated"], stderr=subprocess.PIPE
    )
    place, end_s = Path(f"/proc/{process.pid}/wchan"), time.monotonic() + 3
    while time.monotonic() < end_s and not (place.exists() and "wait_for_partner" in place.read_text()):
        time.sleep(0.05)  # until it waits there, where the system says so
    process.send_signal(signal.SIGINT)
    _, complaint = process.communicate(timeout=20)
    assert (process.returncode, complaint) == (130, b"gpu-xform: interrupted\n")


def test_an_interrupt_inside_any_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(matrices, "explain", interrupted)
    assert main(["explain", "--scale", "2"]) == 130
    assert capsys.readouterr() == ("", "gpu-xform: interrupted\n")


def test_a_file_that_is_not_read_whole_is_named_in_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    save_mesh(samples.cube(), "cube.stl")
    with Path("cube.stl").open("ab") as file:
        file.write(b"more")
    assert main(["transform", "cube.stl", "moved.stl", "--scale", "2"]) == 0
    assert capfd.readouterr().err == "gpu-xform: warning: cube.stl: 4 bytes behind its 12 triangles are left out\n"
