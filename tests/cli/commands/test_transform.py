"""`gpu-xform transform`: options, files, and accuracy."""

import io
import shlex
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from gpu_xform import Mesh, load_mesh, matrices, samples, save_mesh
from gpu_xform.cli import main
from tests.support.cli import error_of, run_in_process
from tests.support.types import Array

C30, S30 = np.sqrt(3) / 2, 0.5

SCALE = ("--scale", "1,2,3"), np.diag([1.0, 2, 3, 1])

ROTATE = ("--rotate-z", "30"), np.array([[C30, -S30, 0, 0], [S30, C30, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])

TRANSLATE = ("--translate", "-0.5,2,0"), np.array([[1.0, 0, 0, -0.5], [0, 1, 0, 2], [0, 0, 1, 0], [0, 0, 0, 1]])

SIXTEEN = "0 -0.3 7 -0.5 0.3 0 0 2 0 5 0.25 11 0 0 0 1"

POINTS = np.array([[1.0, 2, 3], [-4, 5, -6], [0.125, 0, 7], [1e6, -1e-6, 3], [0, 0, 0]])


def moved(points: Array, *steps: Array) -> Array:
    homogeneous = np.column_stack([points, np.ones(len(points))])
    for step in steps:
        homogeneous = (step @ homogeneous.T).T
    return np.asarray(homogeneous[:, :3])


def assert_as_accurate_as_promised(result: Array, points: Array, matrix: Array, unit: float) -> None:
    magnitudes = np.abs(points) @ np.abs(matrix[:3, :3]).T + np.abs(matrix[:3, 3])
    assert (np.abs(result - moved(points, matrix)) <= 6 * unit * magnitudes).all()


@pytest.fixture(autouse=True)
def _files() -> None:
    save_mesh(samples.house(), "house.obj")
    np.save("points.npy", POINTS)


def run_transform(*options: str, points: Array | None = None) -> Array:
    if points is not None:
        np.save("points.npy", points)
    assert main(["transform", "points.npy", "moved.npy", *options]) == 0
    return np.asarray(np.load("moved.npy"))


@pytest.mark.float64
@pytest.mark.parametrize("order", [(SCALE, ROTATE, TRANSLATE), (TRANSLATE, ROTATE, SCALE), (ROTATE, TRANSLATE, SCALE)])
def test_transforms_apply_in_the_order_typed(order: tuple[tuple[tuple[str, str], Array], ...]) -> None:
    options = [word for typed, _ in order for word in typed]
    assert main(["transform", "house.obj", "moved.obj", *options]) == 0
    house, result = samples.house(), load_mesh("moved.obj")
    product = np.linalg.multi_dot([matrix for _, matrix in reversed(order)])
    assert_as_accurate_as_promised(result.positions, house.positions, product, 2.0**-53)
    another_order = moved(house.positions, SCALE[1], TRANSLATE[1], ROTATE[1])
    assert np.abs(result.positions - another_order).max() > 0.1
    assert np.array_equal(result.offsets, house.offsets)
    assert np.array_equal(result.indices, house.indices)


@pytest.mark.float64
def test_one_option_may_be_typed_twice_and_between_the_files() -> None:
    arguments = ["--translate", "1,0,0", "points.npy", "--scale", "2", "--translate=0,0,1", "moved.npy"]
    assert main(["transform", *arguments]) == 0
    assert np.array_equal(np.load("moved.npy"), np.add(np.add(POINTS, (1, 0, 0)) * 2, (0, 0, 1)))


@pytest.mark.float64
@pytest.mark.parametrize(
    ("typed", "rows"),
    [
        ("--scale 0.5", [[0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 0.5, 0]]),
        ("--scale 1,2,-3", [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, -3, 0]]),
        ("--rotate-x 90", [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0]]),
        ("--rotate-y -90", [[0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0]]),
        ("--rotate-z 30", ROTATE[1][:3]),
        ("--rotate 0,0,-2,-30", ROTATE[1][:3]),
        ("--rotate 1,1,1,120", [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0]]),
        ("--translate -.5,2,1e1", [[1, 0, 0, -0.5], [0, 1, 0, 2], [0, 0, 1, 10]]),
        ("--shear xy=0.5", [[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]),
        ("--shear zx=2,yz=-3", [[1, 0, 0, 0], [0, 1, -3, 0], [2, 0, 1, 0]]),
        ("--reflect 0,0,5", [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0]]),
        ("--reflect -1,1,0", [[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]]),
        ("--project-onto 0,3,0", [[1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 1, 0]]),
        (f"--matrix '{SIXTEEN}'", np.reshape([float(word) for word in SIXTEEN.split()], (4, 4))[:3]),
    ],
)
def test_each_transform(typed: str, rows: npt.ArrayLike) -> None:
    matrix = np.vstack([rows, [0.0, 0, 0, 1]])
    assert np.allclose(run_transform(*shlex.split(typed)), moved(POINTS, matrix), rtol=1e-12, atol=1e-9)


@pytest.mark.float64
@pytest.mark.parametrize("separator", [" ", ",", ", ", "  "])
@pytest.mark.parametrize("where", ["argument", "text", "npy"])
def test_a_matrix_may_be_typed_or_in_a_file(separator: str, where: str) -> None:
    text = separator.join(SIXTEEN.split())
    expected = np.reshape([float(word) for word in SIXTEEN.split()], (4, 4))
    if where == "text":
        words = SIXTEEN.split()
        Path("m.txt").write_text("\n".join(separator.join(words[i : i + 4]) for i in range(0, 16, 4)) + "\n")
        text = "m.txt"
    elif where == "npy":
        np.save("m.npy", expected.astype(np.float32))
        text, expected = "m.npy", expected.astype(np.float32).astype(np.float64)
    result = run_transform("--matrix", text)
    assert_as_accurate_as_promised(result, POINTS, expected, 2.0**-53)


def test_a_projection_divides_only_when_told_to(capsys: pytest.CaptureFixture[str]) -> None:
    points = np.array([[1.0, 2, 4], [3, -1, -8], [1, 1, 0]])
    # The lecture's perspective: x* = d x / (d - z)
    expected = np.column_stack([8 * points[:, :2] / (8 - points[:, 2:]), np.zeros(3)])
    result = run_transform("--perspective-from-eye", "8", "--project", points=points)
    assert np.allclose(result, expected, rtol=1e-15, atol=0)
    Path("moved.npy").unlink()
    assert "--project" in error_of(["transform", "points.npy", "moved.npy", "--perspective-from-eye", "8"], capsys)
    assert not Path("moved.npy").exists()


@pytest.mark.parametrize("chain", [["a.ply", "b.off", "c.obj"], ["a.off", "b.obj", "c.ply"]])
def test_polygons_and_coordinates_survive_conversion(chain: list[str]) -> None:
    mesh = Mesh(samples.snub_dodecahedron().positions, samples.snub_dodecahedron().faces)
    save_mesh(mesh, "start.obj")
    for source, target in zip(["start.obj", *chain], chain, strict=False):
        assert main(["transform", source, target]) == 0
        assert load_mesh(target) == mesh
    assert sorted(np.unique(np.diff(load_mesh(chain[-1]).offsets))) == [3, 5]


@pytest.mark.parametrize(
    "dtype", ["<f4", ">f4", *(pytest.param(dtype, marks=pytest.mark.float64) for dtype in ("<f8", ">f8"))]
)
@pytest.mark.parametrize("shape", [(0, 3), (1, 2), (65, 3), (7, 2)])
def test_an_array_keeps_its_type_and_shape(dtype: str, shape: tuple[int, int]) -> None:
    points = np.random.default_rng(1).normal(size=shape).astype(dtype)
    result = run_transform("--rotate-z", "30", "--translate", "-0.5,2,0", points=points)
    assert result.dtype == np.dtype(dtype).newbyteorder("=")
    assert result.shape == shape
    in_space = np.zeros((len(points), 3))
    in_space[:, : shape[1]] = points
    expected = moved(in_space, ROTATE[1], TRANSLATE[1])[:, : shape[1]]
    assert np.allclose(result, expected, rtol=0, atol=20 * np.finfo(dtype).eps)


@pytest.mark.float64
def test_an_array_in_columns_is_read_as_its_rows() -> None:
    points = np.asfortranarray(POINTS)
    assert np.array_equal(run_transform("--translate", "1,2,3", points=points), np.add(POINTS, (1, 2, 3)))


@pytest.mark.float64
def test_a_file_can_be_its_own_result() -> None:
    assert main(["transform", "points.npy", "points.npy", "--scale", "2"]) == 0
    assert np.array_equal(np.load("points.npy"), 2 * POINTS)


def test_points_of_the_plane_stay_in_it(capsys: pytest.CaptureFixture[str]) -> None:
    flat = np.array([[1.0, 2], [3, 4]])
    assert np.array_equal(run_transform("--rotate-x", "180", points=flat), flat * (1, -1))
    for leaving in ("--rotate-x=90", "--translate=0,0,1", "--shear=zx=1"):
        assert "xy-plane" in error_of(["transform", "points.npy", "moved.npy", leaving], capsys)


@pytest.mark.slow
@pytest.mark.float64
def test_a_pipe_in_and_a_pipe_out() -> None:
    typed = ["transform", "-", "-", "--file-type", "npy", "--translate", "-1,0,0"]
    result = run_in_process(*typed, input=Path("points.npy").read_bytes())
    assert (result.returncode, result.stderr) == (0, b"")
    assert np.array_equal(np.load(io.BytesIO(result.stdout)), np.subtract(POINTS, (1, 0, 0)))


def test_a_model_through_standard_output_keeps_the_type_of_the_input(
    capsysbinary: pytest.CaptureFixture[bytes],
) -> None:
    assert main(["transform", "house.obj", "-", "--scale", "2"]) == 0
    mesh = load_mesh(io.BytesIO(capsysbinary.readouterr().out), file_type="obj")
    assert mesh == samples.house().transformed(matrices.scale(2))
