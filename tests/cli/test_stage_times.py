"""What --verbose prints."""

import re
from pathlib import Path

import pytest

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.cli.stage_times import format_size, report_stage

TIME = r", (?:[\d.]+ ms|[\d.]+ s)"


def test_a_picture_tells_of_each_stage(working_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gx.save_mesh(gx.samples.house(), "house.obj")
    assert main(["render", "house.obj", "-o", "house.png", "--resolution", "64,48", "--verbose"]) == 0
    printed = capsys.readouterr()
    assert printed.out == ""
    size = format_size((working_folder / "house.png").stat().st_size)
    expected = [
        "gpu-xform: read house.obj: 10 points, 7 faces",
        rf"gpu-xform: opened: {re.escape(str(gx.default_device()))}",
        "gpu-xform: drew house.png",
        f"gpu-xform: wrote house.png: {size}",
        "gpu-xform: total",
    ]
    lines = printed.err.splitlines()
    assert len(lines) == len(expected)
    assert all(any(re.fullmatch(line + TIME, each) for each in lines) for line in expected), lines


@pytest.mark.parametrize(
    "command",
    [
        "transform house.obj moved.ply --scale 2",
        "transform points.npy moved.npy --scale 2",
        "animate house.obj -o house.webp --frames 2 --resolution 32,32",
        "info house.obj",
    ],
)
def test_other_commands_tell_what_they_do(
    command: str, working_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import numpy as np

    gx.save_mesh(gx.samples.house(), "house.obj")
    np.save("points.npy", np.ones((5, 3)))
    assert main([*command.split(), "-v"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines
    assert all(re.fullmatch(r"gpu-xform: .+" + TIME, line) for line in lines), lines
    assert lines[-1].startswith("gpu-xform: total")
    assert list(working_folder.iterdir())


def test_without_it_nothing_is_told(working_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gx.save_mesh(gx.samples.house(), "house.obj")
    assert main(["render", "house.obj", "-o", "house.png", "--resolution", "64,48"]) == 0
    with report_stage("read"):
        pass
    assert capsys.readouterr().err == ""
    assert working_folder.exists()


@pytest.mark.parametrize(
    ("n_bytes", "text"), [(0, "0 bytes"), (999, "999 bytes"), (1234, "1.23 kB"), (45_600_000, "45.6 MB")]
)
def test_sizes_are_short(n_bytes: int, text: str) -> None:
    assert format_size(n_bytes) == text
