"""What happens where wgpu cannot be imported: one typed error of the library, one line and exit code of the command."""

import subprocess
import sys
from pathlib import Path

import pytest

CALLS = """
import sys
import gpu_xform as gx
from gpu_xform.cli import main

cube = gx.samples.cube()
for call in (lambda: gx.adapters, lambda: gx.render(cube), lambda: gx.save_page(cube, "x.html"), lambda: gx.Device()):
    try:
        call()
    except gx.NoAdapterError as error:
        print(error)
print(cube._repr_png_(), gx.transform_points([[1, 2, 3]], gx.scale(2), device=gx.Device("host")).tolist())
gx.save_mesh(cube, "cube.obj")
for command in ("bench", "doctor", "render cube.obj -o cube.png", "completion bash"):
    print(main(command.split()), file=sys.stderr)
"""


def test_where_wgpu_cannot_be_imported_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("GPU_XFORM_ADAPTER", raising=False)
    (tmp_path / "wgpu.py").write_text("raise OSError('no library for this machine')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    result = subprocess.run([sys.executable, "-c", CALLS], cwd=tmp_path, capture_output=True, text=True, check=True)
    reason = "graphics adapters are used by wgpu, which can't be imported: OSError: no library for this machine; "
    *errors, others = result.stdout.splitlines()[:5]
    assert all(error.startswith(reason) and "gx.Device('host')" in error for error in errors)
    assert others == "None [[2.0, 4.0, 6.0]]"
    *lines, completion = result.stderr.splitlines()
    assert completion == "0"
    assert lines[1::2] == ["3"] * 3
    assert all(line.startswith(f"gpu-xform: error: {reason}") for line in lines[::2])
    assert {path.name for path in tmp_path.iterdir()} - {"__pycache__"} == {"wgpu.py", "cube.obj"}
