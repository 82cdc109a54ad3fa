"""Memory while files are read: little beside the bytes of the file and what the mesh holds in the end."""

import tracemalloc
from pathlib import Path

import pytest

import gpu_xform as gx


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
