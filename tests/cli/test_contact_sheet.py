"""Contact sheets on the command line."""

import re
from pathlib import Path

import numpy as np
import pytest

from gpu_xform import load_mesh, render_array, samples, save_mesh
from gpu_xform.cli import main
from gpu_xform.cli.contact_sheet import make_distinct_names
from gpu_xform.rendering.contact_sheet import GAP_PX, TILE_PX
from tests.support.cli import read_png

STYLE = ("--color", "navy", "--edges", "feature")


@pytest.fixture(autouse=True)
def _files() -> None:
    Path("models/deep").mkdir(parents=True)
    for name, mesh in (("a.obj", samples.house()), ("b.ply", samples.cube()), ("deep/a.obj", samples.cube())):
        save_mesh(mesh, f"models/{name}")
    Path("models/bad.off").write_text("OFF nothing")


def test_names_are_as_short_as_they_can_be() -> None:
    assert make_distinct_names(["x/a.obj", "x/b.obj"]) == ["a", "b"]
    assert make_distinct_names(["x/a.obj", "x/a.stl", "x/b.obj"]) == ["a.obj", "a.stl", "b"]
    assert make_distinct_names(["x/a.obj", "y/a.obj", "y/a.stl"]) == ["x/a.obj", "y/a.obj", "a.stl"]


def test_each_model_is_drawn_in_its_place(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "models/**", "--sheet", "made/s.png", *STYLE, "--resolution", "800,600"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == "gpu-xform: 4 pictures: 3 done, 1 failed"
    sheet = read_png("made/s.png")
    tile = (TILE_PX, TILE_PX * 3 // 4)
    rows = (sheet.shape[0] - GAP_PX) // 2
    inner = np.s_[2:-2, 2:-2]  # without the frame
    for i, name in ((0, "a.obj"), (1, "b.ply"), (3, "deep/a.obj")):
        x, y = GAP_PX + (i % 2) * (tile[0] + GAP_PX), GAP_PX + (i // 2) * rows
        alone = render_array(load_mesh(f"models/{name}"), size=tile, color="navy", edges="feature")
        assert np.array_equal(sheet[y : y + tile[1], x : x + tile[0]][inner], alone[inner])
        assert (sheet[y + tile[1] + 2 : y + rows - GAP_PX, x : x + tile[0], 0] < 128).any()  # its name
    bad = sheet[GAP_PX + rows : GAP_PX + rows + tile[1], GAP_PX : GAP_PX + tile[0]].astype(int)[inner]
    assert ((bad[..., 0] - bad[..., 1]) > 60).any()
    assert (bad == 255).mean() > 0.95


def test_vector_sheets_have_the_names_as_texts() -> None:
    assert main(["render", "models/**", "--sheet", "s.svg", "--sheet", "s.svg", *STYLE]) == 2
    page = Path("s.svg").read_text("utf-8")
    assert re.findall(r"<text[^>]*>([^<]+)<", page) == ["models/a.obj", "b", "bad", "not drawn", "models/deep/a.obj"]
    assert main(["render", "models/a.obj", "--sheet", "s.pdf", *STYLE]) == 0
    assert Path("s.pdf").read_bytes().startswith(b"%PDF")


def test_names_that_no_font_has_are_escaped_and_long_ones_lose_their_middle() -> None:
    save_mesh(samples.cube(), "models/deep/\U0001f9ca.obj")
    save_mesh(samples.cube(), f"models/deep/{'long' * 30}.obj")
    assert main(["render", "models/deep", "--sheet", "s.svg", "--font", "DejaVuSans", *STYLE]) == 0
    texts = re.findall(r"<text[^>]*>([^<]+)<", Path("s.svg").read_text("utf-8"))
    assert texts[0] == "a"
    assert re.fullmatch(r"(long)*l?o?n?\N{HORIZONTAL ELLIPSIS}o?n?g?(long)+", texts[1])
    assert texts[2] in ("\\U0001f9ca", "\U0001f9ca")


def test_a_sheet_goes_beside_other_files() -> None:
    assert main(["render", "models/b.ply", "-o", "out/{model}.png", "--sheet", "s.png", "--resolution", "64,64"]) == 0
    assert read_png("out/b.png").shape == (64, 64, 4)
    assert read_png("s.png").shape[1] == TILE_PX + 2 * GAP_PX
