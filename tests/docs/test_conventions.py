import re
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parents[2] / "docs" / "conventions.md"


def test_the_page_runs() -> None:
    page = PAGE.read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    blocks = list(re.finditer(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL))
    for block in blocks:
        line = page.count("\n", 0, block.start(1))
        exec(compile("\n" * line + block[1], str(PAGE), "exec"), names)  # noqa: S102 - the page is ours
    assert len(blocks) == page.count("```python")


def test_every_section_but_pictures_has_an_example_that_asserts() -> None:
    _, *sections = PAGE.read_text(encoding="utf-8").split("\n## ")
    titles = [section.partition("\n")[0] for section in sections if "\nassert " not in section]
    assert titles == ["Pictures"]
