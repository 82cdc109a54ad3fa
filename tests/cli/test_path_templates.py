"""Placeholders in paths."""

from pathlib import Path

import pytest

from gpu_xform.cli.path_templates import Template
from tests.support.cli import error_of, list_pngs


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("plain.png", "plain.png"),
        ("{model}.png", "scan.v2.png"),
        ("{model}/{model}-{folder}.png", "scan.v2/scan.v2-in/put.png"),
        ("{parent}-{model}-{suffix}.png", "put-scan.v2-obj.png"),
        ("{{model}}.png", "{model}.png"),
        ("{{{model}}}.png", "{scan.v2}.png"),
    ],
)
def test_placeholders(text: str, path: str) -> None:
    assert Template(text).path_for("in/put/scan.v2.obj") == path
    assert Template(text).is_per_model == ("scan" in path)
    assert Template("{folder}").path_for("a.obj") == "."
    assert Template("{model}.laz").path_for("in/tile.2.copc.laz") == "tile.2.laz"


@pytest.mark.parametrize(
    ("text", "model", "path"),
    [
        ("pages/{folder}/{model}.png", "../repo/models/a.obj", "pages/repo/models/a.png"),
        ("pages/{folder}/{model}.png", "../../a.obj", "pages/./a.png"),
        ("pages/{model}-{folder}.png", "in/../../x/a.obj", "pages/a-x.png"),
        ("../refs/{folder}/{model}.png", "../models/a.obj", "../refs/models/a.png"),
        ("{folder}/{model}.png", "../models/a.obj", "../models/a.png"),
        ("./{folder}/{model}.png", "../models/a.obj", "./../models/a.png"),
    ],
)
def test_folders_of_models_above_stay_below_the_folder_that_was_typed(text: str, model: str, path: str) -> None:
    assert Template(text).path_for(model) == path


def test_braces_in_a_model_s_name_are_left_alone() -> None:
    assert Template("{folder}/{model}.png").path_for("{model}/{x}.obj") == "{model}/{x}.png"


@pytest.mark.parametrize("option", ["-o", "--reference", "--reference-diff"])
@pytest.mark.parametrize("text", ["{name}.png", "{}.png", "{model:>9}.png", "{model!r}.png", "{.png", "{model}}.png"])
def test_other_braces_are_a_usage_error(option: str, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    message = error_of(["render", "house.obj", option, text], capsys)
    assert f"{option}" in message
    assert "expected {model}, {suffix}, {parent} or {folder}, or doubled braces" in message
    assert not list_pngs()


def test_a_model_without_folder_or_type_has_a_parent_and_no_suffix(working_folder: Path) -> None:
    assert Template("{parent}").path_for("a.obj") == working_folder.name
    assert Template("{model}-{suffix}").path_for("deep/scan") == "scan-"


@pytest.mark.parametrize(
    ("text", "root", "marks_names", "match", "mismatch"),
    [
        ("refs/{model}.png", "refs", False, "refs/a.b.png", "refs/a/b.png"),
        ("refs/{folder}/{model}.png", "refs", False, "refs/x/y/a.png", "refs/a.png"),
        ("r/e-{parent}/{model}-{suffix}.png", "r", True, "r/e-x/a-obj.png", "r/x/a-obj.png"),
        ("{model}.png", "", False, "a.png", "x/a.png"),
        ("{folder}/{model}.expected.png", "", True, "x/a.expected.png", "x/a.png"),
        ("{{r}}/{model}.png", "{r}", False, "{r}/a.png", "r/a.png"),
    ],
)
def test_what_could_be_of_a_template(text: str, root: str, marks_names: bool, match: str, mismatch: str) -> None:
    template = Template(text)
    assert (template.root, template.marks_names) == (root, marks_names)
    assert template.matches(match)
    assert not template.matches(mismatch)
