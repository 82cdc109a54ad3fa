"""Pages: true to scale in SVG, in PDF as two other programs measure it, and in pixels; and paper that is too small."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pypdfium2
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform import Camera, Mesh
from gpu_xform.cli import main
from gpu_xform.drawing.page import PAPERS
from gpu_xform.errors import ArgumentError, ArgumentTypeError

FRONT: dict[str, Any] = {"direction": (0, 0, -1), "orthographic": True}
# 600 x 400 mm, and a mark at its lower left, so that no two corners are alike.
PLATE = Mesh([(-300, -200, 0), (300, -200, 0), (300, 200, 0), (-300, 200, 0)], [(0, 1, 2, 3)])
MM_PER_POINT = 25.4 / 72


def svg_extent(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners in millimetres from the top left of the page of what the visible lines span."""
    width, height = (float(side) for side in re.findall(r'(?:width|height)="([\d.]+)mm"', text)[:2])
    box = [float(number) for number in re.findall(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', text)[0]]
    numbers = re.findall(r"-?[\d.]+", " ".join(re.findall(r' d="(.*?)"', text.split('class="visible"')[1])))
    points = np.array(numbers, float).reshape(-1, 2) * (width / box[0], height / box[1])
    return points.min(axis=0), points.max(axis=0)


@pytest.mark.parametrize(
    ("paper", "sides"), [("A4", (210, 297)), ("A4 landscape", (297, 210)), ((150.5, 99.7), (150.5, 99.7))]
)
def test_an_svg_is_as_large_as_its_paper_and_true_to_scale(paper: Any, sides: tuple[float, float]) -> None:
    text = gx.render_svg(PLATE, camera=FRONT, paper=paper, drawing_scale="1:10", margin="5mm")
    assert f'width="{sides[0]:g}mm" height="{sides[1]:g}mm"' in text
    low, high = svg_extent(text)
    np.testing.assert_allclose(high - low, (60.0, 40.0), atol=0.006)
    np.testing.assert_allclose(0.5 * (low + high), 0.5 * np.array(sides), atol=0.006)


def test_a_pdf_is_true_to_scale_as_another_program_measures_it() -> None:
    document = gx.render_pdf(PLATE, camera=FRONT, paper="A4", drawing_scale="1:5", line_width="0.5mm")
    [page] = pypdfium2.PdfDocument(document)
    np.testing.assert_allclose(np.multiply(page.get_size(), MM_PER_POINT), PAPERS["A4"], atol=1e-3)
    background, lines = page.get_objects()
    np.testing.assert_allclose(np.multiply(background.get_bounds(), MM_PER_POINT), (0, 0, *PAPERS["A4"]), atol=1e-2)
    left, low, right, high = np.multiply(lines.get_bounds(), MM_PER_POINT)
    # pdfium widens the bounds of a line by its width at each side.
    np.testing.assert_allclose((right - left - 1.0, high - low - 1.0), (120.0, 80.0), atol=0.01)
    np.testing.assert_allclose((left + right, low + high), PAPERS["A4"], atol=0.02)


def test_rendered_the_pdf_has_the_scale_too() -> None:
    document = gx.render_pdf(PLATE, camera=FRONT, paper="A5 landscape", drawing_scale="1:4", line_width="0.2mm")
    [page] = pypdfium2.PdfDocument(document)
    picture = page.render(scale=600 / 72).to_numpy()  # 600 dpi
    rows, columns = (np.flatnonzero((picture[..., 0] < 128).any(axis=axis)) for axis in (1, 0))
    size_mm = np.array([columns[-1] - columns[0], rows[-1] - rows[0]]) * 25.4 / 600 - 0.2
    np.testing.assert_allclose(size_mm, (150.0, 100.0), atol=0.06)


@pytest.mark.parametrize(("units", "factor"), [("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("in", 25.4)])
def test_units_are_those_of_the_model_and_pixels_follow_the_dpi(units: str, factor: float) -> None:
    plate = Mesh(PLATE.positions / factor, PLATE.faces)
    picture = gx.render_array(
        plate, camera=FRONT, paper="100x80mm", drawing_scale=0.1, units=units, dpi=127, antialias=False
    )
    assert picture.shape == (400, 500, 4)
    rows, columns = (np.flatnonzero((picture[..., 0] < 128).any(axis=axis)) for axis in (1, 0))
    np.testing.assert_allclose((columns[-1] - columns[0], rows[-1] - rows[0]), (300, 200), atol=1)
    np.testing.assert_allclose((columns[0], rows[0]), (100, 100), atol=1)


def test_without_a_scale_models_fill_the_page_between_its_margins() -> None:
    low, high = svg_extent(gx.render_svg(PLATE, camera=FRONT, paper="A4", margin=20))
    np.testing.assert_allclose((low[0], high[0]), (20.0, 190.0), atol=0.01)
    cube = gx.samples.cube()
    low, high = svg_extent(gx.render_svg(cube, paper="A6", edges="all"))  # in perspective
    assert (low > 9.99).all()
    assert (high < np.array(PAPERS["A6"]) - 9.99).all()


def test_a_camera_of_ones_own_keeps_its_target_at_the_centre_of_the_page() -> None:
    camera = Camera.look_at((300, 200, 900), (300, 200, 0), orthographic=True)
    low, high = svg_extent(gx.render_svg(PLATE, camera=camera, paper="A2", drawing_scale="1:4"))
    np.testing.assert_allclose((high[0], low[1]), np.multiply(PAPERS["A2"], 0.5), atol=0.01)
    np.testing.assert_allclose(high - low, (150.0, 100.0), atol=0.01)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        (
            {"paper": "A4", "drawing_scale": "1:2"},
            ArgumentError,
            r"^paper must be at least 320 x 220 mm, as A3 landscape is, for the models at 1:2 with margins of 10 mm, "
            r"got A4, 210 x 297 mm$",
        ),
        (
            {"paper": "A6", "drawing_scale": "10:1", "margin": 0},
            ArgumentError,
            r"^paper must be at least 6000 x 4000 mm, for the models at 10:1, got A6, 105 x 148 mm$",
        ),
        ({"paper": "A9"}, ArgumentError, "^paper must be one of A0, A1, .* got 'A9'"),
        ({"paper": "A4 sideways"}, ArgumentError, "^paper must be one of"),
        ({"paper": 4}, ArgumentTypeError, "^paper must be a name such as 'A4'"),
        ({"paper": (0, 5)}, ArgumentError, "^paper must have sides"),
        ({"paper": "A4", "drawing_scale": "1:0"}, ArgumentError, "^drawing_scale must be a ratio"),
        ({"paper": "A4", "drawing_scale": "big"}, ArgumentError, "^drawing_scale must be a ratio"),
        ({"paper": "A4", "drawing_scale": -1}, ArgumentError, "^drawing_scale must be a ratio"),
        ({"drawing_scale": "1:2"}, ArgumentError, "^drawing_scale must go with paper"),
        ({"margin": 5}, ArgumentError, "^margin must go with paper"),
        ({"paper": "A4", "margin": 120}, ArgumentError, "^margin must leave room on paper of 210 x 297 mm, got 120 mm"),
        ({"paper": "A4", "units": "yd"}, ArgumentError, "^units must be one of um, mm, cm, m, in, ft, got 'yd'"),
        ({"paper": "A4", "size": (10, 20)}, ArgumentError, "^size must not be given with paper"),
        (
            {"paper": "A4", "drawing_scale": "1:9", "camera": {"orthographic": False}},
            ArgumentError,
            "^drawing_scale must go with an orthographic camera",
        ),
        (
            {"paper": "A4", "drawing_scale": "1:9", "camera": Camera.look_at((0, 0, 2000), (0, 0, 0))},
            ArgumentError,
            "^drawing_scale must go with an orthographic camera",
        ),
    ],
    ids=str,
)
def test_what_no_page_can_be_is_refused(options: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        gx.render_svg(PLATE, **{"camera": FRONT, **options})


def test_pictures_know_their_resolution_where_it_means_lengths(tmp_path: Path) -> None:
    assert "dpi" not in gx.render(PLATE, size=(16, 12)).info
    assert gx.render(PLATE, size=(16, 12), dpi=300).info["dpi"] == (300, 300)
    gx.save_mesh(PLATE, tmp_path / "plate.obj")
    command = ["render", str(tmp_path / "plate.obj"), "-o", str(tmp_path / "page.png")]
    assert main([*command, "--paper", "90x60mm", "--drawing-scale", "0.1", "--margin", "0"]) == 0
    with Image.open(tmp_path / "page.png") as image:
        assert image.info["dpi"] == pytest.approx((96, 96), abs=0.02)


def test_a_scale_may_be_one_number_in_a_text() -> None:
    assert gx.render_svg(PLATE, camera=FRONT, paper="A4", drawing_scale="0.1") == gx.render_svg(
        PLATE, camera=FRONT, paper="A4", drawing_scale=0.1
    )
