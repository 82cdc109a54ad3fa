"""A .npy file to another, in chunks, interrupted and resumed."""

import dataclasses
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.compute import streaming as module
from gpu_xform.device import Device
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from tests.support.cli import error_of
from tests.support.full_disk import largest_file
from tests.support.las_files import make_las
from tests.support.reference_transform import AFFINE, PLANAR, PROJECTIVE, some_points
from tests.support.types import Array


@pytest.fixture(autouse=True)
def _small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "CHUNK_BYTES", 1200)  # 100 points of three float32


def saved(path: Path, points: Array) -> Path:
    np.save(path, points)
    return path


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("n", [0, 1, 99, 100, 101, 250])
@pytest.mark.parametrize("dtype", ["<f4", "<f8", ">f4", ">f8"])
@pytest.mark.parametrize("matrix", [AFFINE, PLANAR], ids=["space", "plane"])
def test_the_file_holds_what_the_function_returns(tmp_path: Path, n: int, dtype: str, matrix: Array) -> None:
    points = some_points(n, dtype, len(matrix) - 1)
    source, destination = saved(tmp_path / "in.npy", points), tmp_path / "out.npy"
    gx.transform_file(source, destination, matrix)
    result = np.load(destination)
    assert result.dtype == np.dtype(dtype).newbyteorder("=")
    assert np.array_equal(result, gx.transform_points(points, matrix))
    assert names(tmp_path) == ["in.npy", "out.npy"]


def test_a_projection_divides(tmp_path: Path) -> None:
    points = some_points(150, np.float32)
    source = saved(tmp_path / "in.npy", points)
    gx.transform_file(source, tmp_path / "out.npy", PROJECTIVE, project=True)
    assert np.array_equal(np.load(tmp_path / "out.npy"), gx.project_points(points, PROJECTIVE))
    with pytest.raises(ArgumentError, match="matrix must be affine"):
        gx.transform_file(source, tmp_path / "other.npy", PROJECTIVE)
    assert not (tmp_path / "other.npy.partial").exists()


def test_a_file_may_be_transformed_onto_itself(tmp_path: Path) -> None:
    points = some_points(250, np.float32)
    source = saved(tmp_path / "in.npy", points)
    gx.transform_file(source, source, AFFINE)
    assert np.array_equal(np.load(source), gx.transform_points(points, AFFINE))


def test_progress_is_told_after_every_chunk(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    source = saved(tmp_path / "in.npy", some_points(250, np.float32))
    gx.transform_file(source, tmp_path / "out.npy", AFFINE, progress=lambda done, total: told.append((done, total)))
    assert told == [(100, 250), (200, 250), (250, 250)]


class StopError(Exception):
    """Stands for whatever ends a run."""


def interrupt_after(chunks: int) -> Any:
    calls: list[int] = []

    def progress(done: int, _: int) -> None:
        calls.append(done)
        if len(calls) == chunks:
            raise StopError

    return progress


def test_an_interrupted_run_leaves_nothing_that_looks_finished_and_is_resumed(tmp_path: Path) -> None:
    points = some_points(950, np.float32)
    source, destination = saved(tmp_path / "in.npy", points), tmp_path / "out.npy"
    with pytest.raises(StopError):
        gx.transform_file(source, destination, AFFINE, progress=interrupt_after(4))
    assert not destination.exists()
    partial = tmp_path / "out.npy.partial"
    with partial.open("ab") as file:
        file.write(b"torn" * 151)  # what a killed process may leave: 50 points of a chunk, and a part of one
    told: list[int] = []
    gx.transform_file(source, destination, AFFINE, resume=True, progress=lambda done, _: told.append(done))
    assert told == [500, 600, 700, 800, 900, 950]
    assert np.array_equal(np.load(destination), gx.transform_points(points, AFFINE))
    assert names(tmp_path) == ["in.npy", "out.npy"]


def test_a_file_that_becomes_itself_is_not_resumed_once_it_is_done(tmp_path: Path) -> None:
    points = some_points(950, np.float32)
    path, link = saved(tmp_path / "in.npy", points), tmp_path / "link.npy"
    link.symlink_to(path)
    with pytest.raises(StopError):
        gx.transform_file(path, path, AFFINE, progress=interrupt_after(4))
    gx.transform_file(path, path, AFFINE, resume=True)
    moved = gx.transform_points(points, AFFINE)
    for source, destination in ((path, path), (link, path), (path, link)):
        with pytest.raises(gx.ArgumentError) as caught:
            gx.transform_file(source, destination, AFFINE, resume=True)
        assert str(caught.value) == (
            f"resume must have an unfinished run to go on with, got {str(destination)!r}, which is its own source: "
            "without resume, its points move again"
        )
        assert np.array_equal(np.load(path), moved)
    gx.transform_file(path, path, AFFINE)
    assert np.array_equal(np.load(path), gx.transform_points(moved, AFFINE))


@pytest.mark.slow
def test_a_killed_process_is_resumed(tmp_path: Path, process_device: Device) -> None:
    points = some_points(950, np.float32)
    source, destination = saved(tmp_path / "in.npy", points), tmp_path / "out.npy"
    script = (
        "import os, signal, sys, numpy as np\n"
        "import gpu_xform as gx\n"
        "from gpu_xform.compute import streaming as module\n"
        "module.CHUNK_BYTES = 1200\n"
        "stop = lambda done, total: done >= 500 and os.kill(os.getpid(), signal.SIGKILL)\n"
        "gx.transform_file(sys.argv[1], sys.argv[2], np.load(sys.argv[3]), progress=stop)\n"
    )
    np.save(tmp_path / "matrix.npy", AFFINE)
    environment = os.environ | {"GPU_XFORM_ADAPTER": process_device.adapter.name}
    run = subprocess.run(
        [sys.executable, "-c", script, source, destination, tmp_path / "matrix.npy"], env=environment, check=False
    )
    assert run.returncode == -signal.SIGKILL
    assert not destination.exists()
    told: list[int] = []
    gx.transform_file(source, destination, AFFINE, resume=True, progress=lambda done, _: told.append(done))
    assert told[0] == 600
    assert np.array_equal(np.load(destination), gx.transform_points(points, AFFINE))


@pytest.mark.parametrize("change", ["matrix", "source", "project"])
def test_other_work_is_not_resumed(tmp_path: Path, change: str) -> None:
    points = some_points(250, np.float32)
    source, destination = saved(tmp_path / "in.npy", points), tmp_path / "out.npy"
    with pytest.raises(StopError):
        gx.transform_file(source, destination, AFFINE, progress=interrupt_after(1))
    matrix = AFFINE.copy()
    if change == "matrix":
        matrix[0, 0] += 1e-9
    elif change == "source":
        saved(source, points + 1)
    with pytest.raises(ArgumentError, match="belongs to other work"):
        gx.transform_file(source, destination, matrix, project=change == "project", resume=True)
    gx.transform_file(source, destination, matrix)
    assert np.array_equal(np.load(destination), gx.transform_points(np.load(source), matrix))


def test_what_another_device_left_is_not_resumed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its last digits may differ: the file would be neither the one nor the other."""
    source, destination = saved(tmp_path / "in.npy", some_points(250, np.float32)), tmp_path / "out.npy"
    device, other = gx.Device("host"), gx.Device("host")
    vars(other)["adapter"] = dataclasses.replace(device.adapter, driver="other 1.0")
    with pytest.raises(StopError):
        gx.transform_file(source, destination, AFFINE, progress=interrupt_after(1), device=device)
    with pytest.raises(ArgumentError, match="belongs to other work, or was computed by another device or by workers"):
        gx.transform_file(source, destination, AFFINE, resume=True, device=other)
    gx.transform_file(source, destination, AFFINE, resume=True, device=device)
    assert np.array_equal(np.load(destination), gx.transform_points(np.load(source), AFFINE, device=device))
    monkeypatch.setenv("GPU_XFORM_ADAPTER", "that of workers")
    types = ("npy", "ply", "zarr", "las", "laz")
    assert [module._describe_computer(None, name) for name in types] == ["workers that of workers"] * 3 + [""] * 2


@pytest.mark.parametrize("resume", [False, True])
def test_a_second_run_into_one_destination_is_told_who_is_at_it(tmp_path: Path, resume: bool) -> None:
    source = saved(tmp_path / "in.npy", some_points(250, np.float32))
    other, destination = saved(tmp_path / "other.npy", some_points(250, np.float32) + 1), tmp_path / "out.npy"
    told: list[str] = []

    def begin_another(done: int, _: int) -> None:
        if done == 200:
            with pytest.raises(ArgumentError) as refused:
                gx.transform_file(other, destination, AFFINE, resume=resume)
            told.append(str(refused.value))

    gx.transform_file(source, destination, AFFINE, progress=begin_another)
    (message,) = told
    holder = f"{os.fspath(destination)!r}, which process {os.getpid()} on "
    assert f"destination must be written by one run at a time, got {holder}" in message
    assert np.array_equal(np.load(destination), gx.transform_points(np.load(source), AFFINE))
    assert names(tmp_path) == ["in.npy", "other.npy", "out.npy"]


def test_the_command_names_who_writes_a_destination(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = saved(tmp_path / "in.npy", some_points(250, np.float32))
    script = (
        "import sys, time\n"
        "import gpu_xform as gx\n"
        "from gpu_xform.compute import streaming\n"
        "streaming.CHUNK_BYTES = 1200\n"
        "def wait(done, total):\n"
        "    print(done, flush=True)\n"
        "    sys.stdin.read(1)\n"
        "gx.transform_file(sys.argv[1], sys.argv[2], gx.scale(2), progress=wait)\n"
    )
    command = [sys.executable, "-c", script, str(source), str(tmp_path / "out.npy")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as first:
        assert first.stdout
        assert first.stdout.readline() == b"100\n"
        message = error_of(["transform", str(source), str(tmp_path / "out.npy"), "--scale", "3"], capsys)
        assert f"out.npy', which process {first.pid} on {socket.gethostname()} is at" in message
        first.communicate(b"...")
    assert first.returncode == 0
    assert np.array_equal(np.load(tmp_path / "out.npy"), np.load(source) * np.float32(2))
    assert names(tmp_path) == ["in.npy", "out.npy"]


def test_a_run_that_was_killed_holds_no_lock(tmp_path: Path) -> None:
    points = some_points(250, np.float32)
    source, destination = saved(tmp_path / "in.npy", points), tmp_path / "out.npy"
    with pytest.raises(StopError):
        gx.transform_file(source, destination, AFFINE, progress=interrupt_after(2))
    gx.transform_file(source, destination, AFFINE)
    assert np.array_equal(np.load(destination), gx.transform_points(points, AFFINE))


def test_resuming_what_never_began_begins_it(tmp_path: Path) -> None:
    source = saved(tmp_path / "in.npy", some_points(50, np.float32))
    gx.transform_file(source, tmp_path / "out.npy", AFFINE, resume=True)
    assert len(np.load(tmp_path / "out.npy")) == 50


def test_a_full_disk_is_the_systems_own_error_and_the_old_file_stays(tmp_path: Path) -> None:
    source = saved(tmp_path / "in.npy", some_points(5000, np.float32))
    destination = saved(tmp_path / "out.npy", np.zeros(3))
    with largest_file(20_000), pytest.raises(OSError, match="File too large"):
        gx.transform_file(source, destination, AFFINE)
    assert np.array_equal(np.load(destination), np.zeros(3))
    gx.transform_file(source, destination, AFFINE, resume=True)
    assert np.array_equal(np.load(destination), gx.transform_points(np.load(source), AFFINE))


@pytest.mark.parametrize(
    ("array", "error", "message"),
    [
        (np.ones((4, 4)), ArgumentError, r"source must have shape \(n, 3\) or \(n, 2\), got \(4, 4\)"),
        (np.ones(4), ArgumentError, "source must have shape"),
        (np.ones((4, 3), int), ArgumentTypeError, "source must hold float32 or float64, got int64"),
        (np.asfortranarray(np.ones((4, 3))), ArgumentError, "source must be C-ordered"),
    ],
)
def test_arrays_that_are_not_points_are_refused(
    tmp_path: Path, array: Array, error: type[Exception], message: str
) -> None:
    source = saved(tmp_path / "in.npy", array)
    with pytest.raises(error, match=message):
        gx.transform_file(source, tmp_path / "out.npy", AFFINE)
    assert names(tmp_path) == ["in.npy"]


def test_a_truncated_file_is_refused_before_any_work(tmp_path: Path) -> None:
    source = saved(tmp_path / "in.npy", some_points(50, np.float32))
    source.write_bytes(source.read_bytes()[:-1])
    with pytest.raises(ArgumentError, match="source must hold 600 bytes of points, got 599"):
        gx.transform_file(source, tmp_path / "out.npy", AFFINE)
    assert names(tmp_path) == ["in.npy"]


def test_a_model_file_is_told_which_types_are_points(tmp_path: Path) -> None:
    gx.save_mesh(gx.samples.cube(), tmp_path / "a.obj")
    with pytest.raises(ArgumentError, match=r"must end in \.las, \.laz, \.ply or \.zarr, or be a \.npy file, got"):
        gx.transform_file(tmp_path / "a.obj", tmp_path / "b.npy", AFFINE)


def test_what_is_not_a_npy_file_is_refused(tmp_path: Path) -> None:
    source = tmp_path / "in.npy"
    source.write_text("v 1 2 3\n")
    with pytest.raises(ArgumentError, match=r"source must be a \.npy file"):
        gx.transform_file(source, tmp_path / "out.npy", AFFINE)


@pytest.mark.parametrize("shape", ["+".join("1" * 4000), "-" * 9000 + "1"])
def test_no_depth_of_a_header_exhausts_a_stack(tmp_path: Path, shape: str) -> None:
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}, 3)}}\n".encode()
    (tmp_path / "in.npy").write_bytes(b"\x93NUMPY\x01\0" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(ArgumentError, match=r"source must be a \.npy file"):
        gx.transform_file(tmp_path / "in.npy", tmp_path / "out.npy", AFFINE)


@pytest.mark.slow
def test_memory_maps_go_in_and_out_without_staying_in_memory(tmp_path: Path, process_device: Device) -> None:
    """A map of 120 MB each way, in chunks of 8 MiB: the process grows by far less than either."""
    script = (
        "import re, sys, dataclasses, numpy as np\n"
        "import gpu_xform as gx\n"
        "device = gx.Device(sys.argv[3])\n"
        "small = gx.Device(sys.argv[3], limits=dataclasses.replace(device.limits, max_binding_bytes=8 << 20))\n"
        "matrix = gx.translate(1, 2, 3)\n"
        "gx.transform_points(np.ones((1_000_000, 3), np.float32), matrix, device=small)\n"
        # Not getrusage: its figure begins at the peak of the process that started this one.
        "def peak(): return int(re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read())[1]) / 1024\n"
        "idle = peak()\n"
        "source = np.load(sys.argv[1], mmap_mode='r')\n"
        "out = np.lib.format.open_memmap(sys.argv[2], 'w+', source.dtype, source.shape)\n"
        "gx.transform_points(source, matrix, out=out, device=small)\n"
        "grown = peak() - idle\n"
        "assert (out[-5:] == source[-5:] + np.float32([1, 2, 3])).all()\n"
        "assert (out[:5] == source[:5] + np.float32([1, 2, 3])).all()\n"
        "print(grown)\n"
    )
    source = np.lib.format.open_memmap(tmp_path / "in.npy", "w+", np.float32, (10_000_000, 3))
    source[:5] = source[-5:] = 7
    del source
    command = [sys.executable, "-c", script, str(tmp_path / "in.npy"), str(tmp_path / "out.npy"), process_device.name]
    run = subprocess.run(command, check=True, capture_output=True, text=True)
    assert float(run.stdout) < 60


@pytest.mark.parametrize("kind", ["npy", pytest.param("ply", marks=pytest.mark.float64), "las"])
def test_a_run_is_resumed_with_parts_of_another_size(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As those of workers, and of the host device, are."""
    source = tmp_path / f"in.{kind}"
    if kind == "las":
        make_las(source, 950)
    else:
        gx.transform_file(saved(tmp_path / "points.npy", some_points(950, np.float32)), source, AFFINE)
    gx.transform_file(source, tmp_path / f"whole.{kind}", AFFINE)
    with pytest.raises(StopError):
        gx.transform_file(source, tmp_path / f"out.{kind}", AFFINE, progress=interrupt_after(4))
    monkeypatch.setattr(module, "CHUNK_BYTES", 1700)
    told: list[int] = []
    gx.transform_file(source, tmp_path / f"out.{kind}", AFFINE, resume=True, progress=lambda done, _: told.append(done))
    assert 0 < told[0] - 1700 // 12 <= 400 or kind != "npy"
    assert (tmp_path / f"out.{kind}").read_bytes() == (tmp_path / f"whole.{kind}").read_bytes()
    assert not (tmp_path / f"out.{kind}.partial").exists()


def test_parts_on_processors_stay_small(
    tmp_path: Path, host: Device, device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "CHUNK_BYTES", 32 << 20)
    n = 800_000
    source = saved(tmp_path / "in.npy", np.ones((n, 3), np.float32))
    told: dict[Device, list[int]] = {host: [], device: []}
    for each, done in told.items():

        def note(n: int, _: int, done: list[int] = done) -> None:
            done.append(n)

        gx.transform_file(source, tmp_path / "out.npy", AFFINE, device=each, progress=note)
    assert told[host][0] == module.HOST_CHUNK_BYTES // 12
    assert told[device][0] == (module.CPU_CHUNK_BYTES // 12 if device.adapter.kind == "CPU" else n)
    assert told[host][-1] == told[device][-1] == n
