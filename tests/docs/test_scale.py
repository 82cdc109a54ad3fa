"""The page on points by the billion: its code runs, in order."""

import re
import shlex
from pathlib import Path

import pytest

from gpu_xform.cli import main

PAGE = Path(__file__).parents[2] / "docs" / "scale.md"


@pytest.mark.filterwarnings("ignore:.*NPY does not hold.*")
def test_the_code_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"^```(python|bash)\n(.*?)^```", PAGE.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    assert [kind for kind, _ in blocks] == ["python", "python", "bash", "python", "python", "python", "python"]
    for kind, block in blocks:
        if kind == "python":
            exec(compile(block, str(PAGE), "exec"), names)  # noqa: S102
            continue
        for line in block.splitlines():
            name, *arguments = shlex.split(line)
            assert name == "gpu-xform"
            if "--workers" not in arguments:  # processes are started in tests/test_cluster.py
                assert main(arguments) == 0, line
