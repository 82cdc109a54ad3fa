"""Files read in a process of their own: the same mesh comes back, or a MeshError, whatever happens in there."""

import io
from pathlib import Path

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError
from gpu_xform.formats import isolation
from tests.support.cli import error_of
from tests.support.python_run import linux_only

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


@pytest.mark.parametrize("kind", ["ply", "obj", "glb"])
def test_the_same_mesh_comes_back(kind: str) -> None:
    if kind == "ply":
        data = PLY
    else:
        file = io.BytesIO()
        gx.save_mesh(gx.samples.icosphere(2) if kind == "glb" else gx.samples.house(), file, file_type=kind)
        data = file.getvalue()
    plain = gx.load_mesh(io.BytesIO(data), file_type=kind)
    isolated = gx.load_mesh(io.BytesIO(data), file_type=kind, isolated=True)
    assert isolated == plain
    assert isolated.metadata == plain.metadata
    assert isolated.positions.dtype == plain.positions.dtype


def test_what_is_malformed_is_the_same_error_and_warning() -> None:
    with pytest.raises(MeshError, match=r"^<file>: line 1: expected 'ply', got 'no ply'"):
        gx.load_mesh(io.BytesIO(b"no ply\n"), file_type="ply", isolated=True)
    file = io.BytesIO()
    gx.save_mesh(gx.samples.cube(), file, file_type="stl")
    with pytest.warns(gx.MeshWarning, match="4 bytes behind its 12 triangles"):
        gx.load_mesh(io.BytesIO(file.getvalue() + b"more"), file_type="stl", isolated=True)


CRASHES = {
    "an endless loop": ("while True: pass", r"more than 1 s of a processor, the limit FileLimits\(cpu_s=...\)"),
    "a crash": ("os.abort()", "the process that read it ended with -6"),
    "much memory": ("x = bytearray(1 << 40)", r"more than 100,000,000 bytes, the limit FileLimits\(memory_bytes=...\)"),
    "no answer": ("os._exit(0)", "gave no answer"),
    "an array from elsewhere": (
        "print(json.dumps({'mesh': [{'array': [8, [9, 3], '<f8']}] * 7}), flush=True); os._exit(0)",
        "outside of the shared memory",
    ),
    "objects": ('print(\'{"mesh": [{"array": [0, [1], "|O"]}]}\', flush=True); os._exit(0)', "gave no mesh"),
    "another error": ("raise KeyError('deep inside')", "it cannot be read: KeyError: 'deep inside'"),
}


@pytest.mark.parametrize("name", CRASHES)
def test_only_mesh_errors_escape(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    code, message = CRASHES[name]
    program = (
        f"import json, os\nfrom gpu_xform.formats import isolation\ndef read(*_):\n    {code}\nisolation.serve(read)\n"
    )
    monkeypatch.setattr(isolation, "_COMMAND", program)
    limits = gx.FileLimits(cpu_s=1, memory_bytes=100_000_000)
    with pytest.raises(MeshError, match=message):
        gx.load_mesh(io.BytesIO(PLY), file_type="ply", isolated=True, limits=limits)


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
