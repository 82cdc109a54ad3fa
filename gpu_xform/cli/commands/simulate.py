"""`gpu-xform simulate`: a file that shows cloth in motion, falling and hanging by the laws of mechanics."""

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._core.types import Float64Array
from ...errors import ArgumentError
from ...geometry.mesh import Mesh
from .. import argument_types as types
from .. import files
from .. import options as groups
from ..arguments_from_options import (
    choose_device,
    collect_picture_arguments,
    compose_transforms,
    require_drawing_options,
)
from ..option_errors import name_options_in_errors
from ..read_layers import read_style

if TYPE_CHECKING:
    from ...geometry.scene import Scene
    from ...simulation.obstacles import Obstacle

SAMPLES = ("cloth", "curtain")
PIN_TOLERANCE = 1e-6  # of the size of the model, within which a point lies on a side
STRAIN = 0.01  # of the model under its own weight, if no stiffness is given
SHEAR_RATIO, BEND_RATIO = 0.1, 0.003  # of the stiffness of the edges
GRAVITY_M_S2 = 9.81
OBSTACLE_STYLE: dict[str, Any] = {"edges": "silhouette", "hidden": "remove", "color": "#9aa0a6", "line_width": 1.0}

USAGE = "MODEL -o OUT [options]"
DESCRIPTION = """\
Join the points of a model by springs, let it fall or hang, and draw it as an
animated file."""
EPILOG = """\
MODEL is cloth (1 m x 1 m, flat), curtain (1 m x 1 m, in pleats), or a model
file. Lengths are in metres, masses in kilograms, times in seconds. The
transforms place the model before it moves. Its edges become springs, as do the
diagonals of its quads; weaker ones resist folding. Points don't collide with
one another. The end of OUT gives the format, as with animate.

examples:
  gpu-xform simulate cloth -o scarf.gif --sphere 0,-0.3,0,0.25 --hidden remove
  gpu-xform simulate curtain -o curtain.mp4 --pin top --wind 0,0,3 --drag 1.5
  gpu-xform simulate cloth -o flag.html --rotate-x 90 --pin left --wind 4,0,1
  gpu-xform simulate ball.obj -o ball.gif --translate 0,2,0 --floor 0
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `simulate`."""
    parser.set_defaults(extra_layers=[])
    group = parser.add_argument_group("files")
    group.add_argument("model", metavar="MODEL", type=types.parse_file_path, help="cloth, curtain, or a model file")
    group.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        type=types.parse_file_path,
        required=True,
        help="the animation; the end of its name gives the format",
    )
    groups.add_reading_options(group)
    group.add_argument(
        "--quads",
        metavar="N,M",
        type=types.parse_count_pair,
        help="quads of cloth and curtain along their sides (default: 40,40; 64,40)",
    )
    _add_material(parser)
    _add_surroundings(parser)
    group = parser.add_argument_group("time")
    group.add_argument(
        "--duration", metavar="S", type=types.parse_number, default="2", help="seconds (default: %(default)s)"
    )
    group.add_argument(
        "--fps", metavar="N", type=types.parse_frame_rate, default="25", help="frames per second (default: %(default)s)"
    )
    groups.add_drawing_options(parser, resolution="640,480")
    groups.add_general_options(parser, adapter=True, rasterizer=True)


def _add_material(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("material")
    group.add_argument(
        "--pin",
        metavar="P[,...]",
        type=types.parse_pins,
        action="append",
        default=[],
        dest="pins",
        help=f"points that stay where they are: numbers, from 0, {', '.join(types.PIN_SIDES)} or corners",
    )
    for flag, metavar, text in (
        ("--mass", "KG", "of the whole model (default: 0.1)"),
        ("--stretch-stiffness", "K", "of edges in N/m (default: 1%% longer under its own weight)"),
        ("--shear-stiffness", "K", f"of the diagonals of quads (default: {SHEAR_RATIO:g} of the edges')"),
        ("--bend-stiffness", "K", f"of what resists folding (default: {BEND_RATIO:g} of the edges')"),
        ("--damping", "S", "seconds times stiffness is a spring's damping (default: 2e-4)"),
    ):
        group.add_argument(flag, metavar=metavar, type=types.parse_number, help=text)


def _add_surroundings(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("surroundings")
    group.add_argument(
        "--gravity",
        metavar="X,Y,Z",
        type=types.parse_point,
        default=f"0,-{GRAVITY_M_S2:g},0",
        help="in m/s^2 (default: %(default)s)",
    )
    group.add_argument(
        "--drag", metavar="C", type=types.parse_number, default="1", help="drag coefficient (default: %(default)s)"
    )
    group.add_argument("--wind", metavar="X,Y,Z", type=types.parse_point, help="velocity of the air in m/s")
    for flag, metavar, parse, text in (
        ("--sphere", "X,Y,Z,R", types.parse_sphere, "a ball that points cannot enter: centre and radius"),
        ("--box", "X,Y,Z,A,B,C", types.parse_box, "a box: its centre, and the lengths of its sides"),
        ("--floor", "Y", types.parse_number, "a floor at this height"),
    ):
        group.add_argument(flag, metavar=metavar, type=parse, action="append", default=[], help=text)
    group.add_argument(
        "--friction", metavar="F", type=types.parse_number, default="0.3", help="of obstacles (default: %(default)s)"
    )
    group.add_argument(
        "--gap",
        metavar="M",
        type=types.parse_number,
        default="0.006",
        help="distance that points keep from obstacles (default: %(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Simulate a model, and draw it."""
    require_drawing_options(options)
    from ... import animation
    from ..._core.progress import show_progress
    from ...animation.encoders.registry import make_writer
    from ...drawing.layer import Layer
    from ...geometry.scene import Scene
    from ...simulation.springs import Springs

    with name_options_in_errors(options, [options.model]):
        make_writer(options.output)  # raises for an unknown format, before there is work
        style = read_style(options, options.model, "simulate, whose points move")
        mesh = _make_mesh(options).transformed(compose_transforms(options))
        obstacles, bodies = _make_obstacles(options)
        device = choose_device(options)
        springs = Springs(mesh, **_collect_material(options, mesh), device=device)
        with show_progress(f"{options.model}: simulation", " frames") as progress:
            path = springs.simulate(
                options.duration,
                options.fps,
                gravity=options.gravity,
                drag=options.drag if len(mesh.faces) else 0.0,
                wind=options.wind,
                obstacles=obstacles,
                progress=progress,
            )
        meshes = path.meshes()

        def stage(frame: int) -> "Scene":
            scene = Scene()
            for body in bodies:
                scene.add(body, **OBSTACLE_STYLE)
            scene.add(meshes[frame], **style)
            return scene

        arguments = collect_picture_arguments(options, [Layer(meshes[0])], device)
        animation.animate(
            stage(0),
            stage,
            options.output,
            n_frames=len(path),
            fps=options.fps,
            rasterizer=options.rasterizer,
            **arguments,
        )
    return 0


def _make_mesh(options: argparse.Namespace) -> Mesh:
    """Return the sample, or read the model."""
    from ... import samples

    if options.model == "cloth":
        return samples.cloth(*(options.quads or (40, 40)))
    if options.model == "curtain":
        return samples.curtain(*(options.quads or (64, 40)))
    if options.quads is not None:
        raise ArgumentError(f"--quads is for {' and '.join(SAMPLES)}: a file has its own")
    return files.read_mesh(options.model, options.file_type, options.tolerance)


def _collect_material(options: argparse.Namespace, mesh: Mesh) -> dict[str, Any]:
    """Return keywords of `Springs`."""
    mass = 0.1 if options.mass is None else options.mass
    stretch = options.stretch_stiffness
    if stretch is None:
        size = float(np.ptp(mesh.positions, axis=0).max(initial=0.0)) if mesh.n_points else 0.0
        stretch = mass * GRAVITY_M_S2 / (STRAIN * (size or 1.0))
    return {
        "mass": mass,
        "stretch": stretch,
        "shear": SHEAR_RATIO * stretch if options.shear_stiffness is None else options.shear_stiffness,
        "bend": BEND_RATIO * stretch if options.bend_stiffness is None else options.bend_stiffness,
        "damping": 2e-4 if options.damping is None else options.damping,
        "pinned": _find_pins(mesh.positions, [pin for pins in options.pins for pin in pins]),
    }


def _find_pins(points: Float64Array, pins: Sequence[int | str]) -> list[int]:
    """Return the indices of pinned points: given ones, those on a side of the bounds, those next to their corners."""
    if len(points) == 0:
        return []
    low, high = points.min(axis=0), points.max(axis=0)
    tolerance = PIN_TOLERANCE * float((high - low).max())
    found = set[int]()
    for pin in pins:
        if isinstance(pin, int):
            found.add(pin)
        elif pin == "corners":
            corners = np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), axis=-1).reshape(-1, 3)
            for corner in corners:
                found.add(int(np.argmin(np.linalg.norm(points - corner, axis=1))))
        else:
            axis, is_high = divmod(types.PIN_SIDES.index(pin), 2)
            distances = high[axis] - points[:, axis] if is_high else points[:, axis] - low[axis]
            found.update(np.flatnonzero(distances <= tolerance).tolist())
    return sorted(found)


def _make_obstacles(options: argparse.Namespace) -> tuple[list["Obstacle"], list[Mesh]]:
    """Return the obstacles, and meshes of those that are drawn."""
    from ... import samples
    from ...matrices import chain, scale, translate
    from ...simulation.obstacles import Box, HalfSpace, Sphere

    surface = {"friction": options.friction, "gap": options.gap}
    obstacles: list[Obstacle] = []
    bodies = []
    for center, radius in options.sphere:
        obstacles.append(Sphere(center, radius, **surface))
        bodies.append(samples.icosphere(4).transformed(chain(scale(radius), translate(*center))))
    for center, sides in options.box:
        obstacles.append(Box(center, sides, **surface))
        bodies.append(samples.cube().transformed(chain(scale(*(sides / 2.0)), translate(*center))))
    obstacles += [HalfSpace((0.0, height, 0.0), **surface) for height in options.floor]
    return obstacles, bodies
