"""The page on CAD files and robots runs: its code, and its commands."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from gpu_xform.cli import main
from tests.support import step_files
from tests.support.urdf_files import ARM, TETRAHEDRON

PAGE = Path(__file__).parents[2] / "docs" / "cad_and_robots.md"


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("part.step").write_bytes(step_files.write_cylinder(20, 50))
    Path("meshes").mkdir()
    Path("meshes/tetra.stl").write_text(TETRAHEDRON, "utf-8")
    Path("arm.urdf").write_text(ARM.replace("package://arm_description/", ""), "utf-8")


def test_its_code_runs_as_it_stands() -> None:
    names: dict[str, Any] = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL):
        exec(code, names)  # noqa: S102 - our own page


def test_its_commands_run(capfd: pytest.CaptureFixture[str]) -> None:
    commands = "".join(re.findall(r"```sh\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)).splitlines()
    for words in map(shlex.split, commands):
        if words[0] == "gpu-xform":
            assert main(words[1:]) == 0, capfd.readouterr().err
