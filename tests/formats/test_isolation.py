"""Files read in a process of their own: the same mesh comes back, or a MeshError, whatever happens in there."""

import gc
import io
import os
import re
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform._core import limited_process
from gpu_xform.cli import main
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError, MissingExtraError
from gpu_xform.formats import isolation
from gpu_xform.formats.isolation_models import describe_scene
from tests.fuzz.seeds import list_seeds
from tests.support.cli import error_of
from tests.support.isolation import assert_same
from tests.support.python_run import linux_only, python_output

pytestmark = linux_only

PLY = b"""ply
format ascii 1.0
comment of somebody
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
property int part
end_header
0 0 0 1 2 3
1 0 0 4 5 6
0 1 0 7 8 9
0 0 1 9 9 9
3 0 1 2 7
4 0 1 2 3 8
"""


@pytest.mark.parametrize("kind", ["ply", "obj", "glb", "npy"])
def test_the_same_mesh_comes_back(kind: str) -> None:
    if kind == "ply":
        data = PLY
    else:
        file = io.BytesIO()
        models = {"obj": gx.samples.house(), "glb": gx.samples.icosphere(2), "npy": gx.Mesh(np.eye(3))}
        gx.save_mesh(models[kind], file, file_type=kind)
        data = file.getvalue()
    plain = gx.load_mesh(io.BytesIO(data), file_type=kind)
    isolated = gx.load_mesh(io.BytesIO(data), file_type=kind, isolated=True)
    assert isolated == plain
    assert isolated.metadata == plain.metadata
    assert isolated.positions.dtype == plain.positions.dtype


@pytest.mark.parametrize("n_points", [40_000, 400_000])
def test_a_file_that_no_pipe_holds_at_once_is_read_soon(n_points: int) -> None:
    """Before, what a pipe did not take within a fiftieth of a second never came, and the reader waited for it."""
    data = b"v 1 2 3\n" * n_points
    begin = time.monotonic()
    assert gx.load_mesh(io.BytesIO(data), file_type="obj", isolated=True).n_points == n_points
    assert time.monotonic() - begin < 20


def test_what_is_malformed_is_the_same_error_and_warning() -> None:
    with pytest.raises(MeshError, match=r"^<file>: line 1: expected 'ply', got 'no ply'"):
        gx.load_mesh(io.BytesIO(b"no ply\n"), file_type="ply", isolated=True)
    file = io.BytesIO()
    gx.save_mesh(gx.samples.cube(), file, file_type="stl")
    with pytest.warns(gx.MeshWarning, match="4 bytes behind its 12 triangles"):
        gx.load_mesh(io.BytesIO(file.getvalue() + b"more"), file_type="stl", isolated=True)


@pytest.mark.parametrize("load", [gx.load_mesh, gx.load_scene])
def test_a_warning_names_the_file_and_the_line_of_the_caller(
    load: Callable[..., gx.Mesh | gx.Scene], working_folder: Path
) -> None:
    (working_folder / "a.obj").write_bytes(b"mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\ncurv 0 1 1 2\n")
    facet = b"solid b\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    (working_folder / "b.stl").write_bytes(facet + b"endloop\nendfacet\n")
    for name in ("a.obj", "b.stl"):
        told = []
        for isolated in (False, True):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                load(name, isolated=isolated)
            told.append([(str(each.message), each.category, each.filename, each.lineno) for each in caught])
        assert told[1] == told[0]
        assert all(each[0].startswith(f"{name}: ") and each[2] == __file__ for each in told[0])
        assert len(told[0]) == {"a.obj": 2, "b.stl": 1}[name]


@pytest.mark.parametrize("is_enabled", [True, False])
def test_no_garbage_is_collected_while_an_answer_is_understood(is_enabled: bool, monkeypatch: Any) -> None:
    found = []

    def decode(*_: Any) -> Any:
        found.append(gc.isenabled())
        raise ValueError("malformed")

    monkeypatch.setattr(isolation, "decode", decode)
    was_enabled = gc.isenabled()
    (gc.enable if is_enabled else gc.disable)()
    try:
        with pytest.raises(MeshError, match="malformed"):
            gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True)
        assert (found, gc.isenabled()) == ([False], is_enabled)
    finally:
        (gc.enable if was_enabled else gc.disable)()


def test_a_scene_is_read_in_isolation_as_well(working_folder: Path) -> None:
    scene = gx.Scene()
    scene.add(gx.samples.cube(), name="base", transform=gx.translate(1, 2, 3))
    scene.add(gx.samples.house(), name="top", parent="base").visible = False
    gx.save_mesh(scene, "scene.glb")
    (working_folder / "scan.ply").write_bytes(PLY)
    for name in ("scene.glb", "scan.ply"):
        plain, isolated = gx.load_scene(name), gx.load_scene(name, isolated=True, limits=gx.FileLimits(points=100))
        assert_same(describe_scene(isolated), describe_scene(plain))
        with pytest.raises(MeshError, match=r"FileLimits\(points=3\)"):
            gx.load_scene(name, isolated=True, limits=gx.FileLimits(points=3))


TICK_S = 0.02  # after which the system looks what a process has taken
READER_S = 60  # so long a reader would go on
NAMES = {"CPU": r"the limit FileLimits\(cpu_s=...\)", "MEMORY": r"the limit FileLimits\(memory_bytes=...\)"}

CRASHES = {
    "an endless loop": ("while True: pass", r"reading it takes more than 1 s of a processor, {CPU}"),
    "a crash": ("os.abort()", r"the process that read it crashed \(SIGABRT\)"),
    "much memory": ("x = bytearray(110_000_000)", "reading it takes more than 100,000,000 bytes, {MEMORY}"),
    "a large answer": (
        "os.write = lambda *_: (_ for _ in ()).throw(OSError(27, 'File too large'))\n    return gx.samples.cube()",
        "reading it takes more than 100,000,000 bytes, {MEMORY}",
    ),
    "a crash for want of memory": (
        "x = bytearray(80_000_000); time.sleep(0.3); os.abort()",
        r"the process that read it crashed \(SIGABRT\) when it had taken 8\d,\d+,\d+ of the 100,000,000 bytes of "
        r"memory that FileLimits\(memory_bytes=...\) allows",
    ),
    "killed by another": (
        "os.kill(os.getpid(), 9)",
        "the process that read it was killed, as a system does that lacks memory",
    ),
    "an exit": ("os._exit(3)", "the process that read it ended with 3"),
    "no answer": (
        "os._exit(0)",
        r"the process that read it gave no answer: maybe it hit a limit, "
        r"FileLimits\(cpu_s=1, memory_bytes=100000000\)",
    ),
    "an array from elsewhere": (
        "print(json.dumps({'model': [{'array': [8, [9, 3], '<f8']}] * 7}), flush=True); os._exit(0)",
        ".*outside of the shared memory",
    ),
    "objects": ('print(\'{"model": [{"array": [0, [1], "|O"]}]}\', flush=True); os._exit(0)', ".*gave no model.*"),
    "another error": ("raise KeyError('deep inside')", "it cannot be read: KeyError: 'deep inside'"),
}


@pytest.mark.parametrize("name", CRASHES)
def test_only_mesh_errors_escape(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    code, message = CRASHES[name]
    program = (
        f"import json, os, time, gpu_xform as gx\nfrom gpu_xform.formats import isolation\ndef read(*_):\n    {code}\n"
    )
    program += "isolation.serve(read, lambda _: None)\n"
    monkeypatch.setattr(isolation, "_COMMAND", program)
    monkeypatch.setattr(limited_process, "_WAIT_S", 120.0)
    limits, start = gx.FileLimits(cpu_s=1, memory_bytes=100_000_000), time.monotonic()
    for short, whole in NAMES.items():
        message = message.replace(f"{{{short}}}", whole)
    with pytest.raises(MeshError, match=f"^<file>: {message}$"):  # no other limit is named
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True, limits=limits)
    assert time.monotonic() - start < limited_process._WAIT_S  # the system has ended it, not our patience


@pytest.mark.parametrize("memory_bytes", [1, 500_000, 1_000_000])
def test_a_reader_that_lacks_memory_and_crashes_says_so(memory_bytes: int, tmp_path: Path) -> None:
    """What reads LAZ aborts then, faster than anybody looks what it has taken."""
    with pytest.raises(MeshError, match=r"FileLimits\(memory_bytes=\.\.\.\)") as raised:
        read_laz_within(memory_bytes, tmp_path)
    assert f"{memory_bytes:,} bytes" in str(raised.value)


@pytest.mark.parametrize("memory_bytes", range(1_500_000, 3_000_000, 250_000))
def test_a_reader_whose_memory_may_be_enough_reads_or_says_so(memory_bytes: int, tmp_path: Path) -> None:
    """How much is enough depends on Python and on the C library."""
    try:
        told = f"{read_laz_within(memory_bytes, tmp_path).n_points} points"
    except MeshError as error:
        told = str(error)
    assert re.search(r"^[1-9]\d* points$|FileLimits\(memory_bytes=\.\.\.\)", told)


def read_laz_within(memory_bytes: int, folder: Path) -> gx.Mesh:
    data = next(seed.data for seed in list_seeds(folder) if seed.kind == "laz")
    limits = gx.FileLimits(memory_bytes=memory_bytes)
    return gx.load_mesh(io.BytesIO(data), file_type="laz", isolated=True, limits=limits)


def test_a_process_that_works_without_a_processor_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    program = (
        f"import time\nfrom gpu_xform.formats import isolation\nisolation.serve(lambda *_: time.sleep({READER_S}), "
    )
    monkeypatch.setattr(isolation, "_COMMAND", program + "lambda _: None)")
    monkeypatch.setattr(limited_process, "_WAIT_S", 0.5)
    with pytest.raises(MeshError, match=r"^<file>: the process that read it did not end within 0\.7 s$"):
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True, limits=gx.FileLimits(cpu_s=0.1))


@pytest.mark.parametrize("cpu_s", [1e-6, 0.02, 0.2])
def test_few_seconds_of_a_processor_are_kept(cpu_s: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = tmp_path / "taken"
    reader = f"import time\nfrom gpu_xform.formats import isolation\nfile = open({str(place)!r}, 'wb', 0)\n"
    reader += "def read(*_):\n    begin = time.process_time()\n"
    reader += "    while True:\n        file.seek(0), file.write(b'%.6f' % (time.process_time() - begin))\n"
    monkeypatch.setattr(isolation, "_COMMAND", f"{reader}isolation.serve(read, lambda _: time.sleep(0.1))\n")
    before = signal.signal(signal.SIGPROF, signal.SIG_IGN)  # which a child inherits
    try:
        with pytest.raises(MeshError, match=f"more than {cpu_s:g} s of a processor"):
            gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True, limits=gx.FileLimits(cpu_s=cpu_s))
    finally:
        signal.signal(signal.SIGPROF, before)
    assert float(place.read_bytes() or 0) < cpu_s + TICK_S


def test_what_takes_less_than_a_tick_is_measured() -> None:
    with pytest.raises(MeshError, match=r"more than 1e-06 s of a processor, the limit FileLimits\(cpu_s=...\)"):
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True, limits=gx.FileLimits(cpu_s=1e-6))


def test_limits_are_kept_where_nobody_hears_how_a_process_ended() -> None:
    """Before, the answer came late, and counted, where SIGCHLD is ignored, as servers do."""
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        assert gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True).n_points == 4
        told = r"gave no answer: maybe it hit a limit, FileLimits\(cpu_s=1e-09, memory_bytes=4294967296\)$"
        with pytest.raises(MeshError, match=told):
            gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True, limits=gx.FileLimits(cpu_s=1e-9))
    finally:
        signal.signal(signal.SIGCHLD, before)


@pytest.mark.parametrize(
    ("hard_bytes", "result"),
    [
        ("resource.getrlimit(resource.RLIMIT_FSIZE)[1]", "True"),
        ("10240", "<file>: its arrays take more than 10,240 bytes, the limit of the size of files (ulimit -f)"),
    ],
)
def test_a_limit_of_the_size_of_files_is_raised_or_named(hard_bytes: str, result: str) -> None:
    program = f"""
        import io, resource
        import gpu_xform as gx
        sphere, file = gx.samples.icosphere(4), io.BytesIO()
        gx.save_mesh(sphere, file, file_type="obj")
        resource.setrlimit(resource.RLIMIT_FSIZE, (10240, {hard_bytes}))
        try:
            read = gx.load_mesh(io.BytesIO(file.getvalue()), file_type="obj", isolated=True)
            print(read.n_points == sphere.n_points)
        except gx.MeshError as error:
            print(error)
    """
    assert python_output(program) == f"{result}\n"


def test_a_file_is_given_to_its_reader_without_a_copy(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[bytes] = []

    def run(_: str, parts: list[bytes], *__: object, **___: object) -> limited_process.Ended:
        given.extend(parts)
        raise MemoryError

    monkeypatch.setattr(isolation, "run_limited", run)
    with pytest.raises(MeshError, match="this process lacks memory for it"):
        isolation.read_isolated_mesh(PLY, "ply", None, None, gx.FileLimits())
    assert given[1] is PLY


@pytest.mark.parametrize("kind", ["3mf", "dae", "glb", "las", "laz", "npy", "obj", "off", "ply", "stl", "urdf", "wrl"])
def test_limits_count_from_where_the_reader_begins(kind: str, tmp_path: Path) -> None:
    """NumPy's linear algebra and the libraries of a format take up to 150 MB and 0.2 s before."""
    data = next(seed.data for seed in list_seeds(tmp_path) if seed.kind == kind)
    data = data.replace(b"package://arm_description/", b"")
    (tmp_path / f"a.{kind}").write_bytes(data)
    limits = gx.FileLimits(cpu_s=0.1, memory_bytes=16_000_000)
    assert gx.load_mesh(tmp_path / f"a.{kind}", isolated=True, limits=limits) == gx.load_mesh(tmp_path / f"a.{kind}")


@pytest.mark.parametrize("end", ["time.sleep(60)", "os._exit(3)"], ids=["too long", "ended"])
def test_no_process_is_left_behind(end: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # As Open CASCADE's was, for its own minute, when the process that waits for it was killed.
    place = tmp_path / "pid"
    program = (
        "import os, subprocess, sys, time, pathlib\n"
        f"child = subprocess.Popen(['sleep', '60'])\npathlib.Path({str(place)!r}).write_text(str(child.pid))\n{end}\n"
    )
    monkeypatch.setattr(isolation, "_COMMAND", program)
    monkeypatch.setattr(limited_process, "_WAIT_S", 0.5)
    with pytest.raises(MeshError):
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True, limits=gx.FileLimits(cpu_s=0.1))
    assert has_ended(int(place.read_text()))


def has_ended(process: int) -> bool:
    """Return whether a process ends within a second."""
    status = Path(f"/proc/{process}/status")
    for _ in range(100):
        if not status.exists() or "State:\tZ" in status.read_text():
            return True
        time.sleep(0.01)
    return False


def test_a_reader_ends_with_the_process_that_waits_for_it(tmp_path: Path) -> None:
    place = tmp_path / "pid"
    reader = "import os, time, pathlib\nfrom gpu_xform.formats import isolation\n"
    reader += f"def read(*_):\n    time.sleep({READER_S})\n"
    reader += f"pathlib.Path({str(place)!r}).write_text(str(os.getpid()))\nisolation.serve(read, lambda _: None)\n"
    program = f"import io, gpu_xform as gx\nfrom gpu_xform.formats import isolation\nisolation._COMMAND = {reader!r}\n"
    program += f"gx.load_mesh(io.BytesIO({PLY!r}), file_type='ply', isolated=True)\n"
    with subprocess.Popen([sys.executable, "-c", program]) as waiting:
        deadline = time.monotonic() + READER_S
        while not (place.exists() and place.read_text()) and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(0.3)  # it reads now
        waiting.kill()
    assert has_ended(int(place.read_text()))


def test_a_service_may_have_closed_its_standard_streams() -> None:
    program = "import os\nos.close(0), os.close(1)\nimport io, gpu_xform as gx\n"
    program += f"assert gx.load_mesh(io.BytesIO({PLY!r}), file_type='ply', isolated=True).n_points\n"
    assert python_output(program) == ""


@pytest.mark.parametrize("limits", [gx.FileLimits(cpu_s=1e9), gx.FileLimits(cpu_s=1e300, memory_bytes=2**70)])
def test_limits_beyond_those_of_the_system_are_none(limits: gx.FileLimits) -> None:
    mesh = gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True, limits=limits)
    assert mesh == gx.load_mesh(io.BytesIO(PLY), file_type="ply")


def test_where_the_system_has_no_limits_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "darwin")
    with pytest.raises(ArgumentError, match="isolated must be False here: only Linux limits"):
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True)
    with pytest.raises(ArgumentTypeError, match="isolated must be True or False, got 1"):
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=1)  # type: ignore[arg-type]


def test_the_command_reads_in_isolation(working_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (working_folder / "scan.ply").write_bytes(PLY)
    assert main(["transform", "scan.ply", "x.ply", "--isolated", "--scale", "2"]) == 0
    assert np.array_equal(gx.load_mesh("x.ply").positions, 2 * gx.load_mesh("scan.ply").positions)
    message = error_of(["transform", "scan.ply", "y.ply", "--isolated", "--file-limits", "points=3"], capsys)
    assert "scan.ply: it has 4 points, more than FileLimits(points=3) allows" in message
    gx.save_mesh(gx.samples.cube(), "cube.glb")
    for options, flag in (
        (["--isolated"], "--isolated"),
        (["--file-limits", "cpu_s=1"], "--file-limits of cpu_s and memory_bytes"),
        (["--file-limits", "memory_bytes=1e9"], "--file-limits of cpu_s and memory_bytes"),
    ):
        message = error_of(["transform", "cube.glb", "x.glb", *options], capsys)
        assert f"cube.glb: {flag} is for meshes, and glTF that becomes glTF is copied" in message


@pytest.mark.parametrize(
    "command", ["info cube.glb", "render cube.glb -o x.png", "transform cube.glb x.ply", "simulate cube.glb -o x.gif"]
)
@pytest.mark.usefixtures("working_folder")
def test_limits_without_isolation_are_told_of_by_its_option(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    gx.save_mesh(gx.samples.cube(), "cube.glb")
    message = error_of([*command.split(), "--file-limits", "cpu_s=1"], capsys)
    path = "cube.glb: " * command.startswith("info")
    assert message == (
        f"gpu-xform: error: {path}--isolated: isolated must be set for limits of cpu_s and memory_bytes\n"
    )


def test_a_layer_of_the_command_is_read_in_isolation(
    working_folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (working_folder / "scan.ply").write_bytes(PLY)
    (working_folder / "other.ply").write_bytes(PLY)
    monkeypatch.setattr(isolation, "_COMMAND", "import os; os._exit(3)")
    command = ["render", "scan.ply", "-o", "x.png", "--resolution", "9,9", "--layer"]
    message = error_of([*command, "other.ply --isolated"], capsys)
    assert "other.ply: the process that read it ended with 3" in message
    assert "scan.ply: the process" in error_of([*command, "other.ply", "--isolated"], capsys)
    assert main([*command, "other.ply"]) == 0


def test_limits_that_only_a_process_keeps_need_one() -> None:
    for limits in (gx.FileLimits(cpu_s=1), gx.FileLimits(memory_bytes=1 << 30)):
        for load, kind in ((gx.load_mesh, "ply"), (gx.load_scene, "glb"), (gx.load_scene, "ply")):
            with pytest.raises(ArgumentError, match="isolated must be set for limits of cpu_s and memory_bytes"):
                load(io.BytesIO(PLY), file_type=kind, limits=limits)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        ("[" * 100_000, "gave no answer$"),
        ("[]", "gave no answer$"),
        ("true", "gave no answer$"),
        ('{"warnings": []', "gave no answer$"),
        ('{"warnings": ["' + "long " * 300_000 + '"]}', "takes more than 1,000,000 bytes to describe"),
        ('{"model": []}', "gave no model: ValueError: not enough values"),
        ('{"model": {"array": [0, [1], "|O"]}}', "gave no model: ValueError: an array is malformed$"),
        ('{"model": {"array": [0, [1], "<m8[s]"]}}', "gave no model: ValueError: an array is malformed$"),
        ('{"model": {"array": [0, [-1, 3], "<f8"]}}', "gave no model: ValueError: an array is malformed$"),
        ('{"model": {"array": [-8, [1, 3], "<f8"]}}', "gave no model: ValueError: an array is malformed$"),
        ('{"model": {"array": [0, [1.0, 3], "<f8"]}}', "gave no model: ValueError: an array is malformed$"),
        (
            '{"model": {"array": [1, [1], "<f8"]}}',
            "gave no model: ValueError: an array is outside of the shared memory$",
        ),
        ('{"model": {"again": 3}}', "gave no model: IndexError"),
        ('{"model": {"pickle": ""}}', "gave no model: ValueError: unknown content 'pickle'$"),
        ('{"error": "so", "is_missing": true}', "so$"),
        ('{"error": "so", "is_missing": 1}', "so$"),
    ],
)
def test_no_answer_is_trusted(answer: str, message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file may have taken over the process that read it."""
    ended = limited_process.Ended(0, answer.encode(), False, 0)

    def run(_: str, __: Any, *___: object, pass_fds: list[int]) -> limited_process.Ended:
        os.write(pass_fds[0], bytes(8))
        return ended

    monkeypatch.setattr(isolation, "run_limited", run)
    monkeypatch.setattr(isolation, "_MAX_ANSWER_BYTES", 1_000_000)
    is_missing = '"is_missing": true' in answer
    with pytest.raises(gx.GpuXformError, match=message) as raised:
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True)
    assert raised.type is (MissingExtraError if is_missing else MeshError)


def test_an_extra_that_a_reader_lacks_is_that_error_here_too(monkeypatch: pytest.MonkeyPatch) -> None:
    program = """from gpu_xform.errors import MissingExtraError
from gpu_xform.formats import isolation
def read(*_):
    raise MissingExtraError("PLY needs more")
isolation.serve(read, lambda _: None)
"""
    monkeypatch.setattr(isolation, "_COMMAND", program)
    with pytest.raises(MissingExtraError, match="PLY needs more"):
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True)
