"""The README does what it says: its lines run, its pictures are what scripts draw, its links lead somewhere."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from docs.builder.gallery import run_script
from docs.builder.project import REPOSITORY, SITE
from tests.support.pages import run_page

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "README.md").read_text(encoding="utf-8")
PICTURES = re.findall(r'src="([^"]+)"', PAGE)


@pytest.mark.slow
def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    ran = run_page(ROOT / "README.md", tmp_path, monkeypatch)
    assert [line.split()[1] for line in ran.commands] == [
        *("doctor", "render", "render", "render", "render", "simulate", "transform")
    ]
    assert "Everything works." in capfd.readouterr().out
    for name in ("house.png", "teapot.png", "torus.svg", "house.gif", "cloud.png", "turned.png", "thumbs/house.png"):
        assert (tmp_path / name).stat().st_size > 500, name
    points, matrix, moved = (ran.names[name] for name in ("points", "matrix", "moved"))
    np.testing.assert_allclose(moved, points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3], rtol=0, atol=5e-6)


def test_the_page_is_short_and_shows_three_pictures() -> None:
    assert PAGE.count("\n") <= 125
    assert PAGE.count("```") == 2 * len(re.findall(r"^```(?:sh|python)$", PAGE, re.MULTILINE))
    assert len(PICTURES) == 3


PAGES = [
    *sorted(ROOT.glob("*.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
    *(ROOT / folder / "README.md" for folder in ("benchmarks", "packaging")),
]


def anchors(page: str) -> set[str]:
    titles = re.findall(r"^#+ (.+)$", page, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_links_lead_somewhere(path: Path) -> None:
    page = path.read_text("utf-8")
    if path.is_relative_to(ROOT / "docs" / "builder"):
        return  # pages with names of the site, which its build resolves
    for target in re.findall(r'\]\(([^)\s]+)\)|src="([^"]+)"', page):
        file, _, anchor = "".join(target).partition("#")
        if file.startswith("https://"):
            continue
        linked = path.parent / file if file else path
        assert linked.exists(), file
        assert not anchor or anchor in anchors(linked.read_text("utf-8")), anchor


def test_addresses_are_those_of_the_project() -> None:
    for address in re.findall(r"https://[^)\s]+", PAGE):
        assert address.startswith((REPOSITORY, SITE)), address


def test_the_page_names_targets_that_there_are() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE))
    named = set(re.findall(r"(?:^|`)make ([a-z-]+)", PAGE, re.MULTILINE))
    assert {"demo", "test", "check", "docs", "help"} <= named <= targets


@pytest.mark.slow
def test_the_demo_draws_what_the_page_shows(tmp_path: Path) -> None:
    demo = ROOT / "examples" / "demo.py"
    ran = subprocess.run([sys.executable, demo], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    written = re.findall("^wrote (.+)$", ran.stdout, re.MULTILINE)
    assert sorted(written) == sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.glob("demo/*"))
    for shown in ("teapot.png", "snub_dodecahedron.png"):
        assert_alike(ROOT / "docs" / "images" / shown, tmp_path / "demo" / shown, 8, 50)


@pytest.mark.slow
def test_a_script_of_the_gallery_draws_the_scan(tmp_path: Path) -> None:
    drawn = run_script(ROOT / "examples" / "gallery" / "terrain_scan.py", tmp_path)
    with Image.open(ROOT / "docs" / "images" / "terrain_scan.png") as stored, Image.open(drawn) as image:
        small = image.convert("RGB").resize(stored.size, Image.Resampling.LANCZOS)
        difference = np.abs(np.asarray(stored.convert("RGB"), np.int16) - np.asarray(small))
    assert difference.mean() < 6  # the stored one has a palette


def assert_alike(stored: Path, drawn: Path, threshold: int, most: int) -> None:
    """Another device may round a rim otherwise; an edge too many or too few covers more than this."""
    with Image.open(stored) as image, Image.open(drawn) as other:
        assert (image.mode, image.size) == (other.mode, other.size)
        difference = np.abs(np.asarray(image, np.int16) - np.asarray(other)).max(axis=2)
    assert np.count_nonzero(difference > threshold) <= most
