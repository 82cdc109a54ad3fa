"""The page on line drawings runs, and lists every line type."""

import re
from pathlib import Path

import gpu_xform as gx
from gpu_xform.drawing.dash_patterns import LINE_TYPES

PAGE = Path(__file__).parents[2] / "docs" / "drawings.md"


def test_the_page_runs(tmp_path: Path) -> None:
    names = {"gx": gx, "path": tmp_path / "picture.png"}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL):
        exec(code, names)  # noqa: S102 - our own page


def test_it_lists_every_line_type() -> None:
    listed = dict(re.findall(r"\| (\d\d) +\| `([a-z-]+)`", PAGE.read_text("utf-8")))
    assert listed == {number: name for number, (name, _) in LINE_TYPES.items()}
