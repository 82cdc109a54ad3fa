"""The tutorials run, block by block and command by command, and leave what they say."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.support.pages import run_page

FOLDER = Path(__file__).parents[2] / "docs" / "tutorials"
PICTURES = {
    "ci": ["pictures/house.png", "pictures/ring.png", "differences/house.png"],
    "illustration": ["teapot.svg", "ring.svg", "ring.pdf", "sheet.pdf", "section.png", "ring.png"],
    "lidar": ["scan.png"],
    "robotics": ["arm.png", "reach.webp"],
    "teaching": ["order.png", "cubes.png", "cube.html"],
}


def test_there_is_a_tutorial_per_kind_of_user() -> None:
    assert {path.stem for path in FOLDER.glob("*.md")} == set(PICTURES)


@pytest.mark.slow
@pytest.mark.parametrize("name", PICTURES)
def test_a_tutorial_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ran = run_page(FOLDER / f"{name}.md", tmp_path, monkeypatch)
    assert ran.names["gx"].__name__ == "gpu_xform"
    for picture in PICTURES[name]:
        path = tmp_path / picture
        if path.suffix == ".png":
            with Image.open(path) as image:
                white = Image.new("RGBA", image.size, "white")
                ink = np.asarray(Image.alpha_composite(white, image.convert("RGBA")))[..., :3].min(axis=2) < 200
            assert 0.002 < ink.mean() < 0.95, picture
        else:
            assert path.stat().st_size > 1000, picture
    if name == "ci":
        assert not (tmp_path / "differences" / "ring.png").exists()
