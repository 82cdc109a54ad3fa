"""Patterns in paths, and what is no file."""

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import samples, save_mesh
from gpu_xform.cli import main, paths
from tests.support.cli import error_of, list_pngs

SIZE = ("--resolution", "60,40")


def test_patterns_that_no_shell_has_expanded() -> None:
    Path("in/deep").mkdir(parents=True)
    for name in ("in/b.obj", "in/deep/a.obj", "in/x1.obj", "in/x[1].obj"):
        save_mesh(samples.cube(), name)
    assert paths.expand_globs(["in/*.obj"]) == ["in/b.obj", "in/x1.obj", "in/x[1].obj"]
    assert paths.expand_globs(["in/**/*.obj"]) == ["in/b.obj", "in/deep/a.obj", "in/x1.obj", "in/x[1].obj"]
    assert paths.expand_globs(["in/x[1].obj"]) == ["in/x[1].obj"]
    assert paths.expand_globs(["in/x[12].obj"]) == ["in/x1.obj"]
    assert paths.expand_globs(["in/*.wrl"]) == ["in/*.wrl"]
    assert paths.expand_globs(["-"]) == ["-"]
    assert main(["render", "in/*.obj", "-o", "{model}.png", *SIZE]) == 0
    assert list_pngs() == ["b.png", "x1.png", "x[1].png"]


KINDS = ["glb", "gltf", "npy", "obj", "off", "ply", "stl"]


def feed(pipe: Path, data: bytes) -> threading.Thread:
    """Make a FIFO, and write data into it once it is opened, as `<(zcat model.gz)` does."""
    os.mkfifo(pipe)
    thread = threading.Thread(target=pipe.write_bytes, args=(data,), daemon=True)
    thread.start()
    return thread


@pytest.mark.skipif(sys.platform == "win32", reason="it has no FIFOs")
@pytest.mark.parametrize("kind", KINDS)
def test_a_model_may_come_through_a_fifo(kind: str, working_folder: Path) -> None:
    model = gx.Mesh(np.eye(3)) if kind == "npy" else gx.samples.icosphere(1)
    gx.save_mesh(model, f"whole.{kind}")
    whole = gx.load_mesh(f"whole.{kind}")
    for command in (f"transform pipe.{kind} out.{kind} --scale 2", f"render pipe.{kind} -o out.svg"):
        thread = feed(working_folder / f"pipe.{kind}", Path(f"whole.{kind}").read_bytes())
        with time_limit(30):  # it was opened twice, of which the second waits for ever
            assert main(command.split()) == 0
        thread.join(30)
        Path(f"pipe.{kind}").unlink()
    np.testing.assert_allclose(gx.load_mesh(f"out.{kind}").positions, 2.0 * whole.positions, rtol=1e-6)


@pytest.mark.skipif(sys.platform == "win32", reason="it has no FIFOs")
@pytest.mark.parametrize(
    ("command", "words"),
    [("info {}", "not through a pipe"), ("transform {} out.las", "source must be a file for this type, got")],
)
def test_what_must_seek_says_so_of_a_fifo(
    command: str, words: str, working_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    os.mkfifo(working_folder / "pipe.las")  # which nobody feeds
    with time_limit(30):
        message = error_of(command.format("pipe.las").split(), capsys)
    assert "pipe.las" in message
    assert words in message


@contextlib.contextmanager
def time_limit(seconds: int) -> Iterator[None]:
    """Raise TimeoutError in what waits longer."""

    def stop(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
