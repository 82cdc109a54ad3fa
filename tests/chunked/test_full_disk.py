"""A disk that is full in the middle: an error that names the destination, nothing half-written, and a way on."""

from pathlib import Path

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.chunked import zarr as module
from gpu_xform.compute import streaming
from tests.support.full_disk import largest_file
from tests.support.las_files import make_las
from tests.support.reference_transform import AFFINE, some_points


@pytest.mark.parametrize("target", ["npy", "zarr", "laz"])
def test_a_disk_that_is_full_from_the_start_names_the_destination_and_nothing_is_left(
    tmp_path: Path, target: str
) -> None:
    """On the host device: newer Mesa and SwiftShader keep memory in files, whose limit ends a process by a signal."""
    np.save(tmp_path / "in.npy", some_points(600, "f8"))
    out = tmp_path / f"out.{target}"
    with largest_file(0), pytest.raises(OSError, match=f"File too large: '.*out.{target}'"):
        gx.transform_file(tmp_path / "in.npy", out, AFFINE, device=gx.Device("host"))
    assert [path.name for path in tmp_path.iterdir()] == ["in.npy"]


@pytest.mark.parametrize(("source", "target"), [("las", "las"), ("npy", "ply"), ("npy", "zarr")])
def test_a_full_disk_names_the_destination_and_the_run_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str, target: str
) -> None:
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 3000)
    monkeypatch.setattr(module, "SHARD_POINTS", 4000)
    read, out, whole = tmp_path / f"in.{source}", tmp_path / f"out.{target}", tmp_path / f"whole.{target}"
    make_las(read, 1000) if source == "las" else np.save(read, some_points(6000, "f8"))
    with largest_file(30_000), pytest.raises(OSError, match=f"File too large: '.*out.{target}'"):
        gx.transform_file(read, out, AFFINE)
    assert not out.exists()
    gx.transform_file(read, out, AFFINE, resume=True)
    gx.transform_file(read, whole, AFFINE)
    files = [path for path in out.rglob("*") if path.is_file()] if out.is_dir() else [out]
    for file in files:
        assert file.read_bytes() == (whole / file.relative_to(out) if out.is_dir() else whole).read_bytes()
    assert {path.name for path in tmp_path.iterdir()} == {read.name, out.name, whole.name}
