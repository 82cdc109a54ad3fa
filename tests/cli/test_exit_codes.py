import contextlib
import errno
import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest

from gpu_xform import Mesh, PrecisionError, samples, save_mesh
from gpu_xform._core.atomic_files import atomic_write
from gpu_xform.cli import files, main
from gpu_xform.compute import transform
from gpu_xform.errors import DeviceError, DeviceMemoryError, ShaderError
from gpu_xform.formats import registry
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.rendering import raster as wireframe
from tests.support.cli import error_of, run_in_process

OLD = b"what was there before"
NO_DRIVER = {"VK_DRIVER_FILES": os.devnull, "VK_ICD_FILENAMES": os.devnull}

RENDER = "render house.obj -o out.png "
TRANSFORM = "transform house.obj out.obj "
ARRAY = "transform points.npy out.npy "


@pytest.fixture(autouse=True)
def _files(working_folder: Path) -> Iterator[None]:
    """Run in a folder whose files are all the same afterwards."""
    save_mesh(samples.house(), "house.obj")
    save_mesh(Mesh([(0, 0, 0), (1, 0, 0)], [(1, 1)]), "dot.obj")
    np.save("points.npy", np.ones((4, 3)))
    np.save("matrix33.npy", np.eye(3))
    np.save("matrix_complex.npy", np.eye(4) * 1j)
    np.save("matrix_nan.npy", np.full((4, 4), np.nan))
    np.save("words.npy", np.array(["a", "b"]))
    np.save("cube.npy", np.ones((2, 2, 4)))
    np.save("objects.npy", np.array([None]), allow_pickle=True)
    whole = Path("points.npy").read_bytes()
    Path("huge.npy").write_bytes(whole.replace(b"(4, 3), }" + b" " * 17, b"(%d, 3), }" % 10**17))
    Path("huger.npy").write_bytes(whole.replace(b"(4, 3), }" + b" " * 29, b"(%d, 3), }" % 10**29))
    Path("open.npy").write_bytes(whole.replace(b"(4, 3)", b"((4, 3"))
    Path("octal.npy").write_bytes(whole.replace(b"'<f8'", b"'<08'"))
    Path("mixed.npy").write_bytes(whole.replace(b" 'shape'", b"b'shape'"))
    Path("grumble.npy").write_bytes(whole.replace(b"(4, 3)", b"(4or3)"))
    Path("short.npy").write_bytes(whole[:-1])
    for name, shape in (("sum.npy", "+".join("1" * 4000)), ("minus.npy", "-" * 9000 + "1")):
        header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}, 3)}}\n".encode()
        Path(name).write_bytes(whole[:8] + len(header).to_bytes(2, "little") + header + whole[128:])
    Path("version.npy").write_bytes(whole.replace(b"NUMPY\x01", b"NUMPY\x09"))
    Path("long.npy").write_bytes(whole + b"\0")
    Path("empty.npy").write_bytes(b"")
    Path("garbage.obj").write_bytes(b"v 0 0 0\nv 1 0 zero\nf 1 2 3\n")
    Path("binary.obj").write_bytes(bytes(range(256)) * 8)
    Path("model.xyz").write_bytes(b"1 2 3")
    Path("fifteen.txt").write_text("1 " * 15)
    Path("folder.png").mkdir()
    for name in ("out.png", "out.obj", "out.npy", "out.bmp", "out.3mf", "out"):
        Path(name).write_bytes(OLD)
    before = {path: path.read_bytes() for path in working_folder.rglob("*") if path.is_file()}
    yield
    assert {path: path.read_bytes() for path in working_folder.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ("", "render, animate, simulate, view, transform, convolve, info, explain, doctor, bench or completion"),
        ("rendr", "rendr"),
        ("--verison", "--verison"),
        ("render", "MODEL"),
        ("render house.obj", "-o"),
        ("render house.obj -o", "-o"),
        ("transform house.obj", "OUT"),
        (RENDER + "--scal 2", "--scal"),
        (RENDER + "--scale", "--scale"),
        ("render none.obj -o out.png", "none.obj: No such file"),
        ("render folder.png -o out.png", "folder.png: no model is there, no file of type .3mf, "),
        ("render house.obj/x.obj -o out.png", "house.obj/x.obj: Not a directory"),
        ("render garbage.obj -o out.png", "garbage.obj: line 2"),
        ("render binary.obj -o out.png", "binary.obj: "),
        ("render dot.obj -o out.png", "dot.obj: "),
        ("render model.xyz -o out.png", "model.xyz: "),
        ("render house.obj -o out.png --file-type xyz", "xyz"),
        ("render house.obj -o out.png --file-type off", "house.obj: "),
        ("render - -o out.png", "--file-type"),
        ("render house.obj -o folder.png", "folder.png: Is a directory"),
        ("render house.obj -o none/out.png", "none/out.png: No such file"),
        ("render house.obj -o house.obj/out.png", "house.obj/out.png: Not a directory"),
        ("render none.obj -o out.bmp", "out.bmp: the type must be one of png"),
        ("render none.obj -o out", "out: the type must be one of png"),
        (RENDER + "--scale a", "--scale: expected one factor, or three"),
        (RENDER + "--scale 1,2", "--scale"),
        (RENDER + "--scale 1,,2", "--scale"),
        (RENDER + "--scale ''", "--scale"),
        (RENDER + "--scale nan", "--scale: x must be finite"),
        (RENDER + "--scale 1e999", "--scale"),
        (RENDER + "--scale 1e200 --scale 1e200", "range"),
        (RENDER + "--rotate-x 1,2", "--rotate-x"),
        (RENDER + "--rotate-z ninety", "--rotate-z"),
        (RENDER + "--rotate 1,0,0", "--rotate"),
        (RENDER + "--rotate 0,0,0,90", "--rotate: axis"),
        (RENDER + "--translate -1,2", "--translate: expected three numbers"),
        (RENDER + "--shear xx=1", "--shear"),
        (RENDER + "--shear xy=1,xy=2", "--shear"),
        (RENDER + "--shear xy", "--shear"),
        (RENDER + "--shear xy=", "--shear"),
        (RENDER + "--reflect 0,0,0", "--reflect"),
        (RENDER + "--project-onto 1", "--project-onto"),
        (RENDER + "--perspective-from-eye 0", "--perspective-from-eye"),
        (RENDER + "--matrix 1,2,3", "--matrix: expected 16 numbers"),
        (RENDER + "--matrix none.txt", "none.txt"),
        (RENDER + "--matrix folder.png", "folder.png"),
        (RENDER + "--matrix fifteen.txt", "fifteen.txt"),
        (RENDER + "--matrix binary.obj", "binary.obj"),
        (RENDER + "--matrix matrix33.npy", "matrix33.npy"),
        (RENDER + "--matrix matrix_nan.npy", "matrix_nan.npy"),
        (RENDER + "--matrix matrix_complex.npy", "matrix_complex.npy"),
        (RENDER + "--matrix empty.npy", "empty.npy"),
        (RENDER + "--resolution 100", "--resolution"),
        (RENDER + "--resolution 0,5", "--resolution"),
        (RENDER + "--resolution -5,5", "--resolution"),
        (RENDER + "--resolution 1e2,5", "--resolution"),
        (RENDER + "--resolution 999999999x1", "--resolution: size must be at most 65536"),
        (RENDER + "--resolution 100000,5", "--resolution: size must be at most 65536"),
        ("render house.obj -o out.svg --resolution 65000,16500", "--resolution: size must be at most"),
        (RENDER + "--line-width 0", "--line-width"),
        (RENDER + "--line-width -1", "--line-width"),
        (RENDER + "--line-width inf", "--line-width"),
        (RENDER + "--line-width 1e9", "--line-width: expected a positive number of pixels, at most 1,000,000, got"),
        (RENDER + "--point-size 1e9", "--point-size: expected a positive number of pixels, at most 1,000,000, got"),
        (
            RENDER + "--scalars -",
            "--scalars: expected x, y, z, an .npy file, or an attribute, of which house.obj has",
        ),
        (RENDER + "--color blurple", "--color"),
        (RENDER + "--color 0,0,2", "--color"),
        (RENDER + "--color '#12'", "--color"),
        (RENDER + "--background-color face", "--background-color"),
        (RENDER + "--background-color red --no-background", "--no-background"),
        (
            RENDER + "--background red --no-background",
            "argument --no-background: not allowed with argument --background",
        ),
        (RENDER + "--background face", "argument --background: "),
        (RENDER + "--size 0,5", "argument --size: expected a width and a height in pixels"),
        (RENDER + "--fov 180", "argument --fov: expected degrees between 0 and 180"),
        ("explain --rotate-zz 3", "unrecognized arguments: --rotate-zz 3; did you mean --rotate-z?"),
        ("--versoin", "unrecognized arguments: --versoin; did you mean --version?"),
        (RENDER + "--up Q", "--up"),
        (RENDER + "--up 0,0,0", "--up"),
        (RENDER + "--camera-view-angle 180", "--camera-view-angle"),
        (
            RENDER + "--camera-direction -Y --camera-view-up Y",
            "--camera-direction must not be parallel to the up direction of the picture",
        ),
        (RENDER + "--camera-direction Z --camera-view-up 0,0,2", "give another --camera-view-up"),
        (RENDER + "--camera-view-up=-0.45,-0.4,-1", "camera options: the direction of view must not be parallel to"),
        ("animate house.obj -o out.gif --camera-view-up=-0.45,-0.4,-1", "camera options: the direction of view must"),
        (RENDER + "--camera-position 0,9,0", "camera options: up must not be parallel"),
        (RENDER + "--camera-position 0,9,0", "give another --camera-view-up"),
        ("animate house.obj -o out.gif --camera-direction -Y --camera-view-up Y", "give another --camera-view-up"),
        ("view house.obj --camera-direction -Y --camera-view-up Y", "give another --camera-view-up"),
        (RENDER + "--camera-position 0,0,0", "camera options: --camera-position and --camera-focal-point must differ"),
        (RENDER + "--camera-orthographic --fov 50", "--camera-view-angle cannot go with --camera-orthographic"),
        (RENDER + "--units in", "--units must come with --paper"),
        (RENDER + "--drawing-scale 1:5", "--drawing-scale must come with --paper"),
        (RENDER + "--shading smooth", "--shading must come with --fill"),
        (RENDER + "--hidden show --hidden-style color=red", "--hidden-style must come with --hidden dash or fade"),
        (RENDER + "--fill shaded", "it may also be shade, face or file; did you mean 'shade'"),
        (RENDER + "--camera-focal-point 1,2,3", "--camera-focal-point"),
        (RENDER + "--camera-position 1,2,3 --camera-direction X", "--camera-direction"),
        (RENDER + "--translate 0,0,50 --perspective-from-eye 5", "house.obj: "),
        ("transform none.obj out.obj", "none.obj: No such file"),
        ("transform none.npy out.npy", "none.npy: No such file"),
        ("transform none.obj out.bmp", "out.bmp: the type must be one of"),
        ("transform none.obj out.3mf", "out.3mf: the type must be one of"),
        ("transform none.obj out", "out: the type must be one of"),
        ("transform house.obj out.npy", "out.npy: "),
        (
            "transform house.obj out.npy",
            "out.npy: NPY holds points only, and would lose the faces of this mesh, 7 of them",
        ),
        ("transform words.npy out.obj", "words.npy: positions must have shape (n, 3), got (2,)"),
        ("transform objects.npy out.obj", "objects.npy: not an .npy file of numbers: it holds Python's objects"),
        ("transform points.npy out.obj --resume", "--resume is for .npy files that become .npy files"),
        ("transform points.npy out.stl", "out.stl: STL holds triangles only, this mesh has no faces"),
        ("render huge.npy -o out.png", "huge.npy: not an .npy file of numbers: the header declares 2,"),
        ("render cube.npy -o out.png", "cube.npy: positions must have shape (n, 3), got (2, 2, 4)"),
        ("transform house.obj none/out.obj", "none/out.obj: No such file"),
        ("transform house.obj folder.png/../house.obj/x.obj", "x.obj: Not a directory"),
        ("transform points.npy none/out.npy", "none/out.npy: No such file"),
        ("transform points.npy folder.png --file-type npy", "folder.png: "),
        (TRANSFORM + "--perspective-from-eye 5", "--project"),
        (TRANSFORM + "--perspective-from-eye 1 --project", "house.obj, transformed: positions must be finite"),
        (TRANSFORM + "--scale 1e308 --scale 10", "range"),
        ("transform words.npy out.npy", "words.npy: points must hold"),
        ("transform cube.npy out.npy", "cube.npy: points must have shape"),
        ("transform objects.npy out.npy", "objects.npy: not an .npy file of numbers"),
        ("transform huge.npy out.npy", "got 96 in 'huge.npy'"),
        ("transform huger.npy out.npy", "got 96 in 'huger.npy'"),
        ("transform open.npy out.npy", "open.npy: not an .npy file"),
        ("transform octal.npy out.npy", "octal.npy: not an .npy file"),
        ("transform mixed.npy out.npy", "mixed.npy: not an .npy file"),
        ("transform grumble.npy out.npy", "grumble.npy: "),
        ("transform sum.npy out.npy", "sum.npy: not an .npy file"),
        ("transform minus.npy out.npy", "minus.npy: not an .npy file"),
        ("transform version.npy out.npy", "version.npy: not an .npy file of numbers: version 9.0 is not known"),
        (RENDER + "--scalars long.npy", "long.npy: not an .npy file of numbers: the header declares 96 bytes, got 97"),
        ("transform short.npy out.npy", "got 95 in 'short.npy'"),
        ("transform empty.npy out.npy", "empty.npy: "),
        ("transform house.obj out.npy --file-type npy", "house.obj: not an .npy file"),
        (ARRAY + "--project --matrix matrix33.npy", "matrix33.npy"),
        ("explain", "--rotate-z"),
        ("explain --scale 2 --point 1,2", "--point"),
        ("explain --scale 1e200 --scale 1e200", "range"),
        ("explain out.obj --scale 2", "out.obj"),
        ("doctor now", "now"),
        ("bench --points abc", "--points: expected positive whole numbers N,N,..., got 'abc'"),
        ("bench --points 1e4,,3", "--points: expected positive whole numbers"),
        ("bench --points 0.5", "--points: expected positive whole numbers"),
        ("animate house.obj -o out.gif --fps 0", "--fps: fps must lie in"),
        ("animate house.obj -o out.bmp", "-o: path must end in one of"),
    ],
)
def test_bad_input_is_one_line_and_touches_nothing(typed: str, words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert words in error_of(shlex.split(typed), capsys)


@pytest.mark.parametrize("path", ["", "house.obj/", "new.png/", "new.png/."])
@pytest.mark.parametrize(
    ("typed", "argument"),
    [
        ("render {} -o out.png", "MODEL"),
        ("render house.obj -o out.png {}", "MODEL"),
        ("animate {} -o out.gif", "MODEL"),
        ("view {}", "MODEL"),
        ("transform {} out.obj", "IN"),
        ("transform house.obj {}", "OUT"),
        ("render house.obj -o {}", "-o/--output"),
        ("animate house.obj -o {}", "-o/--output"),
        (RENDER + "--reference {}", "--reference"),
        (RENDER + "--reference x.png --reference-diff {}", "--reference-diff"),
    ],
)
def test_what_is_no_path_of_a_file_is_said_of_the_argument(
    typed: str, argument: str, path: str, capsys: pytest.CaptureFixture[str]
) -> None:
    expected = f"gpu-xform: error: argument {argument}: expected the path of a file, got '{path}'\n"
    assert error_of(shlex.split(typed.format(shlex.quote(path))), capsys) == expected


@pytest.mark.parametrize("command", [RENDER, TRANSFORM, ARRAY, "doctor "])
def test_an_unknown_adapter_is_named_with_those_there_are(
    command: str, capsys: pytest.CaptureFixture[str], device: GpuDevice
) -> None:
    if command == "doctor ":
        assert main(["doctor", "--adapter", "nonesuch"]) == 3
        message = capsys.readouterr().out
    else:
        message = error_of(shlex.split(command + "--adapter nonesuch"), capsys, code=3)
    assert "'nonesuch'" in message
    assert device.name in message


@pytest.mark.slow
@pytest.mark.parametrize("command", [RENDER, TRANSFORM, ARRAY])
def test_without_a_driver_a_line_says_what_to_install(command: str) -> None:
    result = run_in_process(*shlex.split(command), env=os.environ | NO_DRIVER)
    assert (result.returncode, result.stdout) == (3, b"")
    assert result.stderr.startswith(b"gpu-xform: error: no graphics adapter")
    assert b"nstall" in result.stderr
    assert result.stderr.count(b"\n") == 1


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (MemoryError(), 2, "not enough memory"),
        (MemoryError("Unable to allocate 4 TiB"), 2, "4 TiB"),
        (DeviceMemoryError("the device has not enough memory"), 2, "the device has not enough memory"),
        (DeviceError("the device is\nlost"), 1, "the device is lost"),
        (ShaderError("does not compile"), 1, "does not compile"),
        (PrecisionError("no double precision"), 2, "no double precision"),
        (PermissionError(errno.EACCES, "Permission denied", "secret"), 2, "secret: Permission denied"),
        (OSError("an error without a number"), 2, "an error without a number"),
    ],
)
def test_what_the_library_raises_has_its_exit_code(
    error: BaseException, code: int, words: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(wireframe, "render", fail)
    monkeypatch.setattr(transform, "transform_few", fail)
    assert words in error_of(shlex.split(RENDER), capsys, code)
    assert words in error_of(shlex.split(TRANSFORM), capsys, code)
    assert words in error_of(shlex.split(ARRAY), capsys, code)


class FullDisk:
    def __init__(self, file: BinaryIO) -> None:
        self.file = file

    def write(self, data: bytes) -> int:
        self.file.write(bytes(data)[:10])
        self.file.flush()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), self.file.name)


@pytest.mark.parametrize("command", [RENDER, TRANSFORM])
def test_a_full_disk_leaves_the_older_file_and_nothing_else(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextlib.contextmanager
    def almost_full(path: str) -> Iterator[FullDisk]:
        with atomic_write(path) as file:
            yield FullDisk(file)

    monkeypatch.setattr(files, "atomic_write", almost_full)
    monkeypatch.setattr(registry, "atomic_write", almost_full)
    target = shlex.split(command)[-1]
    assert error_of(shlex.split(command), capsys) == f"gpu-xform: error: {target}: {os.strerror(errno.ENOSPC)}\n"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read and write everything")
def test_permissions(capsys: pytest.CaptureFixture[str]) -> None:
    Path("house.obj").chmod(0)
    try:
        assert "house.obj: Permission denied" in error_of(shlex.split(RENDER), capsys)
    finally:
        Path("house.obj").chmod(0o600)


def test_a_line_break_in_a_name_stays_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert "a b.obj: No such file" in error_of(shlex.split("render 'a\nb.obj' -o out.png"), capsys)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("command", ["explain --scale 2", "transform points.npy -"])
def test_a_full_standard_output_is_said_once(command: str, unbuffered: str) -> None:
    with Path("/dev/full").open("wb") as full:
        typed = [sys.executable, "-m", "gpu_xform", *shlex.split(command)]
        environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
        result = subprocess.run(typed, stdout=full, stderr=subprocess.PIPE, check=False, text=True, env=environment)
    assert result.returncode == 2
    assert result.stderr == f"gpu-xform: error: standard output: {os.strerror(errno.ENOSPC)}\n"


@pytest.mark.parametrize(
    ("stream", "command"),
    [("stdin", "render - -o out.png --file-type obj"), ("stdout", "explain --scale 2"), ("stdout", RENDER[:-8] + " -")],
)
def test_a_closed_standard_stream(
    stream: str, command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, stream, None)
    assert "Bad file descriptor" in error_of(shlex.split(command), capsys)
