import inspect
import io
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from gpu_xform import Camera, Mesh, matrices, render_array, samples, save_mesh
from gpu_xform.cli import main, option_groups
from gpu_xform.colors import FACE_CYCLE
from gpu_xform.gpu.device import Device

Pixels = npt.NDArray[np.uint8]
SIZE = ("--resolution", "120,80")


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    save_mesh(samples.house(), "house.obj")


def drawn(*options: str, model: str = "house.obj") -> Pixels:
    assert main(["render", model, "-o", "out.png", *options]) == 0
    with Image.open("out.png") as image:
        assert (image.format, image.mode) == ("PNG", "RGBA")
        return np.asarray(image)


def expected(**arguments: Any) -> Pixels:
    return render_array(samples.house(), size=(120, 80), **arguments)


def test_the_corners_of_the_model_are_lit_and_the_frame_is_not() -> None:
    pixels = drawn("--resolution", "200,150", "--camera-position", "3,4,9", "--line-width", "3")
    assert pixels.shape == (150, 200, 4)
    # By hand: the view's axes, the distance along it, 15 degrees to the picture's upper edge.
    eye = np.array([3.0, 4.0, 9.0])
    forward = -eye / np.linalg.norm(eye)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    away = samples.house().positions - eye
    half_height = (away @ forward) * np.tan(np.radians(15))
    x = 100 + 75 * (away @ right) / half_height
    y = 75 - 75 * (away @ up) / half_height
    assert x.min() > 2
    assert x.max() < 198
    assert (pixels[y.astype(int), x.astype(int), :3] < 32).all()
    assert (pixels[[0, 0, -1, -1], [0, -1, 0, -1]] == 255).all()


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ([], {}),
        (
            ["--rotate-y", "-30", "--scale", "1,2,1"],
            {"transform": matrices.scale(1, 2, 1) @ matrices.rotate_y(-np.pi / 6)},
        ),
        (["--perspective-from-eye", "3"], {"transform": matrices.perspective_from_eye(3)}),
        (["--line-width", "7.5"], {"line_width": 7.5}),
        (["--color", "face"], {"color": "face"}),
        (["--color", "tomato"], {"color": "tomato"}),
        (["--color", "1,0.5,0"], {"color": (1, 0.5, 0)}),
        (["--background-color", "#123456"], {"background": "#123456"}),
        (["--no-background"], {"background": None}),
        (["--camera-direction", "-Z"], {"camera": Camera.fit(samples.house(), direction=(0, 0, -1))}),
        (
            ["--camera-direction=0,-1,0", "--camera-view-up", "-Z", "--camera-orthographic"],
            {"camera": Camera.fit(samples.house(), direction=(0, -1, 0), up=(0, 0, -1), orthographic=True)},
        ),
        (["--camera-view-angle", "60"], {"camera": Camera.fit(samples.house(), fov_y=60)}),
        (
            ["--camera-position", "-3,4,5", "--camera-focal-point", "-1,0,.5", "--camera-view-angle", "50"],
            {"camera": Camera.look_at((-3, 4, 5), (-1, 0, 0.5), fov_y=50)},
        ),
        (
            ["--translate", "1,2,3", "--camera-position", "9,9,9"],
            {"transform": matrices.translate(1, 2, 3), "camera": Camera.look_at((9, 9, 9), (1, 2, 3))},
        ),
        (
            ["--camera-position", "-3,4,5", "--camera-orthographic", "--up", "x"],
            {"camera": Camera.look_at((-3, 4, 5), (0, 0, 0), (1, 0, 0), orthographic=True)},
        ),
    ],
)
def test_options_are_the_library_s_arguments(options: list[str], arguments: dict[str, Any]) -> None:
    pixels = drawn(*SIZE, *options)
    assert np.array_equal(pixels, expected(**arguments))
    assert not options or not np.array_equal(pixels, expected())


def test_no_background_is_transparent_between_the_lines() -> None:
    alpha = drawn(*SIZE, "--no-background")[..., 3]
    assert (alpha[[0, 0, -1, -1], [0, -1, 0, -1]] == 0).all()
    assert alpha.max() == 255


def test_one_color_for_each_face() -> None:
    pixels = drawn("--resolution", "300x300", "--color", "face", "--line-width", "4")
    colors = {"#" + bytes(color).hex() for color in pixels[..., :3].reshape(-1, 3)}
    # Later faces cover the edges they share with earlier ones: the two gables come first, and have none left.
    assert [cycled in colors for cycled in FACE_CYCLE] == 2 * [False] + 5 * [True] + 3 * [False]


@pytest.mark.parametrize("typed", ["30,20", "30x20", "30X20", " 30 , 20 "])
def test_a_resolution_is_width_and_height(typed: str) -> None:
    assert drawn("--resolution", typed).shape == (20, 30, 4)


def test_the_default_picture_is_1024_square_and_black_on_white() -> None:
    pixels = drawn()
    assert np.array_equal(pixels, render_array(samples.house()))
    assert pixels.shape == (1024, 1024, 4)


@pytest.mark.parametrize(
    ("up", "world_from_upright"),
    [
        ("+Z", matrices.rotate_x(90, degrees=True)),
        ("-Z", matrices.rotate_x(-90, degrees=True)),
        ("x", matrices.rotate_z(-90, degrees=True)),
        ("-X", matrices.rotate_z(90, degrees=True)),
        ("-y", matrices.rotate_x(180, degrees=True)),
        ("0,3e5,3e5", matrices.rotate_x(45, degrees=True)),
    ],
)
def test_a_model_with_another_up_looks_the_same(up: str, world_from_upright: npt.NDArray[np.float64]) -> None:
    save_mesh(samples.house().transformed(world_from_upright), "lying.obj")
    difference = np.abs(drawn(*SIZE, "--up", up, model="lying.obj").astype(int) - expected())
    assert difference.max() <= 2
    assert np.abs(drawn(*SIZE, model="lying.obj").astype(int) - expected()).max() > 200


def test_standard_output_holds_the_picture_and_nothing_else(capsysbinary: pytest.CaptureFixture[bytes]) -> None:
    typed = [sys.executable, "-m", "gpu_xform", "render", "-", "--file-type", "OBJ", "-o", "-", *SIZE]
    result = subprocess.run(typed, input=Path("house.obj").read_bytes(), capture_output=True, check=False)
    assert (result.returncode, result.stderr) == (0, b"")
    with Image.open(io.BytesIO(result.stdout)) as image:
        assert np.array_equal(np.asarray(image), expected())
    assert result.stdout.endswith(b"IEND\xaeB`\x82")
    assert main(["render", "house.obj", "-o", "-", *SIZE]) == 0
    assert capsysbinary.readouterr() == (result.stdout, b"")
    assert list(Path().iterdir()) == [Path("house.obj")]


def test_a_part_of_the_adapter_s_name_picks_it(device: Device) -> None:
    assert np.array_equal(drawn(*SIZE, "--adapter", device.name[1:5].upper()), expected())


def test_an_older_picture_is_replaced() -> None:
    Path("out.png").write_bytes(b"older")
    Path("OTHER.PNG").write_bytes(b"older")
    drawn(*SIZE)
    assert main(["render", "house.obj", "-o", "OTHER.PNG", *SIZE]) == 0
    assert Path("OTHER.PNG").read_bytes() == Path("out.png").read_bytes()
    assert len(list(Path().iterdir())) == 3


def test_a_type_may_be_said_for_a_name_that_does_not_say_it() -> None:
    Path("house.obj").rename("house.txt")
    assert np.array_equal(drawn(*SIZE, "--file-type", ".obj", model="house.txt"), expected())


def test_points_behind_a_projection_s_eye_are_not_framed() -> None:
    save_mesh(Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 50)], [(0, 1, 2)]), "point.obj")
    options = [*SIZE, "--perspective-from-eye", "5", "--camera-direction", "-Z"]
    triangle = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    camera = Camera.fit(triangle, direction=(0, 0, -1))
    assert np.array_equal(drawn(*options, model="point.obj"), render_array(triangle, size=(120, 80), camera=camera))


def test_edges_are_chosen_by_name() -> None:
    house = samples.house()
    split = Mesh(house.positions, house.to_trimesh().faces)
    save_mesh(split, "split.obj")
    assert np.array_equal(drawn("--edges", "feature", model="split.obj"), drawn())
    assert not np.array_equal(drawn(model="split.obj"), drawn())
    # The walls stand at right angles; nothing else turns as far.
    sharp, some = drawn("--edges", "feature", "--feature-angle", "89", model="split.obj"), drawn()
    assert (sharp != some).any()
    assert ((sharp == some) | (sharp == 255)).mean() > 0.98
    save_mesh(samples.grid(3), "grid.obj")
    rim = drawn("--edges", "boundary", model="grid.obj")
    assert np.array_equal(drawn("--edges", "boundary,feature", model="grid.obj"), rim)
    assert not np.array_equal(drawn(model="grid.obj"), rim)


@pytest.mark.parametrize("options", [["--edges", "creases"], ["--feature-angle", "181"], ["--feature-angle", "x"]])
def test_edges_that_are_none_are_refused(options: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "house.obj", "-o", "out.png", *options]) == 2
    assert options[0] in capsys.readouterr().err
    assert not Path("out.png").exists()


def test_the_help_names_the_library_s_defaults() -> None:
    defaults = {name: parameter.default for name, parameter in inspect.signature(render_array).parameters.items()}
    said = {flag: re.search(r"\(default: (.*)\)", text) for flag, _, _, text in option_groups.STYLE}
    for flag, default in said.items():
        value = defaults[flag.removeprefix("--").replace("-", "_")]
        assert default is not None
        assert default[1] == ("all" if flag == "--edges" else f"{value:g}" if isinstance(value, float) else value)
