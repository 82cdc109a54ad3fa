"""`gpu-xform completion`: what bash completes with the script, and what the others print."""

import builtins
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from gpu_xform.cli import main
from gpu_xform.cli.commands import SUMMARIES

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


@pytest.mark.parametrize("shell", ["zsh", "tcsh"])
def test_other_shells_get_a_script_of_all_commands(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    printed = capsys.readouterr().out
    assert all(command in printed for command in SUMMARIES)


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
