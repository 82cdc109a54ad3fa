"""Odd arguments for public functions: each call ends in a result or in an error of gpu_xform, soon. `make fuzz`."""

import argparse
import os
import random
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

import gpu_xform as gx

MAX_CPU_S = 5.0
ENDLESS_CPU_S = 60.0
POINTS = np.random.default_rng(0).normal(size=(20, 3))
CUBE = gx.samples.cube()
TILE = np.random.default_rng(1).random((9, 8), np.float32)

Call = tuple[Callable[..., Any], dict[str, Any]]

# Each function with arguments that are right, of which some are replaced.
CALLS: dict[str, Call] = {
    "transform_points": (gx.transform_points, {"points": POINTS, "matrix": gx.translate(1, 2, 3), "precision": "auto"}),
    "transform_vectors": (gx.transform_vectors, {"points": POINTS, "matrix": gx.scale(2), "normalize": True}),
    "transform_normals": (gx.transform_normals, {"points": POINTS, "matrix": gx.scale(2)}),
    "project_points": (gx.project_points, {"points": POINTS, "matrix": gx.perspective(1.0, 1.0, 0.1, 9.0)}),
    "by index": (gx.transform_points, {"points": POINTS, "matrix": np.stack([np.eye(4)] * 2), "index": [0, 1] * 10}),
    "bounds": (gx.bounds, {"points": POINTS}),
    "rotate": (gx.rotate, {"axis": (1, 2, 3), "angle": 0.3, "degrees": True}),
    "look_at": (gx.look_at, {"eye": (1, 2, 3), "target": (0, 0, 0), "up": (0, 1, 0)}),
    "perspective": (gx.perspective, {"fov_y": 1.0, "aspect": 1.0, "near": 0.1, "far": 9.0}),
    "inverse": (gx.inverse, {"m": gx.scale(2)}),
    "decompose": (gx.decompose, {"m": gx.scale(2)}),
    "in an array": (gx.transform_points, {"points": POINTS, "matrix": gx.scale(2), "out": np.empty_like(POINTS)}),
    "Mesh": (gx.Mesh, {"positions": POINTS, "faces": [(0, 1, 2), (2, 1, 3, 4)]}),
    "Camera.fit": (gx.Camera.fit, {"model": CUBE, "direction": (0, 0, -1), "fov_y": 40.0}),
    "render": (gx.render_array, {"models": CUBE, "size": (24, 16), "line_width": 2.0, "hidden": "dash", "fill": "tan"}),
    "styles": (gx.render_array, {"models": CUBE, "size": (24, 16), "scalars": "z", "cmap": "viridis", "alpha": 0.5}),
    "render_svg": (gx.render_svg, {"models": CUBE, "size": (24, 16), "hidden": "fade", "depth_cue": 0.5}),
    "animate": (gx.animate, {"models": CUBE, "frames": [np.eye(4)], "fps": 20.0, "size": (16, 16)}),
    "turntable": (gx.turntable, {"models": CUBE, "frames": 2, "axis": "y", "size": (16, 16)}),
    "convolve": (gx.convolve, {"image": TILE, "kernel": np.ones((3, 3)), "border": "wrap", "origin": (1, 1)}),
    "gaussian": (gx.gaussian, {"sigma": 1.0}),
    "bezier": (gx.bezier, {"control_points": np.random.default_rng(2).normal(size=(4, 4, 3)), "n": 3}),
    "subdivide": (gx.subdivide, {"mesh": CUBE, "levels": 1}),
    "Springs": (gx.Springs, {"model": CUBE, "mass": 1.0, "stretch": 100.0, "damping": 1e-3}),
    "save_mesh": (gx.save_mesh, {"mesh": CUBE, "target": "saved.obj", "file_type": "obj"}),
    "load_mesh": (gx.load_mesh, {"source": "cube.obj", "file_type": "obj", "tolerance": 0.1}),
    "Layer": (gx.Layer, {"model": CUBE, "color": "red", "point_size": 3.0}),
    "FileLimits": (gx.FileLimits, {"points": 5, "depth": 3, "cpu_s": 1.0}),
    "compare_images": (
        gx.compare_images,
        {"picture": np.zeros((4, 4, 3), np.uint8), "reference": np.zeros((4, 4, 3), np.uint8)},
    ),
}
ODD: list[Any] = [
    None, True, 0, -1, 1, 7, 2**31, -(2**63), 10**30, 0.0, -0.5, 1e-320, 1e39, 1e308, float("nan"), float("inf"), 1j,
    "", "x", "none", "a\0b", "\ud800", b"obj", object(), [], [1], [[]], [[1, 2], [3]], {}, {"a": 1}, set(),
    (0, 0), (1, 2, 3), (-1, 5), ("a", "b"), range(3), np.float32(2), np.bool_(True), np.array(3), np.zeros((0, 3)),
    np.ones(3), np.ones((2, 2)), np.eye(3), np.eye(4), np.full((4, 4), np.nan), np.zeros((4, 4)), np.ones((5, 3), int),
    np.ones((3, 3), complex), np.array(["a"]), np.array([None]), np.ma.masked_array([1.0, 2.0], [True, False]),
    np.datetime64("2020"), np.broadcast_to(np.float32(1), (1 << 40, 3)), np.broadcast_to(1.0, (1 << 40, 4, 4)),
    np.broadcast_to(1, (1 << 50,)), np.ones((3, 3)).view(np.matrix), POINTS[::-1], POINTS.astype(">f4"), CUBE,
    gx.Scene(), gx.Camera.look_at((0, 0, 5), (0, 0, 0)), lambda *_: None,
]  # fmt: skip
ALLOWED = (gx.errors.GpuXformError, OSError)


def stop_endless_call(*_: object) -> None:
    """Raise, when a call has taken ENDLESS_CPU_S of a processor, what is no error of gpu_xform."""
    raise AssertionError("the call did not end")


def main() -> int:
    """Call for some seconds; print what was found, and return how many calls broke the promise, at most 1."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 2**32)
    options = parser.parse_args()
    rng, end = random.Random(options.seed), time.monotonic() + options.seconds  # noqa: S311 - no secret
    outcomes: Counter[str] = Counter()
    broken: dict[str, str] = {}
    warnings.simplefilter("ignore")
    signal.signal(signal.SIGPROF, stop_endless_call)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        gx.save_mesh(CUBE, "cube.obj")
        while time.monotonic() < end:
            name, changed = rng.choice(list(CALLS)), {}
            function, right = CALLS[name]
            for argument in rng.sample(list(right), min(len(right), rng.choice((1, 1, 1, 2)))):
                changed[argument] = rng.choice(ODD)
            begin, what = time.process_time(), ""
            signal.setitimer(signal.ITIMER_PROF, ENDLESS_CPU_S)
            try:
                function(**(right | changed))
                outcomes["result"] += 1
            except ALLOWED:
                outcomes["error of gpu_xform"] += 1
            except Exception as error:
                last = traceback.extract_tb(error.__traceback__)[-1]
                outcomes["other"] += 1
                what = f"{name}: {type(error).__name__}: {str(error)[:80]} at {last.filename}:{last.lineno}"
            if time.process_time() - begin > MAX_CPU_S:
                what = what or f"{name}: {time.process_time() - begin:.1f} s of a processor"
            if what:
                broken.setdefault(what, repr(changed)[:150])
        os.chdir("/")
    print(f"seed {options.seed}: {sum(outcomes.values()):,} calls: {dict(outcomes)}")
    for what, arguments in sorted(broken.items()):
        print(f"BROKEN {what}: {arguments}")
    return min(len(broken), 1)


if __name__ == "__main__":
    sys.exit(main())
