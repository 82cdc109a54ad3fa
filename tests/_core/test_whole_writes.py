"""Files whose `write` takes a part of the data get all of it, or an error is raised."""

import io
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gpu_xform import Mesh, samples, save_mesh
from gpu_xform._core.whole_writes import write_all
from tests.support.python_run import linux_only


class ShortFile(io.RawIOBase):
    """A raw file that takes at most 7 bytes at a time, and in the end only so many in all."""

    def __init__(self, room: int = 1 << 30) -> None:
        self.content = bytearray()
        self._room = room

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int | None:
        taken = bytes(data)[: min(7, self._room)]
        self._room -= len(taken)
        self.content += taken
        return len(taken)


@pytest.mark.parametrize("data", [b"", b"x" * 50, np.arange(12.0).reshape(3, 4).data, np.empty((0, 3)).data])
def test_all_is_written(data: Any) -> None:
    file = ShortFile()
    assert write_all(file, data) == len(file.content) == memoryview(data).nbytes  # type: ignore[arg-type]
    assert file.content == bytes(data)


def test_a_file_that_takes_no_more_is_an_error() -> None:
    with pytest.raises(OSError, match="nothing could be written"):
        write_all(ShortFile(20), b"x" * 50)  # type: ignore[arg-type]


def test_a_pipe_that_would_have_to_wait_is_an_error() -> None:
    read, write = os.pipe()
    os.set_blocking(write, False)
    with open(write, "wb", buffering=0) as file, open(read, "rb"), pytest.raises(BlockingIOError):  # noqa: PTH123
        write_all(file, b"x" * (1 << 20))


@pytest.mark.parametrize("file_type", ["glb", "gltf", "npy", "obj", "off", "ply", "stl"])
def test_every_writer_writes_all(file_type: str) -> None:
    file, whole = ShortFile(), io.BytesIO()
    mesh = samples.cube() if file_type != "npy" else Mesh(samples.cube().positions)
    save_mesh(mesh, file, file_type=file_type)  # type: ignore[arg-type]
    save_mesh(mesh, whole, file_type=file_type)
    assert bytes(file.content) == whole.getvalue()


LIMITED = """
import os, resource, sys
import numpy as np
import gpu_xform as gx
model = gx.samples.icosphere(3)
made = gx.animate(model, np.stack([np.eye(4)] * 2), size=(120, 90), edges="all") if sys.argv[1] != "mesh" else None
sys.dont_write_bytecode = True  # its files would be cut short, and spoil the next import
resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
kinds = {"mesh": ("obj", "off", "ply", "stl", "glb", "gltf", "npy"), "animation": ("gif", "apng", "webp", "html")}
for kind in kinds[sys.argv[1]]:
    try:
        if made is None:
            gx.save_mesh(gx.Mesh(model.positions) if kind == "npy" else model, f"out.{kind}")
        else:
            made.save(f"out.{kind}")
    except OSError as error:
        assert (error.filename, error.strerror) == (f"out.{kind}", "File too large"), error
    else:
        raise AssertionError(kind)
    assert os.listdir() == [], os.listdir()
"""


@linux_only
@pytest.mark.parametrize("what", ["mesh", "animation"])
def test_a_file_that_has_no_room_is_named(what: str, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", LIMITED, what], cwd=tmp_path, check=False)
    if what == "animation" and done.returncode == -signal.SIGBUS:
        pytest.skip("this driver keeps memory in files, whose limit ends the process")
    assert done.returncode == 0
