"""The page on labels and axes runs, and its picture is what its code draws."""

import re
from pathlib import Path

import numpy as np
from PIL import Image

import gpu_xform as gx

PAGE = Path(__file__).parents[2] / "docs" / "annotations.md"


def test_the_page_draws_its_picture(tmp_path: Path) -> None:
    names = {"gx": gx, "np": np, "path": tmp_path / "hills.png"}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL):
        exec(code, names)  # noqa: S102 - our own page
    with Image.open(PAGE.parent / "images" / "hills.png") as stored, Image.open(tmp_path / "hills.png") as drawn:
        assert stored.size == drawn.size
        difference = np.abs(np.asarray(stored.convert("RGB"), np.int16) - np.asarray(drawn.convert("RGB"))).max(axis=2)
    # Another device may round a rim otherwise, and another FreeType may hint letters otherwise.
    assert np.count_nonzero(difference > 32) <= 2000
