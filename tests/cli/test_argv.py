"""Values that begin with a minus sign, and suggestions for unknown options."""

import shlex

import pytest

from gpu_xform.cli import main
from gpu_xform.cli.argv import attach_values, split_words
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


@pytest.mark.parametrize(
    ("text", "elsewhere", "on_windows"),
    [
        (r"C:\parts\bolt.obj --scale 2", ["C:partsbolt.obj", "--scale", "2"], [r"C:\parts\bolt.obj", "--scale", "2"]),
        (r"'C:\my parts\bolt.obj' -x", [r"C:\my parts\bolt.obj", "-x"], [r"C:\my parts\bolt.obj", "-x"]),
        (r'"my parts/bolt.obj" a#b', ["my parts/bolt.obj", "a#b"], ["my parts/bolt.obj", "a#b"]),
        (r"a\ b.obj", ["a b.obj"], ["a\\", "b.obj"]),
        ("", [], []),
    ],
)
def test_words_of_an_option(text: str, elsewhere: list[str], on_windows: list[str]) -> None:
    assert split_words(text, is_windows=False) == elsewhere == shlex.split(text)
    assert split_words(text, is_windows=True) == on_windows


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (
            "rendr a.obj",
            "explain, doctor, bench, completion, got 'rendr'; did you mean 'render'?",
        ),
        (
            "bench --dtype float23",
            "--dtype: expected float32, float64, got 'float23'; did you mean 'float32'?",
        ),
        ("render a.obj --cmap virids", "got 'virids'; did you mean 'viridis'?"),
        ("render a.obj --rasterizer compte", "got 'compte'; did you mean 'compute'?"),
        ("render a.obj --edges sillhouette", "got 'sillhouette'; did you mean 'silhouette'?"),
        ("render a.obj --edges all,bundary", "got 'all,bundary'; did you mean 'boundary'?"),
        ("render a.obj --hidden removed", "got 'removed'; did you mean 'remove'?"),
        ("render a.obj --color gren", "got 'gren'; did you mean 'green'?"),
        ("render a.obj -o a.pngg", "got pngg; did you mean 'png'?"),
        ("transform a.obj a.pyl", "got pyl; did you mean 'ply'?"),
    ],
)
def test_misspelt_commands_and_values(typed: str, message: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(shlex.split(typed)) == 2
    assert message in capfd.readouterr().err


@pytest.mark.parametrize(
    "typed",
    [
        "render none.obj -o a.png",
        "render none.obj other.obj -o {model}.png",
        "animate none.obj -o a.gif",
        "transform none.obj a.obj",
        "transform none.npy a.npy",
    ],
)
def test_input_is_checked_before_the_device_is_opened(typed: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main([*shlex.split(typed), "--adapter", "no such adapter"]) == 2
    error = capfd.readouterr().err
    assert "No such file or directory" in error
    assert "adapter" not in error
