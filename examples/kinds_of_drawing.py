"""Seven models, each as a thumbnail, as a drawing with dashed hidden lines, and shaded.

`python examples/kinds_of_drawing.py FOLDER` writes some twenty pictures: what one model asks of a style another does
not, a cube of twelve edges and a scan of a million triangles above all.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import gpu_xform as gx

CAMERA: dict[str, Any] = {"direction": (-0.55, 1, -0.7), "up": (0, 0, 1)}
THUMBNAIL: dict[str, Any] = {"size": (128, 128), "fill": "shade", "line_width": "auto"}
DASHED: dict[str, Any] = {"size": (900, 700), "hidden": "dash", "line_width": 2}
SHADED: dict[str, Any] = {"size": (900, 700), "fill": "tan", "shading": "flat", "hidden": "remove", "line_width": 1.5}
OUTLINES = ["feature", "silhouette"]
UPRIGHT = gx.rotate_x(90, degrees=True)  # from y up to z up


def prism(profile: npt.ArrayLike, low: float, high: float) -> gx.Mesh:
    """Return a polygon of the xy-plane, counter-clockwise, between two heights."""
    outline = np.asarray(profile, float)
    n = len(outline)
    points = np.vstack([np.insert(outline, 2, height, axis=1) for height in (low, high)])
    sides = [(i, (i + 1) % n, (i + 1) % n + n, i + n) for i in range(n)]
    return gx.Mesh(points, [range(n)[::-1], range(n, 2 * n), *sides])


def tube(outer: npt.ArrayLike, bore: float, low: float, high: float) -> gx.Mesh:
    """Return a polygon about the origin with a round bore, between two heights."""
    outline = np.asarray(outer, float)
    n = len(outline)
    circle = bore * outline / np.linalg.norm(outline, axis=1, keepdims=True)
    rings = [(outline, low), (outline, high), (circle, high), (circle, low)]
    points = np.vstack([np.insert(ring, 2, height, axis=1) for ring, height in rings])
    quads = [
        (k * n + i, k * n + (i + 1) % n, (k + 1) % 4 * n + (i + 1) % n, (k + 1) % 4 * n + i)
        for k in range(4)
        for i in range(n)
    ]
    return gx.Mesh(points, quads)


def circle(radius: float, n: int) -> npt.NDArray[np.float64]:
    """Return the corners of a regular polygon, (n, 2)."""
    angle = np.arange(n) * 2 * np.pi / n
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def gear(n_teeth: int = 18) -> gx.Mesh:
    """Return a wheel with straight teeth."""
    angle = np.arange(4 * n_teeth) * 2 * np.pi / (4 * n_teeth)
    radius = np.tile([10, 10, 12, 12], n_teeth)
    return tube(radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]), 4, 0, 5)


def bracket() -> list[gx.Layer]:
    """Return an angle with a rib, and a boss on its foot."""
    angle = prism([(0, 0), (40, 0), (40, 6), (12, 6), (6, 12), (6, 40), (0, 40)], 0, 40)
    boss = tube(circle(7, 64), 4, 0, 4)
    return [
        gx.Layer(angle, transform=gx.chain(UPRIGHT, gx.translate(0, 20, 0))),
        gx.Layer(boss, transform=gx.translate(28, 0, 6)),
    ]


def scan(n: int = 708) -> gx.Mesh:
    """Return a landscape of 2 (n - 1)^2 triangles, a million by default."""
    x, y = np.meshgrid(np.linspace(-3, 3, n), np.linspace(-3, 3, n), indexing="ij")
    z = 0.5 * np.sin(2 * x + np.cos(3 * y)) + 0.3 * np.cos(5 * y - x) * np.exp(-(x**2) / 4)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    quads = np.column_stack([corner, corner + n, corner + n + 1, corner, corner + n + 1, corner + 1])
    return gx.Mesh(np.column_stack([x.ravel(), y.ravel(), z.ravel()]), quads.reshape(-1, 3))


def assembly() -> list[gx.Layer]:
    """Return a flange with six nuts, and a wheel on its neck."""
    places = np.array([gx.translate(x, y, 6) for x, y in circle(23, 6)])
    return [
        gx.Layer(tube(circle(30, 96), 9, 0, 6)),
        gx.Layer(tube(circle(14, 96), 9, 6, 26)),
        gx.Layer(tube(circle(4.5, 6), 2, 0, 4), transform=places),
        gx.Layer(tube(circle(20, 96), 14, 16, 22)),
    ]


def restyle(models: gx.Mesh | Sequence[gx.Layer], **style: Any) -> list[gx.Layer]:
    """Return the layers of a model in a style."""
    layers = [gx.Layer(models)] if isinstance(models, gx.Mesh) else models
    return [gx.Layer(layer.model, transform=layer.transform, **style) for layer in layers]


def main(folder: Path) -> None:
    """Write the pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn: dict[str, gx.Mesh | list[gx.Layer]] = {
        "cube": gx.samples.cube(),
        "bracket": bracket(),
        "gear": gear(),
        "teapot": [gx.Layer(gx.samples.teapot(16), transform=UPRIGHT)],
        "scan": scan(),
        "assembly": assembly(),
    }
    for name, model in drawn.items():
        edges = {} if name == "cube" else {"edges": OUTLINES}
        for kind, look in (("thumbnail", THUMBNAIL), ("dashed", DASHED), ("shaded", SHADED)):
            style: dict[str, Any] = {key: value for key, value in look.items() if key != "size"} | edges
            if name == "scan" and kind != "dashed":  # whose silhouettes would be most of the picture
                style |= {"edges": []}
            if kind == "shaded" and name in ("teapot", "scan"):
                style |= {"shading": "smooth"}
            gx.render(restyle(model, **style), camera=CAMERA, size=look["size"]).save(folder / f"{name}-{kind}.png")
    cloud = gx.transform_points(gx.samples.teapot(64).positions, UPRIGHT)
    for size in ((128, 128), (900, 700)):
        picture = gx.render(cloud, scalars="z", cmap="viridis", point_size=2, camera=CAMERA, size=size, depth_cue=0.3)
        picture.save(folder / ("cloud.png" if size[0] > 128 else "cloud-thumbnail.png"))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
