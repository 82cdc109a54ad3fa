from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gpu_xform import DisplayError, render, samples, save_mesh
from gpu_xform.cli import main
from gpu_xform.cli.parser import parse
from gpu_xform.viewer import window
from tests.support.cli import error_of, read_png


@pytest.fixture(autouse=True)
def _files(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    save_mesh(samples.house(), "house.obj")
    save_mesh(samples.cube(), "cube.obj")
    Path("garbage.obj").write_bytes(b"v 0 0 zero\n")
    Path("points.ply").write_bytes(b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n")


@pytest.fixture
def viewed(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the command would show, once it has run."""
    given: dict[str, Any] = {}

    def view(models: Any, **arguments: Any) -> None:
        given.update(arguments, models=models)

    monkeypatch.setattr(window, "view", view)
    return given


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--color", "face", "--rotate-y", "30", "--up", "+Z"],
        ["--edges", "feature", "--hidden", "dash", "--line-width", "3", "--background-color", "navy"],
        ["--no-background", "--fill", "gold", "--camera-position", "5,4,9", "--camera-orthographic"],
        ["cube.obj", "--scalars", "y"],
    ],
)
def test_what_is_shown_is_what_render_draws(options: list[str], viewed: dict[str, Any]) -> None:
    assert main(["view", "house.obj", *options]) == 0
    size = viewed["size"]
    assert size == (960, 720)
    del viewed["up"]
    shown = render(**viewed)
    assert main(["render", "house.obj", *options, "-o", "house.png", "--resolution", "960,720"]) == 0
    np.testing.assert_array_equal(np.asarray(shown), read_png("house.png"))


def test_turns_are_about_the_up_of_the_model_unless_the_picture_has_one(viewed: dict[str, Any]) -> None:
    assert main(["view", "house.obj", "--up", "+Z"]) == 0
    assert viewed["up"].tolist() == [0, 0, 1]
    assert main(["view", "house.obj", "--camera-view-up", "+Z"]) == 0
    assert viewed["up"] is None


def test_models_are_named_after_their_files(viewed: dict[str, Any]) -> None:
    assert main(["view", "house.obj", "--resolution", "300x200", "cube.obj"]) == 0
    assert [layer.name for layer in viewed["models"]] == ["house", "cube"]
    assert viewed["size"] == (300, 200)


@pytest.mark.parametrize(
    ("command", "usual"), [("render", (1024, 1024)), ("animate", (640, 480)), ("view", (960, 720))]
)
def test_a_size_has_two_names_and_each_command_its_own(command: str, usual: tuple[int, int]) -> None:
    typed = [command, "house.obj", *([] if command == "view" else ["-o", "out"])]
    assert parse(typed).resolution == usual
    assert parse([*typed, "--size", "30x20"]).resolution == (30, 20)
    assert parse([*typed, "--resolution", "30,20"]).resolution == (30, 20)


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        ("view house.obj", "no display: DISPLAY and WAYLAND_DISPLAY are not set; render, or gpu-xform render, draws"),
        ("view missing.obj", "missing.obj: No such file or directory"),
        ("view garbage.obj", "garbage.obj: line 1"),
        ("view points.ply", "points.ply: "),
        ("view", "the following arguments are required: MODEL"),
        ("view house.obj -o out.png", "unrecognized arguments: -o out.png"),
        ("view house.obj --cmap viridis", "--cmap must come with --scalars"),
        ("view house.obj --camera-focal-point 0,0,0", "camera options: "),
        ("view house.obj --resolution 0,5", "argument --resolution: "),
    ],
)
def test_what_is_wrong_is_one_line(typed: str, message: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert error_of(typed.split(), capfd).startswith(f"gpu-xform: error: {message}")


def test_a_window_that_cannot_be_opened_is_wrong_usage(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise DisplayError("no display: why")

    monkeypatch.setattr(window, "view", refuse)
    assert error_of(["view", "house.obj"], capsys) == "gpu-xform: error: no display: why\n"
