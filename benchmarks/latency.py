"""Latency of small calls beside NumPy, and beside an empty dispatch: results are checked first, medians of one run."""

import os
import platform
import statistics
import time
from collections.abc import Mapping

import numpy as np
from harness import Contender, calm_threads

import gpu_xform as gx
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice, default_gpu_device

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
    """One call on few points on a graphics adapter, beside an empty submission and the read-back of as many bytes."""
    rows = []
    matrix = gx.rotate((1, 2, 3), 0.7)
    for n in (10, 100, 1000):
        points = np.random.default_rng(0).normal(size=(n, 3)).astype(np.float32)
        target = np.empty_like(points)
        buffer = Buffer(device.context, 16 * n, label="latency")

        def empty(buffer: Buffer = buffer, target: np.typing.NDArray[np.float32] = target) -> None:
            with device.encode_commands(buffer, label="latency"):
                pass
            with buffer.map_read(target.nbytes) as view:
                target[...] = view.view(np.float32).reshape(target.shape)

        contenders: dict[str, Contender] = {
            "ours": lambda points=points: gx.transform_points(points, matrix, device=device),  # type: ignore[misc]
            "empty": empty,
        }
        seconds = medians(contenders, calls=20)
        what = f"{device.name}, one call on {n:,} points"
        rows.append(row(what, "an empty submission, read back", seconds["ours"], seconds["empty"], "1.3 x"))
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
