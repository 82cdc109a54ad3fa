"""Placeholders in paths."""

import pytest

from gpu_xform.cli.path_templates import Template
from tests.support.cli import error_of, list_pngs


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("plain.png", "plain.png"),
        ("{model}.png", "scan.v2.png"),
        ("{model}/{model}-{folder}.png", "scan.v2/scan.v2-in/put.png"),
        ("{{model}}.png", "{model}.png"),
        ("{{{model}}}.png", "{scan.v2}.png"),
    ],
)
def test_placeholders(text: str, path: str) -> None:
    assert Template(text).path_for("in/put/scan.v2.obj") == path
    assert Template(text).is_per_model == ("scan" in path)
    assert Template("{folder}").path_for("a.obj") == "."


def test_braces_in_a_model_s_name_are_left_alone() -> None:
    assert Template("{folder}/{model}.png").path_for("{model}/{x}.obj") == "{model}/{x}.png"


@pytest.mark.parametrize("option", ["-o", "--reference", "--reference-diff"])
@pytest.mark.parametrize("text", ["{name}.png", "{}.png", "{model:>9}.png", "{model!r}.png", "{.png", "{model}}.png"])
def test_other_braces_are_a_usage_error(option: str, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    message = error_of(["render", "house.obj", option, text], capsys)
    assert f"{option}" in message
    assert "expected {model} or {folder}, or doubled braces" in message
    assert not list_pngs()
