import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from gpu_xform import Camera, Layer, animate, load_scene, matrices, samples, save_mesh, turntable
from gpu_xform.cli import main
from tests.formats.test_gltf_animations import animated
from tests.support.cli import error_of, run_in_process
from tests.support.pty_run import run_on_terminal
from tests.support.types import Pixels

SMALL = ("--resolution", "60,40", "--frames", "4")
HOUSE = samples.house()


@pytest.fixture(autouse=True)
def _files() -> None:
    save_mesh(HOUSE, "house.obj")


def read_frames(path: str = "out.webp") -> list[Pixels]:
    frames = []
    with Image.open(path) as image:
        for k in range(getattr(image, "n_frames", 1)):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGBA"), np.uint8))
    return frames


def run_animate(*options: str) -> list[Pixels]:
    assert main(["animate", "house.obj", "-o", "out.webp", *SMALL, *options]) == 0
    return read_frames()


def expected(**arguments: Any) -> list[Pixels]:
    return [np.asarray(frame, np.uint8) for frame in turntable(HOUSE, 4, size=(60, 40), **arguments)]


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ([], {}),
        (["--turntable"], {}),
        (["--axis", "z"], {"axis": "z"}),
        (["--axis", "-1,2,0.5"], {"axis": (-1, 2, 0.5)}),
        (
            ["--rotate-x", "20", "--scale", "1,2,1"],
            {"transform": matrices.chain(matrices.rotate_x(20, degrees=True), matrices.scale(1, 2, 1))},
        ),
        (["--color", "face", "--line-width", "3"], {"color": "face", "line_width": 3}),
        (["--edges", "boundary,feature", "--no-antialias"], {"edges": ["boundary", "feature"], "antialias": False}),
        (["--background-color", "#123456"], {"background": "#123456"}),
        (["--no-background"], {"background": None}),
        (["--camera-direction", "-Z"], {"camera": {"direction": (0, 0, -1)}}),
        (
            ["--camera-direction=0,-1,0", "--camera-view-up", "-Z", "--camera-orthographic"],
            {"camera": {"direction": (0, -1, 0), "up": (0, 0, -1), "orthographic": True}, "axis": "y"},
        ),
        (["--camera-view-angle", "60"], {"camera": {"fov_y": 60}}),
        (["--camera-position", "3,4,9", "--translate", "0,1,0"], None),
    ],
    ids=str,
)
def test_options_are_the_library_s_arguments(options: list[str], arguments: dict[str, Any] | None) -> None:
    if arguments is None:
        moved = matrices.translate(0, 1, 0)
        arguments = {"camera": Camera.look_at((3, 4, 9), (0, 1, 0)), "transform": moved}
    frames = run_animate(*options)
    assert np.array_equal(frames, expected(**arguments))
    assert options in ([], ["--turntable"]) or not np.array_equal(frames, expected())


def test_several_models_turn_together_about_their_common_middle() -> None:
    save_mesh(samples.cube().transformed(matrices.translate(4, 0, 0)), "cube.off")
    assert main(["animate", "house.obj", "--color", "red", "cube.off", "-o", "out.webp", *SMALL]) == 0
    scene = [Layer(HOUSE, color="red"), Layer(samples.cube(), color="red", transform=matrices.translate(4, 0, 0))]
    assert np.array_equal(read_frames(), [np.asarray(frame) for frame in turntable(scene, 4, size=(60, 40))])


def test_numbers_color_what_moves() -> None:
    frames = run_animate("--scalars", "y", "--cmap", "magma")
    assert np.array_equal(frames, expected(scalars=HOUSE.positions[:, 1], cmap="magma"))


def test_the_turn_is_about_the_model_s_up() -> None:
    save_mesh(HOUSE.transformed(matrices.rotate_x(90, degrees=True)), "house.obj")
    difference = np.abs(np.stack(run_animate("--up", "+Z")).astype(int) - expected())
    assert difference.max() <= 2


def test_matrices_move_the_model_after_its_own_transforms() -> None:
    poses = np.stack([matrices.translate(k, 0, 0) @ matrices.rotate_z(k) for k in range(3)])
    np.save("poses.npy", poses)
    options = ["--matrices", "poses.npy", "--resolution", "60x40", "--scale", "2", "--fps", "8"]
    assert main(["animate", "house.obj", "-o", "out.webp", *options]) == 0
    made = animate(HOUSE, poses, size=(60, 40), transform=matrices.scale(2))
    assert np.array_equal(read_frames(), [np.asarray(frame) for frame in made])
    with Image.open("out.webp") as image:
        image.load()
        assert image.info["duration"] == 125


@pytest.mark.slow
def test_without_more_it_is_a_hundred_frames_of_640_by_480_twenty_a_second() -> None:
    assert main(["animate", "house.obj", "-o", "out.gif"]) == 0
    with Image.open("out.gif") as image:
        assert (getattr(image, "n_frames", 1), image.size) == (100, (640, 480))
        assert (image.info["duration"], image.info["loop"]) == (50, 0)


@pytest.mark.slow
def test_a_model_from_standard_input_and_one_file_a_frame() -> None:
    typed = ["animate", "-", "--file-type", "obj", "-o", "f/{frame:02}.png", *SMALL]
    ran = run_in_process(*typed, input=Path("house.obj").read_bytes())
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, b"", b"")
    assert sorted(path.name for path in Path("f").iterdir()) == ["00.png", "01.png", "02.png", "03.png"]
    assert np.array_equal([read_frames(f"f/{k:02}.png")[0] for k in range(4)], expected())


def test_a_padded_video_is_a_warning_of_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        typed = ["animate", "house.obj", "-o", "out.mp4", "--resolution", "61,40", "--frames", "2"]
        assert main(typed) == 0
    warning = "gpu-xform: warning: MP4 holds even sizes only: 61 x 40 is padded to 62 x 40\n"
    assert capfd.readouterr() == ("", warning)
    assert Path("out.mp4").stat().st_size > 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-o", "out.avi"], "path must end in one of .apng, .gif, .html, .mp4, .png, .webm, .webp, or hold {frame}"),
        (["-o", "-"], "path must end in one of"),
        (["-o", "{k}.png"], "path must hold {frame}, or {frame:04} for four digits, once, got '{k}.png'"),
        (["-o", "no/out.gif"], "no/out.gif: No such file or directory"),
        (["-o", "out.gif", "--fps", "51"], "fps must be at most 50 in a GIF, got 51"),
        (["-o", "out.gif", "--fps", "0"], "fps must lie in [0.01, 1000], got 0"),
        (["-o", "out.gif", "--fps", "x"], "argument --fps: expected one number, got 'x'"),
        (["-o", "out.gif", "--frames", "0"], "frames must be at least 1, got 0"),
        (["-o", "out.gif", "--frames", "-3"], "argument --frames: expected a whole number, got '-3'"),
        (["-o", "out.gif", "--axis", "0,0,0"], "argument --axis: the direction must not be the zero vector"),
        (["-o", "out.mp4", "--no-background"], "background must be opaque in MP4"),
        (
            ["-o", "out.gif", "--matrices", "flat.npy"],
            "flat.npy: expected an array of shape (frames, 4, 4), got (3, 3)",
        ),
        (["-o", "out.gif", "--matrices", "nan.npy"], "frames[1] must be finite, got nan at index (2, 2)"),
        (["-o", "out.gif", "--matrices", "none.npy"], "none.npy: No such file or directory"),
        (["-o", "out.gif", "--matrices", "nan.npy", "--turntable"], "not allowed with argument --matrices"),
        (["-o", "out.gif", "--matrices", "nan.npy", "--frames", "3"], "--axis and --frames are for --turntable"),
        (["-o", "out.gif", "--camera-focal-point", "0,0,0"], "--camera-focal-point must come with --camera-position"),
        (["-o", "out.gif", "--cmap", "magma"], "--cmap must come with --scalars"),
        ([], "the following arguments are required: -o/--output"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_is_wrong_is_one_line_and_leaves_no_file(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    np.save("flat.npy", np.eye(3))
    np.save("nan.npy", np.stack([np.eye(4), np.diag([1, 1, np.nan, 1])]))
    before = sorted(Path().iterdir())
    assert message in error_of(["animate", "house.obj", "--resolution", "40,40", *options], capsys)
    assert sorted(Path().iterdir()) == before


def test_models_with_nothing_to_draw_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    typed = ["-o", "out.gif", "--edges", "boundary", "--resolution", "40,40"]
    message = error_of(["animate", "house.obj", *typed], capsys)
    assert "gpu-xform: error: house.obj: edges must choose at least one edge" in message
    message = error_of(["animate", "house.obj", "house.obj", *typed], capsys)
    assert "gpu-xform: error: house.obj and 1 more: house: edges must" in message
    assert list(Path().iterdir()) == [Path("house.obj")]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of its own")
@pytest.mark.parametrize(("columns", "rows"), [(80, 24), (0, 0)])
def test_a_bar_is_shown_on_a_terminal_only(columns: int, rows: int) -> None:
    typed = ["animate", "house.obj", "-o", "out.webp", *SMALL]
    code, told = run_on_terminal(*typed, columns=columns, rows=rows)
    assert code == 0
    assert "out.webp: " in told
    assert "frames/s]" in told
    piped = run_in_process(*typed)
    assert (piped.returncode, piped.stdout, piped.stderr) == (0, b"", b"")


def test_an_animation_of_the_file_is_played(capsys: pytest.CaptureFixture[str]) -> None:
    moves = np.array([(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)])
    data = animated(("translation", moves, "LINEAR")).pack()
    Path("dance.glb").write_bytes(data)
    small = ("--resolution", "60,40", "--fps", "2")
    assert main(["animate", "dance.glb", "-o", "out.webp", "--animation", "dance", "--rotate-z", "20", *small]) == 0
    scene = load_scene("dance.glb")
    turned = matrices.rotate_z(20, degrees=True)
    own = animate(scene, scene.animations["dance"], fps=2, size=(60, 40), transform=turned)
    frames = read_frames()
    assert len(frames) == len(own) == 9
    assert all(np.array_equal(frame, np.asarray(other, np.uint8)) for frame, other in zip(frames, own, strict=True))
    for options, message in (
        (["dance.glb", "--animation", "walk"], "dance.glb has no 'walk', its animations: 'dance'"),
        (["house.obj", "--animation", "walk"], "house.obj has no 'walk', its animations: none"),
        (["dance.glb", "house.obj", "--animation", "dance"], "--animation is for one model"),
        (["dance.glb", "--animation", "dance", "--frames", "3"], "--animation has its own length"),
        (["dance.glb", "--animation", "dance", "--scalars", "z"], "--scalars is not for a file of several models"),
    ):
        assert message in error_of(["animate", *options, "-o", "out.webp"], capsys)
