"""The page on simulation runs, and its frames are as many as it says."""

from pathlib import Path

from tests.support.python_run import python_output

PAGE = Path(__file__).parents[2] / "docs" / "simulation.md"


def test_the_page_runs() -> None:
    _, *blocks = PAGE.read_text("utf-8").split("\n```python\n")
    assert len(blocks) == 3
    cloth, *others = (block.partition("\n```")[0] for block in blocks)
    output = python_output("\n".join([cloth, "print(path.shape)", *others, "print(len(animation))"]))
    assert output.split("\n")[:2] == ["(31, 441, 3)", "11"]
