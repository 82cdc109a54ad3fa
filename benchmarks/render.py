"""Wireframes beside their peers: one frame of a scene that stays, drawn and read back, ratios from one run.

Each renderer has a process of its own, and they draw in turn. Before its time counts, its picture must show what ours
shows. The peers come with `pip install 'gpu_xform[bench]'`; one that cannot start is named.
"""

import argparse
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from harness import Row, calm_threads, medians, table
from pictures import Pixels, difference, n_shades
from PIL import Image
from renderers import EYE, FOV_Y, LINE_WIDTH, RENDERERS, SIDE, TARGET, UP
from workers import RendererError, Worker

import gpu_xform as gx


@dataclass(frozen=True)
class Comparison:
    """Two renderers of the same picture, and the ratio asked for."""

    what: str
    ours: str
    theirs: str
    at_most: float | None = None
    largest: int = 8  # the icosphere beyond which it takes too long

    def __str__(self) -> str:
        return f"{self.what}: {self.ours} beside {self.theirs}"


SMOOTH = "1.5 px, anti-aliased"
COMPARISONS = [
    Comparison("1 px, aliased", "ours, aliased", "moderngl GL_LINES", 1.0),
    Comparison(SMOOTH, "ours", "ours, aliased", 2.0),
    Comparison(SMOOTH, "ours", "pygfx line segments", 0.3),
    Comparison(SMOOTH, "ours", "pygfx line segments, aa=True, ppaa='none'"),
    Comparison(SMOOTH, "ours", "pygfx mesh wireframe", 0.3),
    Comparison(SMOOTH, "ours", "pygfx mesh wireframe, ppaa='fxaa'"),
    Comparison(SMOOTH, "ours", "pyvista lines, MSAA", 0.6),
    Comparison(f"{SMOOTH}, hidden lines removed", "ours, hidden lines removed", "f3d mesh with edges", 0.18),
    Comparison(f"{SMOOTH}, hidden lines removed", "ours, hidden lines removed", "ours, aliased, hidden lines removed"),
    Comparison(SMOOTH, "ours, by render passes", "ours"),
    Comparison(
        f"{SMOOTH}, hidden lines removed", "ours, by render passes, hidden lines removed", "f3d mesh with edges", 0.6
    ),
    Comparison(f"{SMOOTH}, in many colours", "ours, by height", "pyvista lines by height, MSAA"),
    Comparison(SMOOTH, "ours", "matplotlib Line3DCollection", largest=6),
    Comparison(SMOOTH, "ours", "skia, projected lines", largest=6),
]
ALIASED = {"ours, aliased", "ours, aliased, hidden lines removed", "moderngl GL_LINES"}
PACKAGES = ["wgpu", "moderngl", "pygfx", "pyvista", "vtk", "f3d", "matplotlib", "skia-python"]

COARSE = 4  # an icosphere whose lines lie well apart in the picture
SHIFT = 3  # pixels


def stands_up(comparison: Comparison, pictures: dict[str, Pixels]) -> bool:
    """Tell whether both draw the same, each as it says; print why not."""
    ours, theirs = pictures[comparison.ours], pictures[comparison.theirs]
    width_ours, width_theirs = (1.0 if name in ALIASED else LINE_WIDTH for name in (comparison.ours, comparison.theirs))
    width_ratio = width_theirs / width_ours
    reason = difference(ours, theirs, width_ratio)
    for name in (comparison.ours, comparison.theirs):
        if reason is None and (n_shades(pictures[name]) == 2) != (name in ALIASED):
            reason = f"{name} draws in {n_shades(pictures[name])} shades"
    if reason is None and difference(ours, np.roll(theirs, SHIFT, axis=1), width_ratio) is None:
        raise SystemExit(f"{comparison}: the same picture moved by {SHIFT} pixels would pass")
    if reason is not None:
        print(f"- {comparison}: NOT COMPARED, {reason}")
    return reason is None


def end_idle(workers: dict[str, Worker], comparisons: list[Comparison]) -> None:
    """End those workers that no comparison needs any more."""
    for name in workers.keys() - {name for each in comparisons for name in (each.ours, each.theirs)}:
        workers.pop(name).close()


def set_up(n: int, workers: dict[str, Worker], comparisons: list[Comparison]) -> list[Comparison]:
    """Show icosphere(n) in the workers; return the comparisons that stand up, and print what keeps the others out."""
    comparisons = [each for each in comparisons if n <= each.largest]
    end_idle(workers, comparisons)
    pictures = {}
    for name, worker in workers.items():
        try:
            pictures[name], drawn_on = worker.show(n)
        except RendererError as error:
            print(f"- {name}: NOT COMPARED, {error}")
        else:
            if n == COARSE:
                print(f"- {name}: {drawn_on}")
    comparisons = [each for each in comparisons if {each.ours, each.theirs} <= pictures.keys()]
    comparisons = [each for each in comparisons if stands_up(each, pictures)]
    end_idle(workers, comparisons)
    return comparisons


def frames(comparisons: list[Comparison], sizes: list[int], rounds: int) -> dict[tuple[Comparison, int], Row]:
    """Time one frame of icospheres of these sizes with every renderer."""
    names = dict.fromkeys(name for each in comparisons for name in (each.ours, each.theirs))
    workers = {name: Worker(RENDERERS[name]) for name in names}
    comparisons = set_up(COARSE, workers, comparisons)
    rows = {}
    for n in sizes:
        comparisons = set_up(n, workers, comparisons)
        seconds = medians({name: worker.draw for name, worker in workers.items()}, rounds=rounds)
        for each in comparisons:
            what = f"{each.what}, {30 * 4**n:,} edges"
            rows[each, n] = Row(what, each.theirs, seconds[each.ours], seconds[each.theirs], each.at_most)
    end_idle(workers, [])
    return rows


def scaling(rows: dict[tuple[Comparison, int], Row]) -> list[str]:
    """Return how the time per frame grows with the number of edges."""
    seconds: dict[str, dict[int, float]] = {}
    for (each, n), row in rows.items():
        seconds.setdefault(each.ours, {})[n] = row.ours
        seconds.setdefault(each.theirs, {})[n] = row.theirs
    lines = []
    for name, by_size in seconds.items():
        few, many = min(by_size), max(by_size)
        if few < many:
            growth = by_size[many] / by_size[few]
            lines.append(f"{4 ** (many - few)} times the edges, {name}: {growth:.1f} times the time")
    return lines


OUR_COMMAND = """
import sys
from gpu_xform.cli import main
if main(sys.argv[1:]) != 0:
    sys.exit("failed")
"""

THEIR_SCRIPT = f"""
import sys
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=({SIDE}, {SIDE}))
mesh = pyvista.read(sys.argv[1])
plotter.add_mesh(mesh, style="wireframe", color="black", line_width={LINE_WIDTH}, lighting=False)
plotter.background_color = "white"
plotter.enable_anti_aliasing("msaa")
plotter.camera_position = [{EYE}, {TARGET}, {UP}]
plotter.camera.view_angle = {FOV_Y}
plotter.screenshot(sys.argv[2])
"""

PRINT_PEAK = """
import re  # not getrusage: its figure begins at the peak of the process that started this one
print(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1])
"""


def commands(model: Path, then: str = "") -> dict[str, tuple[list[str], Path]]:
    """Return two commands that make a picture of a file in a process of their own, and the picture of each."""

    def joined(numbers: Iterable[float]) -> str:
        return ",".join(f"{number:g}" for number in numbers)

    view = f"--camera-position {joined(EYE)} --camera-focal-point {joined(TARGET)} --camera-view-up {joined(UP)}"
    frame = f"--camera-view-angle {FOV_Y} --resolution {SIDE},{SIDE} --line-width {LINE_WIDTH}"
    ours, theirs = model.with_name("ours.png"), model.with_name("theirs.png")
    arguments = ["render", str(model), "-o", str(ours), *view.split(), *frame.split()]
    return {
        "ours": ([sys.executable, "-c", OUR_COMMAND + then, *arguments], ours),
        "pyvista": ([sys.executable, "-c", THEIR_SCRIPT + then, str(model), str(theirs)], theirs),
    }


def run(command: list[str]) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def checked_run(made: dict[str, tuple[list[str], Path]]) -> dict[str, str] | None:
    """Run each command once and return what it prints; None, and print why, where the pictures are not the same."""
    printed = {}
    for name, (command, _) in made.items():
        try:
            printed[name] = run(command)
        except subprocess.CalledProcessError as error:
            last = (error.stderr.strip().splitlines() or [f"status {error.returncode}"])[-1]
            print(f"- {name}, a process of its own: NOT COMPARED, {last}")
            return None
    ours, theirs = (np.asarray(Image.open(picture).convert("RGB")) for _, picture in made.values())
    reason = difference(ours, theirs)
    if reason is not None:
        print(f"- pyvista, a process of its own: NOT COMPARED, {reason}")
        return None
    return printed


def cold(n: int, rounds: int) -> list[Row]:
    """Time whole processes that make a PNG picture of an OBJ file."""
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "icosphere.obj"
        gx.save_mesh(gx.samples.icosphere(n), model)
        made = commands(model)
        if checked_run(made) is None:
            return []
        seconds = medians({name: partial(run, command) for name, (command, _) in made.items()}, rounds, warm_up=1)
    what = f"cold process, OBJ to PNG, {30 * 4**n:,} edges"
    return [Row(what, "a pyvista script, style='wireframe'", seconds["ours"], seconds["pyvista"], 1.0)]


def peak_memory(n: int) -> list[str]:
    """Return the peak memory of whole processes that make a PNG picture of a PLY file."""
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "icosphere.ply"
        gx.save_mesh(gx.samples.icosphere(n), model)
        printed = checked_run(commands(model, then=PRINT_PEAK))
    if printed is None:
        return []
    ours, theirs = (int(text.split()[-1]) / 1024 for text in printed.values())
    what = f"peak memory of a process, PLY to PNG, {30 * 4**n:,} edges"
    return [f"{what}: {ours:.0f} MB, pyvista {theirs:.0f} MB: {ours / theirs:.2f} (asked: at most 1)"]


def named(package: str) -> str:
    """Return a package's name and version."""
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return f"no {package}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few rounds: rough figures")
    parser.add_argument("--only", metavar="NAME", default="", help="rows that name this: pygfx, f3d, cold, memory, ...")
    parser.add_argument("--sizes", type=int, nargs="+", default=[6, 8], metavar="N", help="of icospheres (6 8)")
    options = parser.parse_args()
    calm_threads()
    rounds = 3 if options.quick else 9
    print(f"{os.cpu_count()} processors; Python {platform.python_version()}, ", end="")
    print(", ".join(map(named, PACKAGES)), end="\n\n")
    timed = frames([each for each in COMPARISONS if options.only in str(each)], sorted(options.sizes), rounds)
    rows = list(timed.values())
    if options.only in "cold pyvista":
        rows += cold(4, rounds)
    print(f"\n{table(rows)}\n")
    lines = scaling(timed)
    if options.only in "memory pyvista":
        lines += peak_memory(8)
    print(*lines, sep="\n")


if __name__ == "__main__":
    main()
