"""A cloud of points in memory, coloured by height, beside pyvista; and `Camera.fit` beside NumPy's extremes.

A picture is made from the array each time: bounds, colours, drawing and reading back. Ours fades with distance as well.
The pictures are compared first, by the mean colours of squares of pixels, as dots here are round and smooth.
"""

import argparse
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from harness import Row, calm_threads, medians, table

import gpu_xform as gx

SIDE = 1024
POINT_SIZE = 2
EYE, TARGET, UP, FOV_Y = (0.0, 0.0, 60.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 30.0
SQUARE_PX = 32
MAX_DIFFERENCE = 12.0  # of the mean colours of a square, of 255

Points = npt.NDArray[np.float32]
Pixels = npt.NDArray[np.uint8]


def ours(points: Points, depth_cue: float) -> Pixels:
    """Return a picture by this library."""
    camera = gx.Camera.look_at(EYE, TARGET, UP, fov_y=FOV_Y)
    style: dict[str, Any] = {"scalars": points[:, 2], "point_size": float(POINT_SIZE), "depth_cue": depth_cue}
    return gx.render_array(points, camera=camera, size=(SIDE, SIDE), **style)


def pyvista_points(points: Points) -> Pixels:
    """Return a picture by pyvista."""
    import pyvista

    plotter: Any = pyvista.Plotter(off_screen=True, window_size=[SIDE, SIDE])
    colors = {"scalars": points[:, 2], "cmap": "viridis", "show_scalar_bar": False}
    plotter.add_mesh(pyvista.PolyData(points), style="points", point_size=POINT_SIZE, lighting=False, **colors)
    plotter.background_color = "white"
    plotter.camera_position = [EYE, TARGET, UP]
    plotter.camera.view_angle = FOV_Y
    image = np.asarray(plotter.screenshot(return_img=True))
    plotter.close()
    return image


def difference(ours: Pixels, theirs: Pixels) -> float:
    """Return by how much the mean colours of the squares of two pictures differ, on average."""
    n = SIDE // SQUARE_PX
    means = [image[..., :3].reshape(n, SQUARE_PX, n, SQUARE_PX, 3).mean(axis=(1, 3)) for image in (ours, theirs)]
    return float(np.abs(means[0] - means[1]).mean())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=3_100_000)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    calm_threads()
    points = (np.random.default_rng(1).normal(size=(options.points, 3)) * (5, 3, 1)).astype(np.float32)
    theirs = pyvista_points(points)
    apart = difference(ours(points, 0.0), theirs)
    moved = difference(ours(points, 0.0), np.roll(theirs, SQUARE_PX, axis=1))
    print(f"- mean colours of squares differ by {apart:.2f}, of the same picture moved by a square by {moved:.2f}")
    if apart > MAX_DIFFERENCE or moved < 2.0 * apart:
        raise SystemExit("the pictures are not the same")
    many = np.random.default_rng(2).normal(size=(10_000_000, 3))
    seconds = medians(
        {
            "ours": partial(ours, points, 0.5),
            "pyvista": partial(pyvista_points, points),
            "fit": lambda: gx.Camera.fit(many).clip_from_world(1.0),
            "extremes": lambda: (many.min(axis=0), many.max(axis=0)),
        },
        rounds=options.rounds,
        warm_up=1,
    )
    what = f"{options.points:,} points by height, depth cue"
    print(
        table(
            [
                Row(what, "pyvista, without a cue", seconds["ours"], seconds["pyvista"], 0.5),
                Row("Camera.fit, 10 M points", "NumPy's min and max", seconds["fit"], seconds["extremes"], 1.2),
            ]
        )
    )


if __name__ == "__main__":
    main()
