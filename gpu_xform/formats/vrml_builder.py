"""The mesh of a VRML scene as it grows, shape by shape."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array
from ..errors import MeshError
from ..geometry.mesh import Mesh, take_over
from ._growing_array import GrowingArray
from ._warn import warn
from .limits import Budget, budget
from .vrml_attributes import (
    NO_APPEARANCE,
    Appearance,
    AttributeBuilder,
    MovedNormals,
    read_colors_of_points,
    says_color,
)
from .vrml_extrusions import Extrusion, ExtrusionQueue, list_faces
from .vrml_faces import Faces, FaceStyle, read_grid, read_indexed, read_primitive
from .vrml_nodes import PlacedNode
from .vrml_placements import UNMOVED, Placement
from .vrml_primitives import PRIMITIVES, read_extrusion
from .vrml_values import Numbers

_PRIMITIVE_DISCOUNT = 4  # a molecule has many thousands of spheres, each of thousands of numbers: they count for less
_MAX_NAMED = 8
_MAX_APPEARANCES = 1 << 8
_NO_NUMBERS = Numbers(0, "")
_NO_POINTS = np.empty((0, 3))


class State(NamedTuple):
    """What nodes change for the nodes after them or below them.

    is_clockwise : whether faces are clockwise seen from outside, as ShapeHints of VRML 1.0 says
    is_vrml1 : whether a Transform moves what follows it, and a Group keeps no state of its own
    folder, inlined : where the current file lies, and the files that the walk is in
    """

    placement: Placement = UNMOVED
    coordinates: PlacedNode | None = None
    is_clockwise: bool = False
    is_vrml1: bool = False
    appearance: Appearance = NO_APPEARANCE
    folder: Path | None = None
    inlined: tuple[Path, ...] = ()

    def then(self, matrix: Float64Array) -> "State":
        """Return the state with what follows moved."""
        return State(self.placement.then(matrix), *self[1:])

    def with_appearance(self, appearance: Appearance) -> "State":
        """Return the state with another appearance; `_replace` takes twice as long."""
        placement, coordinates, is_clockwise, is_vrml1, _, folder, inlined = self
        return State(placement, coordinates, is_clockwise, is_vrml1, appearance, folder, inlined)

    def style(self) -> FaceStyle:
        """Return what shapes are like in this state."""
        return FaceStyle(self.appearance, self.is_vrml1, self.is_clockwise, self.placement.is_mirrored)


class _Read(NamedTuple):
    """A shape that was read, what its own points come of, and how many nodes and numbers it took of the budget."""

    faces: Faces
    source: Float64Array | Extrusion
    n_nodes: int
    n_numbers: int


class KnownAppearance(NamedTuple):
    """What a node says of a style, and for which of the times that the prototype around it was shown."""

    placed: PlacedNode
    n_entered: int
    appearance: Appearance


@dataclass
class MeshBuilder:
    """What was read so far."""

    budget: Budget = field(default_factory=budget)
    depth: int = 0
    points: GrowingArray = field(default_factory=lambda: GrowingArray(np.float64, 3))
    sizes: GrowingArray = field(default_factory=lambda: GrowingArray(np.uint32))
    corners: GrowingArray = field(default_factory=lambda: GrowingArray(np.uint32))
    extrusions: ExtrusionQueue = field(default_factory=ExtrusionQueue)
    attributes: AttributeBuilder = field(default_factory=AttributeBuilder)
    point_ranges: dict[tuple[int, bytes], tuple[int, int]] = field(default_factory=dict)
    moved_normals: MovedNormals = field(default_factory=dict)
    appearances: dict[Appearance, Appearance] = field(default_factory=dict)
    appearances_of_nodes: dict[int, KnownAppearance] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)
    as_groups: Counter[str] = field(default_factory=Counter)

    def _count(self, n_numbers: int, line: int) -> None:
        """Count numbers drawn; raise MeshError if there are too many."""
        self.budget.take_numbers(n_numbers, line)

    def share(self, appearance: Appearance) -> Appearance:
        """Return an equal appearance that shapes before had, if there is one: what was read of it is there."""
        if len(self.appearances) >= _MAX_APPEARANCES:
            self.appearances.clear()
        return self.appearances.setdefault(appearance, appearance)

    def add_indexed(self, shape: PlacedNode, coordinates: PlacedNode | None, state: State) -> None:
        """Add a face set or a line set."""
        index = shape.numbers("coordIndex")
        if index is None:
            return
        style, points = state.style(), _points_of(coordinates)
        key = shape.scope, style, points
        known: _Read | None = shape.recall(key)
        n_new = 0 if known is None else self._count_new(points, state.placement)
        if known is not None and self._take_again(known, n_new, shape):
            base, _ = self._add_points(points, state.placement, shape.line)
            self._add_faces(known.faces, base, state.placement)
            return
        n_indices = index.count_at_most()
        self._count(n_indices, shape.line)
        if (values := index.integers()).size == 0:
            return
        if coordinates is None:
            raise MeshError(f"line {shape.line}: {shape.kind} has no coordinates")
        base, n_points = self._add_points(points, state.placement, coordinates.line)
        before = self.budget.taken()
        faces = read_indexed(shape, index, values, n_points, style, self.budget.take_nodes)
        self.attributes.note(style.appearance)
        shape.keep(key, self._note_taken(before, faces, _NO_POINTS, n_indices))
        self._add_faces(faces, base, state.placement)

    def add_point_set(self, shape: PlacedNode, coordinates: PlacedNode, state: State) -> None:
        """Add a point set."""
        start, count = self._add_points(_points_of(coordinates), state.placement, coordinates.line)
        if says_color(shape, state.appearance):
            try:
                self._count(count, shape.line)
                colors = read_colors_of_points(shape, state.appearance, count, self.budget.take_nodes)
            except MeshError:
                if self.budget.is_spent:
                    raise
                self.attributes.misfits["color"] += 1
                return
            self.attributes.add("point", "color", start, colors, count)
            self.attributes.has_colors = True

    def add_primitive(self, shape: PlacedNode, state: State) -> None:
        """Add a primitive shape; an extrusion's points come with those of all others."""
        style = state.style()
        key = shape.scope, style
        read: _Read | None = shape.recall(key)
        if read is None or not self._take_again(read, 0, shape):
            before = self.budget.taken()
            made = self._read_primitive(shape, style)
            if made is None:
                return
            self.attributes.note(style.appearance)
            read = self._note_taken(before, *made, 0)
            shape.keep(key, read)
        if isinstance(read.source, Extrusion):
            start = self.points.reserve(read.source.form.n_points)
            self.extrusions.add(start, read.source, state.placement.matrix)
        else:
            start = len(self.points)
            self.points.append(state.placement.move(read.source))
        self._add_faces(read.faces, start, state.placement)

    def _read_primitive(self, shape: PlacedNode, style: FaceStyle) -> tuple[Faces, Float64Array | Extrusion] | None:
        """Return the faces of a primitive, and its points or what they come of; None for one without faces."""
        if shape.kind == "Extrusion":
            extrusion = read_extrusion(shape)
            if extrusion is None:
                return None
            corners, sizes = list_faces(extrusion.form)
            self._count((3 * extrusion.form.n_points + len(corners)) // _PRIMITIVE_DISCOUNT, shape.line)
            return read_primitive(shape, corners, sizes, style), extrusion
        points, corners, sizes = polygons = PRIMITIVES[shape.kind](shape)
        if len(sizes) == 0:
            return None
        self._count((points.size + len(corners)) // _PRIMITIVE_DISCOUNT, shape.line)
        if shape.kind == "ElevationGrid":
            return read_grid(shape, polygons, style, self.budget.take_nodes), points
        return read_primitive(shape, corners, sizes, style), points

    def _count_new(self, points: Numbers, placement: Placement) -> int:
        """Return how many numbers `_add_points` will count."""
        return 0 if (id(points), placement.key) in self.point_ranges else points.count_at_most()

    def _take_again(self, read: _Read, n_more: int, shape: PlacedNode) -> bool:
        """Count again what a shape took when it was read; False if that, and more numbers, are more than are left."""
        if not self.budget.has_room(read.n_nodes, read.n_numbers + n_more):
            return False
        self.budget.take_nodes(read.n_nodes, shape.line)
        self.budget.take_numbers(read.n_numbers, shape.line)
        return True

    def _note_taken(
        self, before: tuple[int, int], faces: Faces, source: Float64Array | Extrusion, n_more: int
    ) -> _Read:
        """Return a shape that was read since the budget was `before`, and `n_more` numbers earlier."""
        n_nodes, n_numbers = self.budget.taken()
        return _Read(faces, source, n_nodes - before[0], n_numbers - before[1] + n_more)

    def _add_points(self, points: Numbers, placement: Placement, line: int) -> tuple[int, int]:
        """Return the index of the first moved point and their number; sets of equal coordinates share points."""
        key = id(points), placement.key
        if key not in self.point_ranges:
            self._count(points.count_at_most(), line)
            rows = points.floats(3)
            self.point_ranges[key] = len(self.points), len(rows)
            self.points.append(placement.move(rows))
        return self.point_ranges[key]

    def _add_faces(self, faces: Faces, base: int, placement: Placement) -> None:
        """Add faces, whose points are those from `base` on, and their attributes."""
        n_corners, n_faces = len(self.corners), len(self.sizes)
        normals = faces.move_normals(placement, self.moved_normals)
        for place, name, rows, n in faces.parts if normals is None else [*faces.parts, normals]:
            self.attributes.add(place, name, n_corners if place == "corner" else n_faces, rows, n)
        self.attributes.has_colors |= faces.says_color
        for name in faces.misfits:
            self.attributes.misfits[name] += 1
        self.sizes.append(faces.sizes)
        self.corners.append(faces.corners + base)

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


def _list_counts(counts: Counter[str]) -> str:
    names = [f"{count} {name}" for name, count in counts.most_common(_MAX_NAMED)]
    n_more = sum(counts.values()) - sum(count for _, count in counts.most_common(_MAX_NAMED))
    return ", ".join(names) + (f" and {n_more} more" if n_more else "")


def _points_of(coordinates: PlacedNode | None) -> Numbers:
    points = None if coordinates is None else coordinates.numbers("point")
    return _NO_NUMBERS if points is None else points
