"""`gpu-xform completion`: what bash completes with the script, and what the others print."""

import builtins
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from gpu_xform.animation.encoders.registry import ENCODERS
from gpu_xform.cli import main
from gpu_xform.cli.commands import SUMMARIES
from gpu_xform.cli.completions import BY_NAME, _list_adapters, find_completions
from gpu_xform.cli.parser import make_parser
from gpu_xform.drawing.page import PAPERS
from gpu_xform.gpu.adapters import find_adapter

TRY = """
source "$1"; shift
function=$(complete -p gpu-xform | sed 's/.*-F \\([^ ]*\\).*/\\1/')
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
"$function" gpu-xform "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("completion") / "gpu-xform"
    with pytest.MonkeyPatch.context() as patch, path.open("w") as file:
        patch.setattr("sys.stdout", file)
        assert main(["completion", "bash"]) == 0
    return path


def complete(script: Path, words: Sequence[str], folder: Path) -> list[str]:
    bash = shutil.which("bash")
    assert bash
    arguments = [bash, "-c", TRY, "bash", str(script), "gpu-xform", *words]
    return subprocess.run(arguments, cwd=folder, capture_output=True, check=True, text=True).stdout.split()


def test_bash_completes_commands_options_and_files(script: Path, tmp_path: Path) -> None:
    (tmp_path / "house.obj").touch()
    (tmp_path / "horse.ply").touch()
    assert set(complete(script, [""], tmp_path)) >= SUMMARIES.keys()
    assert complete(script, ["conv"], tmp_path) == ["convolve"]
    assert complete(script, ["render", "--feat"], tmp_path) == ["--feature-angle"]
    assert complete(script, ["transform", "--resu"], tmp_path) == ["--resume"]
    assert set(complete(script, ["render", "ho"], tmp_path)) == {"house.obj", "horse.ply"}
    assert complete(script, ["convolve", "hou"], tmp_path) == ["house.obj"]


def test_bash_completes_the_values_of_options(script: Path, tmp_path: Path) -> None:
    for name in ("part.STL", "colors.npy", "reference.png", "notes.txt", "my part.obj"):
        (tmp_path / name).touch()
    (tmp_path / "folder").mkdir()
    for typed, expected in (
        ("render --hidden r", ["remove"]),
        ("render --edges feature,si", ["feature,silhouette"]),
        ("render --fill go", ["gold", "goldenrod"]),
        ("render --fill col", ["colors.npy"]),
        ("render --cmap viridis", ["viridis"]),
        ("render --labels n", ["names", "notes.txt"]),
        ("render --units c", ["cm"]),
        ("render --paper A4", ["A4", "A4-landscape"]),
        ("render --reference r", ["reference.png"]),
        ("render part", ["part.STL"]),
        ("render fo", ["folder"]),
        ("render part.STL -o ", ["reference.png", "folder"]),
        ("simulate c", ["cloth", "curtain", "colors.npy"]),
        ("simulate cloth --pin left,to", ["left,top"]),
        ("transform --adapter ho", ["host"]),
        ("convolve notes.txt --border s", ["symmetric"]),
        ("bench --dtype float6", ["float64"]),
    ):
        assert complete(script, typed.split(" "), tmp_path) == expected, typed
    assert complete(script, ["render", "my\\ p"], tmp_path) == ["my", "part.obj"]  # one name, split here


def test_options_take_what_completes_them() -> None:
    commands = make_parser().get_default("command_parsers")
    for command in commands.values():
        command.fill()
    found = find_completions(commands)
    options = {name for action in found for name in action.option_strings}
    assert options > {"--hidden", "--fill", "--cmap", "--file-type", "--adapter", "--rasterizer", "--axis", "--report"}
    for action, completion in found.items():
        parse: Any = action.type or str
        for word in completion.words:
            parse(word)  # raises otherwise
        if action.choices:
            assert completion.words == tuple(action.choices)
    assert set(BY_NAME["animate output"].file_types) == set(ENCODERS)
    assert set(PAPERS) <= set(BY_NAME["paper"].words)


def test_names_of_adapters_choose_them() -> None:
    assert [find_adapter(word).info["device"].split()[0] for word in _list_adapters()] == list(_list_adapters())


@pytest.mark.parametrize("shell", ["zsh", "tcsh"])
def test_other_shells_get_a_script_of_all_commands(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    printed = capsys.readouterr().out
    assert all(command in printed for command in SUMMARIES)
    assert "show remove dash fade" in printed


def test_without_the_extra_the_command_names_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    load = builtins.__import__

    def refuse(name: str, *arguments: Any, **keywords: Any) -> Any:
        if name == "shtab":
            raise ImportError("No module named 'shtab'")
        return load(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", refuse)
    assert main(["completion", "bash"]) == 2
    assert "pip install 'gpu_xform[completion]'" in capsys.readouterr().err


def test_another_shell_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "fish"]) == 2
    assert "argument SHELL: expected bash, zsh, tcsh, got 'fish'" in capsys.readouterr().err
