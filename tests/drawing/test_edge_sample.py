"""Lines as wide as a dense mesh can bear."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import ArgumentTypeError, Camera, Layer, samples
from gpu_xform.drawing.edge_sample import DEFAULT_LINE_WIDTH_PX, fit_line_width, project_sample

SIZE = (128, 96)
CAMERA = Camera.look_at((2.7, 1.9, 4.4), (0, 0, 0), fov_y=30.0)


def picture(mesh: gx.Mesh, **style: Any) -> Any:
    return gx.render_array(mesh, camera=CAMERA, size=SIZE, **style)


@pytest.mark.parametrize("mesh", [samples.cube(), samples.house(), samples.icosphere(0)])
def test_lines_that_are_far_apart_are_as_wide_as_ever(mesh: gx.Mesh) -> None:
    np.testing.assert_array_equal(picture(mesh, line_width="auto"), picture(mesh))


@pytest.mark.parametrize("hidden", ["show", "remove"])
@pytest.mark.parametrize("n", [4, 5, 6, 7])
def test_a_dense_mesh_is_grey_and_no_blot(n: int, hidden: str) -> None:
    mesh = samples.icosphere(n)
    inside = picture(mesh, fill="white", color="none")[..., :3].sum(axis=2) >= 0
    disc = picture(mesh, fill="black", color="none")[..., 0] == 0
    assert inside.all()
    thin = picture(mesh, line_width="auto", hidden=hidden)[..., 0][disc]
    thick = picture(mesh, hidden=hidden)[..., 0][disc]
    assert 90 < thin.mean() < 215
    assert thick.mean() < thin.mean() - (40 if n > 4 else 10)


def test_the_width_is_what_covers_half_of_the_box_around_the_edges() -> None:
    ends = np.array([[(10.0, 10.0), (40.0, 50.0)], [(10.0, 50.0), (40.0, 10.0)]])  # 50 pixels each, in 30 x 40
    assert fit_line_width(ends, 1000, (100, 100), hides_half=False) == pytest.approx(0.5 * 1200 / (1000 * 50))
    assert fit_line_width(ends, 1000, (100, 100), hides_half=True) == pytest.approx(1200 / (1000 * 50))
    assert fit_line_width(ends, 2, (100, 100), hides_half=False) == DEFAULT_LINE_WIDTH_PX
    assert fit_line_width(ends[:0], 2, (100, 100), hides_half=False) == DEFAULT_LINE_WIDTH_PX
    assert fit_line_width(ends[:, :1].repeat(2, axis=1), 9, (100, 100), hides_half=False) == DEFAULT_LINE_WIDTH_PX


def test_edges_that_reach_behind_the_eye_are_not_measured() -> None:
    matrix = CAMERA.clip_from_world(1.0)
    ends = np.array([[(0.0, 0, 0), (1, 0, 0)], [(0.0, 0, 0), (9, 9, 19)]])
    assert len(project_sample(lambda: ends, matrix, SIZE)) == 1


def test_svg_has_the_same_width() -> None:
    text = gx.render_svg(samples.icosphere(5), camera=CAMERA, size=SIZE, line_width="auto", hidden="remove")
    width = float(text.split('stroke-width="')[1].split('"')[0])
    assert 0.01 <= width < 1.0


@pytest.mark.parametrize("width", ["Auto", "wide", ""])
def test_another_word_is_an_error(width: str) -> None:
    with pytest.raises(
        ArgumentTypeError, match="line_width must be 'auto', a number of pixels, or one with a unit, px, mm, cm, in, pt"
    ):
        Layer(samples.cube(), line_width=width)
