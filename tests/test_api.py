"""The page that lists all names lists those there are."""

import re
from pathlib import Path

import gpu_xform
from gpu_xform import errors

PAGE = (Path(__file__).parent.parent / "docs" / "api.md").read_text("utf-8")
ROWS = re.findall(r"^\| `(\w+)` +\| (.+?) +\|$", PAGE, re.MULTILINE)


def test_the_page_names_exactly_the_public_names() -> None:
    names = [name for name, _ in ROWS]
    assert sorted(names) == gpu_xform.__all__
    assert len(names) == PAGE.count("\n| `")


def test_the_page_says_what_an_error_is_besides() -> None:
    for name, phrase in ROWS:
        value = getattr(gpu_xform, name)
        if value is errors.GpuXformError or not isinstance(value, type) or not issubclass(value, errors.GpuXformError):
            continue
        others = {base.__name__ for base in value.__bases__} - {"GpuXformError"}
        assert set(re.findall(r"`(\w+)`", phrase)) == others, name
