"""Memory while files are read: little beside the bytes of the file and what the mesh holds in the end."""

import tracemalloc
from pathlib import Path

import laspy
import pytest

import gpu_xform as gx
from tests.support.las_files import make_las


@pytest.mark.parametrize(("file_type", "most"), [("ply", 1.5), ("glb", 1.5), ("obj", 4.2)])
def test_a_file_is_read_with_little_more_memory_than_its_bytes_and_its_mesh(
    tmp_path: Path, file_type: str, most: float
) -> None:
    path = tmp_path / f"ball.{file_type}"
    gx.save_mesh(gx.samples.icosphere(6), path)
    gx.load_mesh(path)  # imports what reads it
    tracemalloc.start()
    mesh = gx.load_mesh(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    held = mesh.positions.nbytes + 4 * 3 * mesh.n_faces
    assert peak - path.stat().st_size <= most * held


def test_a_scan_takes_little_more_memory_than_its_records_and_its_mesh(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", 100_000, 0, normals=False)
    laspy.read(tmp_path / "in.las").write(tmp_path / "in.laz")
    gx.load_mesh(tmp_path / "in.laz")
    tracemalloc.start()
    mesh = gx.load_mesh(tmp_path / "in.laz")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    held = mesh.positions.nbytes + sum(column.nbytes for column in mesh.attributes.point.values())
    records = 20 * mesh.n_points
    assert peak - 2 * (tmp_path / "in.laz").stat().st_size <= 1.1 * (held + records)
