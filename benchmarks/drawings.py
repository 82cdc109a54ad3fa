"""Thumbnails beside F3D's, and a drawing in SVG beside CadQuery's, ratios from one run; outputs are checked first.

Both come with `pip install f3d cadquery`. One process: all have their devices and engines open before.
"""

import re
import tempfile
from pathlib import Path
from typing import Any

import cadquery
import f3d
import numpy as np
from gallery import bracket, gear
from harness import Row, calm_threads, medians, table
from pictures import Pixels

import gpu_xform as gx
from gpu_xform.drawing.legible_style import legible_style

SIZE = (256, 256)
MIN_INK, MAX_INK = 0.05, 0.95  # part of a thumbnail that is not white
N_HOLES = (8, 5)
N_SIDES = 166  # of a hole: both draw the same 20,000 straight edges
TOLERANCE = 0.01, 0.1  # of the tessellation, as CadQuery takes it
DRAWING = (1000, 800)


def write_models(folder: Path) -> list[Path]:
    """Write nine models of eight to 82,000 faces as binary STL, which both read themselves."""
    models = {
        "cube": gx.samples.cube(),
        "house": gx.samples.house(),
        "teapot": gx.samples.teapot(),
        "ball": gx.samples.snub_dodecahedron(),
        "torus": gx.samples.torus(48, 24),
        "bracket": bracket(),
        "gear": gear(),
        "sphere": gx.samples.icosphere(4),
        "dense": gx.samples.icosphere(6),
    }
    paths = [folder / f"{name}.stl" for name in models]
    for path, mesh in zip(paths, models.values(), strict=True):
        gx.save_mesh(mesh, path)
    return paths


def our_thumbnails(paths: list[Path]) -> list[Pixels]:
    """Load and draw all models as `gpu-xform render` does if there are many."""
    meshes = map(gx.load_mesh, paths)
    return [gx.render_array(mesh, size=SIZE, **legible_style(mesh, SIZE)) for mesh in meshes]


def f3d_thumbnails(engine: Any, paths: list[Path]) -> list[Pixels]:
    """Load and draw all models with F3D's defaults on white."""
    pictures = []
    for path in paths:
        engine.scene.clear()
        engine.scene.add(str(path))
        engine.window.camera.reset_to_bounds()
        image = engine.window.render_to_image()
        pictures.append(np.frombuffer(image.content, np.uint8).reshape(*SIZE[::-1], image.channel_count)[::-1])
    return pictures


def require_pictures(pictures: list[Pixels]) -> None:
    """Exit unless every picture shows something on white."""
    for number, picture in enumerate(pictures):
        ink = float((picture[..., :3].min(axis=2) < 250).mean())
        if not MIN_INK < ink < MAX_INK:
            raise SystemExit(f"NOT COMPARED: picture {number} is covered by {100 * ink:.1f} %")


def drilled() -> tuple[Any, gx.Mesh]:
    """Return a solid with holes, and its tessellation."""
    across, along = N_HOLES
    places = [(11 * (i - (across - 1) / 2), 12 * (j - (along - 1) / 2)) for i in range(across) for j in range(along)]
    solid: Any = cadquery.Workplane("XY").rect(100, 70).pushPoints(places).polygon(N_SIDES, 7).extrude(8)
    points, triangles = solid.val().tessellate(*TOLERANCE)
    return solid, gx.Mesh([point.toTuple() for point in points], triangles)


def main() -> None:
    """Print the table."""
    calm_threads()
    f3d.Log.set_verbose_level(f3d.Log.VerboseLevel.QUIET)
    engine = f3d.Engine.create(True)
    engine.window.size = SIZE
    engine.options.update({"render.background.color": (1.0, 1.0, 1.0)})
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        paths = write_models(Path(folder))
        require_pictures(our_thumbnails(paths))
        require_pictures(f3d_thumbnails(engine, paths))
        seconds = medians({"ours": lambda: our_thumbnails(paths), "f3d": lambda: f3d_thumbnails(engine, paths)}, 5, 1)
        rows.append(Row("nine thumbnails, 256 x 256", "F3D in Python", seconds["ours"], seconds["f3d"], 1.0))
    solid, mesh = drilled()
    camera = gx.Camera.fit(mesh, direction=(-1, 1, -1), up=(0, 0, 1), orthographic=True)
    options: Any = {"width": DRAWING[0], "height": DRAWING[1], "projectionDir": (1, -1, 1), "showAxes": False}

    def theirs(*, hidden: bool) -> str:
        exporters: Any = cadquery.exporters
        return str(exporters.getSVG(solid.val(), {**options, "showHidden": hidden}))

    for hidden in ("dash", "remove"):

        def ours(hidden: Any = hidden) -> str:
            return gx.render_svg(mesh, camera=camera, size=DRAWING, edges=["feature", "silhouette"], hidden=hidden)

        def other(hidden: str = hidden) -> str:
            return theirs(hidden=hidden == "dash")

        for text in (ours(), other()):
            if len(re.findall(r"<path", text)) == 0:
                raise SystemExit("NOT COMPARED: a drawing is empty")
        seconds = medians({"ours": ours, "theirs": other}, rounds=3, warm_up=0)
        what = f"SVG, hidden lines: {hidden}, {len(solid.val().Edges()):,} edges"
        rows.append(Row(what, "CadQuery's SVG export", seconds["ours"], seconds["theirs"], 0.2))
    print(table(rows))


if __name__ == "__main__":
    main()
