"""The style of pictures that nobody has chosen one for."""

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Mesh, samples
from gpu_xform.cli import main
from gpu_xform.drawing.legible_style import legible_style
from tests.support.cli import read_png

SIZE = (64, 64)


def test_a_cube_has_its_edges_and_a_dense_ball_is_no_blot() -> None:
    for mesh in (samples.cube(), samples.icosphere(5)):
        pixels = gx.render_array(mesh, size=SIZE, **legible_style(mesh, SIZE))
        inside = pixels[pixels[..., :3].min(axis=2) < 250]
        assert (inside[:, 0] > 100).mean() > 0.5  # most of what is covered is light
        assert np.ptp(inside[:, 0].astype(int)) > 60  # and not all alike
    assert legible_style(samples.cube(), SIZE)["edges"] == ["feature", "silhouette"]
    assert legible_style(samples.icosphere(5), SIZE)["color"] == "none"
    assert legible_style(Mesh(np.eye(3)), SIZE) == {}


@pytest.mark.usefixtures("working_folder")
def test_pictures_of_many_models_have_it_unless_a_style_is_typed() -> None:
    house = samples.house()
    gx.save_mesh(house, "house.obj")
    np.save("cloud.npy", np.random.default_rng(1).random((50, 3)))
    expected = gx.render_array(house, size=SIZE, **legible_style(house, SIZE))
    assert main(["render", "house.obj", "cloud.npy", "-o", "{model}.png", "--size", "64,64"]) == 0
    np.testing.assert_array_equal(read_png("house.png"), expected)
    assert main(["render", "house.obj", "-o", "{model}.png", "--size", "64,64", "--line-width", "1.5"]) == 0
    np.testing.assert_array_equal(read_png("house.png"), gx.render_array(house, size=SIZE))
    assert main(["render", "house.obj", "-o", "one.png", "--size", "64,64"]) == 0
    np.testing.assert_array_equal(read_png("one.png"), gx.render_array(house, size=SIZE))
