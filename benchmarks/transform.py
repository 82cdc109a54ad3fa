"""Bulk transforms beside their peers: each output is checked before its time counts, ratios come from one run.

The peers come with `pip install 'gpu_xform[bench]'`, but for open3d, which wants `libusb-1.0` besides.
"""

import argparse
import importlib
import itertools
import os
import platform
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numba
import numpy as np
import numpy.typing as npt
from harness import Contender, Row, calm_threads, medians, table

import gpu_xform as gx
from gpu_xform.compute.host import choose
from gpu_xform.compute.kernels import transform as transform_kernel
from gpu_xform.compute.kernels.job import Epilogue
from gpu_xform.compute.kernels.transform import MATRICES_PER_DISPATCH
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.chunking import DispatchPlan
from gpu_xform.gpu.device import GpuDevice, default_gpu_device
from gpu_xform.gpu.dispatch import Binding, dispatch
from gpu_xform.gpu.shaders import ComputePipeline
from gpu_xform.gpu.timing import time_kernel

Points = npt.NDArray[Any]


def numpy_idioms(points: Points, matrix: npt.NDArray[np.float64], out: Points) -> dict[str, Contender]:
    """Return the three ways that people write an affine transform of (n, 3) in NumPy."""
    linear = np.ascontiguousarray(matrix[:3, :3].T.astype(points.dtype))
    offset = matrix[:3, 3].astype(points.dtype)

    def operators() -> Points:
        return np.asarray(points @ linear + offset)

    def in_place() -> Points:
        np.matmul(points, linear, out=out)
        np.add(out, offset, out=out)
        return out

    def einsum() -> Points:
        result = np.einsum("ni,ij->nj", points, linear)
        result += offset
        return np.asarray(result)

    return {"NumPy P @ R + t": operators, "NumPy with out=": in_place, "NumPy einsum": einsum}


def peers(points: Points, matrix: npt.NDArray[np.float64], out: Points) -> dict[str, Contender]:
    """Return the same transform by other libraries, each in the fastest way that its documentation offers."""
    import pylinalg
    import pyvista
    import trimesh

    single = matrix.astype(points.dtype)
    cloud = pyvista.PolyData(points)
    return {
        "trimesh transform_points": lambda: trimesh.transform_points(points, matrix),
        "pyvista transform": lambda: cloud.transform(matrix, inplace=False).points,
        "pylinalg vec_transform": lambda: pylinalg.vec_transform(points, single),
        "torch addmm(out=)": torch_addmm(points, matrix, out),
    }


def torch_addmm(points: Points, matrix: npt.NDArray[np.float64], out: Points) -> Contender:
    """Return the same transform by torch."""
    import torch

    single = matrix.astype(points.dtype)
    linear, offset = torch.from_numpy(single[:3, :3].T.copy()), torch.from_numpy(single[:3, 3].copy())
    torch_points, torch_out = torch.from_numpy(points), torch.from_numpy(out)
    return lambda: torch.addmm(offset, torch_points, linear, out=torch_out).numpy()


def warp_kernel(points: Points, matrix: npt.NDArray[np.float64], out: Points) -> Contender:
    """Return the same transform by a kernel of Warp for CPUs, which is one thread, on the arrays where they are."""
    wp: Any = importlib.import_module("warp")
    wp.config.quiet = True
    wp.init()

    @wp.kernel  # type: ignore[untyped-decorator, unused-ignore]
    def transform(
        m: wp.mat44,
        source: wp.array(dtype=wp.vec3),  # type: ignore[valid-type]
        destination: wp.array(dtype=wp.vec3),  # type: ignore[valid-type]
    ) -> None:
        i = wp.tid()
        destination[i] = wp.transform_point(m, source[i])

    arrays = [wp.array(array, dtype=wp.vec3, device="cpu", copy=False) for array in (points, out)]
    m = wp.mat44(*matrix.astype(np.float32).ravel().tolist())

    def run() -> Points:
        wp.launch(transform, dim=len(points), inputs=[m, arrays[0]], outputs=[arrays[1]], device="cpu")
        return out

    return run


def open3d_cloud(points: Points, matrix: npt.NDArray[np.float64]) -> Contender:
    """Return open3d's transform of a cloud, which is in place: it goes there and back in turn."""
    o3d: Any = importlib.import_module("open3d")
    cloud = o3d.t.geometry.PointCloud(o3d.core.Tensor.from_numpy(points.copy()))
    ways = itertools.cycle([o3d.core.Tensor(m.astype(np.float32)) for m in (matrix, gx.inverse(matrix))])
    return lambda: cloud.transform(next(ways)).point.positions.numpy()


def installed(peers: dict[str, Callable[[], Contender]]) -> dict[str, Contender]:
    """Return the peers that are installed and start; say which are left out."""
    found = {}
    for name, start in peers.items():
        try:
            found[name] = start()
        except ImportError as error:
            print(f"{name} is left out: {error}")
    return found


def scipy_rotation(points: Points, rotation: npt.NDArray[np.float64]) -> Contender:
    """Return SciPy's own way to rotate points."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(rotation[:3, :3])
    return lambda: turn.apply(points)


def checked(contenders: dict[str, Contender], expected: Points, tolerance: float) -> dict[str, Contender]:
    """Return the contenders; stop where one computes something else."""
    for name, run in contenders.items():
        worst = float(np.abs(np.asarray(run()) - expected).max())
        if not worst <= tolerance:
            raise SystemExit(f"{name} is off by {worst}: not compared")
    return contenders


class Copies:
    """What the device and the way to it cost alone: the loads and stores of the transform without its arithmetic."""

    def __init__(self, device: GpuDevice, points: Points, out: Points) -> None:
        self.plan = DispatchPlan.of(device, len(points), 3, points.dtype)
        if self.plan.chunk < len(points):
            raise SystemExit(f"{len(points):,} points take more than one binding of {device.name}: not compared")
        self.points, self.out = points, out
        n_bytes = self.plan.chunk * self.plan.point_bytes
        self.source, self.destination = (
            Buffer(device.context, n_bytes, label="copies"),
            Buffer(device.context, n_bytes, label="copies"),
        )
        self.source.upload(points)
        self.pipeline = self.plan.pipeline("copy_points")

    def there_and_back(self) -> Points:
        """Copy in, copy on the device, copy out."""
        self.source.upload(self.points)
        return self.back()

    def back(self) -> Points:
        """Copy on the device and out."""
        device = self.plan.device
        with device.encode_commands(self.source, self.destination, label="copies") as encoder:
            n_workgroups = self.plan.n_workgroups(len(self.points))
            bindings = device.bind_groups.bind(self.pipeline, source=self.source, destination=self.destination)
            dispatch(encoder, self.pipeline, bindings, n_workgroups)
        transform_kernel.read_results(self.plan, self.destination, self.out[None])
        return self.out


class ManyCopies:
    """What a stack of matrices costs the device alone: each result stored and brought back, and nothing computed."""

    def __init__(self, device: GpuDevice, points: Points, out: Points) -> None:
        self.plan = DispatchPlan.of(device, len(points), 3, points.dtype, max_bytes=transform_kernel.MAX_BATCH_BYTES)
        if self.plan.chunk < len(points):
            raise SystemExit(f"{len(points):,} points take more than one binding of {device.name}: not compared")
        self.points, self.out = points, out
        self.row_bytes = self.plan.chunk * self.plan.point_bytes
        self.n_rows = transform_kernel.max_matrices(self.plan)
        self.source, self.destination = (
            Buffer(device.context, self.row_bytes, label="copies"),
            Buffer(device.context, self.n_rows * self.row_bytes, label="copies"),
        )

    def __call__(self) -> Points:
        """Copy in, copy on the device to as many places as there are matrices, copy out."""
        self.source.upload(self.points)
        for first in range(0, len(self.out), self.n_rows):
            part = self.out[first : first + self.n_rows]
            self.copy(len(part))
            transform_kernel.read_results(self.plan, self.destination, part)
        return self.out

    def copy(self, n_rows: int) -> None:
        """Dispatch copies to the first `n_rows` places, as many at once as the engine computes."""
        device = self.plan.device
        with device.encode_commands(self.source, self.destination, label="copies") as encoder:
            for first in range(0, n_rows, MATRICES_PER_DISPATCH):
                n = min(MATRICES_PER_DISPATCH, n_rows - first)
                pipeline = self.plan.pipeline("copy_points", n_matrices=n)
                places = Binding(self.destination, first * self.row_bytes, n * self.row_bytes)
                bindings = device.bind_groups.bind(pipeline, source=self.source, destination=places)
                dispatch(encoder, pipeline, bindings, self.plan.n_workgroups(len(self.points)))


def end_to_end(device: GpuDevice, n_points: int, dtype: npt.DTypeLike) -> list[Row]:
    """Array in, array out, into a warm `out`."""
    rng = np.random.default_rng(1)
    points = rng.standard_normal((n_points, 3)).astype(dtype)
    matrix = gx.chain(gx.scale(0.3, 0.5, 2), gx.rotate((1, 2, 3), 0.7), gx.translate(-0.5, 2, 1))
    rotation = gx.rotate((1, 2, 3), 0.7)
    ours, theirs = np.empty_like(points), np.empty_like(points)
    expected = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    tolerance = 1e-5 if points.dtype == np.float32 else 1e-13
    idioms = numpy_idioms(points, matrix, theirs)
    contenders = {"ours": lambda: gx.transform_points(points, matrix, out=ours)} | idioms
    if points.dtype == np.float32:
        contenders |= peers(points, matrix, theirs)
    contenders = checked(contenders, expected, tolerance)
    copies = Copies(device, points, theirs)
    contenders |= checked({"copies": copies.there_and_back}, points, 0)
    if points.dtype == np.float32:
        contenders["ours, a rotation"] = lambda: gx.transform_points(points, rotation, out=ours)
        contenders["SciPy Rotation.apply"] = scipy_rotation(points, rotation)
    seconds = medians(contenders)
    what = f"end to end, {points.dtype}, {n_points / 1e6:g} M"
    best = min(idioms, key=seconds.__getitem__)
    limit, floor = 0.75 if dtype is np.float32 else 1.2, seconds["copies"]
    rows = [Row(what, f"best of NumPy: {best}", seconds["ours"], seconds[best], limit, floor)]
    if points.dtype == np.float32:
        asked = {"trimesh transform_points": 0.35, "pyvista transform": 0.35, "pylinalg vec_transform": 0.45}
        asked["torch addmm(out=)"] = 1.0
        rows += [Row(what, name, seconds["ours"], seconds[name], limit, floor) for name, limit in asked.items()]
        turned = "SciPy Rotation.apply"
        rows.append(Row(what, turned, seconds["ours, a rotation"], seconds[turned], 1.0, floor))
        rows.append(Row(what, "copy in, copy kernel, copy out", seconds["ours"], floor, 1.15))
    return rows


def kernel(device: GpuDevice, n_points: int) -> Row:
    """Time the kernel by the device's own clock, beside one that copies."""
    points = np.random.default_rng(1).standard_normal((n_points, 3), dtype=np.float32)
    copies = Copies(device, points, np.empty_like(points))
    (transforms,) = transform_kernel.upload_transforms(copies.plan, gx.rotate((1, 2, 3), 0.7)[None], n_points)
    buffers: dict[str, Buffer | Binding] = {"source": copies.source, "destination": copies.destination}
    pipeline = copies.plan.pipeline("transform_points", epilogue=Epilogue.NONE, n_matrices=1)
    stages: dict[str, tuple[ComputePipeline, dict[str, Buffer | Binding]]] = {
        "ours": (pipeline, {"transforms": transforms, **buffers}),
        "copy": (copies.pipeline, buffers),
    }
    clock: dict[str, list[float]] = {name: [] for name in stages}
    for _ in range(25):
        for name, stage in stages.items():
            clock[name].append(time_kernel(device, *stage, copies.plan.n_workgroups(n_points)))
    ours, copy = (statistics.median(clock[name][2:]) for name in ("ours", "copy"))
    return Row(f"kernel, float32, {n_points / 1e6:g} M, resident", "a copy kernel, same bytes", ours, copy, 1.15)


def chain_of_five(device: GpuDevice, n_points: int) -> Row:
    """Five matrices on resident points and one result read, beside NumPy applying each."""
    points = np.random.default_rng(1).standard_normal((n_points, 3), dtype=np.float32)
    steps = [gx.rotate((1, k, 2), 0.3) @ gx.translate(0.1 * k, 0, -0.2) for k in range(5)]
    single = [(np.ascontiguousarray(m[:3, :3].T, np.float32), m[:3, 3].astype(np.float32)) for m in steps]
    ours, theirs = np.empty_like(points), np.empty_like(points)
    scratch = np.empty_like(points)
    buffer = gx.PointBuffer(points, device=device)

    def chained() -> Points:
        result = buffer
        for matrix in steps:
            result = result.transformed(matrix)
        return result.numpy(out=ours)

    def one_by_one() -> Points:
        given = points
        for k, (linear, offset) in enumerate(single):
            target = theirs if k % 2 == 0 else scratch
            np.matmul(given, linear, out=target)
            given = np.add(target, offset, out=target)
        return given

    with buffer:
        expected = np.column_stack([points, np.ones(n_points)]) @ gx.chain(*steps).T
        checked({"ours": chained, "NumPy": one_by_one}, expected[:, :3], 1e-4)
        copies = Copies(device, points, scratch.copy())
        seconds = medians({"ours": chained, "NumPy": one_by_one, "copies": copies.back}, rounds=9)
    what = f"chain of 5, {n_points / 1e6:g} M, resident, one result read"
    return Row(what, "NumPy applying 5, out=", seconds["ours"], seconds["NumPy"], 0.15, seconds["copies"])


def many_matrices(device: GpuDevice, k: int, n_points: int) -> Row:
    """Every one of k matrices on the same points."""
    points = np.random.default_rng(1).standard_normal((n_points, 3), dtype=np.float32)
    stack = np.array([gx.rotate((1, 2, 3), 0.1 * i) @ gx.translate(i, 0, 1) for i in range(k)])
    linear = np.ascontiguousarray(stack[:, :3, :3].swapaxes(1, 2), np.float32)
    offset = stack[:, None, :3, 3].astype(np.float32)
    ours, theirs = (np.empty((k, n_points, 3), np.float32) for _ in range(2))
    contenders: dict[str, Contender] = {
        "ours": lambda: gx.transform_points(points, stack, out=ours),
        "NumPy matmul": lambda: np.add(np.matmul(points, linear, out=theirs), offset, out=theirs),
        "NumPy einsum": lambda: np.add(np.einsum("ni,kij->knj", points, linear, out=theirs), offset, out=theirs),
    }
    expected = points[None].astype(np.float64) @ stack[:, :3, :3].swapaxes(1, 2) + stack[:, None, :3, 3]
    checked(contenders, expected, 1e-4)
    del expected
    repeated = np.broadcast_to(points, theirs.shape)
    contenders |= checked({"copies": ManyCopies(device, points, theirs)}, repeated, 0)
    seconds = medians(contenders)
    best = min(("NumPy matmul", "NumPy einsum"), key=seconds.__getitem__)
    what = f"{k} matrices x {n_points:,} points"
    return Row(what, f"best of NumPy: {best}", seconds["ours"], seconds[best], 0.5, seconds["copies"])


@numba.njit(parallel=True, error_model="numpy")  # type: ignore[untyped-decorator]
def bare_loop(points: Points, m: Points, out: Points) -> None:
    """Do what anyone would write with numba, with the loads and stores of our loop."""
    for i in numba.prange(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        out[i, 0] = m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3]
        out[i, 1] = m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3]
        out[i, 2] = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3]


def without_numba(run: Contender) -> Contender:
    """Return what runs as on a machine without numba."""

    def call() -> object:
        found = choose._import_loops
        choose._import_loops = lambda: None  # type: ignore[assignment]
        try:
            return run()
        finally:
            choose._import_loops = found

    return call


def on_host(n_points: int, dtype: npt.DTypeLike) -> list[Row]:
    """Array in, array out, into a warm `out`, on the host device."""
    host = gx.Device("host")
    points = np.random.default_rng(1).standard_normal((n_points, 3)).astype(dtype)
    matrix = gx.chain(gx.scale(0.3, 0.5, 2), gx.rotate((1, 2, 3), 0.7), gx.translate(-0.5, 2, 1))
    rotation = gx.rotate((1, 2, 3), 0.7)
    ours, theirs = np.empty_like(points), np.empty_like(points)
    expected = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    tolerance = 1e-5 if points.dtype == np.float32 else 1e-13
    single = matrix.astype(points.dtype)
    idioms = numpy_idioms(points, matrix, theirs)

    def bare() -> Points:
        bare_loop(points, single, theirs)
        return theirs

    def run() -> Points:
        return gx.transform_points(points, matrix, out=ours, device=host)

    contenders: dict[str, Contender] = {"ours": run, "a bare numba loop": bare, "without": without_numba(run), **idioms}
    if points.dtype == np.float32:
        contenders["torch addmm(out=)"] = torch_addmm(points, matrix, theirs)
        contenders |= installed(
            {
                "open3d transform": lambda: open3d_cloud(points, matrix),
                "Warp, a kernel on the CPU": lambda: warp_kernel(points, matrix, theirs),
            }
        )
    contenders = checked(contenders, expected, tolerance)
    del expected
    contenders["ours, a rotation"] = lambda: gx.transform_points(points, rotation, out=ours, device=host)
    contenders["SciPy Rotation.apply"] = scipy_rotation(points, rotation)
    seconds = medians(contenders)
    what = f"host, {points.dtype}, {n_points / 1e6:g} M"
    best = min(idioms, key=seconds.__getitem__)
    is_single = points.dtype == np.float32
    rows = [
        Row(what, f"best of NumPy: {best}", seconds["ours"], seconds[best], 0.35 if is_single else 0.5),
        Row(what, "a bare numba loop", seconds["ours"], seconds["a bare numba loop"], 1.1 if is_single else None),
        Row(
            f"{what}, without numba",
            f"best of NumPy: {best}",
            seconds["without"],
            seconds[best],
            0.6 if is_single else None,
        ),
    ]
    if is_single:
        asked = {"torch addmm(out=)": 0.4, "open3d transform": 0.6, "Warp, a kernel on the CPU": 0.6}
        rows += [
            Row(what, name, seconds["ours"], seconds[name], at_most)
            for name, at_most in asked.items()
            if name in seconds
        ]
        turned = "SciPy Rotation.apply"
        rows.append(Row(what, turned, seconds["ours, a rotation"], seconds[turned], 0.4))
    return rows


def stacks_on_host() -> list[Row]:
    """Many matrices on the same points, and a matrix per point, on the host device."""
    host, rng = gx.Device("host"), np.random.default_rng(1)
    rows = []
    for k, n_points, at_most in ((150, 100_000, 0.6), (1000, 1000, 0.8)):
        points = rng.standard_normal((n_points, 3), dtype=np.float32)
        stack = gx.rotate((1, 2, 3), rng.normal(size=k)) @ gx.translate(1, 0, 2)
        linear = np.ascontiguousarray(stack[:, :3, :3].swapaxes(1, 2), np.float32)
        offset = stack[:, None, :3, 3].astype(np.float32)
        ours, theirs = (np.empty((k, n_points, 3), np.float32) for _ in range(2))
        contenders: dict[str, Contender] = {
            "ours": partial(gx.transform_points, points, stack, out=ours, device=host),
            "NumPy matmul": partial(_multiply_stack, points, linear, offset, theirs),
        }
        expected = points[None].astype(np.float64) @ stack[:, :3, :3].swapaxes(1, 2) + stack[:, None, :3, 3]
        seconds = medians(checked(contenders, expected, 1e-4))
        what = f"host, {k} matrices x {n_points:,} points"
        rows.append(Row(what, "NumPy matmul", seconds["ours"], seconds["NumPy matmul"], at_most))
    n = 1_000_000
    points, own = rng.standard_normal((n, 3), dtype=np.float32), gx.rotate((1, 2, 3), rng.normal(size=n))
    index, single = np.arange(n), own.astype(np.float32)
    contenders = {
        "ours": lambda: gx.transform_points(points, single, index=index, device=host),
        "einsum": lambda: np.einsum("nij,nj->ni", single[:, :3, :3], points) + single[:, :3, 3],
        "matmul": lambda: (single[:, :3, :3] @ points[:, :, None])[..., 0] + single[:, :3, 3],
    }
    expected = np.einsum("nij,nj->ni", own[:, :3, :3], points.astype(np.float64))
    seconds = medians(checked(contenders, expected, 1e-5))
    best = min(("einsum", "matmul"), key=seconds.__getitem__)
    rows.append(Row("host, a matrix per point, 1 M", f"best of NumPy: {best}", seconds["ours"], seconds[best], 0.25))
    return rows


def _multiply_stack(points: Points, linear: Points, offset: Points, out: Points) -> Points:
    return np.asarray(np.add(np.matmul(points, linear, out=out), offset, out=out))


def overhead(n_points: int) -> tuple[str, float]:
    """Return the median milliseconds of one call on very few points."""
    points = np.random.default_rng(1).standard_normal((n_points, 3), dtype=np.float32)
    out = np.empty_like(points)
    matrix = gx.rotate((1, 2, 3), 0.7)
    seconds = medians({"ours": lambda: gx.transform_points(points, matrix, out=out)}, rounds=301, warm_up=20)
    return f"one call on {n_points} points", 1e3 * seconds["ours"]


FILE_SCRIPT = """
import re, sys
import gpu_xform as gx
matrix = gx.rotate((1, 2, 3), 0.7)
gx.transform_points([[1.0, 2.0, 3.0]], matrix)
def peak():  # not getrusage: its figure begins at the peak of the process that started this one
    return int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1]) / 1024
idle = peak()
gx.transform_file(sys.argv[1], sys.argv[2], matrix)
print(peak() - idle)
"""


def file_memory(n_points: int) -> tuple[str, float]:
    """Return the megabytes by which a process grows that transforms a file of many points; the file is checked."""
    block = np.random.default_rng(1).standard_normal((1_000_000, 3), dtype=np.float32)
    with tempfile.TemporaryDirectory() as folder:
        source, destination = Path(folder) / "in.npy", Path(folder) / "out.npy"
        points = np.lib.format.open_memmap(source, "w+", np.float32, (n_points, 3))
        for start in range(0, n_points, len(block)):
            points[start : start + len(block)] = block[: n_points - start]
        points.flush()
        command = [sys.executable, "-c", FILE_SCRIPT, str(source), str(destination)]
        grown = float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        result, matrix = np.load(destination, mmap_mode="r"), gx.rotate((1, 2, 3), 0.7)
        expected = block @ matrix[:3, :3].T
        if result.shape != points.shape or np.abs(result[-len(block) :] - expected).max() > 1e-5:
            raise SystemExit("the file is wrong")
    return f"file of {n_points / 1e6:g} M points, peak memory over the idle process", grown


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--millions", type=float, default=8.0, help="of points (default: %(default)s)")
    parser.add_argument("--file-millions", type=float, default=200.0, help="in the file, 0 for none (%(default)s)")
    parser.add_argument("--host", action="store_true", help="the rows of the host device alone")
    options = parser.parse_args()
    calm_threads()
    n_points = int(options.millions * 1e6)
    device = default_gpu_device()
    print(f"{device.name} ({device.adapter.kind}), {device.adapter.driver}; {os.cpu_count()} processors; ", end="")
    print(f"Python {platform.python_version()}, NumPy {np.__version__}\n")
    rows = on_host(n_points, np.float32) + on_host(n_points // 2, np.float64) + stacks_on_host()
    if options.host:
        print(table(rows))
        return
    rows += end_to_end(device, n_points, np.float32)
    rows.append(kernel(device, n_points))
    rows.append(chain_of_five(device, n_points))
    rows.append(many_matrices(device, 150, 100_000))
    rows += end_to_end(device, n_points // 2, np.float64)
    print(table(rows))
    what, milliseconds = overhead(100)
    print(f"\n{what}: {milliseconds:.2f} ms (asked: at most 0.5)")
    if options.file_millions:
        what, megabytes = file_memory(int(options.file_millions * 1e6))
        print(f"{what}: {megabytes:.0f} MB (asked: at most 600)")


if __name__ == "__main__":
    main()
