"""`doctor --tune`: both rasterisers timed, printed and kept."""

import json
from pathlib import Path
from typing import Any

import pytest

import gpu_xform as gx
from gpu_xform import DeviceError
from gpu_xform.cli import main
from gpu_xform.diagnostics import tune as tune_module
from gpu_xform.diagnostics.tune import EDGE_COUNTS, LENGTHS_PX, format_tuning, tune
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster.tuning import TunedCell, load_tuning

GRID = ((10, 100), (2.0, 50.0))
CELLS = [TunedCell(1_000, 2.0, 5.0, 2.0), TunedCell(100_000, 200.0, 1.5, 1.25)]


def test_each_cell_is_timed_by_both(device: GpuDevice) -> None:
    cells = tune(device, *GRID)
    assert [(cell.n_edges, cell.length_px) for cell in cells] == [(10, 2.0), (10, 50.0), (100, 2.0), (100, 50.0)]
    assert all(0.0 < cell.render_ms < 1e5 and 0.0 < cell.compute_ms < 1e5 for cell in cells)


def test_the_grid_leaves_out_what_would_take_minutes(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tune_module, "_time_cell", lambda _, n_edges, length: TunedCell(n_edges, length, 1.0, 1.0))
    timed = [(cell.n_edges, cell.length_px) for cell in tune(device)]
    assert (10_000, 200.0) in timed
    assert (1_000_000, 2.0) in timed
    assert (1_000_000, 200.0) not in timed
    assert {n for n, _ in timed} == set(EDGE_COUNTS)
    assert {length for _, length in timed} == set(LENGTHS_PX)


def test_rasterizers_that_differ_are_an_error(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    whole: Any = gx.render_array

    def differing(mesh: Any, rasterizer: str, **arguments: Any) -> Any:
        picture = whole(mesh, rasterizer=rasterizer, **arguments)
        picture[512, 512, 0] ^= 128 if rasterizer == "render" else 0
        return picture

    monkeypatch.setattr(tune_module, "render_array", differing)
    with pytest.raises(DeviceError, match="draws wrongly: the pictures of its rasterisers differ by 128/255"):
        tune(device, (10,), (2.0,))


def test_the_table_says_what_was_faster_and_that_a_cpu_does_not_mind(device: GpuDevice) -> None:
    text = format_tuning(device, CELLS)
    rows = [line.split() for line in text.splitlines()[4:6]]
    assert rows == [
        ["1,000", "2", "5.00", "2.00", "2.50", "compute"],
        ["100,000", "200", "1.50", "1.25", "1.20", "render"],
    ]
    assert device.name in text
    assert ("This device is a CPU" in text) == (device.adapter.kind == "CPU")


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is measured."""
    monkeypatch.setattr(tune_module, "tune", lambda _: CELLS)


@pytest.mark.usefixtures("quick")
def test_the_command_prints_and_keeps_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], device: GpuDevice
) -> None:
    path = tmp_path / "new" / "tuning.json"
    monkeypatch.setenv("GPU_XFORM_TUNING", str(path))
    assert main(["doctor", "--tune"]) == 0
    assert capsys.readouterr() == (f"{format_tuning(device, CELLS)}Kept in {path}\n", "")
    assert load_tuning(device.adapter) == tuple(CELLS)
    assert main(["doctor", "--tune", "--json"]) == 0
    parsed = json.loads(capsys.readouterr().out)
    assert [TunedCell(**cell) for cell in parsed["cells"]] == CELLS
    assert (parsed["adapter"], parsed["driver"]) == (device.name, device.adapter.driver)


@pytest.mark.usefixtures("quick")
def test_a_file_that_cannot_be_written_is_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], device: GpuDevice
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("GPU_XFORM_TUNING", str(tmp_path / "file" / "tuning.json"))
    assert main(["doctor", "--tune"]) == 0
    out, err = capsys.readouterr()
    assert out == format_tuning(device, CELLS)
    assert err.startswith("gpu-xform: warning: the tuning could not be kept: ")
    assert (tmp_path / "file").read_text() == "in the way"
