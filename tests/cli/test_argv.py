"""Values that begin with a minus sign, and suggestions for unknown options."""

import shlex

import pytest

from gpu_xform.cli.argv import attach_values
from tests.support.cli import error_of, list_pngs


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("--translate -0.5,2,0", ["--translate=-0.5,2,0"]),
        ("--translate=-0.5,2,0", ["--translate=-0.5,2,0"]),
        ("--rotate-x -.5 a.obj", ["--rotate-x=-.5", "a.obj"]),
        ("--up -Z -o -", ["--up=-Z", "-o", "-"]),
        ("--up -y --scale 2", ["--up=-y", "--scale", "2"]),
        ("--scale 2 -o out.png", ["--scale", "2", "-o", "out.png"]),
        ("--matrix '-1 0 0'", ["--matrix=-1 0 0"]),
        ("--scale=2 -1.obj", ["--scale=2", "-1.obj"]),
        ("a -- --translate -1.obj", ["a", "--", "--translate", "-1.obj"]),
        ("-1", ["-1"]),
        ("", []),
    ],
)
def test_values_that_begin_with_a_minus_sign(typed: str, expected: list[str]) -> None:
    assert attach_values(shlex.split(typed)) == expected


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("--scal 2 cube.off", "; did you mean --scale?"),
        ("cube.off --frob", ""),
        ("--colour=red --edgs feature --width 2 --colr blue", "; did you mean --color and --edges and --line-width?"),
        ("--out y.png", "; did you mean --output?"),
        ("--rotatex=-30", "; did you mean --rotate-x?"),
        ("--angle 3", ""),
        ("-q", ""),
    ],
)
def test_an_unknown_option_is_no_model(typed: str, meant: str, capsys: pytest.CaptureFixture[str]) -> None:
    message = error_of(["render", "house.obj", "-o", "x.png", *typed.split()], capsys)
    assert message == f"gpu-xform: error: unrecognized arguments: {typed}{meant}\n"
    assert not list_pngs()
