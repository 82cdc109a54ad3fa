"""The page on line drawings runs, and lists every line type."""

import re
from pathlib import Path

import gpu_xform as gx
from gpu_xform.cli.options import STYLE
from gpu_xform.drawing.dash_patterns import LINE_TYPES
from gpu_xform.vector.coincident import MAX_SEGMENTS

PAGE = Path(__file__).parents[2] / "docs" / "drawings.md"


def test_the_page_runs(tmp_path: Path) -> None:
    names = {"gx": gx, "path": tmp_path / "picture.png"}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL):
        exec(code, names)  # noqa: S102 - our own page


def test_it_lists_every_line_type() -> None:
    listed = dict(re.findall(r"\| (\d\d) +\| `([a-z-]+)`", PAGE.read_text("utf-8")))
    assert listed == {number: name for number, (name, _) in LINE_TYPES.items()}


def test_it_says_how_many_segments_may_be_searched_for_those_that_lie_on_others() -> None:
    limit = f"{MAX_SEGMENTS:,} segments"
    for place in (PAGE, PAGE.with_name("features.md")):
        assert limit in place.read_text("utf-8")
    options = {option.flag: option.help for option in STYLE}
    assert all(limit in " ".join(text.split()) for text in (gx.Layer.__doc__ or "", options["--hidden"]))
