"""Points by the billion beside their peers, and the paper to 1e12 points with the numbers of this machine.

    python benchmarks/scale.py [--fraction 0.1] [--devices host,llvmpipe] [--rows npy,las,...] [--folder /fast/disk]

Every peer's file is compared with ours before its time counts; contenders take turns, our devices among them. Sizes
are those of the table in docs/scale.md, times the fraction; in full they take about ten minutes on two idle cores, and
up to 11 GB in the folder at a time. Needs the extras `las`, `zarr`, `dask` and `host`.
"""

import argparse
import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from harness import Contender, Row, calm_threads, medians, table

import gpu_xform as gx

MATRIX = gx.chain(gx.rotate_z(30, degrees=True), gx.rotate_x(5, degrees=True), gx.translate(120, -35, 7.5))
LINEAR, SHIFT = MATRIX[:3, :3], MATRIX[:3, 3]
PART = 1_000_000
POINT_BYTES = 12  # of three float32
MANY = 1e12
MEMORY_ROWS = (
    ("in.las", "o.las"),
    ("in.las", "o.laz"),
    ("in.npy", "o.npy"),
    ("in.zarr", "o.zarr"),
    ("in.ply", "o.ply"),
)
Devices = Mapping[str, gx.Device]
ROWS = ("npy", "ply", "las", "laz", "zarr", "memory")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fraction", type=float, default=1.0, help="of the sizes of the table (default: 1)")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--devices", default="host", help="as gx.Device takes them, with commas (default: host)")
    parser.add_argument("--rows", default=",".join(ROWS), help=f"which rows to measure, among {', '.join(ROWS)}")
    parser.add_argument(
        "--first-build",
        default=sys.executable,
        metavar="PYTHON",
        help="whose gpu_xform reads PLY whole (default: this)",
    )
    parser.add_argument("--folder", help="where to put the files, on the disk to measure")
    options = parser.parse_args()
    calm_threads()
    devices = {name: gx.Device(name) for name in options.devices.split(",")}
    folder = Path(tempfile.mkdtemp(prefix="scale-", dir=options.folder))
    measured: dict[str, float] = {}
    rows: list[Row] = []
    try:
        for name in options.rows.split(","):
            start = time.perf_counter()
            more = {"python": options.first_build} if name == "ply" else {}
            found, speeds = globals()[f"measure_{name}"](folder, options.fraction, options.rounds, devices, **more)
            rows += found
            measured |= speeds
            size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
            empty(folder)
            spent = time.perf_counter() - start
            shown = f"{table(found)}\n" if found else ""
            print(f"{shown}{name}: {spent:.0f} s, {size / 1e9:.2f} GB of files\n", flush=True)
        measured |= measure_machine(folder, next(iter(devices.values())))
    finally:
        shutil.rmtree(folder)
    print(
        f"{list(devices.values())}, {os.cpu_count()} processors, {options.fraction:g} of the sizes\n\n{table(rows)}\n"
    )
    print(describe_paper(measured))


def empty(folder: Path) -> None:
    """Remove what a row has left, and let the disk come to rest: the next one would wait for it."""
    for path in folder.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    if hasattr(os, "sync"):
        os.sync()


def compare(
    what: str, against: str, ours: Mapping[str, Contender], theirs: Contender, rounds: int, at_most: float
) -> tuple[list[Row], float]:
    """Return a row per device, all timed in one run, and the seconds of the first."""
    seconds = medians({**ours, "theirs": theirs}, rounds, 0)
    rows = [Row(f"{what}, {name}", against, seconds[name], seconds["theirs"], at_most) for name in ours]
    return rows, rows[0].ours


def make_points(n: int, seed: int = 0) -> Any:
    """Return points in a box of a kilometre."""
    return np.random.default_rng(seed).random((n, 3), np.float32) * np.float32(1000)


def measure_npy(folder: Path, fraction: float, rounds: int, devices: Devices) -> tuple[list[Row], dict[str, float]]:
    """Time a stream of `.npy` beside NumPy over chunks of memory maps."""
    n = int(200e6 * fraction)
    source = np.lib.format.open_memmap(folder / "in.npy", "w+", np.float32, (n, 3))
    for start in range(0, n, PART):
        source[start : start + PART] = make_points(min(PART, n - start), start)
    del source
    linear, shift = LINEAR.T.astype("f4"), SHIFT.astype("f4")

    def by_numpy() -> None:
        points = np.load(folder / "in.npy", mmap_mode="r")
        out = np.lib.format.open_memmap(folder / "numpy.npy", "w+", np.float32, points.shape)
        for start in range(0, n, PART):
            np.matmul(points[start : start + PART], linear, out=out[start : start + PART])
            out[start : start + PART] += shift
        out.flush()

    by_numpy()
    some = slice(None, None, max(n // 1000, 1))
    expected = np.load(folder / "numpy.npy", mmap_mode="r")[some]
    ours = make_ours(folder, "in.npy", "ours.npy", devices)
    for go in ours.values():
        go()
        assert np.abs(np.load(folder / "ours.npy", mmap_mode="r")[some] - expected).max() < 1e-3
    what = f".npy, {n / 1e6:g} M points"
    rows, seconds = compare(what, "NumPy over memmap chunks", ours, by_numpy, rounds, 1.0)
    return rows, {"npy_points_per_s": n / seconds}


def make_ours(folder: Path, source: str, target: str, devices: Devices) -> dict[str, Contender]:
    """Return for each device what transforms a file into another."""

    def bind(device: gx.Device) -> Contender:
        return lambda: gx.transform_file(folder / source, folder / target, MATRIX, device=device)

    return {name: bind(device) for name, device in devices.items()}


MOVE_WHOLE = """
import sys, numpy as np, gpu_xform as gx
matrix = np.array(eval(sys.argv[3]))
for _ in sys.stdin:
    gx.save_mesh(gx.load_mesh(sys.argv[1]).transformed(matrix), sys.argv[2])
    print(flush=True)
"""


@contextlib.contextmanager
def start_whole(python: str, source: Path, target: Path) -> Iterator[Contender]:
    """Lend what reads, transforms and writes a whole mesh with the gpu_xform of an interpreter, in one process."""
    command = [python, "-c", MOVE_WHOLE, str(source), str(target), str(MATRIX.tolist())]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=source.parent) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        to, back = process.stdin, process.stdout

        def whole() -> None:
            to.write(b"\n")
            to.flush()
            assert back.readline(), "the process has ended"

        yield whole
        to.close()


def measure_ply(
    folder: Path, fraction: float, rounds: int, devices: Devices, python: str = sys.executable
) -> tuple[list[Row], dict[str, float]]:
    """Time a stream of PLY beside the reader and writer of whole meshes."""
    n = int(5e6 * fraction)
    write_cloud(folder / "in.ply", n)
    with start_whole(python, folder / "in.ply", folder / "whole.ply") as whole:
        whole()
        expected = gx.load_mesh(folder / "whole.ply").positions
        ours = make_ours(folder, "in.ply", "ours.ply", devices)
        for go in ours.values():
            go()
            assert np.abs(gx.load_mesh(folder / "ours.ply").positions - expected).max() < 1e-3
        del expected
        rows, seconds = compare(f"PLY, {n / 1e6:g} M points", "the whole mesh", ours, whole, 3 * rounds, 0.3)
    return rows, {"ply_points_per_s": n / seconds}


def write_cloud(path: Path, n: int) -> None:
    """Write a binary PLY file of points alone."""
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {n}\n" + "".join(
        f"property float {axis}\n" for axis in "xyz"
    )
    with path.open("wb") as file:
        file.write(f"{head}end_header\n".encode())
        file.write(make_points(n).data)


def make_tile(path: Path, n: int) -> None:
    """Write a tile of 44 bytes per point, in the order in which a scanner sweeps it."""
    import laspy

    header = laspy.LasHeader(point_format=7, version="1.4")
    header.scales, header.offsets = [0.001] * 3, [431_000, 5_123_000, 200]
    header.add_extra_dims([laspy.ExtraBytesParams("amplitude", "f8")])
    random = np.random.default_rng(5)
    with laspy.open(path, "w", header=header) as writer:
        for start in range(0, n, PART):
            count = min(PART, n - start)
            points = laspy.ScaleAwarePointRecord.zeros(count, header=header)
            along = (start + np.arange(count)) / n
            points["X"] = (along * 1e6).astype("i4")
            points["Y"] = (np.sin(along * 3e4) * 3e5).astype("i4") + random.integers(-40, 40, count)
            points["Z"] = (np.sin(along * 70) * 2e4).astype("i4") + random.integers(-90, 90, count)
            points["intensity"] = random.integers(0, 2000, count)
            points["return_number"] = points["number_of_returns"] = np.ones(count, "u1")
            points["gps_time"] = 3e8 + along * 1000
            points["red"] = points["green"] = points["blue"] = random.integers(0, 65536, count).astype("u2")
            points["amplitude"] = random.integers(0, 100, count)
            writer.write_points(points)


def move_by_laspy(source: Path, target: Path) -> None:
    """Move a tile as one does it by hand: in chunks, through world coordinates."""
    import laspy

    with laspy.open(source) as reader:
        header = reader.header
        low, high = np.array([header.mins, header.maxs])
        corners = np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T @ LINEAR.T + SHIFT
        moved = laspy.LasHeader(point_format=header.point_format, version=header.version)
        moved.scales, moved.offsets = header.scales, np.round((corners.min(axis=0) + corners.max(axis=0)) / 2)
        with laspy.open(target, "w", header=moved) as writer:
            for points in reader.chunk_iterator(PART):
                xyz = np.stack([points.x, points.y, points.z], axis=1) @ LINEAR.T + SHIFT
                cells = np.rint((xyz - moved.offsets) / moved.scales).astype(np.int32)
                points.array["X"], points.array["Y"], points.array["Z"] = cells.T
                points.scales, points.offsets = moved.scales, moved.offsets
                writer.write_points(points)


def measure_las(folder: Path, fraction: float, rounds: int, devices: Devices) -> tuple[list[Row], dict[str, float]]:
    """Time LAS beside laspy and NumPy by hand."""
    import laspy

    n = int(20e6 * fraction)
    make_tile(folder / "in.las", n)

    def by_hand() -> None:
        move_by_laspy(folder / "in.las", folder / "hand.las")

    by_hand()
    ours = make_ours(folder, "in.las", "ours.las", devices)
    for go in ours.values():
        go()
        with laspy.open(folder / "ours.las") as mine, laspy.open(folder / "hand.las") as theirs:
            for points, expected in zip(mine.chunk_iterator(PART), theirs.chunk_iterator(PART), strict=True):
                for axis in "xyz":
                    assert np.abs(np.asarray(points[axis]) - np.asarray(expected[axis])).max() < 0.0011
    rows, seconds = compare(f"LAS, {n / 1e6:g} M points", "laspy and NumPy by hand", ours, by_hand, rounds, 1.0)
    return rows, {"las_points_per_s": n / seconds}


def measure_laz(folder: Path, fraction: float, rounds: int, devices: Devices) -> tuple[list[Row], dict[str, float]]:
    """Time LAZ beside a copy by laspy with the parallel back end of lazrs."""
    import laspy

    n = int(20e6 * fraction)
    make_tile(folder / "in.las", n)
    gx.transform_file(folder / "in.las", folder / "in.laz", np.eye(4))

    def copy() -> None:
        backend = laspy.LazBackend.LazrsParallel
        with (
            laspy.open(folder / "in.laz", laz_backend=backend) as reader,
            laspy.open(folder / "copy.laz", "w", header=reader.header, laz_backend=backend) as writer,
        ):
            for points in reader.chunk_iterator(PART):
                writer.write_points(points)

    copy()
    assert laspy.open(folder / "copy.laz").header.point_count == n
    ours = make_ours(folder, "in.laz", "ours.laz", devices)
    for go in ours.values():
        go()
        with laspy.open(folder / "ours.laz") as reader, laspy.open(folder / "in.las") as plain:
            moved, before = reader.read_points(PART), plain.read_points(PART)
            expected = np.stack([before.x, before.y, before.z], axis=1) @ LINEAR.T + SHIFT
            assert np.abs(np.stack([moved.x, moved.y, moved.z], axis=1) - expected).max() < 0.00051
    rows, seconds = compare(f"LAZ, {n / 1e6:g} M points", "a copy by laspy, parallel", ours, copy, rounds, 1.1)
    return rows, {"laz_points_per_s": n / seconds}


def _copy_block(block: Any) -> Any:
    return block.copy()


def _move_block(block: Any, linear: Any, shift: Any) -> Any:
    return block @ linear + shift


def measure_zarr(folder: Path, fraction: float, rounds: int, devices: Devices) -> tuple[list[Row], dict[str, float]]:
    """Time a Zarr array on two spawned workers beside the same graph that copies, and that uses NumPy."""
    import zarr

    n = int(200e6 * fraction)
    array = zarr.create_array(
        store=str(folder / "in.zarr"), shape=(n, 3), shards=(PART, 3), chunks=(PART // 4, 3), dtype="f4"
    )
    for start in range(0, n, PART):
        array[start : start + PART] = make_points(min(PART, n - start), start)
    linear, shift = LINEAR.T.astype("f4"), SHIFT.astype("f4")
    changes: dict[str, Callable[[Any], Any]] = {
        **dict.fromkeys(devices, lambda points: gx.dask.transform_points(points, MATRIX)),
        "copy": lambda points: points.map_blocks(_copy_block, dtype="f4"),
        "numpy": lambda points: points.map_blocks(_move_block, linear, shift, dtype="f4"),
    }
    spent = dict.fromkeys(changes, 0.0)  # seconds of the workers' processors

    def run(name: str, client: Any) -> Contender:
        def go() -> None:
            before = sum(client.run(time.process_time).values())
            with client.as_current():
                points = gx.dask.from_zarr(folder / "in.zarr")
                gx.dask.to_zarr(changes[name](points), folder / f"{name}.zarr")
            spent[name] += sum(client.run(time.process_time).values()) - before

        return go

    with contextlib.ExitStack() as stack:
        clients = {name: stack.enter_context(start_workers(device)) for name, device in devices.items()}
        first = next(iter(clients.values()))
        contenders = {name: run(name, clients.get(name, first)) for name in changes}
        found = {}
        for name, go in contenders.items():
            go()
            found[name] = np.asarray(zarr.open_array(str(folder / f"{name}.zarr"), mode="r")[:1000])
        assert all(np.abs(found[name] - found["numpy"]).max() < 1e-3 for name in devices)
        spent = dict.fromkeys(changes, 0.0)
        seconds = medians(contenders, rounds, 0)
    print("processor time over NumPy's: " + ", ".join(f"{k} {v / spent['numpy']:.2f}" for k, v in spent.items()))
    what = f"Zarr, {n / 1e6:g} M points, two workers"
    rows = []
    for name in devices:
        rows.append(Row(f"{what}, {name}", "the same graph copying", seconds[name], seconds["copy"], 1.3))
        rows.append(Row(f"{what}, {name}", "NumPy in the same graph", seconds[name], seconds["numpy"], 1.0))
    return rows, {"zarr_points_per_s": n / rows[0].ours, "zarr_copy_points_per_s": n / seconds["copy"]}


@contextlib.contextmanager
def start_workers(device: gx.Device) -> Iterator[Any]:
    """Lend a client of two spawned workers of a thread each, which have the device."""
    import distributed

    environment = {"GPU_XFORM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50, env=environment
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        client.register_plugin(gx.dask.DevicePlugin(device.name))
        yield client


def measure_memory(
    folder: Path,
    fraction: float,
    rounds: int,  # noqa: ARG001
    devices: Devices,
) -> tuple[list[Row], dict[str, float]]:
    """Print by how much a process grows that streams, over one that has transformed a few points."""
    n = int(20e6 * fraction)
    make_tile(folder / "in.las", n)
    np.save(folder / "in.npy", make_points(n))
    gx.transform_file(folder / "in.npy", folder / "in.zarr", np.eye(4))
    write_cloud(folder / "in.ply", n // 4)
    script = (
        "import re, sys, numpy as np, gpu_xform as gx\n"
        "def peak(): return int(re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read())[1]) / 1024\n"
        "gx.default_device(sys.argv[3])\n"
        "gx.transform_points(np.ones((200_000, 3), np.float32), gx.scale(2))\n"
        "gx.transform_points(np.ones((200_000, 3)), gx.scale(2))\n"
        "import laspy, lazrs, zarr\n"
        "idle = peak()\n"
        "gx.transform_file(sys.argv[1], sys.argv[2], gx.rotate_z(1))\n"
        "print(peak() - idle)\n"
    )
    for name, device in devices.items():
        grown = []
        for source, target in MEMORY_ROWS:
            command = [sys.executable, "-c", script, str(folder / source), str(folder / target), device.name]
            run = subprocess.run(command, check=True, capture_output=True, text=True)
            grown.append(f"{source} to {target} {float(run.stdout):.0f}")
        print(f"{name}, MB over the idle process (at most 200, PLY 100): {', '.join(grown)}")
    return [], {}


def measure_machine(folder: Path, device: gx.Device) -> dict[str, float]:
    """Return what the paper needs of this machine: kernel, memory and disk, in points per second."""
    points = make_points(8_000_000)
    out = np.empty_like(points)
    gx.transform_points(points, MATRIX, out=out, device=device)
    seconds = medians(
        {
            "kernel": lambda: gx.transform_points(points, MATRIX, out=out, device=device),
            "copy": lambda: np.copyto(out, points),
        },
        5,
        1,
    )
    start = time.perf_counter()
    with (folder / "disk").open("wb") as file:
        for _ in range(4):
            file.write(points.data)
        os.fsync(file.fileno())
    disk = 4 * len(points) / (time.perf_counter() - start)
    return {"kernel": len(points) / seconds["kernel"], "copy": len(points) / seconds["copy"], "disk": disk}


def describe_paper(measured: dict[str, float]) -> str:
    """Return how long 1e12 points take by each step, at the speeds of this machine."""
    titles = {
        "kernel": "transform_points in memory",
        "copy": "a copy in memory",
        "disk": "writing to this disk, fsync included",
        "npy_points_per_s": "transform_file, .npy",
        "las_points_per_s": "transform_file, LAS",
        "laz_points_per_s": "transform_file, LAZ",
        "zarr_points_per_s": "gx.dask, Zarr, two workers",
    }
    lines = ["| step | M points/s here | 1e12 points |", "|---|---|---|"]
    for name, title in titles.items():
        if name in measured:
            lines.append(f"| {title} | {measured[name] / 1e6:.3g} | {describe_seconds(MANY / measured[name])} |")
    blocks = {"1 M": 1e6, "16 M": 1 << 24}
    tasks = ", ".join(f"blocks of {name} points are {MANY / size:,.0f} tasks" for name, size in blocks.items())
    return "\n".join(lines) + f"\n\n{MANY * POINT_BYTES / 1e12:g} TB in and as much out; {tasks}."


def describe_seconds(seconds: float) -> str:
    """Return a time in the unit that fits."""
    for size, unit in ((86400, "days"), (3600, "h"), (60, "min")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


if __name__ == "__main__":
    main()
