"""The page on web pages runs, and names keys that there are."""

import re
from pathlib import Path
from typing import Any

import pytest

from gpu_xform.viewer.key_bindings import KEYS

PAGE = Path(__file__).parents[2] / "docs" / "web.md"


def test_the_page_runs_as_it_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL):
        exec(code, names)  # noqa: S102 - our own page


def test_it_tells_of_the_keys_of_the_window() -> None:
    said = PAGE.read_text("utf-8").split("The keys are those of `view`")[1].split("##")[0]
    for keys, _ in KEYS:
        first = keys.split(",")[0]
        assert re.search(rf"\b{first}\b", said) or first == "Q"
