"""The page on continuous integration: its commands run, and what it says of reports and exit codes is so."""

import json
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import get_args

import pytest
import yaml

from gpu_xform import samples, save_mesh
from gpu_xform.cli import exit_codes, main
from gpu_xform.cli.options import MODEL_TYPES
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


def yaml_blocks() -> list[str]:
    return re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize(("schema", "number"), [("github-workflows", 0), ("gitlab-ci", 1)])
def test_recipes_satisfy_their_schemas(schema: str, number: int, tmp_path: Path) -> None:
    path = tmp_path / "recipe.yml"
    path.write_text(yaml_blocks()[number], "utf-8")
    words = ["--builtin-schema", f"vendor.{schema}", str(path)]
    ran = subprocess.run(
        [sys.executable, "-m", "check_jsonschema", *words], capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stdout


def test_the_recipe_of_github_uses_inputs_that_there_are() -> None:
    (step,) = [
        step
        for step in yaml.safe_load(yaml_blocks()[0])["jobs"]["pictures"]["steps"]
        if step["uses"] == "gpu-xform/gpu_xform@COMMIT"
    ]
    assert step["with"].keys() <= yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))["inputs"].keys()


def test_the_script_for_gitlab_runs(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    recipe = yaml.safe_load(yaml_blocks()[1])["pictures"]
    (line,) = recipe["script"]
    assert main([*shlex.split(line)[1:], "--resolution", "96,96"]) == 0
    assert all(
        Path(path).exists() for path in [*recipe["artifacts"]["paths"][:2], recipe["artifacts"]["reports"]["junit"]]
    )


def test_the_hook_of_pre_commit_takes_models_and_compares_them(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
    (named,) = yaml.safe_load(yaml_blocks()[2])["repos"][0]["hooks"]
    assert named["id"] == hook["id"]
    files = re.compile(hook["files"])
    assert all(files.search(f"models/x.{name}") for name in (*MODEL_TYPES, "STL") if name != "npy")
    assert not files.search("models/x.obj.txt")
    words = [*hook["entry"].split()[1:], *hook["args"], "models/house.obj", "models/house.stl"]
    assert main([*words, "--resolution", "96,96"]) == 0
    assert main([*words[:-1], "models/none.obj", "--resolution", "96,96"]) == 2


def test_the_dockerfile_copies_what_the_wheel_needs_and_installs_the_driver() -> None:
    dockerfile = (ROOT / "Dockerfile").read_text("utf-8")
    ignored = (ROOT / ".dockerignore").read_text("utf-8").splitlines()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    needed = {*wheel["packages"], *wheel["force-include"], "pyproject.toml", "README.md", "LICENSE"}
    assert ignored[0] == "*"
    assert {line.removeprefix("!") for line in ignored if line.startswith("!")} == needed
    makefile = (ROOT / "Makefile").read_text("utf-8")
    packages = re.search(r"^DRIVER_PACKAGES := (.*)$", makefile, re.MULTILINE)
    assert packages is not None
    assert all(package in dockerfile for package in packages[1].split())
    assert 'ENTRYPOINT ["gpu-xform"]' in dockerfile
