"""What a shape of VRML adds to a mesh, wherever it stands; a shape that is shown often is read once."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from .limits import budget
from .vrml_attributes import (
    Appearance,
    Column,
    Corners,
    MovedNormals,
    NormalColumn,
    Place,
    find_range,
    read_color,
    read_normal,
    read_parts,
    read_texcoord,
    says_color,
)
from .vrml_nodes import PlacedNode, Visit
from .vrml_placements import Placement
from .vrml_shapes import Polygons
from .vrml_values import Numbers


class FaceStyle(NamedTuple):
    """What stands before a shape or above it and says what its faces are like.

    is_clockwise : whether faces are clockwise seen from outside, as ShapeHints of VRML 1.0 says
    is_mirrored : whether what is above it mirrors it
    """

    appearance: Appearance
    is_vrml1: bool
    is_clockwise: bool
    is_mirrored: bool


class Part(NamedTuple):
    """The rows of an attribute, as many as there are, or one that stands for `n`."""

    place: Place
    name: str
    rows: Float64Array
    n: int


class Faces(NamedTuple):
    """Faces with their attributes.

    corners : the point of each corner, all faces one after the other
    highest : the highest point that the shape names
    normals : not moved yet, and where in `NormalColumn.chosen` each corner or face has its own
    misfits : the attributes that do not fit the shape
    says_color : whether the file says its colour
    """

    corners: IndexArray
    sizes: IndexArray
    highest: int
    parts: list[Part]
    normals: tuple[NormalColumn, IndexArray] | None
    misfits: list[str]
    says_color: bool

    def move_normals(self, placement: Placement, known: MovedNormals) -> Part | None:
        """Return the normals in the world, None if there are none; `known` is as of `NormalColumn.moved`."""
        if self.normals is None:
            return None
        column, places = self.normals
        return _pick("normal", column.moved(placement, known), places)


def read_indexed(
    shape: PlacedNode, index: Numbers, values: IndexArray, n_points: int, style: FaceStyle, visit: Visit
) -> Faces:
    """Return the faces of a face set, or the lines of a line set, with the values of its `coordIndex`."""
    lowest, highest = find_range(values)
    if lowest < -1 or highest >= n_points:
        i = int(np.argmax((values < -1) | (values >= n_points)))
        raise MeshError(f"line {index.line_of(i)}: index {values[i]} is out of range, there are {n_points} points")
    corners = Corners.split(values, highest)
    sizes, order = corners.sizes, corners.places
    if shape.kind == "IndexedLineSet":
        joined = (corners.is_corner[:-1] & corners.is_corner[1:]).nonzero()[0]  # a line of one point joins nothing
        order = np.repeat(joined, 2)
        order[1::2] += 1
        return _make_faces(shape, style, corners, order, np.full(len(joined), 2), lambda: corners.row[joined], visit)
    if len(sizes) and find_range(sizes)[0] < 2:
        line = index.line_of(int(order[(np.cumsum(sizes) - sizes)[np.argmax(sizes < 2)]]))
        raise MeshError(f"line {line}: {shape.kind} needs at least 2 indices before each -1, got 1")
    if _is_turned(shape, style):
        order = order[_reverse_faces(sizes)]
    return _make_faces(shape, style, corners, order, sizes, lambda: np.arange(len(sizes)), visit)


def read_grid(shape: PlacedNode, polygons: Polygons, style: FaceStyle, visit: Visit) -> Faces:
    """Return the faces of an elevation grid."""
    values, sizes = polygons.corners, polygons.sizes
    corners = Corners(values, np.arange(len(values)), sizes, find_range(values)[1])
    order = _reverse_faces(sizes) if _is_turned(shape, style) else corners.places
    return _make_faces(shape, style, corners, order, sizes, lambda: np.arange(len(sizes)), visit)


def read_primitive(shape: PlacedNode, corners: IndexArray, sizes: IndexArray, style: FaceStyle) -> Faces:
    """Return the faces of a primitive or an extrusion, which have colours at most."""
    if _is_turned(shape, style):
        corners = corners[_reverse_faces(sizes)]
    parts: list[Part] = []
    misfits: list[str] = []
    says = False
    try:
        colors = read_parts(shape, style.appearance, len(sizes), is_vrml1=style.is_vrml1)
        says = says_color(shape, style.appearance)
        parts.append(Part("face", "color", colors, len(sizes)))
    except MeshError as error:
        _leave_out("color", error, misfits)
    return Faces(corners, sizes, -1, parts, None, misfits, says)


def _make_faces(
    shape: PlacedNode,
    style: FaceStyle,
    corners: Corners,
    order: IndexArray,
    sizes: IndexArray,
    row_of_face: Callable[[], IndexArray],
    visit: Visit,
) -> Faces:
    """Return faces with their attributes.

    order : which value of `corners` each corner of the faces is
    row_of_face : which row of `corners` each face is, or is a part of
    """
    appearance, is_vrml1 = style.appearance, style.is_vrml1
    parts: list[Part] = []
    misfits: list[str] = []
    normals, says = None, False
    try:
        color = read_color(shape, appearance, corners, is_vrml1=is_vrml1, visit=visit)
        says = says_color(shape, appearance)
        if color.chosen is None:
            parts.append(Part("face", "color", color.rows, len(sizes)))
        else:
            parts.append(_pick("color", color, order if color.is_per_corner else row_of_face()))
    except MeshError as error:
        _leave_out("color", error, misfits)
    if shape.kind != "IndexedLineSet":
        try:
            normal = read_normal(shape, appearance, corners, is_vrml1=is_vrml1, visit=visit)
            if normal is not None:
                normals = normal, order if normal.is_per_corner else row_of_face()
        except MeshError as error:
            _leave_out("normal", error, misfits)
        try:
            texcoord = read_texcoord(shape, appearance, corners, is_vrml1=is_vrml1, visit=visit)
            if texcoord is not None:
                parts.append(_pick("texcoord", texcoord, order))
        except MeshError as error:
            _leave_out("texcoord", error, misfits)
    return Faces(corners.values[order], sizes, corners.highest, parts, normals, misfits, says)


def _pick(name: str, column: Column, places: IndexArray) -> Part:
    """Return the rows of an attribute for the corners or the faces at some places of what it was chosen for."""
    rows, chosen, is_per_corner = column
    picked = rows if chosen is None else rows[chosen[places]]
    return Part("corner" if is_per_corner else "face", name, picked, len(places))


def _leave_out(name: str, error: MeshError, misfits: list[str]) -> None:
    """Leave out an attribute that is malformed or does not fit its shape; raise the error if the budget is spent."""
    if budget().is_spent:
        raise error
    misfits.append(name)


def _is_turned(shape: PlacedNode, style: FaceStyle) -> bool:
    """Tell whether faces must be reversed to be counter-clockwise from outside, mirrors above the shape included."""
    shape.flag("solid", True)
    shape.flag("convex", True)
    is_clockwise = style.is_clockwise if style.is_vrml1 else not shape.flag("ccw", True)
    return is_clockwise != style.is_mirrored


def _reverse_faces(sizes: IndexArray) -> IndexArray:
    """Return the order of corners that reverses each face: its first corner stays the first."""
    size = np.repeat(sizes, sizes)
    starts = np.repeat(np.cumsum(sizes) - sizes, sizes)
    order: IndexArray = starts + (size - (np.arange(len(size)) - starts)) % size
    return order
