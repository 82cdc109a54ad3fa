"""Files on several processes: the same bytes as from one, also when a worker is killed."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
import zarr

import gpu_xform as gx
from gpu_xform.compute import cluster, device_plugin, streaming
from tests.chunked.test_las import MATRIX
from tests.support.las_files import make_las
from tests.support.python_run import linux_only
from tests.support.reference_transform import AFFINE, some_points

# The libraries of the cluster leave sockets to the garbage collector when a process of theirs is killed.
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]


@pytest.fixture(scope="module")
def running() -> Iterator[Any]:
    """A cluster of two spawned processes, for all tests that only need one."""
    import distributed

    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
    ) as local:
        yield local


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 1000)


def write_zarr(path: Path, n: int) -> Any:
    points = some_points(n, "f4")
    array = zarr.create_array(store=str(path), shape=points.shape, shards=(100, 3), chunks=(50, 3), dtype="f4")
    array[:] = points
    return points


def read_all(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_a_running_scheduler_gives_the_same_store_and_the_same_files(
    running: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_zarr(tmp_path / "in.zarr", 950)
    told: list[int] = []
    options = {"scheduler": running.scheduler_address}
    gx.transform_file(
        tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, progress=lambda done, _: told.append(done), **options
    )
    gx.transform_file(tmp_path / "in.zarr", tmp_path / "one.zarr", AFFINE, device=gx.Device("host"))
    assert read_all(tmp_path / "out.zarr") == read_all(tmp_path / "one.zarr")
    assert told == [*range(100, 950, 100), 950]
    make_las(tmp_path / "in.las", 110_000, 6)
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 1_000_000)
    for name in ("laz", "las"):
        gx.transform_file(tmp_path / "in.las", tmp_path / f"out.{name}", MATRIX, **options)
        gx.transform_file(tmp_path / "in.las", tmp_path / f"one.{name}", MATRIX, device=gx.Device("host"))
        assert (tmp_path / f"out.{name}").read_bytes() == (tmp_path / f"one.{name}").read_bytes()
    assert len(laspy.read(tmp_path / "out.laz")) == 110_000


def test_a_worker_grows_by_a_few_parts(running: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At most 200 MB over an idle one."""

    def watch() -> tuple[float, float]:  # inside, so that its code goes to the workers
        """Return how many MB the process has held at most since it was asked before, and what it holds now."""
        status = Path("/proc/self/status").read_text("ascii")
        Path("/proc/self/clear_refs").write_text("5", "ascii")
        peak, now = (float(status.partition(name)[2].split()[0]) / 1024 for name in ("VmHWM:", "VmRSS:"))
        return peak, now

    import distributed

    monkeypatch.setattr(streaming, "CHUNK_BYTES", 32 << 20)
    np.save(tmp_path / "in.npy", np.ones((6_000_000, 3), np.float32))
    options = {"scheduler": running.scheduler_address}
    with distributed.Client(running.scheduler_address, set_as_default=False) as client:
        gx.transform_file(tmp_path / "in.npy", tmp_path / "first.npy", AFFINE, **options)  # what is imported late
        before = client.run(watch)
        gx.transform_file(tmp_path / "in.npy", tmp_path / "out.npy", AFFINE, **options)
        after = client.run(watch)
    assert max(peak - before[name][1] for name, (peak, _) in after.items()) < 200
    assert (tmp_path / "out.npy").read_bytes() == (tmp_path / "first.npy").read_bytes()


def test_an_error_of_a_worker_names_file_and_chunk(running: Any, tmp_path: Path) -> None:
    write_zarr(tmp_path / "in.zarr", 950)
    (tmp_path / "in.zarr" / "c" / "3" / "0").write_bytes(b"spoiled")
    with pytest.raises(gx.ArgumentError, match=r"in\.zarr: chunk c/3/0 \(points 300 to 399\) cannot be read"):
        gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, scheduler=running.scheduler_address)
    assert not (tmp_path / "out.zarr").exists()


def test_a_worker_killed_in_the_middle_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    points = write_zarr(tmp_path / "in.zarr", 6000)
    clients: list[Any] = []
    original = cluster._connect

    @contextlib.contextmanager
    def watched(*arguments: Any) -> Iterator[Any]:
        with original(*arguments) as client:
            clients.append(client)
            yield client

    monkeypatch.setattr(cluster, "_connect", watched)
    killed: list[int] = []

    def kill(done: int, _: int) -> None:
        if done == 1000:
            pids = clients[0].run(os.getpid)
            killed.append(next(iter(pids.values())))
            os.kill(killed[0], signal.SIGKILL)

    gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, workers=2, progress=kill)
    assert len(killed) == 1
    result = zarr.open_array(str(tmp_path / "out.zarr"), mode="r")
    assert np.asarray(result[:]).tobytes() == gx.transform_points(points, AFFINE).tobytes()
    gx.transform_file(tmp_path / "in.zarr", tmp_path / "one.zarr", AFFINE, device=gx.Device("host"))
    assert read_all(tmp_path / "out.zarr") == read_all(tmp_path / "one.zarr")


def test_what_a_run_on_workers_left_is_resumed_by_workers_alone(running: Any, tmp_path: Path) -> None:
    write_zarr(tmp_path / "in.zarr", 950)

    def stop(done: int, _: int) -> None:
        if done == 400:
            raise RuntimeError

    options: dict[str, Any] = {"scheduler": running.scheduler_address}
    with pytest.raises(RuntimeError):
        gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, **options, progress=stop)
    told: list[int] = []
    options |= {"resume": True, "progress": lambda done, _: told.append(done)}
    with pytest.raises(gx.ArgumentError, match="computed by another device or by workers"):
        gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, resume=True)
    gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, **options)
    assert told == [500, 600, 700, 800, 900, 950]
    gx.transform_file(tmp_path / "in.zarr", tmp_path / "one.zarr", AFFINE, device=gx.Device("host"))
    assert read_all(tmp_path / "out.zarr") == read_all(tmp_path / "one.zarr")
    shutil.rmtree(tmp_path / "one.zarr")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"workers": 0}, "workers must be a positive whole number, got 0"),
        ({"workers": 1.5}, "workers must be a whole number, got 1.5"),
        ({"workers": 2, "scheduler": "tcp://x:1"}, "workers and scheduler exclude each other"),
        ({"scheduler": 5}, "scheduler must be a text"),
        ({"workers": 2, "device": gx.Device("host")}, "device is the process's own"),
    ],
)
def test_wrong_workers_are_refused(tmp_path: Path, options: dict[str, Any], message: str) -> None:
    np.save(tmp_path / "in.npy", some_points(10, "f4"))
    with pytest.raises((gx.ArgumentError, gx.ArgumentTypeError), match=message):
        gx.transform_file(tmp_path / "in.npy", tmp_path / "out.npy", AFFINE, **options)
    assert [path.name for path in tmp_path.iterdir()] == ["in.npy"]


def test_a_worker_takes_the_adapter_of_its_slot(monkeypatch: pytest.MonkeyPatch) -> None:
    def fake(*kinds: str) -> None:
        found = [type("Adapter", (), {"kind": kind}) for kind in kinds]
        monkeypatch.setattr(device_plugin, "adapters", lambda: found)

    fake("DiscreteGPU", "DiscreteGPU", "CPU")
    names = ("0", "1", "2", "tcp://10.0.0.1:4000", "worker-3")
    assert [device_plugin.choose_slot(name) for name in names] == ["#0", "#1", "#0", "#0", "#1"]
    fake("CPU")
    assert device_plugin.choose_slot("0") == "host"
    with pytest.raises(gx.ArgumentTypeError, match="adapter must be a text"):
        gx.dask.DevicePlugin(5)  # type: ignore[arg-type]


@linux_only
def test_ctrl_c_in_a_terminal_ends_workers_that_start_in_one_line(tmp_path: Path) -> None:
    """A terminal sends SIGINT to all processes of the command, and workers are hit while they import."""
    import psutil  # type: ignore[import-untyped]

    np.save(tmp_path / "in.npy", np.ones((1000, 3)))
    typed = ["transform", "in.npy", "out.npy", "--scale", "2", "--workers", "2"]
    command = subprocess.Popen(
        [sys.executable, "-m", "gpu_xform", *typed], cwd=tmp_path, stderr=subprocess.PIPE, start_new_session=True
    )
    workers: list[Any] = []
    while command.poll() is None and not workers:
        time.sleep(0.02)
        children = psutil.Process(command.pid).children(recursive=True)
        workers = [child for child in children if child.memory_info().rss > 30e6]  # in the midst of its imports
    os.killpg(command.pid, signal.SIGINT)
    _, printed = command.communicate(timeout=60)
    assert (command.returncode, printed.decode()) == (130, "gpu-xform: interrupted\n")
    assert not [worker for worker in workers if worker.is_running() and worker.status() != psutil.STATUS_ZOMBIE]
    assert [path.name for path in tmp_path.iterdir()] == ["in.npy"]


def test_no_scheduler_is_told_once_and_soon(tmp_path: Path) -> None:
    """A client that finds none waits 20 s for it when it is deleted, and Python prints what comes of that."""
    np.save(tmp_path / "in.npy", some_points(10, "f4"))
    typed = ["transform", "in.npy", "out.npy", "--scale", "2", "--scheduler", "foo"]
    command = subprocess.run(
        [sys.executable, "-m", "gpu_xform", *typed], cwd=tmp_path, stderr=subprocess.PIPE, check=False, timeout=60
    )
    lines = command.stderr.decode().splitlines()
    assert (command.returncode, len(lines)) == (2, 1), lines
    assert "scheduler must be the address of a running scheduler, got 'foo'" in lines[0]
