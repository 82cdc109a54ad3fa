"""Runs that are killed at the start, in the middle and while they finish, and resumed to the same bytes."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import os, shutil, sys, warnings
import numpy as np
import gpu_xform as gx
from gpu_xform.chunked import partial_files, zarr as zarr_module
from gpu_xform.compute import streaming
from tests.support.las_files import make_las

source, target = sys.argv[1:]
streaming.CHUNK_BYTES = streaming.HOST_CHUNK_BYTES = 6000
zarr_module.SHARD_POINTS = 400
warnings.simplefilter("ignore")
matrix = gx.chain(gx.rotate_z(30, degrees=True), gx.translate(1, 2, 3))
make_las(source, 51_000 if target.endswith("laz") else 300, 0, normals=False) if source.endswith("las") else np.save(
    source, np.random.default_rng(0).random((1500, 3)))
device = gx.Device("host")
steps = [0]

def run(kill, resume=False):
    def step():
        steps[0] += 1
        if steps[0] == kill:
            os._exit(9)

    def audit(event, arguments):
        watched = ("open", "os.rename", "os.remove", "os.truncate", "os.mkdir", "os.rmdir", "shutil.rmtree")
        if event in watched and isinstance(arguments[0], (str, os.PathLike)) and "out" in os.fspath(arguments[0]):
            step()

    write = partial_files.FileSink.append
    def append(self, part):
        write(self, part)
        step()
    partial_files.FileSink.append = append
    sys.addaudithook(audit)
    gx.transform_file(source, target, matrix, device=device, resume=resume)
    return steps[0]

def in_child(kill, resume=False):
    child = os.fork()
    if child == 0:
        run(kill, resume)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

def read(path):
    if os.path.isfile(path):
        return open(path, "rb").read()
    found = [os.path.join(folder, name) for folder, _, names in os.walk(path) for name in names]
    return {os.path.relpath(file, path): open(file, "rb").read() for file in found}

copy, remove = (shutil.copytree, shutil.rmtree) if target.endswith("zarr") else (shutil.copy, os.remove)
gx.transform_points(np.ones((3, 3)), matrix, device=device)
parent_end, child_start = os.pipe()
child = os.fork()
if child == 0:
    os.write(child_start, str(run(0)).encode())
    os._exit(0)
os.waitpid(child, 0)
n_steps = int(os.read(parent_end, 20))
whole = read(target)
copy(target, "older")
kept = set(os.listdir())
for kill in (2, n_steps // 2, n_steps - 2, n_steps):
    remove(target)
    copy("older", target)
    assert in_child(kill) == 9, kill
    assert in_child(0, resume=True) == 0, kill
    assert read(target) == whole, kill
    assert set(os.listdir()) == kept, (kill, os.listdir())
print(n_steps)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="forks")
@pytest.mark.parametrize(("source", "target"), [("in.las", "out.laz"), ("in.las", "out.las"), ("in.npy", "out.zarr")])
def test_a_killed_run_is_resumed_to_the_same_bytes(tmp_path: Path, source: str, target: str) -> None:
    """In a process without a device, whose forks are killed: half a second each, since moments matter, not sizes."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, source, target],
        cwd=tmp_path,
        env={"PYTHONPATH": str(Path(__file__).parents[2]), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 6
