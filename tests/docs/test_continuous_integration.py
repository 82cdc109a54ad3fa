"""The page on continuous integration: its commands run, and what it says of reports and exit codes is so."""

import json
import re
import shlex
from pathlib import Path
from typing import get_args

import pytest

from gpu_xform import samples, save_mesh
from gpu_xform.cli import exit_codes, main
from gpu_xform.cli.outcome import Status

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "continuous_integration.md").read_text("utf-8")
COMMANDS = [
    shlex.split(line)[1:]
    for block in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    for line in block.replace("\\\n", " ").splitlines()
    if line.startswith("gpu-xform ")
]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where all commands of the page have run, one after the other."""
    folder = tmp_path_factory.mktemp("ci")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path("models").mkdir()
        save_mesh(samples.house(), "models/house.obj")
        save_mesh(samples.cube(), "models/house.stl")
        for words in COMMANDS:
            assert main([*words, "--resolution", "96,96"]) == 0
    return folder


def test_the_commands_run(place: Path) -> None:
    assert len(COMMANDS) >= 4
    made = {path.relative_to(place).as_posix() for path in place.rglob("*") if path.is_file()}
    assert made >= {
        "references/house-stl.png",
        "sheet.png",
        "sheet.pdf",
        "report.html",
        "report.xml",
        "drawn/house-obj.png",
    }


def test_the_page_lists_what_the_json_report_holds(place: Path) -> None:
    report = json.loads((place / "report.json").read_bytes())
    paragraph = PAGE.split("`report.json` is for programs")[1].split("\n\n")[0]
    named = set(re.findall(r"`(\w[\w ]*)`", paragraph.replace("\n", " ")))
    assert named == {*report, *report["pictures"][0], *get_args(Status)}


def test_the_page_lists_the_exit_codes() -> None:
    codes = exit_codes.DEVICE_FAILED, exit_codes.WRONG_INPUT, exit_codes.NO_ADAPTER, exit_codes.MISMATCH
    assert [int(code) for code in re.findall(r"^\| (\d)  +\|", PAGE, re.MULTILINE)] == [0, *codes]
