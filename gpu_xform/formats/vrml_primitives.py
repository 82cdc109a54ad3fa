"""The primitive shapes of VRML as their nodes describe them."""

from collections.abc import Callable

import numpy as np

from ..errors import MeshError
from .limits import budget
from .vrml_extrusions import Extrusion, make_extrusion
from .vrml_nodes import PlacedNode
from .vrml_shapes import Polygons, make_box, make_cone, make_cylinder, make_elevation_grid, make_sphere


def list_parts(node: PlacedNode) -> set[str]:
    """Return the parts that a cone or a cylinder of VRML 1.0 has."""
    words = " ".join(node.words("parts")).replace("(", " ").replace(")", " ").replace("|", " ").split()
    return {"SIDES", "TOP", "BOTTOM"} if not words or "ALL" in words else set(words)


def _read_box(node: PlacedNode) -> Polygons:
    return make_box(node.floats("size", (2.0, 2.0, 2.0)))


def _read_cube(node: PlacedNode) -> Polygons:
    return make_box(np.array([node.number(name, 2.0) for name in ("width", "height", "depth")]))


def _read_sphere(node: PlacedNode) -> Polygons:
    return make_sphere(node.number("radius", 1.0))


def _read_cone(node: PlacedNode) -> Polygons:
    parts = list_parts(node)
    return make_cone(
        node.number("bottomRadius", 1.0),
        node.number("height", 2.0),
        has_side=node.flag("side", True) and "SIDES" in parts,
        has_bottom=node.flag("bottom", True) and "BOTTOM" in parts,
    )


def _read_cylinder(node: PlacedNode) -> Polygons:
    parts = list_parts(node)
    return make_cylinder(
        node.number("radius", 1.0),
        node.number("height", 2.0),
        has_side=node.flag("side", True) and "SIDES" in parts,
        has_top=node.flag("top", True) and "TOP" in parts,
        has_bottom=node.flag("bottom", True) and "BOTTOM" in parts,
    )


def _read_elevation_grid(node: PlacedNode) -> Polygons:
    n_columns, n_rows = node.integer("xDimension", 0), node.integer("zDimension", 0)
    heights = node.rows("height", ((0.0,),))[:, 0] if node.numbers("height") else np.empty(0)
    if min(n_columns, n_rows) < 0 or n_columns * n_rows > len(heights):
        raise MeshError(f"line {node.line}: ElevationGrid of {n_columns} x {n_rows} points has {len(heights)} heights")
    heights = heights[: n_columns * n_rows].reshape(n_rows, n_columns)
    return make_elevation_grid(heights, node.number("xSpacing", 1.0), node.number("zSpacing", 1.0))


def read_extrusion(node: PlacedNode) -> Extrusion | None:
    """Return an extrusion; None for one without faces."""
    orientations = node.rows("orientation", ((0.0, 0.0, 1.0, 0.0),))
    is_turned = orientations[:, 3] != 0.0
    if is_turned.any() and not orientations[is_turned, :3].any(axis=1).all():
        raise MeshError(f"line {node.line}: an orientation of Extrusion needs an axis that is not zero")
    section = node.rows("crossSection", ((1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)))
    spine = node.rows("spine", ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    if min(len(section), len(spine)) < 2:
        return None
    budget().take_numbers(5 * len(section) * len(spine), node.line)  # three coordinates, and corners
    return make_extrusion(
        section,
        spine,
        node.rows("scale", ((1.0, 1.0),)),
        orientations,
        has_begin_cap=node.flag("beginCap", True),
        has_end_cap=node.flag("endCap", True),
    )


PRIMITIVES: dict[str, Callable[[PlacedNode], Polygons]] = {
    "Box": _read_box,
    "Cone": _read_cone,
    "Cube": _read_cube,
    "Cylinder": _read_cylinder,
    "ElevationGrid": _read_elevation_grid,
    "Sphere": _read_sphere,
}
