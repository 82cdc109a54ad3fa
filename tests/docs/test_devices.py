"""The page on devices runs."""

from pathlib import Path

from tests.support.python_run import python_output

PAGE = Path(__file__).parents[2] / "docs" / "devices.md"


def test_the_page_runs() -> None:
    _, *blocks = PAGE.read_text("utf-8").split("\n```python\n")
    assert len(blocks) >= 4
    python_output("\n".join(block.partition("\n```")[0] for block in blocks))
