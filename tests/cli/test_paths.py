"""Patterns in paths, and what is no file."""

import contextlib
import gzip
import os
import re
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import samples, save_mesh
from gpu_xform.cli import main, paths
from tests.fuzz.seeds import list_seeds
from tests.support import step_files
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


def write_seed(kind: str, folder: Path) -> bytes:
    """Return a model of a type that is not written here."""
    if kind == "urdf":
        return (
            b'<robot name="r"><link name="l"><visual><geometry><box size="1 2 3"/></geometry></visual></link></robot>'
        )
    if kind == "step":
        return step_files.write_box(1, 2, 3)
    if kind == "wrz":
        return gzip.compress(write_seed("wrl", folder))
    return next(seed.data for seed in list_seeds(folder) if seed.kind == kind)


@pytest.mark.skipif(sys.platform == "win32", reason="it has no FIFOs")
@pytest.mark.parametrize("kind", ["3mf", "dae", "las", "laz", "step", "urdf", "wrl", "wrz"])
def test_formats_that_are_only_read_come_through_a_fifo_and_a_pipe_of_a_shell(
    kind: str, working_folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    data = write_seed(kind, tmp_path_factory.mktemp("seeds"))
    Path(f"whole.{kind}").write_bytes(data)
    assert main(["render", f"whole.{kind}", "-o", "whole.svg"]) == 0
    commands = ["render {} -o out.svg", "info {}", "transform {} out.ply --scale 2"]
    for command in commands[:1] if kind in ("las", "laz") else commands:  # the others must seek in a scan
        thread = feed(working_folder / f"pipe.{kind}", data)
        with time_limit(30):
            assert main(command.format(f"pipe.{kind}").split()) == 0
        thread.join(30)
        Path(f"pipe.{kind}").unlink()
        read, write = os.pipe()  # as `<(zcat model.gz)`, which a shell calls so
        thread = threading.Thread(target=write_all, args=(write, data), daemon=True)
        thread.start()
        with time_limit(30):
            assert main([*command.format(f"/dev/fd/{read}").split(), "--file-type", kind]) == 0
        os.close(read)
        thread.join(30)
        drawn, expected = (Path(f"{name}.svg").read_text() for name in ("out", "whole"))
        of_name = re.compile('<title>.*</title>|<g id=".*">')
        assert of_name.sub("", drawn) == of_name.sub("", expected)


def write_all(descriptor: int, data: bytes) -> None:
    with os.fdopen(descriptor, "wb") as file:
        file.write(data)


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


@pytest.mark.parametrize(("flags", "reason"), [(0, "Permission denied"), (os.ST_RDONLY, "Read-only file system")])
def test_where_nothing_can_be_written_the_reason_is_told_before_the_work(
    flags: int, reason: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    save_mesh(samples.cube(), "cube.obj")
    monkeypatch.setattr(os, "access", lambda *_: False)
    monkeypatch.setattr(os, "statvfs", lambda _: SimpleNamespace(f_flag=flags))
    Path("old.png").touch()
    for typed, path in ((["-o", "old.png"], "old.png"), (["-o", "new.png", "--report", "new.html"], "new.html")):
        assert main(["render", "cube.obj", *typed]) == 2
        assert capsys.readouterr().err == f"gpu-xform: error: {path}: {reason}\n"
