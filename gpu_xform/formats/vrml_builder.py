"""The mesh of a VRML scene as it grows, shape by shape."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.attributes import sign_of_determinant
from ..geometry.mesh import Mesh, take_over
from ._growing_array import GrowingArray
from ._warn import warn
from .limits import budget
from .vrml_attributes import (
    NO_APPEARANCE,
    UNMOVED,
    Appearance,
    AttributeBuilder,
    Column,
    Corners,
    MovedNormals,
    read_color,
    read_colors_of_points,
    read_normal,
    read_parts,
    read_texcoord,
    says_color,
)
from .vrml_extrusions import Extrusion, ExtrusionQueue, list_faces
from .vrml_nodes import PlacedNode
from .vrml_shapes import Polygons
from .vrml_values import Numbers

_PRIMITIVE_DISCOUNT = 4  # a molecule has many thousands of spheres, each of thousands of numbers: they count for less
_MAX_NAMED = 8


class State(NamedTuple):
    """What nodes change for the nodes after them or below them.

    is_clockwise : whether faces are clockwise seen from outside, as ShapeHints of VRML 1.0 says
    is_vrml1 : whether a Transform moves what follows it, and a Group keeps no state of its own
    folder, inlined : where the current file lies, and the files that the walk is in
    """

    matrix: Float64Array
    coordinates: PlacedNode | None = None
    is_clockwise: bool = False
    is_vrml1: bool = False
    appearance: Appearance = NO_APPEARANCE
    folder: Path | None = None
    inlined: tuple[Path, ...] = ()

    def then(self, matrix: Float64Array) -> "State":
        """Return the state with what follows moved."""
        moved = matrix if self.matrix is UNMOVED else self.matrix @ matrix
        return State(moved, *self[1:])


@dataclass
class MeshBuilder:
    """What was read so far."""

    depth: int = 0
    points: GrowingArray = field(default_factory=lambda: GrowingArray(np.float64, 3))
    sizes: GrowingArray = field(default_factory=lambda: GrowingArray(np.uint32))
    corners: GrowingArray = field(default_factory=lambda: GrowingArray(np.uint32))
    extrusions: ExtrusionQueue = field(default_factory=ExtrusionQueue)
    attributes: AttributeBuilder = field(default_factory=AttributeBuilder)
    point_ranges: dict[tuple[int, bytes], tuple[int, int]] = field(default_factory=dict)
    moved_normals: MovedNormals = field(default_factory=dict)
    appearances: dict[int, tuple[PlacedNode, Appearance]] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)
    as_groups: Counter[str] = field(default_factory=Counter)

    def visit(self, node: PlacedNode) -> None:
        """Count a visit to a node; raise MeshError if there are too many."""
        budget().take_nodes(1, node.line)

    def _count(self, n_numbers: int, line: int) -> None:
        """Count numbers drawn; raise MeshError if there are too many."""
        budget().take_numbers(n_numbers, line)

    def add_indexed(self, shape: PlacedNode, coordinates: PlacedNode | None, state: State) -> None:
        """Add a face set or a line set."""
        index = shape.numbers("coordIndex")
        if index is not None:
            self._count(index.count_at_most(), shape.line)
        if index is None or (values := index.integers()).size == 0:
            return
        if coordinates is None:
            raise MeshError(f"line {shape.line}: {shape.kind} has no coordinates")
        base, count = self.add_points(coordinates, state.matrix)
        if values.min() < -1 or values.max() >= count:
            i = int(np.argmax((values < -1) | (values >= count)))
            line = index.line_of(i)
            raise MeshError(f"line {line}: index {values[i]} is out of range, there are {count} points")
        corners = Corners.split(values)
        if shape.kind == "IndexedLineSet":
            joined = (corners.is_corner[:-1] & corners.is_corner[1:]).nonzero()[0]  # a line of one point joins nothing
            order = np.stack([joined, joined + 1], axis=1).ravel()
            self._add_attributes(shape, state, corners, order, corners.row[joined])
            self._add_faces(values[order] + base, np.full(len(joined), 2))
            return
        sizes, order = corners.sizes, corners.is_corner.nonzero()[0]
        if sizes.min(initial=2) < 2:
            line = index.line_of(int(order[(np.cumsum(sizes) - sizes)[np.argmax(sizes < 2)]]))
            raise MeshError(f"line {line}: {shape.kind} needs at least 2 indices before each -1, got 1")
        if _is_turned(shape, state):
            order = order[_reverse_faces(sizes)]
        self._add_attributes(shape, state, corners, order, np.arange(len(sizes)))
        self._add_faces(values[order] + base, sizes)

    def add_point_set(self, shape: PlacedNode, coordinates: PlacedNode, state: State) -> None:
        """Add a point set."""
        start, count = self.add_points(coordinates, state.matrix)
        if says_color(shape, state.appearance):
            with self._leave_out_misfits("color"):
                self._count(count, shape.line)
                colors = read_colors_of_points(shape, state.appearance, count, self.visit)
                self.attributes.add("point", "color", start, colors, count)
                self.attributes.has_colors = True

    def add_points(self, coordinates: PlacedNode, matrix: Float64Array) -> tuple[int, int]:
        """Return the index of the first transformed point and their number; sets of equal coordinates share points."""
        numbers = coordinates.numbers("point") or Numbers(coordinates.line, "")
        key = (id(numbers), matrix.tobytes())
        if key not in self.point_ranges:
            self._count(numbers.count_at_most(), coordinates.line)
            points = numbers.floats(3)
            self.point_ranges[key] = len(self.points), len(points)
            self._append_points(points, matrix)
        return self.point_ranges[key]

    def add_polygons(self, shape: PlacedNode, polygons: Polygons, state: State) -> None:
        """Add a primitive shape."""
        sizes = polygons.sizes
        self._count((polygons.points.size + len(polygons.corners)) // _PRIMITIVE_DISCOUNT, shape.line)
        order = _reverse_faces(sizes) if _is_turned(shape, state) else slice(None)
        if shape.kind == "ElevationGrid":
            corners = Corners(polygons.corners, np.ones(len(polygons.corners), bool), sizes)
            self._add_attributes(shape, state, corners, order, np.arange(len(sizes)))
        else:
            self._add_colors(shape, state, len(sizes))
        self._add_faces(polygons.corners[order] + len(self.points), sizes)
        self._append_points(polygons.points, state.matrix)

    def add_extrusion(self, shape: PlacedNode, extrusion: Extrusion, state: State) -> None:
        """Add an extrusion, whose points come with those of all others."""
        corners, sizes = list_faces(extrusion.form)
        n_points = extrusion.form.n_points
        self._count((3 * n_points + len(corners)) // _PRIMITIVE_DISCOUNT, shape.line)
        if _is_turned(shape, state):
            corners = corners[_reverse_faces(sizes)]
        self._add_colors(shape, state, len(sizes))
        start = self.points.reserve(n_points)
        self._add_faces(corners + start, sizes)
        self.extrusions.add(start, extrusion, None if state.matrix is UNMOVED else state.matrix)

    def _add_colors(self, shape: PlacedNode, state: State, n_faces: int) -> None:
        """Add the colours of the faces of a primitive, which come next."""
        with self._leave_out_misfits("color"):
            colors = read_parts(shape, state.appearance, n_faces, is_vrml1=state.is_vrml1)
            self.attributes.add("face", "color", len(self.sizes), colors, n_faces)
            self.attributes.has_colors |= says_color(shape, state.appearance)
        self.attributes.note(state.appearance)

    def _add_attributes(
        self, shape: PlacedNode, state: State, corners: Corners, order: IndexArray | slice, row_of_face: IndexArray
    ) -> None:
        """Add the attributes of the faces that come next.

        order : which value of `corners` each corner of the faces is
        row_of_face : which row of `corners` each face is, or is a part of
        """
        settings: dict[str, Any] = {"is_vrml1": state.is_vrml1, "visit": self.visit}
        self.attributes.note(state.appearance)
        found: dict[str, Column | None] = {}
        with self._leave_out_misfits("color"):
            found["color"] = read_color(shape, state.appearance, corners, **settings)
            self.attributes.has_colors |= says_color(shape, state.appearance)
        if shape.kind != "IndexedLineSet":
            with self._leave_out_misfits("normal"):
                found["normal"] = read_normal(
                    shape, state.appearance, corners, state.matrix, self.moved_normals, **settings
                )
            with self._leave_out_misfits("texcoord"):
                found["texcoord"] = read_texcoord(shape, state.appearance, corners, **settings)
        for name, column in found.items():
            if column is None:
                continue
            if column.chosen is None:
                self.attributes.add("face", name, len(self.sizes), column.rows, len(row_of_face))
            elif column.is_per_corner:
                self.attributes.add("corner", name, len(self.corners), column.rows[column.chosen[order]])
            else:
                self.attributes.add("face", name, len(self.sizes), column.rows[column.chosen[row_of_face]])

    def _leave_out_misfits(self, name: str) -> "_Misfits":
        """Leave out an attribute that is malformed or does not fit its shape, whose points and faces are good."""
        return _Misfits(self, name)

    def _add_faces(self, corners: IndexArray, sizes: IndexArray) -> None:
        self.sizes.append(sizes)
        self.corners.append(corners)

    def _append_points(self, points: Float64Array, matrix: Float64Array) -> None:
        if matrix is not UNMOVED:
            points = points @ matrix[:3, :3].T + matrix[:3, 3]
        self.points.append(points)

    def _list_losses(self) -> str:
        """Return what holds geometry and was not added, and what was read as a group by its children alone."""
        parts = [
            f"{what} {_list_counts(counts)}"
            for what, counts in (("not shown:", self.left_out), ("shown as groups, by their children:", self.as_groups))
            if counts
        ]
        if misfits := self.attributes.describe_misfits():
            parts.append(f"left out, for they do not fit: {misfits}")
        return "; ".join(parts)

    def warn_of_losses(self) -> None:
        """Warn once of what the mesh lacks."""
        if losses := self._list_losses():
            warn(losses)

    def build(self) -> Mesh:
        """Return the mesh of all that was added."""
        if not self.corners and not self.points:
            losses = self._list_losses() or "it needs a face set, a line set, a point set or a primitive"
            raise MeshError(f"no shapes: {losses}")
        offsets = np.zeros(len(self.sizes) + 1, np.int64)
        np.cumsum(self.sizes.take(), out=offsets[1:])
        points, corners = self.points.take(), self.corners.take()
        self.extrusions.fill(points)
        holds = self.attributes.describe_losses()
        return take_over(
            points,
            (offsets, corners),
            attributes=self.attributes.build(len(points), offsets, corners),
            metadata={"vrml": {"holds": holds}} if holds else None,
        )


class _Misfits(NamedTuple):
    """A block whose `MeshError` is counted, unless the budget is spent; small files have many thousands of them."""

    builder: MeshBuilder
    name: str

    def __enter__(self) -> None: ...

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> bool:
        if kind is None or not issubclass(kind, MeshError) or budget().is_spent:
            return False
        self.builder.attributes.misfits[self.name] += 1
        return True


def _list_counts(counts: Counter[str]) -> str:
    names = [f"{count} {name}" for name, count in counts.most_common(_MAX_NAMED)]
    n_more = sum(counts.values()) - sum(count for _, count in counts.most_common(_MAX_NAMED))
    return ", ".join(names) + (f" and {n_more} more" if n_more else "")


def _is_turned(shape: PlacedNode, state: State) -> bool:
    """Tell whether faces must be reversed to be counter-clockwise from outside, mirrors above the shape included."""
    shape.flag("solid", True)
    shape.flag("convex", True)
    is_clockwise = state.is_clockwise if state.is_vrml1 else not shape.flag("ccw", True)
    is_mirrored = state.matrix is not UNMOVED and sign_of_determinant(state.matrix[:3, :3]) < 0
    return is_clockwise != is_mirrored


def _reverse_faces(sizes: IndexArray) -> IndexArray:
    """Return the order of corners that reverses each face: its first corner stays the first."""
    size = np.repeat(sizes, sizes)
    starts = np.repeat(np.cumsum(sizes) - sizes, sizes)
    order: IndexArray = starts + (size - (np.arange(len(size)) - starts)) % size
    return order
