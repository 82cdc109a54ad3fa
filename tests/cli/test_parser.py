"""Help pages, the version, and models between options."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gpu_xform import __version__, samples, save_mesh
from gpu_xform._core import interrupts
from gpu_xform.cli import exit_codes, main
from gpu_xform.cli.argv import attach_values
from gpu_xform.cli.parser import make_parser, parse
from gpu_xform.formats.registry import READERS
from tests.support.cli import read_png

SIXTEEN = "0 -0.3 7 -0.5 0.3 0 0 2 0 5 0.25 11 0 0 0 1"


@pytest.mark.parametrize("option", ["--version", "--help"])
def test_the_version_and_the_help_need_neither_numpy_nor_a_device(option: str) -> None:
    heavy = ["numpy", "wgpu", "trimesh", "PIL", "gpu_xform.cli.options"]
    code = f"""
import contextlib, io, sys
from gpu_xform.cli import main
with contextlib.redirect_stdout(io.StringIO()) as out:
    code = main(["{option}"])
print(code, [name for name in {heavy} if name in sys.modules], len(out.getvalue()) > 10)
"""
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert result.stdout == "0 [] True\n"


def test_the_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr() == (f"gpu-xform {__version__}\n", "")


@pytest.mark.parametrize(
    "name",
    [
        [],
        ["render"],
        ["animate"],
        ["simulate"],
        ["view"],
        ["transform"],
        ["convolve"],
        ["info"],
        ["explain"],
        ["doctor"],
        ["bench"],
        ["completion"],
    ],
)
def test_help_fits_a_terminal_and_its_examples_parse(
    name: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert main([*name, "--help"]) == 0
    page = capsys.readouterr().out
    assert max(map(len, page.splitlines())) <= 80
    lines = page.splitlines()
    options = [i for i, line in enumerate(lines) if line.startswith("  -")]
    assert options
    assert all(re.search(r"\S  +\S", lines[i]) or lines[i + 1].startswith(" " * 20) for i in options)
    Path("pose.txt").write_text(SIXTEEN)
    examples = re.findall(r"(?:^|\| )  ?(?:zcat \S+ \| )?(gpu-xform .*)", page.replace("\\\n", ""), re.MULTILINE)
    assert bool(examples) == (name != ["doctor"])
    for example in examples:
        if "COMMAND" not in example:
            words = shlex.split(re.split(r" \| | > ", example)[0])
            make_parser().parse_args(attach_values(words[1:]))


@pytest.mark.parametrize("name", ["render", "animate", "simulate", "view", "transform", "info"])
def test_help_lists_the_types_that_can_be_read(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([name, "--help"]) == 0
    found = re.search(r"--file-type TYPE .*?:(.*?)\n(?:\n|  -)", capsys.readouterr().out, re.DOTALL)
    assert found is not None
    assert re.split(r",\s+|\s+or\s+", found[1].strip()) == sorted(READERS)


def test_help_lists_each_exit_code_in_ascending_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    listed = capsys.readouterr().out.partition("exit codes:\n")[2].partition("\n\n")[0]
    codes = exit_codes.DEVICE_FAILED, exit_codes.WRONG_INPUT, exit_codes.NO_ADAPTER, exit_codes.MISMATCH
    ends = interrupts.INTERRUPTED, exit_codes.PIPE_CLOSED, interrupts.TERMINATED
    assert [int(line.split()[0]) for line in listed.splitlines()] == [0, *codes, *ends]


def test_help_says_that_a_reference_stands_in_for_a_picture(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "--help"]) == 0
    assert capsys.readouterr().out.startswith(
        "usage: gpu-xform render MODEL... (-o OUT | --reference PNG | ...) [options]\n"
    )


@pytest.mark.parametrize(
    "name",
    ["render", "animate", "simulate", "view", "transform", "convolve", "explain", "doctor", "bench", "completion"],
)
def test_help_is_the_last_option(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([name, "--help"]) == 0
    options = re.findall(r"^  (-.*?)(?:  |\n)", capsys.readouterr().out, re.MULTILINE)
    assert options[-1] == "-h, --help"


def test_models_may_stand_between_the_options() -> None:
    options = parse(["render", "a.obj", "-o", "x.png", "b.obj", "--scale", "2", "c.obj", "--rotate-x", "-90", "-"])
    assert options.models == ["a.obj", "b.obj", "c.obj", "-"]
    assert len(options.steps) == 2
    save_mesh(samples.house(), "house.obj")
    save_mesh(samples.cube(), "cube.off")
    assert main(["render", "house.obj", "-o", "one.png", "--size", "60,40", "cube.off"]) == 0
    assert main(["render", "house.obj", "cube.off", "-o", "other.png", "--size", "60,40"]) == 0
    assert np.array_equal(read_png("one.png"), read_png("other.png"))
