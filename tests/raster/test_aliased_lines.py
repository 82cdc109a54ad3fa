"""Lines one pixel wide, each pixel on or off."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.imaging.colors import COLOR_CYCLE, to_rgba

HOUSE = gx.samples.house()
CAMERA = gx.Camera.look_at((5, 4, 9), (0, 0, 0))
SIZE = (301, 200)


def thin(model: gx.Mesh = HOUSE, **style: object) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    options: dict[str, object] = {"camera": CAMERA, "size": SIZE, "antialias": False} | style
    return gx.render_array(model, **options)  # type: ignore[arg-type]


def test_every_pixel_is_on_or_off() -> None:
    pixels = thin(color="#204060")
    values = {tuple(pixel) for pixel in pixels.reshape(-1, 4).tolist()}
    assert values == {(255, 255, 255, 255), (0x20, 0x40, 0x60, 255)}


def test_lit_pixels_lie_on_the_lines_and_every_line_is_lit() -> None:
    pixels = thin()
    wide = gx.render_array(HOUSE, camera=CAMERA, size=SIZE, line_width=4)
    lit = pixels[..., 0] == 0
    assert (wide[lit][:, 0] < 255).all()
    for edge in HOUSE.edges:
        alone = thin(edges=[edge])[..., 0] == 0
        assert alone.any()
        assert lit[alone].all()
        rest = thin(edges=[other for other in HOUSE.edges.tolist() if other != edge.tolist()])
        assert (rest[alone][:, 0] == 255).any()


def test_a_line_lights_every_column_it_crosses_and_nothing_further_off_than_a_pixel() -> None:
    flat = gx.Mesh(np.array([[-0.9, -0.31, 0], [0.83, 0.4, 0]]), [[0, 1]])
    lit = thin(flat, camera=gx.Camera.window((-1, 1), (-1, 1)), size=(200, 200))[..., 0] == 0
    columns = lit.sum(axis=0)
    assert ((columns[11:182] >= 1) & (columns[11:182] <= 2)).all()  # devices differ in which of two
    assert not columns[:9].any()
    assert not columns[185:].any()
    y, x = np.nonzero(lit)
    slope = 0.71 / 1.73
    from_line = (y + 0.5) - (100 - 100 * (-0.31 + slope * ((x + 0.5) / 100 - 0.1)))
    assert np.abs(from_line).max() * np.cos(np.arctan(slope)) <= 0.75


def test_what_is_behind_the_eye_is_cut_off() -> None:
    crossing = gx.Mesh(np.array([[0, 0, -5], [0.2, 0.1, 30]]), [[0, 1]])
    camera = gx.Camera.look_at((0, 0, 10), (0, 0, 0))
    part = gx.Mesh(np.array([[0, 0, -5], [0.2 * 14.9 / 35, 0.1 * 14.9 / 35, 9.9]]), [[0, 1]])
    whole, cut = thin(crossing, camera=camera), thin(part, camera=camera)
    assert (whole[..., 0] == 0).sum() >= (cut[..., 0] == 0).sum() > 3
    assert (whole[SIZE[1] // 2 + 3 :] == 255).all()
    assert (whole[:, : SIZE[0] // 2 - 3] == 255).all()


def test_each_face_has_its_colour_and_transparency_stays_straight() -> None:
    colors = {tuple(pixel) for pixel in thin(color="face", background=None).reshape(-1, 4).tolist()}
    cycle = {tuple(round(255 * part) for part in to_rgba(name, "color")) for name in COLOR_CYCLE[: HOUSE.n_faces]}
    assert colors - {(0, 0, 0, 0)} <= cycle
    assert len(colors) > 4
    half = thin(color=(1, 0, 0, 0.5), background=None, edges=[[0, 1]])
    assert {tuple(pixel) for pixel in half.reshape(-1, 4).tolist()} == {(0, 0, 0, 0), (255, 0, 0, 128)}


def test_the_line_width_has_no_effect() -> None:
    assert np.array_equal(thin(line_width=7), thin(line_width=1))


def test_the_command_line_draws_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    gx.save_mesh(HOUSE, "house.obj")
    assert main(["render", "house.obj", "-o", "out.png", "--no-antialias", "--resolution", "200,200"]) == 0
    with Image.open("out.png") as image:
        assert set(np.unique(np.asarray(image)[..., 0])) == {0, 255}
