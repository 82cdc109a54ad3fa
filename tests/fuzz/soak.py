"""The same work for long: memory, descriptors, threads and live GPU objects stay flat. `make soak`."""

import argparse
import gc
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import wgpu

import gpu_xform as gx
from gpu_xform._core.allocator import give_back_memory
from gpu_xform.drawing.layer import Style
from gpu_xform.gpu.device import GpuDevice

N_KINDS = 84  # after so many, transforms and renders have done all that they do, and the others after a seventh
# What may come beyond the first tenth of the work: heaps grow by fits and starts.
MAX_GROWTH_BYTES = 24 << 20
N_READINGS = 10


class Reading(NamedTuple):
    """What a process holds at one time."""

    bytes: int
    descriptors: int
    threads: int
    gpu_objects: int


class Work(NamedTuple):
    """A piece of work, and how often it is done by `make soak`."""

    run: Callable[[int], None]
    n: int


def read_process() -> Reading:
    """Return what this process holds, after a collection."""
    gc.collect()
    give_back_memory()
    n_pages = int(Path("/proc/self/statm").read_text("ascii").split()[1])
    gpu_objects = sum(isinstance(each, wgpu.GPUObjectBase) for each in gc.get_objects())
    n_threads = len(os.listdir("/proc/self/task"))  # noqa: PTH208
    return Reading(n_pages * os.sysconf("SC_PAGE_SIZE"), len(os.listdir("/proc/self/fd")), n_threads, gpu_objects)  # noqa: PTH208


def list_works(folder: Path) -> dict[str, Work]:
    """Return the works; what they write goes into a folder."""
    rng = np.random.default_rng(0)
    clouds = [rng.normal(size=(n, 3)).astype(dtype) for n in (10, 1000, 20_000) for dtype in (np.float32, np.float64)]
    matrices = [gx.rotate_x(k / 10.0) for k in range(7)]
    meshes = [gx.samples.cube(), gx.samples.house(), gx.samples.icosphere(2)]
    styles: list[Style] = [{}, {"hidden": "remove"}, {"fill": "tan"}, {"hidden": "dash"}]

    def transform(k: int) -> None:
        gx.transform_points(clouds[k % len(clouds)], matrices[k % len(matrices)])

    def render(k: int) -> None:
        gx.render_array(meshes[k % 3], size=(64 + k % 2 * 16, 64), **styles[k % len(styles)])

    def open_device(k: int) -> None:
        with GpuDevice() as device:
            gx.transform_points(clouds[k % len(clouds)], matrices[1], device=device)

    def animate(k: int) -> None:
        kind = ("gif", "webp", "png", "html")[k % 4]
        gx.turntable(meshes[k % 3], 3, folder / f"turn.{kind}", size=(48, 48))

    return {
        "transforms": Work(transform, 100_000),
        "renders": Work(render, 2_000),
        "devices": Work(open_device, 200),
        "animations": Work(animate, 500),
    }


def soak(name: str, work: Work, n: int) -> list[str]:
    """Do a work `n` times; print what the process held meanwhile, and return what grew."""
    readings = []
    begin = time.monotonic()
    for k in range(n):
        work.run(k)
        if (k + 1) % max(n // N_READINGS, 1) == 0:
            readings.append(read_process())
    first, last = readings[0], readings[-1]
    print(
        f"{name}: {n:,} in {time.monotonic() - begin:.0f} s; from the first tenth to the end: "
        f"{first.bytes / 1e6:.1f} to {last.bytes / 1e6:.1f} MB, {first.descriptors} to {last.descriptors} descriptors, "
        f"{first.threads} to {last.threads} threads, {first.gpu_objects} to {last.gpu_objects} GPU objects",
        flush=True,
    )
    grown = [
        f"{name}: {field} grew from {getattr(first, field)} to {getattr(last, field)}"
        for field in ("descriptors", "threads", "gpu_objects")
        if getattr(last, field) > getattr(first, field)
    ]
    if last.bytes > first.bytes + MAX_GROWTH_BYTES:
        grown.append(f"{name}: memory grew from {first.bytes:,} to {last.bytes:,} bytes")
    return grown


def main(arguments: list[str] | None = None) -> int:
    """Do each work for long; return how many promises were broken, at most 1."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--share", type=float, default=1.0, help="of the whole number of times")
    options = parser.parse_args(arguments)
    grown = []
    with tempfile.TemporaryDirectory() as folder:
        for name, work in list_works(Path(folder)).items():
            for k in range(N_KINDS if work.n > 1_000 else N_KINDS // 7):
                work.run(k)
            grown += soak(name, work, max(round(work.n * options.share), 20))
    for line in grown:
        print(f"BROKEN {line}")
    return min(len(grown), 1)


if __name__ == "__main__":
    sys.exit(main())
