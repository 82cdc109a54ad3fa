"""Models to look at: a cube, a bracket, a gear, a teapot, a scan, a cloud and an assembly, drawn as they are used.

Each is drawn as a thumbnail, as a dashed drawing and shaded: `python benchmarks/gallery.py FOLDER`. All is generated.
"""

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

import gpu_xform as gx
from gpu_xform import Layer, Mesh
from gpu_xform.drawing.legible_style import legible_style

THUMBNAIL = (256, 256)
LARGE = (900, 700)
SCAN_SIDE = 708  # points along one side: a million triangles


def prism(outlines: list[Any], height: float) -> Mesh:
    """Return an extruded polygon with holes: its outer outline first, all (k, 2), counter-clockwise."""
    import mapbox_earcut

    flat = np.concatenate(outlines)
    ends = np.cumsum([len(outline) for outline in outlines])
    triangles = mapbox_earcut.triangulate_float64(flat, ends.astype(np.uint32)).reshape(-1, 3).astype(int)
    n = len(flat)
    points = np.vstack([np.column_stack([flat, np.full(n, z)]) for z in (0.0, height)])
    (ax, ay), (bx, by) = ((flat[triangles[:, k]] - flat[triangles[:, 0]]).T for k in (1, 2))
    areas = ax * by - ay * bx
    triangles[areas < 0] = triangles[areas < 0][:, ::-1]
    faces = [*triangles[:, ::-1].tolist(), *(triangles + n).tolist()]
    for number, (start, end) in enumerate(zip([0, *ends[:-1]], ends, strict=True)):
        ring = np.arange(start, end)
        for a, b in zip(ring, np.roll(ring, -1), strict=True):
            faces.append([a, b, b + n, a + n] if number == 0 else [b, a, a + n, b + n])
    return Mesh(points, faces)


def circle(x: float, y: float, radius: float, n: int = 48) -> Any:
    """Return the corners of a regular polygon."""
    angles = np.arange(n) * (2.0 * math.pi / n)
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


def bracket() -> Mesh:
    """Return an angle bracket of two plates with holes."""
    sheet = np.array([(-40.0, 0.0), (40.0, 0.0), (40.0, 50.0), (-40.0, 50.0)])
    plate = prism([sheet, circle(-22, 30, 8), circle(22, 30, 8), circle(0, 18, 5)], 6.0)
    wall = plate.transformed(gx.chain(gx.rotate_x(90, degrees=True), gx.translate(0, 6, 0)))
    return _join([plate, wall]).transformed(gx.rotate_z(180, degrees=True))


def gear(n_teeth: int = 24) -> Mesh:
    """Return a spur gear with a bore and five holes."""
    angles = np.repeat(np.arange(n_teeth) * (2 * math.pi / n_teeth), 4)
    angles = angles + np.tile(np.array([-0.30, -0.15, 0.15, 0.30]) * (2 * math.pi / n_teeth), n_teeth)
    radii = np.tile([26.0, 31.0, 31.0, 26.0], n_teeth)
    rim = np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])
    around = [circle(15 * math.cos(a), 15 * math.sin(a), 4) for a in np.arange(5) * (2 * math.pi / 5)]
    return prism([rim, circle(0, 0, 6), *around], 8.0)


def scan() -> Mesh:
    """Return a scan-like surface of a million triangles: hills with noise."""
    x, y = np.meshgrid(np.linspace(-1, 1, SCAN_SIDE), np.linspace(-1, 1, SCAN_SIDE), indexing="ij")
    z = 0.3 * np.exp(-4 * (x**2 + y**2)) + 0.08 * np.sin(5 * x + 2) * np.cos(4 * y) + 0.02 * np.sin(17 * x * y)
    z += np.random.default_rng(1).normal(0.0, 3e-4, z.shape)
    at = np.arange(SCAN_SIDE * SCAN_SIDE).reshape(SCAN_SIDE, SCAN_SIDE)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return Mesh(np.column_stack([x.ravel(), y.ravel(), z.ravel()]), triangles)


def cloud() -> Any:
    """Return a cloud of points on a torus."""
    rng = np.random.default_rng(2)
    u, v = rng.uniform(0, 2 * math.pi, (2, 60_000))
    r = 1.0 + 0.4 * np.cos(v)
    return np.column_stack([r * np.cos(u), r * np.sin(u), 0.4 * np.sin(v)]) + rng.normal(0, 0.01, (60_000, 3))


def _join(meshes: list[Mesh]) -> Mesh:
    faces: list[Any] = []
    first = 0
    for mesh in meshes:
        faces += [[first + int(i) for i in face] for face in mesh.faces]
        first += mesh.n_points
    return Mesh(np.vstack([mesh.positions for mesh in meshes]), faces)


def assembly(**style: Any) -> list[Layer]:
    """Return a gear on an axle over a bracket."""
    axle = prism([circle(0, 0, 5.8)], 40.0).transformed(gx.translate(0, 0, -14))
    turned = gx.chain(gx.rotate_x(90, degrees=True), gx.translate(0, 0, 42))
    base = bracket()
    return [
        Layer(base, name="bracket", **{**style, "fill": style.get("fill") and "#c9d4e5"}),
        Layer(gear(), name="gear", transform=turned, **{**style, "fill": style.get("fill") and "#e8c07a"}),
        Layer(axle, name="axle", transform=turned, **{**style, "fill": style.get("fill") and "#bbbbbb"}),
    ]


def main() -> None:
    """Write the pictures into the folder that is named."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "gallery")
    folder.mkdir(parents=True, exist_ok=True)
    z_up: Any = {"up": (0, 0, 1)}
    drawing: Any = {"edges": ["feature", "silhouette"], "hidden": "dash"}
    models: dict[str, tuple[Mesh, Any]] = {
        "cube": (gx.samples.cube(), None),
        "bracket": (bracket(), z_up),
        "gear": (gear(), z_up),
        "teapot": (gx.samples.teapot(), None),
        "scan": (scan(), z_up),
    }
    for name, (mesh, camera) in models.items():
        thumbnail = gx.render(mesh, size=THUMBNAIL, camera=camera, **legible_style(mesh, THUMBNAIL))
        thumbnail.save(folder / f"{name}-thumbnail.png")
        if name != "scan":
            gx.render(mesh, size=LARGE, camera=camera, **drawing).save(folder / f"{name}-dashed.png")
            (folder / f"{name}-dashed.svg").write_text(gx.render_svg(mesh, size=LARGE, camera=camera, **drawing))
        shaded: Any = {"color": "none"} if name == "scan" else {"edges": ["feature", "silhouette"]}
        gx.render(mesh, size=LARGE, camera=camera, fill="shade", **shaded).save(folder / f"{name}-shaded.png")
    points: Any = {"scalars": "z", "camera": z_up}
    gx.render(cloud(), size=THUMBNAIL, point_size=1.5, **points).save(folder / "cloud-thumbnail.png")
    gx.render(cloud(), size=LARGE, **points).save(folder / "cloud.png")
    edges = {"edges": ["feature", "silhouette"]}
    for size, name in ((THUMBNAIL, "thumbnail"), (LARGE, "shaded")):
        layers = assembly(fill="gray", shading="flat", **edges)
        gx.render(layers, size=size, camera=z_up).save(folder / f"assembly-{name}.png")
    gx.render(assembly(hidden="dash", **edges), size=LARGE, camera=z_up).save(folder / "assembly-dashed.png")


if __name__ == "__main__":
    main()
