"""`gpu-xform transform` from .npy to .npy: arrays of any size, interrupted and resumed."""

import errno
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.chunked.partial_files import FileSink
from gpu_xform.cli import main
from gpu_xform.cli.commands import transform as commands
from gpu_xform.compute import streaming
from tests.support.cli import error_of, run_in_process
from tests.support.reference_transform import some_points

STEPS = ["--scale", "0.3", "--rotate-z", "90", "--translate", "-0.5,2,0"]

MATRIX = gx.chain(gx.scale(0.3), gx.rotate_z(90, degrees=True), gx.translate(-0.5, 2, 0))


@pytest.fixture(autouse=True)
def _small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 1200)


@pytest.mark.parametrize("dtype", ["<f4", pytest.param(">f8", marks=pytest.mark.float64)])
@pytest.mark.parametrize("columns", [2, 3])
def test_an_array_is_streamed(dtype: str, columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    points = some_points(950, dtype, columns)
    np.save("in.npy", points)
    monkeypatch.setattr(commands, "_transform_whole_array", None)
    assert main(["transform", "in.npy", "out.npy", *STEPS]) == 0
    matrix = MATRIX if columns == 3 else MATRIX[np.ix_([0, 1, 3], [0, 1, 3])]
    assert np.array_equal(np.load("out.npy"), gx.transform_points(points, matrix))


@pytest.mark.parametrize(
    "array",
    [np.asfortranarray(some_points(9, np.float64)), np.arange(12).reshape(4, 3), np.ones((2, 5, 3), np.float32)],
)
def test_what_cannot_be_streamed_is_taken_whole(array: Any, capsys: pytest.CaptureFixture[str]) -> None:
    np.save("in.npy", array)
    assert main(["transform", "in.npy", "out.npy", *STEPS]) == 0
    assert np.array_equal(np.load("out.npy"), gx.transform_points(array, MATRIX))
    assert "--resume needs an .npy file" in error_of(["transform", "in.npy", "out.npy", "--resume"], capsys)


def test_an_interrupted_run_is_resumed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    points = some_points(950, np.float32)
    np.save("in.npy", points)
    told: list[int] = []
    stop = [300]

    def transform_file(*args: Any, progress: Any, **kwargs: Any) -> None:
        def watched(done: int, whole: int) -> None:
            told.append(done)
            progress(done, whole)
            if done in stop:
                raise KeyboardInterrupt

        streaming_function(*args, progress=watched, **kwargs)

    streaming_function = streaming.transform_file
    monkeypatch.setattr(streaming, "transform_file", transform_file)
    assert main(["transform", "in.npy", "out.npy", *STEPS]) == 130
    assert capsys.readouterr().err == "gpu-xform: interrupted; the same command with --resume continues\n"
    assert not Path("out.npy").exists()
    stop.clear()
    assert main(["transform", "in.npy", "out.npy", *STEPS, "--resume"]) == 0
    assert told == [100, 200, 300, 400, 500, 600, 700, 800, 900, 950]
    assert np.array_equal(np.load("out.npy"), gx.transform_points(points, MATRIX))


@pytest.mark.parametrize(("chunks", "hint"), [(2, "; the same command with --resume continues"), (0, "")])
def test_a_full_disk_says_how_to_go_on(
    chunks: int, hint: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save("in.npy", some_points(950, np.float32))
    append = FileSink.append

    def fill(sink: FileSink, part: Any) -> None:
        if part.start >= 100 * chunks:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "out.npy")
        append(sink, part)

    monkeypatch.setattr(FileSink, "append", fill)
    line = error_of(["transform", "in.npy", "out.npy", *STEPS], capsys)
    assert line == f"gpu-xform: error: out.npy: No space left on device{hint}\n"
    assert Path("out.npy.partial").exists() == bool(hint)


def test_errors_about_scans_name_the_options(capsys: pytest.CaptureFixture[str]) -> None:
    np.save("in.npy", np.ones((9, 3)))
    message = error_of(["transform", "in.npy", "out.npy", "--las-scale", "1"], capsys)
    assert message == "gpu-xform: error: --las-scale: scale is for .las and .laz files, got 'out.npy'\n"
    message = error_of(["transform", "in.npy", "out.npy", "--las-offset", "1,2,3"], capsys)
    assert message == "gpu-xform: error: --las-offset: offset is for .las and .laz files, got 'out.npy'\n"
    Path("out.npy.partial").write_bytes(bytes(999))
    Path("out.npy.partial.work").write_text("another\n")
    message = error_of(["transform", "in.npy", "out.npy", "--resume"], capsys)
    partial = str(Path("out.npy.partial").absolute())
    assert message.startswith(f"gpu-xform: error: --resume: {partial!r} belongs to other work, or was computed")


@pytest.mark.parametrize("output", ["out.npy", "out.zarr"])
def test_what_stands_in_the_place_of_the_unfinished_result_is_named(
    output: str, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save("in.npy", np.ones((9, 3)))
    place = Path(f"{output}.partial").absolute()
    if output == "out.npy":
        place.mkdir()
    else:
        place.write_bytes(b"a file")
    message = error_of(["transform", "in.npy", output], capsys)
    reason = "Is a directory" if output == "out.npy" else "Not a directory"
    assert message == f"gpu-xform: error: {place}: {reason}\n"
    assert place.exists()


def test_models_are_not_resumed(capsys: pytest.CaptureFixture[str]) -> None:
    gx.save_mesh(gx.samples.cube(), "cube.obj")
    assert "--resume is for .npy files" in error_of(["transform", "cube.obj", "out.obj", "--resume"], capsys)


@pytest.mark.slow
def test_no_bar_is_shown_where_there_is_no_terminal() -> None:
    np.save("in.npy", some_points(950, np.float32))
    run = run_in_process("transform", "in.npy", "out.npy")
    assert (run.returncode, run.stdout, run.stderr) == (0, b"", b"")


@pytest.mark.parametrize("by_variable", [False, True])
@pytest.mark.usefixtures("working_folder")
def test_the_host_transforms_without_a_driver(by_variable: bool) -> None:
    points = some_points(9_000, "float32")
    np.save("in.npy", points)
    gx.save_mesh(gx.samples.house(), "house.obj")
    environment = {"VK_DRIVER_FILES": "/nonexistent", "VK_ICD_FILENAMES": "/nonexistent"}
    if by_variable:
        environment["GPU_XFORM_ADAPTER"] = "host"
    chosen = [] if by_variable else ["--adapter", "host"]
    for names in (["in.npy", "out.npy"], ["house.obj", "moved.obj"]):
        run = run_in_process("transform", *names, "--translate", "1,2,3", *chosen, env=os.environ | environment)
        assert (run.returncode, run.stderr) == (0, b"")
    host, move = gx.Device("host"), gx.translate(1, 2, 3)
    assert np.load("out.npy").tobytes() == gx.transform_points(points, move, device=host).tobytes()
    assert np.array_equal(gx.load_mesh("moved.obj").positions, np.add(gx.samples.house().positions, [1, 2, 3]))
    run = run_in_process("render", "house.obj", "-o", "house.png", *chosen, env=os.environ | environment)
    source = "GPU_XFORM_ADAPTER" if by_variable else "--adapter"
    words = "the host device draws no pictures: that takes a graphics adapter"
    assert (run.returncode, run.stderr.decode()) == (2, f"gpu-xform: error: {source}: {words}\n")
    assert not Path("house.png").exists()
