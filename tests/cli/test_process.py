"""The process of the command: how it ends by signals, on full disks, with closed streams, and what a terminal gets."""

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gpu_xform import Scene, samples, save_mesh
from gpu_xform.cli import main
from tests.support.python_run import linux_only

COMMAND = [sys.executable, "-m", "gpu_xform"]
UNBUFFERED = [sys.executable, "-u", "-m", "gpu_xform"]

# Raises a signal when a module is imported, or when the encoder of GIFs has written its first bytes.
RAISE_AT_IMPORT = """
import signal, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            signal.raise_signal(signal.{signal})
sys.meta_path.insert(0, Finder())
from gpu_xform_command import main
sys.exit(main())
"""
RAISE_IN_ENCODER = """
import signal, sys
from gpu_xform.animation.encoders import registry
write = registry.ENCODERS["gif"]
def interrupted(file, sequence):
    file.write(b"begun")
    signal.raise_signal(signal.{signal})
registry.ENCODERS["gif"] = interrupted
from gpu_xform.__main__ import main
sys.exit(main())
"""


RAISE_IN_FINALIZER = """
import signal, sys, time, weakref
from gpu_xform.cli import commands
from gpu_xform.cli.commands import info
class Owner: pass
def interrupted(options):
    owner = Owner()
    reference = weakref.ref(owner, lambda _: signal.raise_signal(signal.{signal}))
    del owner
    for _ in range(500):
        time.sleep(0.01)
    return 0
info.run = interrupted
from gpu_xform.__main__ import main
sys.exit(main())
"""

# As a dataclass does, which makes its methods from a text.
RAISE_IN_EXEC = """
import signal, sys
from gpu_xform.cli.commands import info
info.run = lambda options: exec("signal.raise_signal(signal.{signal})", {{"signal": signal}})
from gpu_xform.__main__ import main
sys.exit(main())
"""


@pytest.fixture(autouse=True)
def _files() -> None:
    save_mesh(samples.cube(), "cube.obj")
    np.save("points.npy", np.ones((20_000, 3)))


def ends_of(command: list[str], **options: object) -> tuple[int, bytes]:
    """Return the exit code of a process and what it writes to standard error."""
    result = subprocess.run(command, stderr=subprocess.PIPE, check=False, timeout=60, **options)  # type: ignore[call-overload]
    return result.returncode, result.stderr


@pytest.mark.parametrize(
    ("module", "name", "end"),
    [
        ("gpu_xform", "SIGINT", (130, b"gpu-xform: interrupted\n")),
        ("gpu_xform", "SIGTERM", (143, b"gpu-xform: terminated\n")),
        ("gpu_xform._core.interrupts", "SIGTERM", (143, b"gpu-xform: terminated\n")),
        ("gpu_xform._core.interrupts", "SIGINT", (130, b"gpu-xform: interrupted\n")),
        ("gpu_xform.cli", "SIGINT", (130, b"gpu-xform: interrupted\n")),
        ("argparse", "SIGTERM", (143, b"gpu-xform: terminated\n")),
        ("numpy", "SIGINT", (130, b"gpu-xform: interrupted\n")),
        # By the compiled part of NumPy, which makes another error of what is raised there.
        ("datetime", "SIGINT", (130, b"gpu-xform: interrupted\n")),
        ("datetime", "SIGTERM", (143, b"gpu-xform: terminated\n")),
    ],
)
def test_a_signal_during_imports_ends_in_one_line(module: str, name: str, end: tuple[int, bytes]) -> None:
    code = RAISE_AT_IMPORT.format(name=module, signal=name)
    assert ends_of([sys.executable, "-c", code, "info", "cube.obj"], stdout=subprocess.DEVNULL) == end


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_signal_while_a_finalizer_runs_is_not_lost(name: str, code: int) -> None:
    command = [sys.executable, "-c", RAISE_IN_FINALIZER.format(signal=name), "info", "cube.obj"]
    word = {130: b"interrupted", 143: b"terminated"}[code]
    assert ends_of(command, stdout=subprocess.DEVNULL) == (code, b"gpu-xform: " + word + b"\n")


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_signal_while_a_text_is_executed_gives_the_exit_code(name: str, code: int) -> None:
    """Python 3.11 remembers such a Ctrl+C even if it is caught, and kills a program of `python -m` at its end."""
    Path("program.py").write_text(RAISE_IN_EXEC.format(signal=name), "utf-8")
    command = [sys.executable, "-m", "program", "info", "cube.obj"]
    word = {130: b"interrupted", 143: b"terminated"}[code]
    assert ends_of(command, stdout=subprocess.DEVNULL) == (code, b"gpu-xform: " + word + b"\n")


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_signal_leaves_no_temporary_file(name: str, code: int) -> None:
    program = RAISE_IN_ENCODER.format(signal=name)
    command = [sys.executable, "-c", program, "animate", "cube.obj", "-o", "cube.gif", "--frames", "2"]
    assert ends_of([*command, "--resolution", "32,32"])[0] == code
    assert sorted(os.listdir()) == ["cube.obj", "points.npy"]  # noqa: PTH208


@linux_only
@pytest.mark.parametrize(
    ("start", "typed"),
    [
        (COMMAND, ["--help"]),
        (UNBUFFERED, ["--help"]),
        (COMMAND, ["explain", "--scale", "2"]),
        (UNBUFFERED, ["info", "cube.obj"]),
    ],
)
def test_what_cannot_be_printed_is_no_success(start: list[str], typed: list[str]) -> None:
    command = subprocess.list2cmdline([*start, *typed]) + " > /dev/full"
    code, printed = ends_of(["sh", "-c", command])
    assert (code, printed) == (2, b"gpu-xform: error: standard output: No space left on device\n")


def limit_files() -> None:
    """Let no file grow beyond 1,000 bytes: a write across the limit is cut short, the next fails."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))


@pytest.mark.parametrize("typed", [["--help"], ["transform", "points.npy", "-"], ["transform", "cube.obj", "-"]])
def test_output_that_is_cut_short_is_no_success(typed: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GPU_XFORM_ADAPTER", "host")  # others keep memory in files, and end by a signal
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # files of it would be cut short, and spoil the next import
    save_mesh(samples.icosphere(2), "cube.obj")
    np.save("points.npy", np.ones((500, 3)))  # too few to be worth numba, whose files would be cut short, too
    with Path("out").open("wb") as out:
        code, printed = ends_of([*UNBUFFERED, *typed], stdout=out, preexec_fn=limit_files)
    assert (code, printed) == (2, b"gpu-xform: error: standard output: File too large\n")


@pytest.mark.parametrize(
    ("closing", "typed", "code"),
    [
        ("2>&-", ["info", "none.obj"], 2),
        ("2>&-", ["render", "cube.obj", "-o", "{model}.txt"], 2),
        (">&-", ["info", "cube.obj"], 2),
        (">&-", ["--help"], 2),
    ],
)
def test_closed_streams_change_no_exit_code(closing: str, typed: list[str], code: int) -> None:
    command = subprocess.list2cmdline([*COMMAND, *typed])
    assert ends_of(["sh", "-c", f"{command} {closing}"], stdout=subprocess.DEVNULL)[0] == code


ESCAPE = "\x1b[31mred\x07\u202e"


@pytest.mark.parametrize(
    "typed",
    [
        [f"in{ESCAPE}fo"],
        ["info", f"none{ESCAPE}.obj"],
        ["info", "cube.obj", f"--{ESCAPE}"],
        ["info", f"broken{ESCAPE}.obj"],
        ["render", "cube.obj", "-o", f"x.{ESCAPE}"],
        ["render", "cube.obj", "-o", "x.png", "--color", ESCAPE],
        ["render", "cube.obj", f"none{ESCAPE}.obj", "-o", "{model}.png", "--resolution", "8,8"],
        ["transform", "cube.obj", "x.obj", "--adapter", ESCAPE],
        ["info", "named.stl"],
    ],
)
def test_no_control_character_reaches_a_terminal(typed: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    Path(f"broken{ESCAPE}.obj").write_text(f"v 1 2 {ESCAPE}\n")
    Path("named.stl").write_text(f"solid {ESCAPE}\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                 f"vertex 0 1 0\nendloop\nendfacet\nendsolid {ESCAPE}\n")  # fmt: skip
    main(typed)
    printed = capfd.readouterr()
    assert printed.out + printed.err
    for character in "\x1b\x07\u202e":
        assert character not in printed.out + printed.err


SPOOF = "a\nspoof"


@pytest.mark.parametrize(
    "typed",
    [
        ["info", f"{SPOOF}.gltf"],
        ["info", f"none{SPOOF}.obj"],
        ["info", "cube.obj", f"--{SPOOF}"],
        ["render", f"{SPOOF}.gltf", "-v", "-o", f"{SPOOF}.png", "--resolution", "8,8"],
        ["render", f"{SPOOF}.gltf", f"none{SPOOF}.obj", "-o", "{model}.png", "--resolution", "8,8"],
        ["render", "cube.obj", "--reference", f"{SPOOF}.png", "--update-references", "--resolution", "8,8"],
        ["render", "cube.obj", "-o", f"{SPOOF}.png", "--resolution", "8,8", "--camera", "0,0,5", "--target", "0,0,9"],
        ["transform", f"{SPOOF}.gltf", f"{SPOOF}.obj", "-v", "--scale", "2"],
        ["transform", "points.npy", f"{SPOOF}.npy", "-v", "--scale", "2"],
        ["animate", f"{SPOOF}.gltf", "-v", "-o", f"{SPOOF}.gif", "--frames", "2", "--resolution", "8,8"],
    ],
)
def test_no_name_begins_a_line(typed: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    scene = Scene()
    scene.add(samples.cube(), name=SPOOF)
    scene.add(samples.house(), name=f"{SPOOF}2")
    save_mesh(scene, f"{SPOOF}.gltf")
    main(typed)
    printed = capfd.readouterr()
    lines = (printed.out + printed.err).splitlines()
    assert lines
    assert not [line for line in lines if line.lstrip().startswith("spoof")]


@pytest.mark.parametrize("raise_it", [lambda: main(["info", "cube.obj"])])
def test_main_in_a_program_of_someone_else_leaves_its_signals_alone(raise_it: Callable[[], int]) -> None:
    before = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)
    raise_it()
    assert (signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)) == before
