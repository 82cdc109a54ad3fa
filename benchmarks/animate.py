"""Whole movies beside their peers: frames drawn, encoded and written, ratios from one run.

Each maker has a process of its own, which stays warm, and they work in turn. Before its time counts, the file that it
writes must show what ours shows. The peers come with `pip install 'gpu_xform[bench]'`.
"""

import argparse
import os
import platform
import tempfile
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Self

import av
import numpy as np
from harness import Row, calm_threads, medians, table
from movies import BALL_FRAMES, BALL_MAKERS, FEW_FRAMES, SPHERE_FRAMES, SPHERE_MAKERS, Maker
from pictures import Pixels, astray
from PIL import Image

import gpu_xform as gx

COMPARED = (0, 7, 13)  # frames
MAX_ASTRAY_PART = 0.02  # of the lit pixels; a lossy format lights a few beside its lines


def frames(path: Path) -> list[Pixels]:
    """Return the frames of a file."""
    if path.suffix == ".mp4":
        with av.open(str(path)) as container:
            return [np.asarray(frame.to_ndarray(format="rgb24")) for frame in container.decode(video=0)]
    shown = []
    with Image.open(path) as image:
        for k in range(getattr(image, "n_frames", 1)):
            image.seek(k)
            shown.append(np.asarray(image.convert("RGB")))
    return shown


def off(ours: Pixels, theirs: Pixels) -> float:
    """Return the part of the lit pixels of either picture that the other has not within a pixel."""
    return max(astray(ours, theirs), astray(theirs, ours))


class Studio:
    """The makers of a movie, each in a process of its own."""

    def __init__(self, makers: Mapping[str, Maker], folder: Path) -> None:
        self._makers = makers
        self._pools = {name: ProcessPoolExecutor(1, get_context("spawn")) for name in makers}
        self.paths = {name: folder / f"{name}{maker.suffix}" for name, maker in makers.items()}

    def make(self, name: str, mesh: gx.Mesh) -> None:
        """Have one of them make the movie of a mesh."""
        self._pools[name].submit(self._makers[name].make, mesh, self.paths[name]).result()

    def require_alike(self, mesh: gx.Mesh) -> None:
        """Stop where what one of them makes of a mesh with few lines does not show what ours shows, frame by frame."""
        for name in self._makers:
            self.make(name, mesh)
        expected = frames(self.paths["ours"])
        for name, path in self.paths.items():
            made = frames(path)
            for k in COMPARED:
                if off(expected[k], made[k]) > MAX_ASTRAY_PART:
                    raise SystemExit(f"{name}, frame {k}: {100 * off(expected[k], made[k]):.2g} % is off: not compared")
                if off(expected[k], made[k + 1]) <= MAX_ASTRAY_PART:
                    raise SystemExit(f"{name}: its frame {k + 1} would pass for frame {k}")

    def medians(self, mesh: gx.Mesh, rounds: int) -> dict[str, float]:
        """Return the median seconds that each of them takes; print how large the files are."""
        contenders = {name: partial(self.make, name, mesh) for name in self._makers}
        seconds = medians(contenders, rounds=rounds, warm_up=1)
        for name, path in self.paths.items():
            print(f"- {name}: {len(frames(path))} frames, {path.stat().st_size / 1e6:.2f} MB")
        return seconds

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for pool in self._pools.values():
            pool.shutdown()


def sphere(rounds: int, folder: Path) -> list[Row]:
    """Time an MP4 of many lines."""
    with Studio(SPHERE_MAKERS, folder) as studio:
        studio.require_alike(gx.samples.icosphere(2))
        mesh = gx.samples.icosphere(5)
        seconds = studio.medians(mesh, rounds)
    what = f"{SPHERE_FRAMES} frames of 1280 x 720, {len(mesh.edges):,} edges, MP4"
    slow = seconds["matplotlib FuncAnimation"] / FEW_FRAMES * SPHERE_FRAMES
    return [
        Row(what, "pyvista open_movie", seconds["ours"], seconds["pyvista open_movie"], 0.4),
        Row(what, f"matplotlib FuncAnimation, of {FEW_FRAMES} frames", seconds["ours"], slow, 0.1),
    ]


def ball(rounds: int, folder: Path) -> list[Row]:
    """Time a GIF of few lines in many colours."""
    mesh = gx.samples.snub_dodecahedron()
    with Studio(BALL_MAKERS, folder) as studio:
        studio.require_alike(mesh)
        seconds = studio.medians(mesh, rounds)
    what = f"{BALL_FRAMES} frames of 640 x 480, snub dodecahedron, a colour a face, GIF"
    return [Row(what, "matplotlib FuncAnimation", seconds["ours"], seconds["matplotlib FuncAnimation"], 0.1)]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="(3)")
    options = parser.parse_args()
    calm_threads()
    print(f"{os.cpu_count()} processors; Python {platform.python_version()}\n")
    with tempfile.TemporaryDirectory() as folder:
        rows = [*sphere(options.rounds, Path(folder)), *ball(options.rounds, Path(folder))]
    print(f"\n{table(rows)}")


if __name__ == "__main__":
    main()
