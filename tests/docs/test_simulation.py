"""The page on simulation runs, and its frames are as many as it says."""

from pathlib import Path

import pytest

from tests.support.python_run import python_output

PAGE = Path(__file__).parents[2] / "docs" / "simulation.md"


def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where it writes a state
    _, *blocks = PAGE.read_text("utf-8").split("\n```python\n")
    assert len(blocks) == 5
    cloth, *others = (block.partition("\n```")[0] for block in blocks)
    output = python_output("\n".join([cloth, "print(path.shape)", *others, "print(len(animation), len(together))"]))
    assert output.split("\n")[:2] == ["(31, 441, 3)", "11 21"]
