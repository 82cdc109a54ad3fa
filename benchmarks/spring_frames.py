"""Frames of a cloth beside pyPBD's XPBD, and a movie of one beside Warp's kernels drawn by pyvista.

pyPBD computes in float64 on all processors; where they have other work, `OMP_NUM_THREADS=1` is faster for it.
"""

import argparse
import importlib
import os
import platform
import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from harness import Row, calm_threads, medians, table
from spring_peers import Peer, Problem, problem_of, scipy_sparse, warp_kernels
from springs import make_cloth

import gpu_xform as gx

FRAME_S = 1.0 / 60.0
N_ERROR_FRAMES = 6  # later the cloth buckles, and every rounding counts
XPBD_SUBSTEPS, XPBD_ITERATIONS = 75, 1
REFERENCE_STEPS = 4  # of the reference in float64, per step of ours
MIN_ERROR_RATIO = 100.0

MOVIE_POINTS, MOVIE_FRAMES, MOVIE_FPS, MOVIE_SIZE = 60, 100, 25, (640, 480)
EYE, TARGET, UP, FOV_Y = (-1.35, 0.6, 2.5), (0.1, -0.45, 0.1), (0.0, 1.0, 0.0), 38.0
CAMERA = gx.Camera.look_at(EYE, TARGET, UP, fov_y=FOV_Y)
LINE_WIDTH = 1.0
N_SAME = 8  # frames in which the movies show the same
DARK, MAX_APART_PX, MAX_PART_APART = 64.0, 2, 0.02
MAX_APART_M = 0.02  # of the movies' cloths at the second frame


def undamped(n: int) -> gx.Springs:
    """Return the cloth of `springs.py` without dampers, which XPBD has in another form."""
    cloth = make_cloth(n)
    return gx.Springs(cloth.mesh, mass=0.2, stretch=1000.0, shear=100.0, bend=50.0, pinned=[0, n - 1])


def xpbd(springs: gx.Springs) -> Peer:
    """Return pyPBD's time step with the same points and a compliant distance constraint per spring; runs frames."""
    pypbd: Any = importlib.import_module("pypbd")

    simulation = pypbd.Simulation.getCurrent()
    simulation.initDefault()
    model = simulation.getModel()
    particles = model.getParticles()
    for point in springs.positions.astype(np.float64):
        particles.addVertex(point)
    for point, mass in enumerate(np.where(springs.pinned, 0.0, springs.masses)):
        particles.setMass(point, float(mass))
    for (i, j), stiffness in zip(springs.springs.tolist(), springs.stiffness, strict=True):
        model.addDistanceConstraint_XPBD(i, j, float(stiffness))
    stepper = simulation.getTimeStep()
    stepper.setValueUInt(pypbd.TimeStepController.NUM_SUB_STEPS, XPBD_SUBSTEPS)
    stepper.setValueUInt(pypbd.TimeStepController.MAX_ITERATIONS, XPBD_ITERATIONS)
    pypbd.TimeManager.getCurrent().setTimeStepSize(FRAME_S)

    def run(n_frames: int) -> None:
        for _ in range(n_frames):
            stepper.step(model)

    return Peer(run, lambda: np.array(particles.getVertices()))


def frames(n: int, rounds: int) -> list[Row]:
    """Time a frame, and compare the errors after a few."""
    springs = undamped(n)
    peer = xpbd(springs)
    n_steps = springs.count_substeps(1.0 / FRAME_S)
    problem = problem_of(springs, FRAME_S / (REFERENCE_STEPS * n_steps))
    reference = scipy_sparse(problem)
    reference.run(REFERENCE_STEPS * n_steps * N_ERROR_FRAMES)
    springs.simulate(N_ERROR_FRAMES * FRAME_S, 1.0 / FRAME_S)
    peer.run(N_ERROR_FRAMES)
    ours, theirs = (
        _rms(positions() - reference.positions()) for positions in (lambda: springs.positions, peer.positions)
    )
    print(f"cloth of {n} x {n} after {N_ERROR_FRAMES} frames, root mean square error in metres:")
    print(f"- ours, {n_steps} steps a frame: {ours:.2g}; XPBD, {XPBD_SUBSTEPS} x {XPBD_ITERATIONS}: {theirs:.2g}")
    print(f"- {theirs / ours:.0f} times less (asked: {MIN_ERROR_RATIO:g})")
    if not theirs / ours >= MIN_ERROR_RATIO:
        raise SystemExit("not accurate enough: not compared")
    seconds = medians(
        {"ours": lambda: springs.simulate(FRAME_S, 1.0 / FRAME_S), "pyPBD": lambda: peer.run(1)}, rounds=rounds
    )
    return [Row(f"a frame of a cloth, {n} x {n}", "pyPBD XPBD", seconds["ours"], seconds["pyPBD"], 1.2)]


def movie_here(springs: gx.Springs, path: Path) -> None:
    """Simulate, and write the GIF with this library."""
    trajectory = springs.simulate((MOVIE_FRAMES - 1) / MOVIE_FPS, MOVIE_FPS)
    gx.animate(springs, trajectory, path, size=MOVIE_SIZE, camera=CAMERA, line_width=LINE_WIDTH)


def movie_warp(peer: Peer, n_steps: int, edges: npt.NDArray[np.int64], path: Path) -> None:
    """Simulate with Warp's kernels, and write the GIF with pyvista: lines whose points move, and a frame after each."""
    import pyvista

    cells = np.insert(edges, 0, 2, axis=1)
    lines = pyvista.PolyData(np.array(peer.positions(), np.float32), lines=cells.ravel())
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(MOVIE_SIZE))
    plotter.add_mesh(lines, color="black", line_width=LINE_WIDTH, lighting=False)
    plotter.background_color = "white"
    plotter.enable_anti_aliasing("msaa")
    plotter.camera_position = [EYE, TARGET, UP]
    plotter.camera.view_angle = FOV_Y
    plotter.open_gif(str(path), fps=MOVIE_FPS)
    plotter.write_frame()
    for _ in range(MOVIE_FRAMES - 1):
        peer.run(n_steps)
        lines.points = np.array(peer.positions(), np.float32)
        plotter.write_frame()
    plotter.close()


def movie(rounds: int, folder: Path) -> list[Row]:
    """Time the movie on the device and on the host, which draws on the device; compare the pictures."""
    springs = make_cloth(MOVIE_POINTS)
    on_host = make_cloth(MOVIE_POINTS, device=gx.Device("host"))
    n_steps = springs.count_substeps(MOVIE_FPS)
    problem = problem_of(springs, 1.0 / MOVIE_FPS / n_steps)
    ours, host, theirs = (folder / f"{name}.gif" for name in ("ours", "host", "warp"))
    edges = springs.mesh.edges
    seconds: dict[Path, list[float]] = {ours: [], host: [], theirs: []}
    for turn in range(rounds + 1):
        springs.reset()
        on_host.reset()
        peer = warp_kernels(problem)
        peer.run(0)
        makers = {
            ours: partial(movie_here, springs, ours),
            host: partial(movie_here, on_host, host),
            theirs: partial(movie_warp, peer, n_steps, edges, theirs),
        }
        for path, make in makers.items():
            taken = _time(make)
            if turn:  # the first round compiles
                seconds[path].append(taken)
    _compare_movies(ours, theirs)
    _compare_movies(host, theirs)
    _compare_states(problem, n_steps)
    medians = {path: statistics.median(values) for path, values in seconds.items()}
    what = f"a GIF of {MOVIE_FRAMES} frames, cloth of {MOVIE_POINTS} x {MOVIE_POINTS}"
    against = "Warp and pyvista"
    return [
        Row(what, against, medians[ours], medians[theirs], 0.5),
        Row(f"{what}, simulated on the host", against, medians[host], medians[theirs], 0.5),
    ]


def _compare_states(problem: Problem, n_steps: int) -> None:
    springs, peer = make_cloth(MOVIE_POINTS), warp_kernels(problem)
    springs.simulate(1.0 / MOVIE_FPS, MOVIE_FPS)
    peer.run(n_steps)
    apart = float(np.abs(np.asarray(peer.positions()) - springs.positions).max())
    print(f"- a frame after the start the cloths are {apart:.1e} m apart")
    if not apart < MAX_APART_M:
        raise SystemExit("another motion: not compared")


def _compare_movies(ours: Path, theirs: Path) -> None:
    """Stop unless both have as many frames of one size, and in the first, before rounding counts, the same lines."""
    here, there = _read_darkness(ours), _read_darkness(theirs)
    if len(here) != MOVIE_FRAMES or len(there) != MOVIE_FRAMES:
        raise SystemExit(f"{len(here)} and {len(there)} frames: not compared")
    apart = max(
        _part_without(a, b) for x, y in zip(here[:N_SAME], there[:N_SAME], strict=True) for a, b in ((x, y), (y, x))
    )
    print(
        f"the movies: {MOVIE_FRAMES} frames of {MOVIE_SIZE}; {apart:.1%} of the dark pixels of one are not in the other"
    )
    if not apart < MAX_PART_APART:
        raise SystemExit("other pictures: not compared")


def _part_without(one: npt.NDArray[np.float64], other: npt.NDArray[np.float64]) -> float:
    """Return the part of the dark pixels of one frame that have none around them in another."""
    from scipy.ndimage import maximum_filter

    dark = one > DARK
    return float((dark & (maximum_filter(other, 2 * MAX_APART_PX + 1) <= DARK)).sum() / dark.sum())


def _read_darkness(path: Path) -> list[npt.NDArray[np.float64]]:
    from PIL import Image, ImageSequence

    frames = []
    with Image.open(path) as movie:
        if movie.size != MOVIE_SIZE:
            raise SystemExit(f"{path} has the size {movie.size}")
        for frame in ImageSequence.Iterator(movie):  # a GIF writes equal frames once, for longer
            darkness = 255.0 - np.asarray(frame.convert("L"), np.float64)
            frames += [darkness] * round(frame.info["duration"] * MOVIE_FPS / 1000.0)
    return frames


def _time(make: Callable[[], object]) -> float:
    start = time.perf_counter()
    make()
    return time.perf_counter() - start


def _rms(differences: npt.NDArray[Any]) -> float:
    return float(np.sqrt((differences**2).sum(axis=1).mean()))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="(5)")
    parser.add_argument("--only", choices=("frames", "movie"), help="one of the two")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="for the movies, which are else deleted")
    options = parser.parse_args()
    calm_threads()
    print(f"{os.cpu_count()} processors; Python {platform.python_version()}\n")
    rows = []
    if options.only != "movie":
        rows += frames(100, options.rounds)
    if options.only != "frames":
        with tempfile.TemporaryDirectory() as folder:
            rows += movie(options.rounds, options.keep or Path(folder))
    print(f"\n{table(rows)}")


if __name__ == "__main__":
    main()
