"""The GitHub Action, whose shell runs here: pictures, outputs, the branch of pictures, the summary, and failure."""

import json
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from gpu_xform import Mesh, samples, save_mesh
from gpu_xform.cli import main
from tests.support.composite_action import ActionRun, run_action

ROOT = Path(__file__).parents[2]
ACTION = ROOT / "action.yml"
SIZE = "--resolution 64,64"
ENVIRONMENT = {
    "GPU_XFORM_ENVIRONMENT": sys.prefix,
    "GITHUB_SERVER_URL": "https://github.example",
    "GITHUB_REPOSITORY": "someone/parts",
    "GITHUB_SHA": "0123abc",
    "GITHUB_RUN_ID": "77",
    "GITHUB_RUN_ATTEMPT": "1",
    "GITHUB_JOB": "look",
}
INSTALL = "Install gpu_xform and a software driver"


def git(*words: str, cwd: Path) -> str:
    identity = ["-c", "user.name=t", "-c", "user.email=t@example.org", "-c", "init.defaultBranch=main"]
    ran = subprocess.run(["git", *identity, *words], cwd=cwd, capture_output=True, text=True, check=True)  # noqa: S607
    return ran.stdout


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clone whose models have references, one of which no longer fits, and one model that is broken."""
    origin, folder = tmp_path / "origin.git", tmp_path / "checkout"
    git("init", "-q", "--bare", str(origin), cwd=tmp_path)
    git("clone", "-q", str(origin), str(folder), cwd=tmp_path)
    monkeypatch.chdir(folder)
    Path("my models").mkdir()
    house = samples.house()
    for name in ("a [1].obj", "changed.obj", "broken.obj"):
        save_mesh(house, f"my models/{name}")
    words = ["--reference", "refs/{model}.png", "--update-references", *SIZE.split()]
    assert main(["render", "my models", *words]) == 0
    git("add", "-A", cwd=folder)
    git("commit", "-qm", "Models", cwd=folder)
    save_mesh(Mesh(house.positions, house.faces[2:]), "my models/changed.obj")
    Path("my models/broken.obj").write_text("nothing")
    return folder


@pytest.fixture
def act(checkout: Path, tmp_path: Path) -> Callable[..., ActionRun]:
    def run(models: str = "my models\n", **inputs: str) -> ActionRun:
        temporary = tmp_path / "runner temp"
        shutil.rmtree(temporary, ignore_errors=True)
        temporary.mkdir()
        values = {"models": models, "references": "refs/{model}.png", "options": SIZE} | {
            name.replace("_", "-"): value for name, value in inputs.items()
        }
        given = {"upload": {"artifact-url": "https://github.example/artifact"}}
        return run_action(ACTION, checkout, temporary, values, ENVIRONMENT, given, (INSTALL,))

    return run


@pytest.mark.slow  # five processes draw, commit and summarise
def test_a_difference_fails_with_pictures_on_a_branch_and_in_the_summary(
    act: Callable[..., ActionRun], checkout: Path
) -> None:
    run = act(pictures_branch="pictures")
    assert run.exit_code == 2, run.log
    pictures = Path(run.outputs["draw"]["pictures"])
    assert {path.relative_to(pictures).as_posix() for path in pictures.rglob("*") if path.is_file()} == {
        *("report.html", "report.json", "report.xml", "differences/my models/changed-obj.png"),
        *("drawn/my models/changed-obj.png", "drawn/my models/a [1]-obj.png"),
    }
    commit = run.outputs["publish"]["commit"]
    git("fetch", "-q", "origin", "pictures", cwd=checkout)
    listed = git("ls-tree", "-r", "--name-only", commit, cwd=checkout).split()
    assert listed == [f"77-1-look/{i}-{name}.png" for i, name in expected_files(pictures)]
    assert git("status", "--porcelain", cwd=checkout).count("\n") == 2  # the two models that were changed
    images = re.findall(r'src="([^"]+)"', run.summary)
    base = "https://github.example/someone/parts/raw/"
    assert set(images) == {
        f"{base}0123abc/refs/a%20%5B1%5D.png",
        f"{base}0123abc/refs/broken.png",
        f"{base}0123abc/refs/changed.png",
        *(f"{base}{commit}/77-1-look/{i}-{name}.png" for i, name in expected_files(pictures)),
    }
    assert "## :x: Pictures of models: 1 not drawn, 1 different from the reference, 1 as expected" in run.summary
    assert "(https://github.example/artifact)" in run.summary
    # The next run adds to the branch.
    again = act(pictures_branch="pictures").outputs["publish"]["commit"]
    git("fetch", "-q", "origin", "pictures", cwd=checkout)
    assert git("rev-parse", f"{again}^", cwd=checkout).strip() == commit


def expected_files(pictures: Path) -> list[tuple[int, str]]:
    records = json.loads((pictures / "report.json").read_bytes())["pictures"]
    (place,) = (i for i, record in enumerate(records) if record["status"] == "differs")
    return [(place, "difference"), (place, "picture")]


@pytest.mark.slow  # as above
def test_without_the_right_to_push_there_is_a_warning_and_a_summary(
    act: Callable[..., ActionRun], checkout: Path
) -> None:
    git("remote", "set-url", "origin", "nowhere", cwd=checkout)
    run = act(pictures_branch="pictures")
    assert run.exit_code == 2
    assert "::warning::the pictures could not be pushed to pictures" in run.log
    assert "commit" not in run.outputs["publish"]
    assert len(re.findall("<img", run.summary)) == 3
    link = '<td><a href="https://github.example/artifact">in the artifact</a></td>'
    assert run.summary.count(link) == 2  # the picture and the difference


def test_what_matches_passes_and_words_are_not_expanded(act: Callable[..., ActionRun]) -> None:
    run = act("my models/a [1].obj\n", options=f"{SIZE} --background-color '#ffffff' --report '$(touch evil).json'")
    assert Path("$(touch evil).json").is_file()
    assert not Path("evil").exists()
    assert (run.exit_code, run.outputs["draw"]["exit-code"]) == (0, "0"), run.log
    assert "## :white_check_mark: Pictures of models: 1 as expected" in run.summary


def test_wrong_usage_fails_at_once(act: Callable[..., ActionRun]) -> None:
    run = act("nowhere/**")
    assert run.exit_code == 2
    assert "nowhere/**" in run.log
    assert run.summary == ""


def test_options_with_an_open_quote_fail_and_are_named(act: Callable[..., ActionRun]) -> None:
    run = act(options=f"{SIZE} --title \"a b'")
    assert run.exit_code != 0
    assert [line for line in run.log.splitlines() if "::error::" in line or "Traceback" in line] == [
        f"::error::options: No closing quotation, in {SIZE} --title \"a b'"
    ]
    assert "pictures:" not in run.log


def test_the_workflow_of_this_repository_uses_the_action_on_models_that_match() -> None:
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8"))
    (step,) = [step for job in workflow["jobs"].values() for step in job["steps"] if step.get("uses") == "./"]
    given = step["with"]
    assert given.keys() <= yaml.safe_load(ACTION.read_text("utf-8"))["inputs"].keys()
    words = [str(ROOT / given["models"]), "--reference", str(ROOT / given["references"]), *given["options"].split()]
    assert main(["render", *words]) == 0  # on whatever adapter the tests run


def test_extras_are_those_of_the_project() -> None:
    known = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    extras = yaml.safe_load(ACTION.read_text("utf-8"))["inputs"]["extras"]["default"]
    assert set(extras.split(",")) <= known.keys()
    for path in ("Dockerfile", "docs/continuous_integration.md"):
        assert f"[{extras}]" in (ROOT / path).read_text("utf-8")


def test_other_actions_are_pinned_as_in_the_workflow() -> None:
    pinned = re.compile(r"uses: (\S+?)@([0-9a-f]{40}) # v[\d.]+$", re.MULTILINE)
    workflow = dict(pinned.findall((ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8")))
    used = pinned.findall(ACTION.read_text("utf-8"))
    assert used
    assert all(workflow[name] == commit for name, commit in used)
    assert ACTION.read_text("utf-8").count("uses: ") == len(used)


@pytest.mark.parametrize(
    ("schema", "path"),
    [
        ("github-actions", "action.yml"),
        ("github-workflows", ".github/workflows/ci.yml"),
    ],
)
def test_files_satisfy_their_schemas(schema: str, path: str) -> None:
    ran = subprocess.run(
        [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}", str(ROOT / path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout


def test_the_page_lists_every_input_and_output() -> None:
    page = (ROOT / "docs" / "continuous_integration.md").read_text("utf-8").split("## GitHub")[1].split("\n## ")[0]
    definition = yaml.safe_load(ACTION.read_text("utf-8"))
    assert set(re.findall(r"^\| `([\w-]+)`", page, re.MULTILINE)) == {*definition["inputs"], *definition["outputs"]}
