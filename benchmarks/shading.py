"""Shaded faces, flat and smooth, beside pyvista's, ratios from one run; both pictures are compared first.

pyvista comes with `pip install 'gpu_xform[bench]'`. One process: pyvista has its window, and gpu_xform its device.
"""

import itertools
from typing import Any

import numpy as np
import pyvista
from harness import Row, calm_threads, medians, table
from pictures import Pixels

import gpu_xform as gx

EYE = (3.0, 2.2, 6.0)
FIELD_OF_VIEW = 30.0  # degrees
SIZE = (1024, 1024)
COLOR = "#dfe3e8"
AMBIENT, DIFFUSE = 0.3, 0.7
LARGEST = 6
MAX_OTHER_PART = 0.01  # of the pixels may differ by more than MAX_STEP: those at the rim
MAX_STEP = 3
AT_MOST = 0.4


def make_plotter(mesh: gx.Mesh, shading: str) -> Any:
    """Return pyvista's picture of a mesh in the light of a lamp at the eye, with flat or smooth shading."""
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(SIZE), lighting="none")
    plotter.add_light(pyvista.Light(light_type="headlight"))
    style = {"interpolation": "flat" if shading == "flat" else "phong", "ambient": AMBIENT, "diffuse": DIFFUSE}
    style |= {"smooth_shading": shading == "smooth"}
    faces = np.column_stack([np.full(mesh.n_faces, 3), mesh.indices.reshape(-1, 3)])
    plotter.add_mesh(pyvista.PolyData(mesh.positions, faces.ravel()), color=COLOR, **style)
    plotter.background_color = "white"
    plotter.show(auto_close=False)
    plotter.camera.position, plotter.camera.focal_point, plotter.camera.up = EYE, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    plotter.camera.view_angle = FIELD_OF_VIEW
    plotter.renderer.ResetCameraClippingRange()
    return plotter


def require_same(ours: Pixels, theirs: Pixels) -> None:
    """Exit unless two pictures show the same; the same one moved by three pixels must not pass."""

    def other_part(picture: Pixels) -> float:
        steps = np.abs(picture[..., :3].astype(int) - ours[..., :3]).max(axis=2)
        return float((steps > MAX_STEP).mean())

    if other_part(theirs) > MAX_OTHER_PART:
        raise SystemExit(f"NOT COMPARED: {100 * other_part(theirs):.2g} % of the pixels differ")
    if other_part(np.roll(theirs, 3, axis=1)) <= MAX_OTHER_PART:
        raise SystemExit("the same picture moved by three pixels would pass")


def main() -> None:
    """Print the table."""
    calm_threads()
    camera = gx.Camera.look_at(EYE, (0.0, 0.0, 0.0), fov_y=FIELD_OF_VIEW)
    rows = []
    for shading, n in itertools.product(("flat", "smooth"), (4, LARGEST)):
        mesh = gx.samples.icosphere(n)
        plotter = make_plotter(mesh, shading)

        def ours(mesh: gx.Mesh = mesh, shading: Any = shading) -> Pixels:
            return gx.render_array(mesh, camera=camera, size=SIZE, fill=COLOR, shading=shading, color="none")

        def theirs(plotter: Any = plotter) -> Pixels:
            plotter.render()
            return np.asarray(plotter.screenshot(None, return_img=True))

        require_same(ours(), theirs())
        seconds = medians({"ours": ours, "theirs": theirs}, rounds=15)
        what = f"{shading} shading, {mesh.n_faces:,} faces, {SIZE[0]} x {SIZE[1]}"
        at_most = AT_MOST if n == LARGEST else None
        rows.append(Row(what, f"pyvista, {shading}", seconds["ours"], seconds["theirs"], at_most))
        plotter.close()
    print(table(rows))


if __name__ == "__main__":
    main()
