"""Tunings: what is kept of them, and which rasteriser "auto" stands for by them."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import pytest

import gpu_xform as gx
from gpu_xform import samples
from gpu_xform.device import Adapter
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster import choose
from gpu_xform.raster.choose import resolve_auto
from gpu_xform.raster.rasterizer import TiledRasterizer
from gpu_xform.raster.tuning import TunedCell, load_tuning, nearest_cell, save_tuning, tuning_path
from gpu_xform.raster.workload import Workload

FEW_LONG = TunedCell(1_000, 200.0, 1.0, 4.0)
FEW_SHORT = TunedCell(1_000, 2.0, 1.21, 1.0)
MANY_SHORT = TunedCell(1_000_000, 2.0, 1.2, 1.0)
MANY_LONG = TunedCell(1_000_000, 200.0, 9.0, 1.0)
CELLS = (FEW_LONG, FEW_SHORT, MANY_SHORT, MANY_LONG)


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of tunings, which does not exist yet."""
    monkeypatch.delenv("GPU_XFORM_RASTERIZER", raising=False)
    path = tmp_path / "a folder" / "tuning.json"
    monkeypatch.setenv("GPU_XFORM_TUNING", str(path))
    return path


@pytest.fixture
def gpu(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> Adapter:
    """The default device's adapter, as if it were a GPU."""
    adapter = dataclasses.replace(device.adapter, kind="DiscreteGPU")
    monkeypatch.setattr(device, "adapter", adapter)
    return adapter


def test_what_is_saved_is_loaded_for_that_adapter_and_driver_alone(file: Path, gpu: Adapter) -> None:
    others = [dataclasses.replace(gpu, driver="another driver"), dataclasses.replace(gpu, name="another adapter")]
    assert load_tuning(gpu) == ()
    assert save_tuning(gpu, CELLS) == file
    assert load_tuning(gpu) == CELLS
    assert [load_tuning(other) for other in others] == [(), ()]
    save_tuning(others[0], CELLS[:1])
    assert (load_tuning(gpu), load_tuning(others[0])) == (CELLS, CELLS[:1])
    save_tuning(gpu, CELLS[1:])
    assert (load_tuning(gpu), load_tuning(others[0])) == (CELLS[1:], CELLS[:1])


CELL: dict[str, Any] = FEW_LONG._asdict()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe",
        b"[]",
        b"null",
        b'{"format": 1}',
        b'{"format": 1, "adapters": []}',
        b'{"format": 1, "adapters": {"KEY": 7}}',
        b'{"format": 1, "adapters": {"KEY": [7]}}',
        b"[" * 100_000,
        *(
            json.dumps({"format": 1, "adapters": {"KEY": [CELL | {name: value}]}}).encode()
            for name in CELL
            for value in ("fast", None, 0, -1, float("nan"), float("inf"))
        ),
        json.dumps({"format": 2, "adapters": {"KEY": [CELL]}}).encode(),
    ],
)
def test_a_damaged_file_is_as_none(content: bytes, file: Path, gpu: Adapter, device: GpuDevice) -> None:
    key = f"{gpu.name} | {gpu.backend} | {gpu.driver}"
    file.parent.mkdir()
    file.write_bytes(content.replace(b"KEY", key.encode()))
    assert load_tuning(gpu) == ()
    assert resolve_auto(device, lambda: Workload(1_000, 200.0)) == "render"
    save_tuning(gpu, CELLS)
    assert load_tuning(gpu) == CELLS


def test_a_file_that_cannot_be_read_is_as_none_and_one_that_cannot_be_written_is_an_error(
    file: Path, gpu: Adapter
) -> None:
    file.parent.write_text("a file, not a folder")
    assert load_tuning(gpu) == ()
    with pytest.raises(OSError, match="a folder"):
        save_tuning(gpu, CELLS)
    file.parent.unlink()
    file.mkdir(parents=True)
    assert load_tuning(gpu) == ()


def test_the_file_is_in_the_cache_folder_of_each_system(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("GPU_XFORM_TUNING", raising=False)
    monkeypatch.setenv("HOME", "/home/someone")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    assert tuning_path() == Path("/home/someone/.cache/gpu_xform/rasterizers.json")
    monkeypatch.setenv("XDG_CACHE_HOME", "/caches")
    assert tuning_path() == Path("/caches/gpu_xform/rasterizers.json")
    monkeypatch.setattr("sys.platform", "darwin")
    assert tuning_path() == Path("/home/someone/Library/Caches/gpu_xform/rasterizers.json")
    monkeypatch.setattr("sys.platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", "/local")
    assert tuning_path() == Path("/local/gpu_xform/rasterizers.json")


def test_the_nearest_cell_is_by_ratios() -> None:
    for cell in CELLS:
        assert nearest_cell(CELLS, Workload(cell.n_edges, cell.length_px)) == cell
    assert nearest_cell(CELLS, Workload(30_000, 15.0)) == FEW_SHORT
    assert nearest_cell(CELLS, Workload(40_000, 15.0)) == MANY_SHORT
    assert nearest_cell(CELLS, Workload(40_000, 25.0)) == MANY_LONG
    assert nearest_cell(CELLS, Workload(0, 0.0)) == FEW_SHORT


@pytest.mark.parametrize(
    ("cell", "expected"), [(FEW_LONG, "render"), (FEW_SHORT, "compute"), (MANY_SHORT, "render"), (MANY_LONG, "compute")]
)
def test_auto_is_compute_on_a_gpu_where_it_was_more_than_a_fifth_faster(
    cell: TunedCell, expected: str, file: Path, gpu: Adapter, device: GpuDevice
) -> None:
    save_tuning(gpu, CELLS)
    workload = Workload(cell.n_edges, cell.length_px)
    assert resolve_auto(device, lambda: workload) == expected
    assert resolve_auto(device) == "render"
    file.unlink()
    assert resolve_auto(device, lambda: workload) == "render"


def test_auto_is_compute_on_cpus_and_asks_neither_the_file_nor_the_workload(
    file: Path, device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_tuning(device.adapter, [TunedCell(1000, 2.0, 1.0, 100.0)])
    assert file.is_file()
    monkeypatch.setattr(choose, "load_tuning", lambda _: pytest.fail("not read"))
    assert resolve_auto(device, lambda: pytest.fail("not estimated")) == "compute"


@pytest.mark.usefixtures("file")
def test_a_picture_on_a_gpu_takes_what_was_faster_for_its_edges(
    gpu: Adapter, device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Few long edges by compute shaders, few short ones by render passes."""
    save_tuning(gpu, [FEW_LONG._replace(render_ms=5.0, compute_ms=1.0), FEW_SHORT._replace(render_ms=1.0)])
    chosen: list[str] = []
    original = TiledRasterizer

    def spy(device: GpuDevice, line_stage: type) -> object:
        chosen.append(line_stage.__name__)
        return original(device, line_stage)

    monkeypatch.setattr(choose, "TiledRasterizer", spy)
    for side in (1024, 16):
        gx.render_array(samples.icosphere(2), size=(side, side), device=device)
    assert chosen == ["ComputeLineStage", "HardwareLineStage"]


def test_a_user_without_a_home_folder_has_no_tuning(gpu: Adapter, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("GPU_XFORM_TUNING", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)

    def fail(_: Path) -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "expanduser", fail)
    assert load_tuning(gpu) == ()
    with pytest.raises(FileNotFoundError, match="GPU_XFORM_TUNING"):
        save_tuning(gpu, CELLS)
