"""VRML 1.0 and VRML 97 (`.wrl`): the shapes, moved by the transforms above them.

Prototypes are expanded, and files beside this one that it names are read. Nodes of both versions may stand in one file.
What holds geometry and cannot be shown, such as text, is counted and named in one warning.
"""

import gzip
import math
import zlib
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._core.error_context import prefix_errors
from .._core.git_lfs import POINTER_WORDS, is_lfs_pointer
from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.attributes import sign_of_determinant
from ..geometry.mesh import Mesh, take_over
from ._beside import find_beside
from ._growing_array import GrowingArray
from ._text import plain_text, quote
from ._warn import warn
from .limits import budget, spend_own
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
from .vrml_primitives import PRIMITIVES, read_extrusion
from .vrml_shapes import Polygons
from .vrml_syntax import Numbers, parse_nodes

_MAX_DECOMPRESSED_BYTES = 1 << 28
_MAX_GZIP_RATIO = 100  # text shrinks to a twentieth at best, bombs to a thousandth
_PRIMITIVE_DISCOUNT = 4  # a molecule has many thousands of spheres, each of thousands of numbers: they count for less
_GROUPS = {"Group", "Anchor", "Billboard", "Collision", "StaticGroup", "Separator", "WWWAnchor"}
_INDEXED = {"IndexedFaceSet", "IndexedLineSet"}
_INLINES = {"Inline": "url", "WWWInline": "name"}
# Where nodes of unknown kinds keep what they show.
_CHILD_FIELDS = ("children", "humanoidBody", "skeleton")
_MAX_NAMED = 8
# Nodes that show nothing themselves.
_SILENT_KINDS = """
Appearance Arc AudioClip Background BackgroundColor BaseColor Color ColorInterpolator Coordinate
CoordinateInterpolator CylinderSensor DirectionalLight Environment Fog FontStyle ImageTexture Info Label LightModel
Material MaterialBinding MovieTexture NavigationInfo Normal NormalBinding NormalInterpolator OrientationInterpolator
OrthographicCamera PerspectiveCamera PixelTexture PlaneSensor PointLight PositionInterpolator ProximitySensor
ScalarInterpolator SceneInfo Script Sound SphereSensor SpotLight Texture2 Texture2Transform TextureCoordinate
TextureCoordinate2 TextureTransform TimeSensor TouchSensor Units Viewpoint VisibilitySensor WorldInfo
"""
_SILENT = frozenset(_SILENT_KINDS.split())


def read(data: bytes, folder: Path | None = None) -> Mesh:
    """Return the mesh of a VRML file, gzip-compressed or not.

    folder : where files that it names may lie

    Raises MeshError with the line of malformed content, for text that unpacks to more than 100 times its bytes, and if
    USE multiplies the scene beyond the budget of the file. Warns of what holds geometry and is not shown.
    """
    with spend_own(len(data)):
        roots, is_vrml1 = _parse(data)
        builder = _MeshBuilder()
        _walk(roots, builder, _Inlines(folder), _State(UNMOVED, is_vrml1=is_vrml1, folder=folder))
    mesh = builder.build()
    builder.warn_of_losses()
    return mesh


def _parse(data: bytes) -> tuple[list[PlacedNode], bool]:
    """Return the nodes at the top of a file, and whether it is of VRML 1.0."""
    if data.startswith(b"\x1f\x8b"):
        data = _decompress(data)
    data = plain_text(data)
    try:
        text = data.decode()
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    header = text.lstrip().split("\n", 1)[0].split()
    if header[:2] not in (["#VRML", "V1.0"], ["#VRML", "V2.0"]):
        got = quote(" ".join(header))
        raise MeshError(f"line 1: expected '#VRML V1.0 ascii' or '#VRML V2.0 utf8', got {got}")
    return [PlacedNode(node) for node in parse_nodes(text)], header[1] == "V1.0"


def _decompress(data: bytes) -> bytes:
    try:
        with gzip.GzipFile(fileobj=BytesIO(data)) as file:
            most = min(_MAX_DECOMPRESSED_BYTES, budget().most_bytes(_MAX_GZIP_RATIO))
            text = file.read(most + 1)
    except (EOFError, OSError, zlib.error) as error:
        raise MeshError(f"the gzip compression is damaged: {error}") from None
    if len(text) > most:
        raise MeshError(f"decompresses to more than {most} bytes, the limit FileLimits(unpacked_bytes=...)")
    budget().take_bytes(len(text), _MAX_GZIP_RATIO, "gzip")
    budget().allow_bytes(len(text))
    return text


class _State(NamedTuple):
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

    def then(self, matrix: Float64Array) -> "_State":
        """Return the state with what follows moved."""
        moved = matrix if self.matrix is UNMOVED else self.matrix @ matrix
        return _State(moved, *self[1:])


@dataclass
class _Inlines:
    """The files that a file names, each parsed once."""

    root: Path | None
    parsed: dict[Path, tuple[list[PlacedNode], bool]] = field(default_factory=dict)

    def find(self, names: list[str], folder: Path | None) -> Path | None:
        """Return the first of `names` that is a file beside the model."""
        plain = [name.partition("#")[0].removeprefix("file:") for name in names]
        paths = (find_beside(self.root, folder, name) for name in plain if name)
        return next((path for path in paths if path is not None), None)

    def parse(self, path: Path) -> tuple[list[PlacedNode], bool]:
        """Return the nodes at the top of a file, and whether it is of VRML 1.0."""
        if path not in self.parsed:
            data = path.read_bytes()
            budget().allow_bytes(len(data))
            with prefix_errors(path.name):
                if is_lfs_pointer(data):
                    raise MeshError(POINTER_WORDS)
                self.parsed[path] = _parse(data)
        return self.parsed[path]


@dataclass
class _MeshBuilder:
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

    def add_indexed(self, shape: PlacedNode, coordinates: PlacedNode | None, state: _State) -> None:
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

    def add_point_set(self, shape: PlacedNode, coordinates: PlacedNode, state: _State) -> None:
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

    def add_polygons(self, shape: PlacedNode, polygons: Polygons, state: _State) -> None:
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

    def add_extrusion(self, shape: PlacedNode, extrusion: Extrusion, state: _State) -> None:
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

    def _add_colors(self, shape: PlacedNode, state: _State, n_faces: int) -> None:
        """Add the colours of the faces of a primitive, which come next."""
        with self._leave_out_misfits("color"):
            colors = read_parts(shape, state.appearance, n_faces, is_vrml1=state.is_vrml1)
            self.attributes.add("face", "color", len(self.sizes), colors, n_faces)
            self.attributes.has_colors |= says_color(shape, state.appearance)
        self.attributes.note(state.appearance)

    def _add_attributes(
        self, shape: PlacedNode, state: _State, corners: Corners, order: IndexArray | slice, row_of_face: IndexArray
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

    builder: _MeshBuilder
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


def _is_turned(shape: PlacedNode, state: _State) -> bool:
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


_Entry: TypeAlias = PlacedNode | Callable[[_State], _State]


def _walk(roots: list[PlacedNode], builder: _MeshBuilder, inlines: _Inlines, state: _State) -> None:
    """Add the shapes of a scene, in the order of the file. Nodes change the state, groups restore it at their end."""
    pending: list[_Entry] = [*reversed(roots)]
    while pending:
        entry = pending.pop()
        if not isinstance(entry, PlacedNode):
            builder.depth -= 1
            state = entry(state)
            continue
        node = entry.expanded(builder.visit)
        if node is None:
            continue
        if _add_shape(node, builder, state):
            continue
        if (changed := _change_state(node, state)) is not None:
            state = changed
            continue
        children, inner = _enter(node, builder, inlines, state)
        if node.kind == "TransformSeparator" or inner is not None:
            builder.depth += 1
            budget().require_depth(builder.depth)
        if node.kind == "TransformSeparator":
            pending.append(lambda last, saved=state: last._replace(matrix=saved.matrix))  # type: ignore[misc]
        elif inner is not None:
            pending.append(lambda _, saved=state: saved)  # type: ignore[misc]
            state = inner
        pending += reversed(children)


def _add_shape(node: PlacedNode, builder: _MeshBuilder, state: _State) -> bool:
    """Add a node that is a shape; return whether it is one."""
    kind = node.node.kind
    if kind in _INDEXED or kind == "PointSet":
        own = next(iter(node.nodes("coord")), None)
        coordinates = state.coordinates if own is None else own.expanded(builder.visit)
        if kind in _INDEXED:
            builder.add_indexed(node, coordinates, state)
        elif coordinates is not None:
            builder.add_point_set(node, coordinates, state)
    elif kind in PRIMITIVES:
        polygons = PRIMITIVES[kind](node)
        if len(polygons.sizes):
            builder.add_polygons(node, polygons, state)
    elif kind == "Extrusion":
        if (extrusion := read_extrusion(node)) is not None:
            builder.add_extrusion(node, extrusion, state)
    else:
        return False
    return True


def _change_state(node: PlacedNode, state: _State) -> _State | None:
    """Return the state after a node that changes it for what follows; None for other nodes."""
    match node.node.kind:
        case "Coordinate3":
            return state._replace(coordinates=node)
        case "ShapeHints":
            return state._replace(is_clockwise=node.words("vertexOrdering") == ["CLOCKWISE"])
        case "Translation" | "Rotation" | "Scale":
            return state.then(_make_matrix(node, "scaleFactor"))
        case "Transform":
            is_group = not state.is_vrml1 or node.nodes("children")
            return None if is_group else state.then(_make_matrix(node, "scaleFactor"))
        case "MatrixTransform":
            return None if node.nodes("children") else state.then(_read_matrix(node))
    appearance = _change_appearance(node, state.appearance) if state.is_vrml1 else None
    return None if appearance is None else state._replace(appearance=appearance)


def _change_appearance(node: PlacedNode, appearance: Appearance) -> Appearance | None:
    """Return the appearance after a node of VRML 1.0 that changes it; None for other nodes."""
    match node.node.kind:
        case "Material":
            return replace(appearance, material=node)
        case "MaterialBinding":
            return replace(appearance, material_binding=next(iter(node.words("value")), "DEFAULT"))
        case "Normal":
            return replace(appearance, normal=node)
        case "NormalBinding":
            return replace(appearance, normal_binding=next(iter(node.words("value")), "DEFAULT"))
        case "TextureCoordinate2":
            return replace(appearance, texcoord=node)
        case "Texture2":
            return replace(appearance, texture=node)
    return None


def _read_appearance(shape: PlacedNode, builder: _MeshBuilder) -> Appearance:
    """Return how the geometry of a Shape of VRML 97 looks; shapes that USE one node share it."""
    placed = next(iter(shape.nodes("appearance")), None)
    if placed is None:
        return NO_APPEARANCE
    known, found = builder.appearances.get(id(placed.node), (placed, None))
    if found is not None and known.scope is placed.scope:
        return found
    node = placed.expanded(builder.visit)
    if node is None:
        return NO_APPEARANCE
    parts = [next(iter(node.nodes(name)), None) for name in ("material", "texture")]
    material, texture = (None if part is None else part.expanded(builder.visit) for part in parts)
    appearance = Appearance(material=material, texture=texture)
    builder.appearances[id(placed.node)] = placed, appearance
    return appearance


def _enter(
    node: PlacedNode, builder: _MeshBuilder, inlines: _Inlines, state: _State
) -> tuple[list[PlacedNode], _State | None]:
    """Return what a node shows, and the state inside it; None if what it changes lasts beyond its end."""
    children = node.nodes("children")
    is_scoped = not state.is_vrml1
    match node.kind:
        case "Shape":
            return node.nodes("geometry") + children, state._replace(appearance=_read_appearance(node, builder))
        case "Transform":
            name = "scale" if "scale" in node.node.fields else "scaleFactor"
            return children, state.then(_make_matrix(node, name))
        case "Separator":
            return children, state._replace(is_vrml1=True)
        case "TransformSeparator":
            return children, None
        case "Group":
            return children, state if is_scoped else None
        case "LOD" | "LevelOfDetail":
            return (node.nodes("level") or children)[:1], state if is_scoped else None
        case "Switch":
            return _choose(node), state if is_scoped else None
        case kind if kind in _GROUPS:
            return children, state
        case kind if kind in _INLINES:
            return _read_inline(node, builder, inlines, state)
        case kind if kind in _SILENT:
            return [], None
    children = [child for name in _CHILD_FIELDS for child in node.nodes(name)]
    if not children:
        builder.left_out[_describe(node)] += 1
        return [], None
    builder.as_groups[_describe(node)] += 1
    return children, state.then(_make_matrix(node, "scale"))


def _describe(node: PlacedNode) -> str:
    return f"{node.kind} (EXTERNPROTO)" if node.node.prototype else node.kind


def _choose(node: PlacedNode) -> list[PlacedNode]:
    """Return the choice of a Switch; by default, none."""
    choices = node.nodes("choice") or node.nodes("children")
    which = node.integer("whichChoice", node.integer("whichChild", -1))
    if which == -3 and "whichChild" in node.node.fields:
        return choices
    return choices[which : which + 1] if which >= 0 else []


def _read_inline(
    node: PlacedNode, builder: _MeshBuilder, inlines: _Inlines, state: _State
) -> tuple[list[PlacedNode], _State | None]:
    """Return the nodes of a file that lies beside this one, and the state for them."""
    names = node.words(_INLINES[node.kind])
    path = inlines.find(names, state.folder)
    if path is None or path in state.inlined:
        why = "not a file beside it" if path is None else "of itself"
        builder.left_out[f"{node.kind} ({why}: {quote(names[0]) if names else 'no name'})"] += 1
        return [], None
    roots, is_vrml1 = inlines.parse(path)
    inlined = (*state.inlined, path)
    return roots, _State(state.matrix, is_vrml1=is_vrml1, folder=path.parent, inlined=inlined)


def _read_matrix(node: PlacedNode) -> Float64Array:
    """Return the matrix of a MatrixTransform."""
    # VRML 1.0 has row vectors: the translation is in the last row.
    matrix = node.floats("matrix", tuple(np.eye(4).ravel())).reshape(4, 4).T
    if (matrix[3] != (0.0, 0.0, 0.0, 1.0)).any():
        raise MeshError(f"line {node.line}: a MatrixTransform must end its rows with 0 0 0 1")
    return matrix


def _make_matrix(node: PlacedNode, scale_name: str) -> Float64Array:
    """Return T C R Q S Q^-1 C^-1 of a node's translation, center, rotation, scale and scaleOrientation: (4, 4)."""
    matrix, fields = UNMOVED.copy(), node.node.fields
    if "rotation" in fields:
        matrix[:3, :3] = _make_rotation(node, "rotation")
    if "scaleOrientation" in fields or scale_name in fields:
        scale_axes = _make_rotation(node, "scaleOrientation")
        scale = np.diag(node.floats(scale_name, (1.0, 1.0, 1.0)))
        matrix[:3, :3] = matrix[:3, :3] @ scale_axes @ scale @ scale_axes.T
    if "translation" in fields:
        matrix[:3, 3] = node.floats("translation", (0.0, 0.0, 0.0))
    if "center" in fields:
        center = node.floats("center", (0.0, 0.0, 0.0))
        matrix[:3, 3] += center - matrix[:3, :3] @ center
    return matrix


def _make_rotation(node: PlacedNode, name: str) -> Float64Array:
    """Return the matrix of an axis and an angle in radians: (3, 3)."""
    numbers = node.numbers(name)
    *axis, angle = node.floats(name, (0.0, 0.0, 1.0, 0.0)).tolist()
    if angle == 0.0:
        return np.eye(3)
    if not any(axis):
        line = node.line if numbers is None else numbers.line
        raise MeshError(f"line {line}: {name} by {angle} needs an axis that is not zero")
    return _rotate_about(axis, angle)


def _rotate_about(axis: list[float], angle: float) -> Float64Array:
    """Return the rotation that `matrices.rotate` makes, without its checks, which take longer than files have time."""
    largest = max(map(abs, axis))
    x, y, z = (part / largest for part in axis)
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    c, s = math.cos(angle), math.sin(angle)
    d = 1.0 - c
    return np.array(
        [
            [c + d * x * x, d * x * y - s * z, d * x * z + s * y],
            [d * x * y + s * z, c + d * y * y, d * y * z - s * x],
            [d * x * z - s * y, d * y * z + s * x, c + d * z * z],
        ]
    )
