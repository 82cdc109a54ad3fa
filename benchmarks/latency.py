"""Latency of small calls beside NumPy and a dispatch that only copies: results are checked first, one run's medians."""

import itertools
import os
import platform
import statistics
import time
from collections.abc import Mapping

import numpy as np
from harness import Contender, calm_threads

import gpu_xform as gx
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.chunking import DispatchPlan
from gpu_xform.gpu.device import GpuDevice, default_gpu_device
from gpu_xform.gpu.dispatch import dispatch
from gpu_xform.gpu.shaders import ComputePipeline

CALLS = 200  # per round: one call is too short for the clock
ROUNDS = 15


def medians(contenders: Mapping[str, Contender], calls: int = CALLS) -> dict[str, float]:
    """Return the median microseconds per call of each contender, over rounds in which they take turns."""
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(ROUNDS + 2):
        for name, run in contenders.items():
            start = time.perf_counter()
            for _ in range(calls):
                run()
            times[name].append(1e6 * (time.perf_counter() - start) / calls)
    return {name: statistics.median(values[2:]) for name, values in times.items()}


def row(what: str, against: str, ours: float, theirs: float, asked: str) -> str:
    """Return a line of the table."""
    return f"| {what} | {ours:.1f} | {asked} | {against} | {theirs:.1f} | {ours / theirs:.2f} |"


def calls_on_host() -> list[str]:
    """One call on few points on the host device."""
    host, rows = gx.Device("host"), []
    matrix = gx.chain(gx.scale(0.3), gx.rotate((1, 2, 3), 0.7), gx.translate(1, 2, 3))
    for n, asked in ((10, "8"), (100, "9"), (1000, "15"), (10_000, "")):
        for dtype in (np.float32, np.float64):
            points = np.random.default_rng(0).normal(size=(n, 3)).astype(dtype)
            m = matrix.astype(dtype)
            contenders: dict[str, Contender] = {
                "ours": lambda points=points: gx.transform_points(points, matrix, device=host),  # type: ignore[misc]
                "NumPy": lambda points=points, m=m: points @ m[:3, :3].T + m[:3, 3],  # type: ignore[misc]
            }
            if not np.allclose(contenders["ours"](), contenders["NumPy"](), atol=1e-5):  # type: ignore[arg-type]
                raise SystemExit("wrong results: not compared")
            seconds = medians(contenders)
            what = f"host, one call on {n:,} points, {np.dtype(dtype)}"
            rows.append(row(what, "`points @ m[:3, :3].T + m[:3, 3]`", seconds["ours"], seconds["NumPy"], asked))
    return rows


def calls_on_adapter(device: GpuDevice) -> list[str]:
    """One call on few points on a graphics adapter, beside a dispatch that only copies them, and their read-back."""
    rows = []
    matrix = gx.rotate((1, 2, 3), 0.7)
    for n in (10, 100, 1000):
        points = np.random.default_rng(0).normal(size=(n, 3)).astype(np.float32)
        target = np.empty_like(points)
        plan = DispatchPlan.of(device, n, 3, points.dtype)
        source, destination = (
            Buffer(device.context, plan.chunk * plan.point_bytes, label="latency", persistent=True) for _ in range(2)
        )
        pipeline = plan.pipeline("copy_points")

        def copy(
            plan: DispatchPlan = plan,
            source: Buffer = source,
            destination: Buffer = destination,
            pipeline: ComputePipeline = pipeline,
            target: np.typing.NDArray[np.float32] = target,
        ) -> None:
            with device.encode_commands(source, destination, label="latency") as encoder:
                bindings = device.bind_groups.bind(pipeline, source=source, destination=destination)
                dispatch(encoder, pipeline, bindings, plan.n_workgroups(len(target)))
            with destination.map_read(target.nbytes) as view:
                target[...] = view.view(np.float32).reshape(target.shape)

        turns = itertools.cycle((matrix, gx.rotate((1, 2, 3), 0.8)))
        contenders: dict[str, Contender] = {
            "ours": lambda points=points: gx.transform_points(points, matrix, device=device),  # type: ignore[misc]
            "others": lambda points=points, turns=turns: gx.transform_points(points, next(turns), device=device),  # type: ignore[misc]
            "copy": copy,
        }
        seconds = medians(contenders, calls=20)
        what, against = f"{device.name}, one call on {n:,} points", "a dispatch that copies, read back"
        rows.append(row(what, against, seconds["ours"], seconds["copy"], "1.3 x"))
        rows.append(row(f"{what}, another matrix", against, seconds["others"], seconds["copy"], ""))
    return rows


def matrices() -> list[str]:
    """Products and inverses of single matrices."""
    a, b, c = gx.scale(0.3), gx.rotate_z(1), gx.translate(1, 2, 3)
    matrix = gx.chain(a, b, c)
    contenders: dict[str, Contender] = {
        "inverse": lambda: gx.inverse(matrix),
        "inv": lambda: np.linalg.inv(matrix),
        "chain": lambda: gx.chain(a, b, c),
        "@": lambda: c @ b @ a,
    }
    seconds = medians(contenders)
    return [
        row("`inverse`", "`np.linalg.inv`", seconds["inverse"], seconds["inv"], "3 x"),
        row("`chain` of three", "`c @ b @ a`", seconds["chain"], seconds["@"], "6"),
    ]


def main() -> None:
    """Print the table."""
    calm_threads()
    device = default_gpu_device()
    print(f"{device.adapter.driver}; {os.cpu_count()} processors; Python {platform.python_version()}, ", end="")
    print(f"NumPy {np.__version__}; microseconds\n")
    print("| what | ours | asked, at most | against | theirs | ratio |\n|---|---|---|---|---|---|")
    print("\n".join(calls_on_host() + calls_on_adapter(device) + matrices()))


if __name__ == "__main__":
    main()
