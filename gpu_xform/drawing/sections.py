"""Section cuts of layers: what lies before a plane is removed, and what it cuts is capped, outlined and hatched."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError
from ..geometry.edges import list_edge_parts
from ..geometry.intersections import number_bodies
from ..geometry.mesh import Mesh
from ..geometry.section_areas import BodyRing, choose_directions, face_areas, find_areas
from ..geometry.sections import (
    CutMesh,
    Ring,
    cut_mesh,
    hatch_area,
    trace_rings,
    triangulate_area,
)
from ..imaging.colors import to_rgba, to_rgba_array
from .intersections import IntersectionLayer, with_mesh
from .layer import SHADED_FILL, Layer, is_auto
from .layer_colors import fill_colors
from .layer_placement import normalize_w
from .lengths import to_pixels
from .point_array import PointArray
from .section_options import Section, parse_hatch, parse_section

OUTLINE_WIDTHS = 2.0  # line widths: ISO 128 draws wide lines twice as wide as narrow ones
HATCH_WIDTHS = 0.5
HATCH_DEGREES = (45.0, 135.0)  # of bodies that lie in one another in turn
HATCH_LINES = 36  # across all that a plane cuts, unless the spacing is given
DEFAULT_LINE_WIDTH_PX = 1.5


@dataclass
class _CutLayer:
    """A layer, one of its instances, and what the plane leaves of it.

    rings : its closed outlines in the plane
    bodies : (f,) the number of the body of each face of the whole mesh: of the faces that edges connect
    """

    layer: Layer
    whole: Mesh
    world_from_model: Float64Array
    cut: CutMesh
    world: Float64Array
    rings: list[Ring]
    bodies: IndexArray


class _Cap(NamedTuple):
    """An area that is cut: points (p, 3) in the world, triangles (t, 3) of them, and the number of its body."""

    points: Float64Array
    triangles: IndexArray
    body: int


def cut_sections(layers: Sequence[Layer]) -> list[Layer]:
    """Return layers in which each with a section is replaced by what is left of it, its caps, outlines and hatching.

    Raises `ArgumentError` for a plane that cuts none of the models that it is for, and for styles by edge.
    """
    if all(layer.section is None for layer in layers):
        return list(layers)
    result: list[list[Layer]] = [[layer] for layer in layers]
    planes: dict[bytes, list[int]] = {}
    for number, layer in enumerate(layers):
        if layer.section is not None:
            planes.setdefault(np.concatenate(parse_section(layer.section)).tobytes(), []).append(number)
    for numbers in planes.values():
        section = parse_section(layers[numbers[0]].section)
        cuts = {number: _cut_layer(with_mesh(layers[number]), section) for number in numbers}
        _require_cut([layers[number] for number in numbers], section, cuts)
        drawn = _draw_areas([(number, each) for number in numbers for each in cuts[number]], section)
        for number in numbers:
            result[number] = [_left_layer(each) for each in cuts[number]] + drawn[number]
    flat = [layer for parts in result for layer in parts]
    if not flat:
        raise ArgumentError.expecting("section", "leave something to draw", "models that all lie before it")
    return flat


def _cut_layer(layer: Layer, section: Section) -> list[_CutLayer]:
    """Return what is left of each instance of a layer; none of those that lie before the plane."""
    mesh = Mesh(layer.model.array) if isinstance(layer.model, PointArray) else layer.model
    if not isinstance(mesh, Mesh):
        raise ArgumentError.expecting("section", "go with models in memory or in files", type(layer.model).__name__)
    if layer.edge_colors is not None:
        raise ArgumentError.expecting("edge_colors", "not be given with section")
    if layer.edges is not None and any(not isinstance(part, str) for part in list_edge_parts(layer.edges)):
        raise ArgumentError.expecting("edges", "be names of sets with section", "an array")
    point, normal = section
    parts = []
    bodies = number_bodies(mesh)
    for matrix in normalize_w(layer.world_from_model):
        plane = np.append(normal, -(normal @ point)) @ matrix
        cut = cut_mesh(mesh, mesh.positions @ plane[:3] + plane[3], bodies)
        if cut.mesh.n_points == 0:
            continue
        homogeneous = cut.mesh.positions @ matrix[:, :3].T + matrix[:, 3]
        world = homogeneous[:, :3] / homogeneous[:, 3:]
        rings = trace_rings(world, world @ _plane_axes(normal).T, cut.outline, cut.bodies)
        parts.append(_CutLayer(replace(layer, model=mesh), mesh, matrix, cut, world, rings, bodies))
    return parts


def _require_cut(layers: Sequence[Layer], section: Section, cuts: dict[int, list[_CutLayer]]) -> None:
    if any(len(part.cut.outline) for parts in cuts.values() for part in parts):
        return
    point, normal = section
    places = []
    for layer in map(with_mesh, layers):
        positions = layer.model.array if isinstance(layer.model, PointArray) else layer.model.positions  # type: ignore[union-attr]
        for matrix in normalize_w(layer.world_from_model):
            world = positions @ matrix[:3, :3].T + matrix[:3, 3]
            places.append((world - point) @ normal)
    along = np.concatenate(places)
    if (
        len(along)
        and along.min() < 0.0 < along.max()
        and all(part.cut.mesh.n_faces == 0 for parts in cuts.values() for part in parts)
    ):
        return  # points and segments have no outline
    reach = f"which lie {along.min():.6g} to {along.max():.6g} along its normal from its point" if len(along) else ""
    raise ArgumentError.expecting("section", f"cut the models, {reach}", "a plane that misses them")


def _plane_axes(normal: Float64Array) -> Float64Array:
    """Return two axes (2, 3) of a plane, along those of the world where the normal is; right-handed with it."""
    up = np.eye(3)[1 if abs(normal[1]) < 0.9 else 2]
    right = np.cross(up, normal)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(normal, right)])


def _left_layer(part: _CutLayer) -> Layer:
    """Return the layer of what is left of an instance, in its style."""
    layer, cut = part.layer, part.cut
    whole = part.whole
    changes: dict[str, Any] = {}
    for name in ("vertex_colors", "scalars"):
        values = getattr(layer, name)
        if values is not None and not isinstance(values, str):
            array = np.asarray(values, np.float64)
            share = part.cut.weights.reshape(-1, *(1,) * (array.ndim - 1))
            changes[name] = (1.0 - share) * array[cut.ends[:, 0]] + share * array[cut.ends[:, 1]]
    if layer.fill is not None:
        colors = fill_colors(layer, whole.n_faces)
        changes["fill"] = colors[cut.faces] if len(colors) > 1 else layer.fill
    if layer.face_colors is not None:
        changes["face_colors"] = to_rgba_array(layer.face_colors, "face_colors", whole.n_faces, "faces")[cut.faces]
    elif isinstance(layer.color, str) and layer.color == "face":
        changes |= {"face_colors": fill_colors(replace(layer, fill="face"), whole.n_faces)[cut.faces], "color": "black"}
    hidden = layer.hidden or ("remove" if layer.hidden_style is None else None)
    style: dict[str, Any] = {"section": None, "hatch": None, "transform": part.world_from_model, "hidden": hidden}
    return replace(layer, model=cut.mesh, **style, **changes)


def _draw_areas(parts: Sequence[tuple[int, _CutLayer]], section: Section) -> dict[int, list[Layer]]:
    """Return the caps, the hatching and the outlines of each layer, by its number."""
    point, normal = section
    axes = _plane_axes(normal)
    origin = normal * (normal @ point)
    rings = [BodyRing(ring, (number, ring.body)) for number, part in parts for ring in part.rings]
    areas = find_areas(rings)
    directions = choose_directions(areas)
    spacing = _choose_spacing([each.ring for each in rings])
    hatches = {number: parse_hatch(part.layer.hatch, has_section=True) for number, part in parts}
    caps: dict[int, list[_Cap]] = {}
    lines: dict[int, list[Float64Array]] = {}
    for area in areas:
        owner, body = area.body
        flat, corners = triangulate_area(area.rings)
        caps.setdefault(owner, []).append(_Cap(flat @ axes + origin, corners, body))
        hatch = hatches[owner]
        if hatch is not None:
            degrees = HATCH_DEGREES[directions[area.body]] if hatch[0] is None else hatch[0]
            ends = hatch_area(area.rings, degrees, spacing if hatch[1] is None else hatch[1])
            lines.setdefault(owner, []).append((ends @ axes + origin).reshape(-1, 3))
    drawn: dict[int, list[Layer]] = {number: [] for number, _ in parts}
    for number, own_layers in drawn.items():
        mine = [part for each, part in parts if each == number]
        layer = mine[0].layer
        if number in caps:
            own_layers.append(_cap_layer(mine[0], caps[number]))
        if number in lines:
            own_layers.append(_line_layer(layer, _segments(np.concatenate(lines[number])), "hatching", HATCH_WIDTHS))
        edges = np.concatenate([part.world[part.cut.outline].reshape(-1, 3) for part in mine])
        if len(edges):
            own_layers.append(_line_layer(layer, _segments(edges), "section", OUTLINE_WIDTHS))
    return drawn


def _segments(ends: Float64Array) -> Mesh:
    return Mesh(ends, np.arange(len(ends)).reshape(-1, 2))


def _choose_spacing(rings: Sequence[Ring]) -> float:
    if not rings:
        return 1.0
    points = np.concatenate([ring.points for ring in rings])
    return float(np.ptp(points, axis=0).max()) / HATCH_LINES or 1.0


_PLAIN: dict[str, Any] = dict.fromkeys(
    (
        *("section", "hatch", "transform", "edges", "point_size", "max_points", "labels"),
        *("face_colors", "edge_colors", "vertex_colors", "scalars", "dash", "hidden_style"),
    )
)


def _cap_layer(part: _CutLayer, caps: Sequence[_Cap]) -> Layer:
    """Return the layer of the areas that are cut: filled as their bodies are, or only hiding what is behind them."""
    layer = part.layer
    firsts = np.cumsum([0, *(len(cap.points) for cap in caps)])
    corners = np.concatenate([cap.triangles + first for cap, first in zip(caps, firsts, strict=False)])
    model = Mesh(np.concatenate([cap.points for cap in caps]), corners)
    name = f"{layer.name or ''} cut area".strip()
    style: dict[str, Any] = {**_PLAIN, "name": name, "color": "black", "shading": "none", "hidden": "remove"}
    if layer.fill is None:
        return _without_legend(layer, style | {"model": model, "alpha": 0.0})
    colors = fill_colors(layer, part.whole.n_faces)
    if len(colors) == 1:
        fill: Any = tuple(colors[0].tolist())
    else:
        by_body = {body: _main_color(part, colors, body) for body in {cap.body for cap in caps}}
        fill = np.repeat([by_body[cap.body] for cap in caps], [len(cap.triangles) for cap in caps], axis=0)
    return _without_legend(layer, style | {"model": model, "fill": fill, "edges": np.empty((0, 2), np.int64)})


def _main_color(part: _CutLayer, colors: Float64Array, body: int) -> Float64Array:
    """Return the colour that more than half of the surface of a body has, of those of its faces, else a light grey."""
    rows = np.flatnonzero(part.bodies == body)
    shades, number = np.unique(np.rint(255.0 * colors[rows]), axis=0, return_inverse=True)
    areas = np.bincount(number.reshape(-1), face_areas(part.whole)[rows], len(shades))
    largest = int(areas.argmax())
    color: Float64Array = shades[largest] / 255.0
    return color if 2.0 * areas[largest] > areas.sum() else np.array(to_rgba(SHADED_FILL, "fill"))


def _line_layer(layer: Layer, lines: Mesh, name: str, widths: float) -> Layer:
    width = DEFAULT_LINE_WIDTH_PX if is_auto(layer.line_width) else to_pixels(layer.line_width, "line_width")
    color = "black" if isinstance(layer.color, str) and layer.color in ("face", "file") else layer.color
    style: dict[str, Any] = {**_PLAIN, "name": f"{layer.name or ''} {name}".strip(), "color": color, "shading": "none"}
    style |= {"model": lines, "fill": None, "line_width": widths * width, "hidden": layer.hidden or "remove"}
    return _without_legend(layer, style)


def _without_legend(layer: Layer, style: dict[str, Any]) -> Layer:
    """Return a layer with changes, and with no place in a legend and no colour bar."""
    own = {each.name: getattr(layer, each.name) for each in fields(layer)}
    return IntersectionLayer(**own | style | {"colorbar": False})
