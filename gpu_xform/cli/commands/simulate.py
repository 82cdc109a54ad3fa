"""`gpu-xform simulate`: a file that shows cloth or hair in motion, by the laws of mechanics."""

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._core.types import Float64Array
from ...errors import ArgumentError
from ...geometry.mesh import Mesh
from .. import files
from .. import options as groups
from ..argument_types import models, numbers, paths, vectors
from ..arguments_from_options import (
    choose_drawing_device,
    collect_picture_arguments,
    compose_transforms,
    require_drawing_options,
)
from ..option_errors import name_options_in_errors
from ..read_layers import read_style
from ..stage_times import report_stage

if TYPE_CHECKING:
    from ...device import Device
    from ...geometry.scene import Scene
    from ...geometry.strands import Strands
    from ...simulation.obstacles import Obstacle
    from ...simulation.springs import Springs
    from ...simulation.trajectory import Trajectory

SAMPLES = ("cloth", "curtain")
HAIR = "hair"
PIN_TOLERANCE = 1e-6  # of the size of the model, within which a point lies on a side
STRAIN = 0.01  # of the model under its own weight, if no stiffness is given
SHEAR_RATIO, BEND_RATIO = 0.1, 0.003  # of the stiffness of the edges
GRAVITY_M_S2 = 9.81
DRAG, GAP_M, DAMPING_S = 1.0, 0.006, 2e-4

HAIR_OPTIONS = ("strands", "points", "curls", "children", "shake")
CLOTH_OPTIONS = ("quads", "pins", "shear_stiffness")
HEAD_RADIUS_M, HAIR_LENGTH_M, CURL_RADIUS_M = 0.1, 0.22, 0.006
N_STRANDS, N_STRAND_POINTS, N_CURLS, CHILDREN_PER_STRAND = 200, 16, 1.5, 10
MIN_GUIDES = 3  # around each child
POINT_MASS_KG = 1e-5
ROOT_STRAIN = 0.03  # of a strand under its own weight, if no stiffness is given
HAIR_BEND_RATIO, CORE_RATIO = 0.03, 0.1  # of the stiffness along strands
MIN_TURN_POINTS = 4  # of a curl that core springs hold
HAIR_DRAG_PER_S, HAIR_GAP_M, HAIR_DAMPING_S = 1.5, 0.002, 3e-5
CLUMP = 0.5
SHAKE_DEGREES, SHAKE_PERIOD_S, SHAKE_START_S = 25.0, 1.4, 0.5
ROOT_COLOR, TIP_COLOR = (0.16, 0.08, 0.04), (0.72, 0.47, 0.24)
COLORS = ("color", "edge_colors", "face_colors", "vertex_colors")
HAIR_STYLE: dict[str, Any] = {"line_width": 0.8, "hidden": "remove"}
HEAD_SCALE = 0.98  # below the roots
HEAD_STYLE: dict[str, Any] = {"edges": "silhouette", "hidden": "remove", "fill": "#f3e3d3", "color": "#a08060"}
FLOOR_RATIO = 1.5  # of the size of the model: the side of the square that is drawn
OBSTACLE_STYLE: dict[str, Any] = {"edges": "silhouette", "hidden": "remove", "color": "#9aa0a6", "line_width": 1.0}

USAGE = "MODEL -o OUT [options]"
DESCRIPTION = """\
Join the points of a model by springs, let it fall or hang, and draw it as an
animated file."""
EPILOG = """\
MODEL is cloth (1 m x 1 m, flat), curtain (1 m x 1 m, in pleats), hair (0.22 m
long, on a head of 0.1 m radius that shakes), or a model file. Lengths are in
metres, masses in kilograms, times in seconds. The transforms place the model
before it moves. Its edges become springs, as do the diagonals of its quads;
weaker ones resist folding. Points don't collide with one another. The end of
OUT gives the format, as with animate.

examples:
  gpu-xform simulate cloth -o scarf.gif --sphere 0,-0.3,0,0.25 --hidden remove
  gpu-xform simulate curtain -o curtain.mp4 --pin top --wind 0,0,3 --drag 1.5
  gpu-xform simulate cloth -o flag.html --rotate-x 90 --pin left --wind 4,0,1
  gpu-xform simulate hair -o hair.gif --curls 3 --children 4000
  gpu-xform simulate ball.obj -o ball.gif --translate 0,2,0 --floor 0
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `simulate`."""
    parser.set_defaults(extra_layers=[])
    group = parser.add_argument_group("files")
    group.add_argument(
        "model", metavar="MODEL", type=paths.parse_file_path, help="cloth, curtain, hair, or a model file"
    )
    group.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        type=paths.parse_file_path,
        required=True,
        help="the animation; the end of its name gives the format",
    )
    groups.add_reading_options(group)
    group.add_argument(
        "--quads",
        metavar="N,M",
        type=numbers.parse_count_pair,
        help="quads of cloth and curtain along their sides (default: 40,40; 64,40)",
    )
    _add_hair(parser)
    _add_material(parser)
    _add_surroundings(parser)
    group = parser.add_argument_group("time")
    group.add_argument(
        "--duration",
        metavar="S",
        type=numbers.parse_number,
        default="2",
        help="seconds (default: %(default)s); at least one frame is simulated",
    )
    group.add_argument(
        "--fps",
        metavar="N",
        type=numbers.parse_frame_rate,
        default="25",
        help="frames per second (default: %(default)s)",
    )
    group.add_argument(
        "--substeps",
        metavar="N",
        type=numbers.parse_count,
        help="steps per frame (default: as few as are stable in a wind as given); more may help if points fly off",
    )
    groups.add_drawing_options(parser, resolution="640,480")
    groups.add_general_options(parser, adapter=True, rasterizer=True)


def _add_hair(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("hair")
    for flag, metavar, parse, text in (
        ("--strands", "N", numbers.parse_count, f"strands that are simulated (default: {N_STRANDS})"),
        ("--points", "N", numbers.parse_count, f"points of each (default: {N_STRAND_POINTS})"),
        ("--curls", "N", numbers.parse_number, f"turns of each (default: {N_CURLS:g}; 0 is straight)"),
        ("--children", "N", numbers.parse_count, f"strands drawn between (default: {CHILDREN_PER_STRAND} per strand)"),
        ("--shake", "DEG", numbers.parse_number, f"how far the head turns to and fro (default: {SHAKE_DEGREES:g})"),
    ):
        group.add_argument(flag, metavar=metavar, type=parse, help=text)


def _add_material(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("material")
    group.add_argument(
        "--pin",
        metavar="P[,...]",
        type=models.parse_pins,
        action="append",
        default=[],
        dest="pins",
        help=f"points that stay where they are: numbers, from 0, {', '.join(models.PIN_SIDES)} or corners",
    )
    for flag, metavar, text in (
        ("--mass", "KG", "of the whole model (default: 0.1; hair: 1e-5 per point)"),
        ("--stretch-stiffness", "K", "of edges in N/m (default: 1%% longer under its own weight; hair: 3%%)"),
        ("--shear-stiffness", "K", f"of the diagonals of quads (default: {SHEAR_RATIO:g} of the edges')"),
        (
            "--bend-stiffness",
            "K",
            f"of what resists folding (default: {BEND_RATIO:g} of the edges'; hair: {HAIR_BEND_RATIO:g})",
        ),
        (
            "--damping",
            "S",
            f"seconds times stiffness is a spring's damping (default: {DAMPING_S:g}; hair: {HAIR_DAMPING_S:g})",
        ),
    ):
        group.add_argument(flag, metavar=metavar, type=numbers.parse_number, help=text)


def _add_surroundings(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("surroundings")
    group.add_argument(
        "--gravity",
        metavar="X,Y,Z",
        type=vectors.parse_point,
        default=f"0,-{GRAVITY_M_S2:g},0",
        help="in m/s^2 (default: %(default)s)",
    )
    group.add_argument(
        "--drag",
        metavar="C",
        type=numbers.parse_number,
        help=f"drag coefficient (default: {DRAG:g}); of hair, the rate in 1/s ({HAIR_DRAG_PER_S:g})",
    )
    group.add_argument("--wind", metavar="X,Y,Z", type=vectors.parse_point, help="velocity of the air in m/s")
    for flag, metavar, parse, text in (
        ("--sphere", "X,Y,Z,R", models.parse_sphere, "a ball that points cannot enter: centre and radius"),
        ("--box", "X,Y,Z,A,B,C", models.parse_box, "a box: its centre, and the lengths of its sides"),
        ("--floor", "Y", numbers.parse_number, "a floor at this height"),
    ):
        group.add_argument(flag, metavar=metavar, type=parse, action="append", default=[], help=text)
    group.add_argument(
        "--friction", metavar="F", type=numbers.parse_number, default="0.3", help="of obstacles (default: %(default)s)"
    )
    group.add_argument(
        "--gap",
        metavar="M",
        type=numbers.parse_number,
        help=f"distance that points keep from obstacles (default: {GAP_M:g}; hair: {HAIR_GAP_M:g})",
    )


@dataclass(frozen=True, eq=False)
class _Simulation:
    """What is simulated and drawn.

    conditions : keywords of `Springs.simulate`
    bodies : what stands around, each with its style
    shapes : returns the models of all frames, each sequence with its style
    """

    springs: "Springs"
    conditions: dict[str, Any]
    bodies: list[tuple[Mesh, dict[str, Any]]]
    shapes: Callable[["Trajectory"], list[tuple[Sequence[Mesh], dict[str, Any]]]]


def run(options: argparse.Namespace) -> int:
    """Simulate a model, and draw it."""
    require_drawing_options(options)
    from ... import animation
    from ..._core.progress import show_progress
    from ...animation.encoders.registry import make_writer
    from ...drawing.layer import Layer
    from ...geometry.scene import Scene

    with name_options_in_errors(options, () if options.model in (*SAMPLES, HAIR) else [options.model]):
        make_writer(options.output)  # raises for an unknown format, before there is work
        style = read_style(options, options.model, "simulate, whose points move")
        make = _prepare_hair if options.model == HAIR else _prepare_cloth
        _require_options(options, CLOTH_OPTIONS if options.model == HAIR else HAIR_OPTIONS)
        device = choose_drawing_device(options)  # which draws the frames: say so before they are made
        simulation = make(options, style, device)
        label = f"{options.model}: simulation"
        with report_stage(f"simulated {options.model}"), show_progress(label, " frames") as progress:
            path = simulation.springs.simulate(
                options.duration,
                options.fps,
                gravity=options.gravity,
                wind=options.wind,
                substeps=options.substeps,
                progress=progress,
                **simulation.conditions,
            )
        shapes = simulation.shapes(path)

        def stage(frame: int) -> "Scene":
            scene = Scene()
            for body, look in simulation.bodies:
                scene.add(body, **look)
            for meshes, look in shapes:
                scene.add(meshes[frame], **look)
            return scene

        arguments = collect_picture_arguments(options, [Layer(path.meshes()[0])], device)
        with report_stage(f"drew and wrote {options.output}"):
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


def _require_options(options: argparse.Namespace, others: Sequence[str]) -> None:
    """Raise ArgumentError if an option of another kind of model is given."""
    for name in others:
        if getattr(options, name) not in (None, []):
            flag = "--pin" if name == "pins" else f"--{name.replace('_', '-')}"
            raise ArgumentError(f"{flag} is {'not ' if options.model == HAIR else ''}for hair")


def _prepare_cloth(options: argparse.Namespace, style: dict[str, Any], device: "Device") -> _Simulation:
    """Return the springs of a mesh, and what it falls upon."""
    from ...simulation.springs import Springs

    mesh = _make_mesh(options).transformed(compose_transforms(options))
    obstacles, bodies = _make_obstacles(options, GAP_M, mesh.positions)
    drag = DRAG if options.drag is None else options.drag
    conditions = {"drag": drag if len(mesh.faces) else options.drag, "obstacles": obstacles}
    springs = Springs(mesh, **_collect_material(options, mesh), device=device)
    return _Simulation(springs, conditions, bodies, lambda path: [(path.meshes(), style)])


def _prepare_hair(options: argparse.Namespace, style: dict[str, Any], device: "Device") -> _Simulation:
    """Return the springs of strands on a head that shakes, and the strands that are drawn between them."""
    from ... import samples
    from ...geometry.strands import Strands
    from ...matrices import inverse, rotate_y, scale
    from ...simulation.children import ChildStrands
    from ...simulation.obstacles import Sphere
    from ...simulation.springs import Springs

    n_strands = N_STRANDS if options.strands is None else options.strands
    n_points = N_STRAND_POINTS if options.points is None else options.points
    curls = N_CURLS if options.curls is None else options.curls
    world_from_model = compose_transforms(options)
    hair = samples.hair(
        n_strands, n_points, radius=HEAD_RADIUS_M, length=HAIR_LENGTH_M, curls=curls, curl_radius=CURL_RADIUS_M
    )
    placed = hair.points @ world_from_model[:3, :3].T + world_from_model[:3, 3]
    hair = Strands(placed, points_per_turn=hair.points_per_turn)
    amplitude = SHAKE_DEGREES if options.shake is None else options.shake

    def world_from_head(seconds: float) -> Float64Array:
        started = max(0.0, seconds - SHAKE_START_S)
        angle = amplitude * min(1.0, 2.0 * started) * math.sin(math.tau * started / SHAKE_PERIOD_S)
        return world_from_model @ rotate_y(angle, degrees=True)

    model_from_world = inverse(world_from_model)
    gap = HAIR_GAP_M if options.gap is None else options.gap
    head = Sphere((0.0, 0.0, 0.0), HEAD_RADIUS_M, friction=options.friction, gap=gap, transform=world_from_head)
    obstacles, bodies = _make_obstacles(options, HAIR_GAP_M, placed.reshape(-1, 3))
    skull = samples.icosphere(4).transformed(world_from_model @ scale(HEAD_SCALE * HEAD_RADIUS_M))
    conditions = {
        "drag_rate": HAIR_DRAG_PER_S if options.drag is None else options.drag,
        "move_pins": lambda seconds: world_from_head(seconds) @ model_from_world,
        "obstacles": [head, *obstacles],
    }
    springs = Springs(hair.mesh, **_collect_hair_material(options, hair), device=device)
    n_children = options.children
    if n_children is None:
        n_children = CHILDREN_PER_STRAND * n_strands if n_strands >= MIN_GUIDES else 0
    if n_children and n_strands < MIN_GUIDES:
        raise ArgumentError(f"--children needs at least {MIN_GUIDES} strands, got {n_strands}")
    coat = ChildStrands(hair, n_children, clump=CLUMP, device=device) if n_children else None

    def list_shapes(path: "Trajectory") -> list[tuple[Sequence[Mesh], dict[str, Any]]]:
        shapes = [(path.meshes(), _style_hair(style, n_strands, n_points))]
        if coat is not None:
            shapes.insert(0, (coat.meshes(path), _style_hair(style, n_children, n_points)))
        return shapes

    return _Simulation(springs, conditions, [(skull, HEAD_STYLE), *bodies], list_shapes)


def _style_hair(style: dict[str, Any], n_strands: int, n_points: int) -> dict[str, Any]:
    """Return the style of strands: lighter towards the tips and different for each, unless a colour is given."""
    if any(name in style for name in COLORS):
        return HAIR_STYLE | style
    along = np.linspace(0.0, 1.0, n_points)[np.newaxis, :, np.newaxis]
    light = np.random.default_rng(0).uniform(0.6, 1.2, (n_strands, 1, 1))
    colors = light * ((1.0 - along) * ROOT_COLOR + along * TIP_COLOR)
    return HAIR_STYLE | {"vertex_colors": np.clip(colors, 0.0, 1.0).reshape(-1, 3)} | style


def _collect_hair_material(options: argparse.Namespace, hair: "Strands") -> dict[str, Any]:
    """Return keywords of `Springs`."""
    n_points = hair.n_strands * hair.n_points
    mass = POINT_MASS_KG * n_points if options.mass is None else options.mass
    stretch = options.stretch_stiffness
    if stretch is None:
        link_m = HAIR_LENGTH_M / (hair.n_points - 1)
        stretch = mass / hair.n_strands * GRAVITY_M_S2 / (ROOT_STRAIN * link_m)
    bend = HAIR_BEND_RATIO * stretch if options.bend_stiffness is None else options.bend_stiffness
    core = CORE_RATIO * stretch if hair.points_per_turn >= MIN_TURN_POINTS else 0.0
    return {
        **hair.springs(stretch, bend=bend, core=core),
        "mass": mass,
        "damping": HAIR_DAMPING_S if options.damping is None else options.damping,
        "pinned": hair.roots,
    }


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
    from ...simulation._validation import MAX_SQUARED, as_positive_float, require_at_most

    require_at_most(mesh.positions, "model", MAX_SQUARED)
    mass = 0.1 if options.mass is None else as_positive_float(options.mass, "mass")
    stretch = options.stretch_stiffness
    if stretch is None:
        size = float(np.ptp(mesh.positions, axis=0).max(initial=0.0)) if mesh.n_points else 0.0
        stretch = mass * GRAVITY_M_S2 / (STRAIN * (size or 1.0))
    return {
        "mass": mass,
        "stretch": stretch,
        "shear": SHEAR_RATIO * stretch if options.shear_stiffness is None else options.shear_stiffness,
        "bend": BEND_RATIO * stretch if options.bend_stiffness is None else options.bend_stiffness,
        "damping": DAMPING_S if options.damping is None else options.damping,
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
            axis, is_high = divmod(models.PIN_SIDES.index(pin), 2)
            distances = high[axis] - points[:, axis] if is_high else points[:, axis] - low[axis]
            found.update(np.flatnonzero(distances <= tolerance).tolist())
    return sorted(found)


def _make_obstacles(
    options: argparse.Namespace, gap_m: float, points: Float64Array
) -> tuple[list["Obstacle"], list[tuple[Mesh, dict[str, Any]]]]:
    """Return the obstacles, and meshes of those that are drawn, with their style."""
    from ... import samples
    from ...matrices import chain, scale, translate
    from ...simulation._validation import MAX_SQUARED, require_at_most
    from ...simulation.obstacles import Box, HalfSpace, Sphere

    for flag, given in (("--sphere", options.sphere), ("--box", options.box)):
        require_at_most([number for one in given for number in np.hstack(one)], flag, MAX_SQUARED)
    require_at_most(options.floor, "--floor", MAX_SQUARED)
    surface = {"friction": options.friction, "gap": gap_m if options.gap is None else options.gap}
    obstacles: list[Obstacle] = []
    bodies: list[Mesh] = []
    for center, radius in options.sphere:
        obstacles.append(Sphere(center, radius, **surface))
        bodies.append(samples.icosphere(4).transformed(chain(scale(radius), translate(*center))))
    for center, sides in options.box:
        obstacles.append(Box(center, sides, **surface))
        bodies.append(samples.cube().transformed(chain(scale(*(sides / 2.0)), translate(*center))))
    for height in options.floor:
        obstacles.append(HalfSpace((0.0, height, 0.0), **surface))
        bodies.append(_make_floor(points, height))
    return obstacles, [(body, OBSTACLE_STYLE) for body in bodies]


def _make_floor(points: Float64Array, height: float) -> Mesh:
    """Return a square below a model, as lines: a face would hide what is seen from below."""
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(3), np.ones(3))
    x, _, z = (low + high) / 2.0
    half = FLOOR_RATIO * float((high - low).max()) / 2.0
    corners = [(x - half, height, z - half), (x + half, height, z - half)]
    corners += [(x + half, height, z + half), (x - half, height, z + half)]
    return Mesh(corners, [[0, 1], [1, 2], [2, 3], [3, 0]])
