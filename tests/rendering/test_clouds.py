"""Arrays of points are models: drawn, moved and converted as the mesh of the same points is."""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.drawing import cloud_source, point_array
from gpu_xform.drawing.point_array import MIN_CLOUD_POINTS
from gpu_xform.errors import ArgumentError, ArgumentTypeError

pytestmark = pytest.mark.usefixtures("rasterizer_name")

POINTS = np.random.default_rng(0).uniform(-1, 1, (40, 3))
SIZE = (60, 50)


class Foreign:
    """An array of another library, as NumPy sees it."""

    def __init__(self, array: npt.NDArray[Any]) -> None:
        self.array = array

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.array(self.array, dtype, copy=copy)


def draw(model: Any, **style: Any) -> npt.NDArray[np.uint8]:
    return gx.render_array(model, size=SIZE, **style)


@pytest.mark.parametrize(
    "array",
    [
        POINTS,
        np.asfortranarray(POINTS),
        POINTS.astype(">f8"),
        np.repeat(POINTS, 2, axis=0)[::2],
        Foreign(POINTS),
    ],
    ids=["plain", "fortran", "big endian", "strided", "foreign"],
)
def test_an_array_is_drawn_as_the_mesh_of_its_points(array: Any) -> None:
    style: dict[str, Any] = {"scalars": POINTS[:, 2], "transform": gx.rotate_y(0.5), "point_size": 3.0}
    expected = draw(gx.Mesh(POINTS), **style)
    assert (expected[..., :3] < 200).any()
    assert np.array_equal(draw(array, **style), expected)
    assert np.array_equal(draw(gx.Layer(array, **style)), expected)


def test_integers_and_single_precision_are_points_too() -> None:
    for points in (np.arange(30).reshape(10, 3) % 7, POINTS.astype(np.float32)):
        assert np.array_equal(draw(points), draw(gx.Mesh(points.astype(np.float64))))


@pytest.mark.parametrize("kind", ["u1", "u2", "i4", "u8", "f2", "f4"])
def test_scalars_of_any_number_type_colour_a_large_cloud(monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    for module in (point_array, cloud_source):
        monkeypatch.setattr(module, "MIN_CLOUD_POINTS", len(POINTS))
    scalars = np.arange(len(POINTS)) % 9
    assert np.array_equal(draw(POINTS, scalars=scalars.astype(kind)), draw(POINTS, scalars=scalars.astype("f8")))


def test_a_layer_makes_one_mesh_of_its_array_and_keeps_it() -> None:
    points = POINTS.copy()
    layer = gx.Layer(points, color="red")
    points[:] = 0.0
    assert layer.model == gx.Mesh(POINTS)


def test_an_array_stands_among_other_models() -> None:
    cloud, cube = gx.Mesh(POINTS), gx.samples.cube()
    assert np.array_equal(draw([POINTS, cube]), draw([cloud, cube]))
    assert np.array_equal(draw([POINTS, POINTS + 1]), draw([cloud, gx.Mesh(POINTS + 1)]))
    assert gx.render_svg(POINTS, size=SIZE) == gx.render_svg(cloud, size=SIZE)


def test_a_scene_shows_an_array_that_its_nodes_share() -> None:
    def scene(model: Any) -> gx.Scene:
        made = gx.Scene()
        made.add(model, name="left")
        made.add(model, name="right", transform=gx.translate(3, 0, 0))
        return made

    shown = scene(POINTS)
    assert len(shown.layers()) == 1
    assert repr(shown).splitlines()[1:] == ["  'left': <array (40, 3)>", "  'right': <array (40, 3)>"]
    assert np.array_equal(draw(shown), draw(scene(gx.Mesh(POINTS))))
    moves: Any = [{"right": gx.translate(k, 0, 0)} for k in range(2)]
    moving = gx.animate(shown, moves, size=SIZE)
    expected = gx.animate(scene(gx.Mesh(POINTS)), moves, size=SIZE)
    assert [frame.tobytes() for frame in moving] == [frame.tobytes() for frame in expected]


@pytest.mark.parametrize("several", [lambda model: model, lambda model: [model, gx.samples.cube()], gx.Layer])
def test_an_array_moves(several: Any) -> None:
    moving, expected = (gx.turntable(several(model), 2, size=SIZE) for model in (POINTS, gx.Mesh(POINTS)))
    assert [frame.tobytes() for frame in moving] == [frame.tobytes() for frame in expected]


@pytest.mark.parametrize(
    ("array", "error", "message"),
    [
        (POINTS[:, :2], ArgumentError, r"model must have shape \(n, 3\), got \(40, 2\)"),
        (POINTS[0], ArgumentError, r"model must have shape \(n, 3\), got \(3,\)"),
        (POINTS[None], ArgumentError, r"model must have shape \(n, 3\), got \(1, 40, 3\)"),
        (np.float64(3), ArgumentError, r"model must have shape \(n, 3\), got \(\)"),
        (POINTS * 1j, ArgumentTypeError, "model must hold real numbers, got dtype complex128"),
        (POINTS > 0, ArgumentTypeError, "model must hold real numbers, got dtype bool"),
        (
            np.where(POINTS[7, 1] == POINTS, np.inf, POINTS),
            ArgumentError,
            r"model must be finite, got inf at index \(7",
        ),
    ],
)
def test_an_array_that_is_no_cloud_is_refused(array: Any, error: type[Exception], message: str) -> None:
    scene = gx.Scene()
    scene.add(array, name="wrong")
    for draw in (gx.render, gx.render_svg, gx.Layer, lambda model: gx.animate(model, [np.eye(4)])):
        with pytest.raises(error, match=f"^{message}"):
            draw(array)
    with pytest.raises(error, match=f"^'wrong': {message}"):
        gx.render(scene)


def test_a_text_of_numpys_own_is_a_path_still(tmp_path: Path) -> None:
    gx.save_mesh(gx.Mesh(POINTS), tmp_path / "cloud.npy")
    assert np.array_equal(draw(np.str_(tmp_path / "cloud.npy")), draw(POINTS))


def test_the_command_draws_and_converts_arrays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.save("cloud.npy", POINTS)
    assert main(["render", "cloud.npy", "-o", "cloud.png", "--scalars", "z", "--resolution", "60x50"]) == 0
    with Image.open("cloud.png") as picture:
        assert np.array_equal(np.asarray(picture), draw(POINTS, scalars=POINTS[:, 2]))
    steps = ["--scale", "2", "--translate", "1,2,3"]
    assert main(["transform", "cloud.npy", "moved.ply", *steps]) == 0
    assert main(["transform", "cloud.npy", "moved.npy", *steps]) == 0
    assert main(["transform", "moved.ply", "back.npy"]) == 0
    assert np.array_equal(gx.load_mesh("moved.ply").positions, np.load("moved.npy"))
    assert np.array_equal(np.load("back.npy"), np.load("moved.npy"))


def test_what_cannot_be_drawn_is_refused_before_its_points_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    def look(*_: object, **__: object) -> None:
        raise AssertionError("the points have been looked at")

    monkeypatch.setattr("gpu_xform.drawing.cloud_source.find_extremes", look)
    monkeypatch.setattr("gpu_xform.drawing.prepare.Framing", look)
    cloud = np.zeros((MIN_CLOUD_POINTS, 3), np.float32)
    with pytest.raises(ArgumentError, match=r"^scalars must have one number for each of the 131072 points, got 3$"):
        draw(cloud, scalars=np.zeros(3))
