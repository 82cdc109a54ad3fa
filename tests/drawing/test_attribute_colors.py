"""Colours and scalars that models hold, in pictures and by name."""

from pathlib import Path
from typing import Any

import numpy as np
import plyfile
import pytest

import gpu_xform as gx
from gpu_xform import Layer, Mesh, samples
from gpu_xform.cli import main
from tests.support.cli import error_of

CUBE = samples.cube()
RED_TO_BLUE = np.linspace([255, 0, 0, 255], [0, 0, 255, 255], 8).astype(np.uint8)
INTENSITY = np.arange(8, dtype=np.float32) ** 2
LOOK: dict[str, Any] = {"size": (120, 90)}


def with_attributes(**attributes: Any) -> Mesh:
    return CUBE.with_attributes(attributes)


def test_the_colors_of_points_are_those_of_the_file() -> None:
    mesh = with_attributes(point={"color": RED_TO_BLUE})
    expected = gx.render_array(CUBE, vertex_colors=RED_TO_BLUE, line_width=3, **LOOK)
    assert np.array_equal(gx.render_array(mesh, color="file", line_width=3, **LOOK), expected)
    floats = with_attributes(point={"color": RED_TO_BLUE[:, :3].astype(np.float32) / np.float32(255)})
    assert np.array_equal(gx.render_array(floats, color="file", line_width=3, **LOOK), expected)


def test_a_path_is_drawn_in_the_colors_of_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    gx.save_mesh(with_attributes(point={"color": RED_TO_BLUE, "intensity": INTENSITY}), "cube.ply")
    expected = gx.render_array(CUBE, vertex_colors=RED_TO_BLUE, **LOOK)
    assert np.array_equal(gx.render_array("cube.ply", color="file", **LOOK), expected)
    by_scalars = gx.render_array(CUBE, scalars=INTENSITY, **LOOK)
    assert np.array_equal(gx.render_array("cube.ply", scalars="intensity", **LOOK), by_scalars)
    assert not np.array_equal(by_scalars, expected)
    assert gx.render_svg("cube.ply", color="file") == gx.render_svg(CUBE, vertex_colors=RED_TO_BLUE, name="cube")


def test_the_colors_of_faces_are_those_of_the_file_or_of_its_materials() -> None:
    colors = np.linspace([1, 0.25, 0, 1], [0, 0.5, 1, 1], 6)
    expected = gx.render_array(CUBE, face_colors=colors, fill=colors, **LOOK)
    mesh = with_attributes(face={"color": colors})
    assert np.array_equal(gx.render_array(mesh, color="file", fill="file", **LOOK), expected)
    materials = with_attributes(
        face={"material": [0, 1, 2, 3, 4, 5]},
        labels={"material": list("abcdef")},
        material={
            name: {"pbrMetallicRoughness": {"baseColorFactor": color.tolist()}}
            for name, color in zip("abcdef", colors, strict=True)
        },
    )
    assert np.array_equal(gx.render_array(materials, color="file", fill="file", **LOOK), expected)


def test_corners_give_points_and_faces_their_mean_color() -> None:
    corner = np.random.default_rng(1).random((24, 3))
    mesh = with_attributes(corner={"color": corner})
    layer = Layer(mesh, color="file")
    means = [corner[mesh.indices == i].mean(axis=0) for i in range(8)]
    assert isinstance(layer.vertex_colors, np.ndarray)
    assert np.allclose(layer.vertex_colors[:, :3], means)
    filled = Layer(mesh, fill="file").fill
    assert np.allclose(filled[:, :3], np.asarray(means)[mesh.indices].reshape(6, 4, 3).mean(axis=1))


def test_scalars_per_face() -> None:
    area = np.arange(6.0)
    mesh = with_attributes(face={"area": area})
    expected = gx.render_array(CUBE, face_colors=Layer(mesh, scalars="area").face_colors, **LOOK)
    assert np.array_equal(gx.render_array(mesh, scalars="area", **LOOK), expected)


def test_what_the_model_does_not_hold_is_an_error() -> None:
    mesh = with_attributes(point={"intensity": INTENSITY, "normal": np.eye(8, 3)}, face={"area": np.arange(6)})
    with pytest.raises(gx.ArgumentError) as caught:
        Layer(mesh, scalars="intensty")
    assert str(caught.value) == (
        "scalars must be 'x', 'y' or 'z', or an attribute with a number per point or face, 'intensity', 'area', "
        "got 'intensty'"
    )
    style: Any
    for argument in ("color", "fill"):
        style = {argument: "file"}
        with pytest.raises(gx.ArgumentError, match=f"^{argument} must be a colour, got 'file': the model holds no "):
            Layer(mesh, **style)
    with pytest.raises(gx.ArgumentError, match=r"be 'x', 'y' or 'z', the model has no others, got 'a'$"):
        Layer(CUBE, scalars="a")


@pytest.mark.usefixtures("working_folder")
def test_the_command_draws_a_scan_in_its_own_colors(capsys: pytest.CaptureFixture[str]) -> None:
    dtype = [("x", "f4"), ("y", "f4"), ("z", "f4"), ("intensity", "f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")]
    rows = [(*p, i, *c[:3]) for p, i, c in zip(CUBE.positions, INTENSITY, RED_TO_BLUE, strict=True)]
    plyfile.PlyData([plyfile.PlyElement.describe(np.array(rows, dtype), "vertex")]).write("scan.ply")
    look = ["--size", "120,90", "--point-size", "7"]
    for options, style in (
        (["--color", "file"], {"vertex_colors": RED_TO_BLUE}),
        (["--scalars", "intensity"], {"scalars": INTENSITY}),
        (["--scalars", "intensity", "--clim", "0,9"], {"scalars": INTENSITY, "clim": (0, 9)}),
    ):
        assert main(["render", "scan.ply", "-o", "scan.png", *look, *options]) == 0
        expected = gx.render(CUBE.positions, point_size=7, **LOOK, **style)
        assert Path("scan.png").exists()
        assert gx.compare_images("scan.png", expected).largest == 0
    assert ", or intensity of scan.ply, got 'depth'" in error_of(
        ["render", "scan.ply", "-o", "a.png", "--scalars", "depth"], capsys
    )


def test_a_material_of_an_odd_shape_has_no_color() -> None:
    # As in "badObject.gltf" of assimp's tests.
    surfaces: list[Any] = [[], {"baseColorFactor": [1, "x", 0, 1]}, {"baseColorFactor": 3}]
    for surface in surfaces:
        odd = {"odd": {"pbrMetallicRoughness": surface}}
        face = {"material": np.zeros(CUBE.n_faces, int)}
        mesh = with_attributes(face=face, labels={"material": ["odd"]}, material=odd)
        with pytest.raises(gx.ArgumentError, match="no attribute 'color' and no coloured material"):
            gx.render_array(mesh, color="file", **LOOK)


def test_coordinates_are_scalars_unless_attributes_have_their_names() -> None:
    mesh = samples.cube()
    plain = gx.render_array(mesh, size=(40, 40), scalars=mesh.positions[:, 2])
    assert np.array_equal(gx.render_array(mesh, size=(40, 40), scalars="z"), plain)
    own = mesh.with_attributes({"point": {"z": mesh.positions[:, 0]}})
    other = gx.render_array(mesh, size=(40, 40), scalars=mesh.positions[:, 0])
    assert np.array_equal(gx.render_array(own, size=(40, 40), scalars="z"), other)


def test_floats_that_are_no_fractions_are_refused() -> None:
    mesh = with_attributes(point={"color": RED_TO_BLUE[:, :3].astype(np.float32)})
    with pytest.raises(gx.ArgumentError, match="'color' of the model must hold uint8, or floats from 0 to 1, got "):
        gx.render_array(mesh, color="file", **LOOK)
