from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from gpu_xform import (
    Box,
    Camera,
    ChildStrands,
    HalfSpace,
    Layer,
    Mesh,
    Sphere,
    Springs,
    Strands,
    matrices,
    render_array,
    samples,
    save_mesh,
    transform_points,
)
from gpu_xform.cli import main
from tests.support.cli import error_of
from tests.support.types import Pixels

SMALL = ("--resolution", "60,40", "--duration", "0.2", "--fps", "20", "--no-antialias")
PLAIN = {"mass": 0.1, "stretch": 98.1, "shear": 9.81, "bend": 0.2943, "damping": 2e-4}
AIM = ("--camera-position", "0,0,4", "--camera-focal-point", "0,0,0")


def run_simulate(*options: str) -> list[Pixels]:
    assert main(["simulate", "-o", "out.webp", *SMALL, *AIM, *options]) == 0
    frames = []
    with Image.open("out.webp") as image:
        for k in range(getattr(image, "n_frames", 1)):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGBA"), np.uint8))
    return frames


def expected(mesh: Mesh, material: dict[str, Any], bodies: tuple[Mesh, ...] = (), **conditions: Any) -> list[Pixels]:
    """Return the frames as the library simulates and draws them."""

    path = Springs(mesh, **PLAIN | material).simulate(0.2, 20, **{"drag": 1.0} | conditions)
    grey: dict[str, Any] = {"edges": "silhouette", "hidden": "remove", "color": "#9aa0a6", "line_width": 1}
    layers = [Layer(body, **grey) for body in bodies]
    return [
        render_array(
            [*layers, Layer(frame, antialias=False)], size=(60, 40), camera=Camera.look_at((0, 0, 4), (0, 0, 0))
        )
        for frame in path.meshes()
    ]


def test_cloth_falls_over_what_is_below() -> None:
    sphere, box = ("0,-0.2,0,0.15", "0.3,-0.1,0.2,0.1,0.2,0.3")
    options = ("--sphere", sphere, "--box", box, "--floor", "-0.1", "--friction", "0.5", "--gap", "0.02")
    frames = run_simulate("cloth", "--quads", "5,4", *options)
    surface = {"friction": 0.5, "gap": 0.02}
    obstacles = [
        Sphere((0, -0.2, 0), 0.15, **surface),
        Box((0.3, -0.1, 0.2), (0.1, 0.2, 0.3), **surface),
        HalfSpace((0, -0.1, 0), **surface),
    ]
    ball = samples.icosphere(4).transformed(matrices.chain(matrices.scale(0.15), matrices.translate(0, -0.2, 0)))
    block = samples.cube().transformed(
        matrices.chain(matrices.scale(0.05, 0.1, 0.15), matrices.translate(0.3, -0.1, 0.2))
    )
    floor = Mesh(
        [[-0.75, -0.1, -0.75], [0.75, -0.1, -0.75], [0.75, -0.1, 0.75], [-0.75, -0.1, 0.75]],
        [[0, 1], [1, 2], [2, 3], [3, 0]],
    )
    assert len(frames) == 5
    assert not np.array_equal(frames[0], frames[-1])
    assert np.array_equal(frames, expected(samples.cloth(5, 4), {}, (ball, block, floor), obstacles=obstacles))


def test_a_curtain_hangs_in_the_wind() -> None:
    options = ("--pin", "top", "--wind", "1,0,3", "--drag", "1.5", "--gravity", "0,-5,0")
    frames = run_simulate("curtain", "--quads", "32,3", *options)
    curtain = samples.curtain(32, 3)
    conditions: dict[str, Any] = {"wind": (1, 0, 3), "drag": 1.5, "gravity": (0, -5, 0)}
    assert np.array_equal(frames, expected(curtain, {"pinned": range(33)}, **conditions))


def test_a_file_has_the_material_and_the_place_that_are_typed() -> None:
    save_mesh(samples.house(), "house.obj")
    options = ("--scale", "0.4", "--pin", "0,3", "--pin", "left", "--mass", "2", "--stretch-stiffness", "300")
    more = ("--shear-stiffness", "50", "--bend-stiffness", "7", "--damping", "1e-3")
    frames = run_simulate("house.obj", *options, *more)
    house = samples.house().transformed(matrices.scale(0.4))
    left = np.flatnonzero(house.positions[:, 0] < -0.39)
    material = {"mass": 2, "stretch": 300, "shear": 50, "bend": 7, "damping": 1e-3, "pinned": [0, 3, *left]}
    assert np.array_equal(frames, expected(house, material))


@pytest.mark.parametrize(
    ("pins", "found"),
    [
        ("corners", [0, 4, 15, 19]),
        ("back", [0, 1, 2, 3, 4]),
        ("front,7", [7, 15, 16, 17, 18, 19]),
        ("left,right", [0, 4, 5, 9, 10, 14, 15, 19]),
    ],
)
def test_pins_have_names(pins: str, found: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    pinned = []

    class StopError(Exception):
        pass

    def simulate(springs: Springs, *_: Any, **__: Any) -> None:
        pinned.extend(np.flatnonzero(springs.pinned).tolist())
        raise StopError

    monkeypatch.setattr(Springs, "simulate", simulate)
    with pytest.raises(StopError):
        main(["simulate", "cloth", "--quads", "4,3", "--pin", pins, "-o", "out.gif"])
    assert pinned == found


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["cloth", "-o", "out.bmp"], "-o: path must end in one of"),
        (["none.obj", "-o", "out.gif"], "none.obj: No such file"),
        (["house.obj", "-o", "out.gif", "--quads", "2,2"], "--quads is for cloth and curtain"),
        (["cloth", "-o", "out.gif", "--quads", "2"], "--quads: expected two whole numbers, N,M, got '2'"),
        (["cloth", "-o", "out.gif", "--pin", "topp"], "got 'topp'; did you mean 'top'?"),
        (["cloth", "-o", "out.gif", "--pin", "5000"], "--pin: pinned must lie in 0..1680, got 5000"),
        (["cloth", "-o", "out.gif", "--pin", "top"], "--pin: pinned must leave a point free, got all 1681"),
        (["cloth", "-o", "out.gif", "--mass", "0"], "--mass: mass must be positive"),
        (["cloth", "-o", "out.gif", "--stretch-stiffness", "-1"], "--stretch-stiffness: stretch must not be negative"),
        (["cloth", "-o", "out.gif", "--stretch-stiffness", "1e12"], "--stretch-stiffness: a frame needs"),
        (["cloth", "-o", "out.gif", "--fps", "1e-3"], "gpu-xform: error: a frame needs"),
        (["cloth", "-o", "out.gif", "--damping", "1e6"], "--damping: a frame needs"),
        (["cloth", "-o", "out.gif", "--substeps", "1"], "--substeps: substeps must be at least"),
        (["cloth", "-o", "out.gif", "--duration", "1e12"], "--duration: duration must fit into memory"),
        (["cloth", "-o", "out.gif", "--gravity", "0,1e30,0"], "--gravity: gravity must hold numbers of at most 1e+18"),
        (["cloth", "-o", "out.gif", "--mass", "1e300"], "--mass: mass must be at most 3.4e+38, got 1e+300"),
        (["cloth", "-o", "out.gif", "--sphere", "0,0,0,1e30"], "--sphere must hold numbers of at most 1e+18 in size"),
        (["cloth", "-o", "out.gif", "--box", "0,0,1e30,1,1,1"], "--box must hold numbers of at most 1e+18 in size"),
        (["cloth", "-o", "out.gif", "--floor", "-1e30"], "--floor must hold numbers of at most 1e+18 in size, got -1e"),
        (["cloth", "-o", "out.gif", "--sphere", "0,0,0,0"], "--sphere: expected a positive radius"),
        (["cloth", "-o", "out.gif", "--box", "0,0,0,1,1,-1"], "--box: expected positive lengths"),
        (["cloth", "-o", "out.gif", "--duration", "0"], "--duration: duration must be positive"),
        (["cloth", "-o", "out.gif", "--scalars", "x"], "--scalars is not for simulate"),
    ],
)
def test_bad_input_is_one_line(typed: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    save_mesh(samples.house(), "house.obj")
    assert words in error_of(["simulate", *typed], capsys)
    assert not Path("out.gif").exists()


def test_hair_swings_on_a_head_that_shakes() -> None:
    options = (
        "--strands",
        "6",
        "--points",
        "9",
        "--curls",
        "2",
        "--children",
        "20",
        "--shake",
        "40",
        "--mass",
        "0.001",
    )
    more = ("--rotate-x", "10", "--translate", "0,0.1,0", "--drag", "2", "--floor", "-0.1", "--gap", "0.004")
    frames = run_simulate("hair", *options, *more, "--color", "navy", "--duration", "0.8")
    place = matrices.chain(matrices.rotate_x(10, degrees=True), matrices.translate(0, 0.1, 0))
    hair = samples.hair(6, 9, radius=0.1, length=0.22, curls=2, curl_radius=0.006)
    hair = Strands(transform_points(hair.points.reshape(-1, 3), place).reshape(6, 9, 3), points_per_turn=4)
    stretch = 0.001 / 6 * 9.81 / (0.03 * 0.22 / 8)

    def head_at(seconds: float) -> Any:
        started = max(0.0, seconds - 0.5)
        angle = 40 * min(1.0, 2 * started) * np.sin(2 * np.pi * started / 1.4)
        return place @ matrices.rotate_y(angle, degrees=True)

    springs = Springs(
        hair.mesh,
        **hair.springs(stretch, bend=0.03 * stretch, core=0.1 * stretch),
        mass=0.001,
        damping=3e-5,
        pinned=hair.roots,
    )
    path = springs.simulate(
        0.8,
        20,
        drag_rate=2,
        move_pins=lambda seconds: head_at(seconds) @ matrices.inverse(place),
        obstacles=[
            Sphere((0, 0, 0), 0.1, friction=0.3, gap=0.004, transform=head_at),
            HalfSpace((0, -0.1, 0), friction=0.3, gap=0.004),
        ],
    )
    skull = samples.icosphere(4).transformed(place @ matrices.scale(0.98 * 0.1))
    head = Layer(skull, edges="silhouette", hidden="remove", fill="#f3e3d3", color="#a08060")
    strands: dict[str, Any] = {"hidden": "remove", "line_width": 0.8, "color": "navy", "antialias": False}
    children = ChildStrands(hair, 20, clump=0.5).meshes(path)
    assert len(frames) == len(path) == 17
    square = 0.75 * np.ptp(hair.points.reshape(-1, 3), axis=0).max()
    x, _, z = (hair.points.reshape(-1, 3).min(axis=0) + hair.points.reshape(-1, 3).max(axis=0)) / 2
    corners = [(x + i * square, -0.1, z + k * square) for i, k in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    grey: dict[str, Any] = {"edges": "silhouette", "hidden": "remove", "color": "#9aa0a6", "line_width": 1}
    floor = Layer(Mesh(corners, [[0, 1], [1, 2], [2, 3], [3, 0]]), **grey)
    for k in (0, 8, 16):
        layers = [head, floor, Layer(children[k], **strands), Layer(path.meshes()[k], **strands)]
        drawn = render_array(layers, size=(60, 40), camera=Camera.look_at((0, 0, 4), (0, 0, 0)))
        assert np.array_equal(frames[k], drawn), k
    assert not np.array_equal(frames[8], frames[16])


def test_hair_has_colours_of_its_own_and_children_only_between_three_strands() -> None:
    drawn = run_simulate("hair", "--strands", "2", "--points", "6", "--curls", "0", "--camera-position", "0,0,0.7")[0]
    assert (drawn != 255).any()
    brown = drawn[(drawn[..., 0] > drawn[..., 2].astype(int) + 20) & (drawn[..., 0] < 200)]
    assert len(brown)


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["cloth", "--strands", "3"], "--strands is for hair"),
        (["curtain", "--shake", "0"], "--shake is for hair"),
        (["hair", "--pin", "top"], "--pin is not for hair"),
        (["hair", "--quads", "3,3"], "--quads is not for hair"),
        (["hair", "--shear-stiffness", "3"], "--shear-stiffness is not for hair"),
        (["hair", "--strands", "0"], "error: strands must be at least 1, got 0"),
        (["hair", "--points", "1"], "error: points must be at least 2, got 1"),
        (["hair", "--curls", "-1"], "error: curls must not be negative, got -1"),
        (["hair", "--strands", "2", "--children", "5"], "--children needs at least 3 strands, got 2"),
        (["hair", "--scale", "2"], "transform must only rotate and translate an obstacle"),
    ],
)
def test_bad_input_for_hair_is_one_line(typed: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert words in error_of(["simulate", *typed, "-o", "out.gif"], capsys)
    assert not Path("out.gif").exists()


def test_the_host_draws_no_frames_and_says_so_before_they_are_made(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Springs, "simulate", None)
    message = error_of(["simulate", "cloth", "-o", "out.gif", "--adapter", "host"], capsys)
    assert "--adapter: the host device draws no pictures" in message


def test_a_floor_is_drawn_and_more_steps_are_taken_on_request(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    simulate = Springs.simulate

    def note(springs: Springs, *arguments: Any, **options: Any) -> Any:
        path = simulate(springs, *arguments, **options)
        asked.append(springs.substeps)
        return path

    monkeypatch.setattr(Springs, "simulate", note)
    above = run_simulate("cloth", "--quads", "3,3", "--pin", "back", "--substeps", "333")
    on_floor = run_simulate("cloth", "--quads", "3,3", "--pin", "back", "--floor", "-0.9", "--substeps", "333")
    assert asked == [333, 333]
    assert not np.array_equal(above[0], on_floor[0])
