"""What stands at a path decides how every writer writes there: regular files, links, FIFOs, folders."""

import os
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform._core.atomic_files import atomic_write
from gpu_xform.cli import main
from gpu_xform.errors import ArgumentError
from tests.support.cli import error_of
from tests.support.python_run import linux_only

Write = Callable[[Path], object]

POINTS = np.arange(30.0).reshape(-1, 3)


def plain(path: Path) -> None:
    with atomic_write(path) as file:
        file.write(b"whole")


WRITERS: dict[str, tuple[str, Write]] = {
    "atomic_write": ("x.bin", plain),
    "save_mesh": ("x.obj", lambda path: gx.save_mesh(gx.samples.cube(), path)),
    "transform_file": ("x.npy", lambda path: gx.transform_file("in.npy", path, gx.scale(2))),
    "animate": ("x.gif", lambda path: gx.turntable(gx.samples.cube(), 2, path, size=(16, 16))),
    "video": ("x.webp", lambda path: gx.turntable(gx.samples.cube(), 2, path, size=(16, 16))),
    "transform": ("x.ply", lambda path: main(["transform", "cube.obj", str(path)])),
    "transform an array": ("x.npy", lambda path: main(["transform", "in.npy", str(path)])),
    "convolve": ("x.png", lambda path: main(["convolve", "in.png", str(path), "--box", "3"])),
    "render": ("x.svg", lambda path: main(["render", "cube.obj", "-o", str(path)])),
}


@pytest.fixture(autouse=True)
def _sources(working_folder: Path) -> None:  # noqa: ARG001
    np.save("in.npy", POINTS)
    gx.save_mesh(gx.samples.cube(), "cube.obj")
    gx.render(gx.samples.cube(), size=(16, 16)).save("in.png")


@pytest.mark.parametrize("name", WRITERS)
def test_a_link_stays_and_its_target_is_replaced(name: str) -> None:
    file, write = WRITERS[name]
    Path("elsewhere").mkdir()
    Path("link" + file).symlink_to(Path("elsewhere") / file)  # which does not exist at first
    for _ in range(2):
        write(Path("link" + file))
        assert Path("link" + file).is_symlink()
        assert os.listdir("elsewhere") == [file]  # noqa: PTH208
    assert (Path("elsewhere") / file).stat().st_size


@linux_only
@pytest.mark.parametrize("name", WRITERS)
def test_a_pipe_stays_and_gets_the_whole_file(name: str) -> None:
    file, write = WRITERS[name]
    pipe = Path("pipe" + file)
    os.mkfifo(pipe)
    got: list[bytes] = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    write(pipe)
    reader.join(30)
    write(Path(file))
    assert pipe.is_fifo()
    assert got[0] == Path(file).read_bytes()


@pytest.mark.parametrize("name", WRITERS)
def test_a_folder_is_refused_before_the_work(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file, write = WRITERS[name]
    Path(file).mkdir()

    def work(*_: object, **__: object) -> None:
        raise AssertionError("this is work")

    for module, function in (
        ("compute.streaming", "transform_points"),
        ("rendering.raster", "begin_render"),
        ("cli.files", "read_mesh"),
        ("compute.convolution.convolve", "convolve"),
    ):
        monkeypatch.setattr(f"gpu_xform.{module}.{function}", work)
    if " " in name or name in ("transform", "convolve", "render"):  # commands
        assert write(Path(file)) == 2
        assert f"{file}: Is a directory" in capsys.readouterr().err
    else:
        with pytest.raises(IsADirectoryError, match=file):
            write(Path(file))
    assert list(Path(file).iterdir()) == []


def test_a_stream_is_not_resumed(capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo("x.npy")
    with pytest.raises(ArgumentError, match=r"resume must not be set for a stream, got 'x\.npy'"):
        gx.transform_file("in.npy", "x.npy", gx.scale(2), resume=True)
    assert "resume must not be set" in error_of(["transform", "in.npy", "x.npy", "--resume"], capsys)


@pytest.mark.parametrize(
    "call",
    [
        lambda: gx.save_mesh(gx.samples.cube(), "a\0b.obj"),
        lambda: gx.load_mesh("a\0b.obj"),
        lambda: gx.load_scene("a\0b.glb"),
        lambda: gx.transform_file("a\0b.npy", "x.npy", gx.scale(2)),
        lambda: gx.transform_file("in.npy", "a\0b.npy", gx.scale(2)),
        lambda: gx.turntable(gx.samples.cube(), 2, "a\0b.gif"),
        lambda: gx.render("a\0b.obj"),
    ],
)
def test_a_path_with_a_nul_is_an_argument_error(call: Callable[[], object]) -> None:
    with pytest.raises(ArgumentError, match=r"hold no NUL character, got 'a\\x00b"):
        call()


def test_a_path_that_no_system_writes_is_an_argument_error() -> None:
    """Half of a surrogate pair, as a file name in broken JSON has it."""
    for call in (lambda: gx.load_mesh("\ud800.obj"), lambda: gx.save_mesh(gx.samples.cube(), "\ud800.obj")):
        with pytest.raises(ArgumentError, match="hold characters that the system can write"):
            call()
