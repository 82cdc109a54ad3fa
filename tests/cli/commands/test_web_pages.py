"""Web pages from the command line: `render -o page.html`, `animate --live`."""

from pathlib import Path

import pytest

import gpu_xform as gx
from gpu_xform.cli import main
from tests.support.cli import error_of

SMALL = ("--resolution", "48,32")


@pytest.fixture(autouse=True)
def _files() -> None:
    gx.save_mesh(gx.samples.house(), "house.obj")


def test_a_page_is_what_the_library_writes() -> None:
    typed = ["--hidden", "remove", "--color", "navy", "--title", "My house"]
    assert main(["render", "house.obj", "-o", "page.html", *SMALL, *typed]) == 0
    house = gx.Layer(gx.samples.house(), name="house", hidden="remove", color="navy")
    gx.save_page([house], "other.html", title="My house", size=(48, 32))
    assert Path("page.html").read_bytes() == Path("other.html").read_bytes()


def test_a_page_per_model_is_called_as_the_model() -> None:
    assert main(["render", "house.obj", "-o", "{model}.html", *SMALL]) == 0
    assert "<title>house</title>" in Path("house.html").read_text("utf-8")


def test_a_large_model_can_be_made_smaller() -> None:
    gx.save_mesh(gx.samples.icosphere(3), "ball.obj")
    assert main(["render", "ball.obj", "-o", "all.html", *SMALL]) == 0
    assert main(["render", "ball.obj", "-o", "some.html", *SMALL, "--max-edges", "200"]) == 0
    assert Path("some.html").stat().st_size < Path("all.html").stat().st_size - 2000


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["-o", "page.html", "--axes"], "page.html: --axes cannot go with a web page"),
        (["-o", "page.html", "--paper", "A4"], "page.html: --paper cannot go with a web page"),
        (["-o", "page.html", "--views", "front,top"], "page.html: --views cannot go with a web page"),
        (["-o", "page.html", "--dpi", "200"], "page.html: --dpi must come with a .png"),
        (["-o", "page.html", "--rasterizer", "compute"], "page.html: --rasterizer must come with a .png"),
        (["-o", "house.png", "--max-edges", "9"], "--max-edges is for web pages, whose names end in .html"),
        (["-o", "house.svg", "--title", "House"], "--title is for web pages, whose names end in .html"),
        (["-o", "page.html", "--labels", "indices"], "labels cannot go into a page, which has no texts"),
    ],
)
def test_options_that_a_page_has_not(typed: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert words in error_of(["render", "house.obj", *typed], capsys)
    assert [path.name for path in Path().iterdir()] == ["house.obj"]


def test_an_animation_can_hold_the_models_in_place_of_pictures() -> None:
    assert main(["animate", "house.obj", "-o", "live.html", "--live", "--frames", "5", *SMALL]) == 0
    assert main(["animate", "house.obj", "-o", "flat.html", "--frames", "2", *SMALL]) == 0
    live, flat = (Path(name).read_text("utf-8") for name in ("live.html", "flat.html"))
    assert "<title>house</title>" in live
    assert 'id="scene"' in live
    assert "<title>house</title>" in flat
    assert 'id="scene"' not in flat


def test_the_page_of_an_animation_can_be_made_smaller_and_has_a_title() -> None:
    gx.save_mesh(gx.samples.icosphere(3), "ball.obj")
    typed = ["animate", "ball.obj", "--live", "--frames", "3", *SMALL]
    assert main([*typed, "-o", "all.html"]) == 0
    assert main([*typed, "-o", "some.html", "--max-edges", "200", "--title", "A ball"]) == 0
    assert Path("some.html").stat().st_size < Path("all.html").stat().st_size - 2000
    assert "<title>A ball</title>" in Path("some.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["-o", "turn.html", "--max-edges", "9"], "--max-edges must come with --live"),
        (["-o", "turn.gif", "--title", "Turn"], "--title is for web pages, whose names end in .html"),
    ],
)
def test_options_of_pages_that_other_animations_have_not(
    typed: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in error_of(["animate", "house.obj", *typed], capsys)


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["-o", "live.gif"], "live.gif: the type must be one of html, htm, got gif"),
        (["-o", "live.html", "--axes"], "--axes cannot go with --live"),
        (["-o", "live.html", "--rasterizer", "render"], "--rasterizer cannot go with --live: the browser draws"),
    ],
)
def test_options_that_a_live_page_has_not(typed: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert words in error_of(["animate", "house.obj", "--live", *typed], capsys)
