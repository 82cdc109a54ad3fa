"""Many models on one command line: into one picture, or each into its own."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from gpu_xform import Camera, Mesh, load_mesh, matrices, render_array, samples, save_mesh
from gpu_xform.cli import files, main
from gpu_xform.errors import DeviceError
from gpu_xform.rendering import raster as wireframe
from tests.support.cli import error_of, list_pngs, read_png, run_in_process
from tests.support.pty_run import run_on_terminal
from tests.support.types import Pixels

SIZE = ("--resolution", "60,40")
PLAIN = (*SIZE, "--line-width", "1.5")  # one picture of many has another style if none is typed
MODELS = {
    "house.obj": samples.house(),
    "cube.off": samples.cube(),
    "solid.ply": samples.snub_dodecahedron(),
    "lines.obj": Mesh([(0, 0, 0), (1, 0, 0), (1, 2, 0)], [(0, 1), (1, 2)]),
}


@pytest.fixture(autouse=True)
def _files() -> None:
    for name, mesh in MODELS.items():
        save_mesh(mesh, name)


def expected_picture(mesh: Mesh | list[Mesh], **arguments: Any) -> Pixels:
    return render_array(mesh, size=(60, 40), **arguments)


def test_each_model_gets_the_picture_it_would_get_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", *MODELS, "-o", "thumbs/small/{model}.png", *PLAIN, "--rotate-y", "20"]) == 0
    assert capsys.readouterr() == ("", "gpu-xform: 4 pictures: 4 done\n")
    assert list_pngs() == sorted(f"thumbs/small/{Path(name).stem}.png" for name in MODELS)
    for name in MODELS:
        alone = expected_picture(load_mesh(name), transform=matrices.rotate_y(20, degrees=True))
        assert np.array_equal(read_png(f"thumbs/small/{Path(name).stem}.png"), alone)


def test_several_models_go_into_one_picture(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "lines.obj", "house.obj", "solid.ply", "-o", "all.png", *SIZE]) == 0
    assert capsys.readouterr() == ("", "")
    meshes = [load_mesh(name) for name in ("lines.obj", "house.obj", "solid.ply")]
    camera = Camera.fit(np.concatenate([mesh.positions for mesh in meshes]))
    together = read_png("all.png")
    darkest = np.min([expected_picture(mesh, camera=camera) for mesh in meshes], axis=0)
    # Where lines of two models meet, both darken the pixel.
    assert (together <= darkest).all()
    assert (together == darkest).mean() > 0.9
    assert ((together < 255) == (darkest < 255)).all()


def test_several_models_are_coloured_by_their_own_faces() -> None:
    assert main(["render", "cube.off", "lines.obj", "-o", "all.png", "--color", "face", *SIZE]) == 0
    assert np.array_equal(read_png("all.png"), expected_picture([samples.cube(), MODELS["lines.obj"]], color="face"))


def test_folders_keep_models_of_one_name_apart(capsys: pytest.CaptureFixture[str]) -> None:
    for name, mesh in (("a", samples.cube()), ("b/c", samples.house())):
        Path(name).mkdir(parents=True)
        save_mesh(mesh, f"{name}/model.obj")
    both = ["render", "a/model.obj", "b/c/model.obj", *PLAIN, "-o"]
    assert main([*both, "t/{model}.png"]) == 2
    expected = "t/model.png: two pictures would be written there, of a/model.obj and of b/c/model.obj; {suffix}, "
    assert capsys.readouterr().err.startswith(f"gpu-xform: error: {expected}")
    assert not Path("t").exists()
    assert main([*both, "t/{folder}/{model}.png"]) == 0
    assert list_pngs() == ["t/a/model.png", "t/b/c/model.png"]
    assert np.array_equal(read_png("t/b/c/model.png"), expected_picture(samples.house()))
    assert main([*both, "{folder}/{model}.png"]) == 0
    assert np.array_equal(read_png("a/model.png"), expected_picture(samples.cube()))


def test_one_path_by_two_names_is_one_path(capsys: pytest.CaptureFixture[str]) -> None:
    Path("a").mkdir()
    message = error_of(["render", "house.obj", "a/../house.obj", "-o", "{folder}/{model}.png"], capsys)
    assert "two pictures would be written" in message
    assert main(["render", "house.obj", "house.obj", "-o", "{model}.png"]) == 2
    assert not list_pngs()


def test_a_bad_model_does_not_stop_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    Path("bad.obj").write_text("v 0 0 zero\n")
    save_mesh(Mesh([(0, 0, 0), (1, 0, 0)], [(1, 1)]), "dot.obj")
    names = ["bad.obj", "house.obj", "none.obj", "dot.obj", "cube.off", "model.xyz"]
    assert main(["render", *names, "-o", "{model}.png", *PLAIN]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    *complaints, summary = printed.err.splitlines()
    assert [line.split(": ")[:3] for line in complaints] == [
        ["gpu-xform", "error", name] for name in ("bad.obj", "none.obj", "dot.obj", "model.xyz")
    ]
    assert complaints[1] == "gpu-xform: error: none.obj: No such file or directory"
    assert summary == "gpu-xform: 6 pictures: 2 done, 4 failed"
    assert list_pngs() == ["cube.png", "house.png"]
    assert np.array_equal(read_png("cube.png"), expected_picture(samples.cube()))
    assert not list(Path().glob(".*"))


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (DeviceError("the device is lost"), 1, "the device is lost"),
        (MemoryError(), 2, "not enough memory"),
        (OSError(28, "No space left on device", "x"), 2, "x: No space left on device"),
    ],
)
def test_whatever_goes_wrong_names_the_model_and_the_worst_decides(
    error: Exception, code: int, words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    render, calls = wireframe.render, []

    def sometimes(*args: Any, **kwargs: Any) -> Image.Image:
        calls.append(1)
        if len(calls) == 1:
            raise error
        return render(*args, **kwargs)

    monkeypatch.setattr(wireframe, "render", sometimes)
    assert main(["render", "house.obj", "none.obj", "cube.off", "-o", "{model}.png", *SIZE]) == code
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == f"gpu-xform: error: house.obj: {words}"
    assert lines[2] == "gpu-xform: 3 pictures: 1 done, 2 failed"
    assert list_pngs() == ["cube.png"]


def test_a_folder_that_cannot_be_made_is_said_before_the_work(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "house.obj", "cube.off", "-o", "solid.ply/{model}.png", *SIZE]) == 2
    assert capsys.readouterr().err == "gpu-xform: error: solid.ply/house.png: Not a directory\n"


def test_a_folder_is_made_for_a_template_only(capsys: pytest.CaptureFixture[str]) -> None:
    assert "none/x.png: No such file" in error_of(["render", "house.obj", "-o", "none/x.png", *SIZE], capsys)
    assert not Path("none").exists()
    assert main(["render", "house.obj", "-o", "none/{model}.png", *SIZE]) == 0
    assert capsys.readouterr().err == ""
    assert list_pngs() == ["none/house.png"]


def test_an_interrupt_keeps_what_is_done(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    read = files.read_mesh

    def interrupted(path: str, file_type: str | None, tolerance: float | None, *pose: None) -> Mesh:
        if path == "solid.ply":
            raise KeyboardInterrupt
        return read(path, file_type, tolerance, *pose)

    monkeypatch.setattr(files, "read_mesh", interrupted)
    assert main(["render", *MODELS, "-o", "{model}.png", *SIZE]) == 130
    assert list_pngs() == ["cube.png", "house.png"]
    assert capsys.readouterr() == ("", "gpu-xform: interrupted\n")


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["-", "-o", "{model}.png", "--file-type", "obj"], "{model}.png: standard input has no name to insert"),
        (["-", "-", "-o", "x.png", "--file-type", "obj"], "standard input can be read only once"),
        (["house.obj", "cube.off", "-o", "{model}.bmp"], "house.bmp: the type must be one of png"),
        (
            ["house.obj", "cube.off", "-o", "{model}"],
            "house: the type must be one of png, svg, pdf, html, htm, got none",
        ),
        (
            ["house.obj", "cube.off", "-o", "x.png", "--reference", "{model}.png"],
            "x.png: two pictures would be written",
        ),
        (["house.obj", "cube.off", "-o", "-", "--reference", "{model}.png"], "-: two pictures would be written"),
        (["house.obj", "none.obj", "-o", "x.png"], "none.obj: No such file"),
        (["house.obj", "cube.off", "-o", "{model}.png", "--camera-focal-point", "1,2,3"], "--camera-focal-point must"),
    ],
)
def test_what_cannot_be_planned_is_one_line(typed: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    message = error_of(["render", *typed], capsys)
    assert words in message
    assert not list_pngs()


@pytest.mark.slow
def test_standard_input_among_others() -> None:
    typed = ["render", "house.obj", "-", "--file-type", "obj", "-o", "-", *SIZE]
    result = run_in_process(*typed, input=Path("lines.obj").read_bytes())
    assert (result.returncode, result.stderr) == (0, b"")
    Path("piped.png").write_bytes(result.stdout)
    assert main(["render", "house.obj", "lines.obj", "-o", "plain.png", *SIZE]) == 0
    assert np.array_equal(read_png("piped.png"), read_png("plain.png"))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of its own")
def test_a_bar_is_shown_on_a_terminal_and_errors_stay_whole_lines() -> None:
    Path("bad.obj").write_text("v 0 0 zero\n")
    code, shown = run_on_terminal("render", "house.obj", "bad.obj", "cube.off", "-o", "{model}.png", *SIZE)
    assert code == 2
    assert "render: " in shown
    assert "pictures/s" in shown
    lines = [line.rpartition("\r")[2] for line in shown.split("\r\n")]
    assert [line for line in lines if line] == [
        "gpu-xform: error: bad.obj: line 1: expected a number, got 'zero'",
        "gpu-xform: 3 pictures: 2 done, 1 failed",
    ]
