"""VRML 1.0 and VRML 97 (`.wrl`): face sets and line sets, transformed to the world.

Primitives (Box, Sphere, ...), text, prototypes, scripts and inlined files are ignored.
"""

import gzip
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from io import BytesIO

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.mesh import Mesh
from ..matrices import rotate
from ._text import plain_text, quote
from .vrml_syntax import Node, Numbers, parse_nodes

_MAX_DECOMPRESSED_BYTES = 1 << 28
# USE can make a short file a huge scene: it may have so many numbers and visits of nodes, plus its size in bytes.
_NUMBER_ALLOWANCE = 1 << 25
_VISIT_ALLOWANCE = 1 << 18
_VRML97_GROUPS = {"Group", "Anchor", "Billboard", "Collision"}
_SHAPE_SETS = {"IndexedFaceSet", "IndexedLineSet"}


def read(data: bytes) -> Mesh:
    """Return the mesh of a VRML file, gzip-compressed or not.

    Raises MeshError with the line of malformed content, for compressed text of more than 256 MiB, and if USE multiplies
    the scene beyond its allowance.
    """
    if data.startswith(b"\x1f\x8b"):
        data = _decompress(data)
    data = plain_text(data)
    try:
        text = data.decode()
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    header = text.lstrip().split("\n", 1)[0].split()
    if header[:2] == ["#VRML", "V1.0"]:
        walk: Callable[[list[Node], _MeshBuilder], None] = _walk_vrml1
    elif header[:2] == ["#VRML", "V2.0"]:
        walk = _walk_vrml97
    else:
        got = quote(" ".join(header))
        raise MeshError(f"line 1: expected '#VRML V1.0 ascii' or '#VRML V2.0 utf8', got {got}")
    builder = _MeshBuilder(_NUMBER_ALLOWANCE + len(data), _VISIT_ALLOWANCE + len(data))
    walk(parse_nodes(text), builder)
    return builder.build()


def _decompress(data: bytes) -> bytes:
    try:
        with gzip.GzipFile(fileobj=BytesIO(data)) as file:
            text = file.read(_MAX_DECOMPRESSED_BYTES + 1)
    except (EOFError, OSError, zlib.error) as error:
        raise MeshError(f"the gzip compression is damaged: {error}") from None
    if len(text) > _MAX_DECOMPRESSED_BYTES:
        raise MeshError(f"decompresses to more than {_MAX_DECOMPRESSED_BYTES} bytes")
    return text


@dataclass
class _MeshBuilder:
    """The mesh under construction, and how much more may be added."""

    numbers_left: int
    visits_left: int
    points: list[Float64Array] = field(default_factory=list)
    sizes: list[IndexArray] = field(default_factory=list)
    corners: list[IndexArray] = field(default_factory=list)
    n_points: int = 0
    point_ranges: dict[tuple[int, bytes], tuple[int, int]] = field(default_factory=dict)

    def visit(self, node: Node) -> None:
        """Count a visit of a node; raise MeshError if there are too many."""
        self.visits_left -= 1
        if self.visits_left < 0:
            raise MeshError(f"line {node.line}: USE multiplies the scene beyond {_VISIT_ALLOWANCE} nodes")

    def _count(self, n_numbers: int, line: int) -> None:
        """Count numbers; raise MeshError if there are too many."""
        self.numbers_left -= n_numbers
        if self.numbers_left < 0:
            raise MeshError(f"line {line}: USE multiplies the scene beyond {_NUMBER_ALLOWANCE} numbers")

    def add(self, shape: Node, coordinates: Node | None, matrix: Float64Array) -> None:
        """Add a face set or a line set."""
        index = shape.numbers.get("coordIndex")
        if index is None or (values := index.integers()).size == 0:
            return
        if coordinates is None:
            raise MeshError(f"line {shape.line}: {shape.kind} has no coordinates")
        base, count = self._add_points(coordinates, matrix)
        self._count(len(values), shape.line)
        wrong = (values < -1) | (values >= count)
        if wrong.any():
            i = int(np.argmax(wrong))
            line = index.line_of(i)
            raise MeshError(f"line {line}: index {values[i]} is out of range, there are {count} points")
        inside = values != -1
        ends = np.flatnonzero(np.diff(inside.astype(np.int8), prepend=0, append=0))
        begins, sizes = ends[::2], ends[1::2] - ends[::2]
        if (sizes < 2).any():
            line = index.line_of(int(begins[np.argmax(sizes < 2)]))
            raise MeshError(f"line {line}: {shape.kind} needs at least 2 indices before each -1, got 1")
        corners = values[inside]
        if shape.kind == "IndexedLineSet":
            joined = (inside[:-1] & inside[1:]).nonzero()[0]
            corners = np.stack([values[joined], values[joined + 1]], axis=1).ravel()
            sizes = np.full(len(joined), 2)
        self.sizes.append(sizes)
        self.corners.append(corners + base)

    def _add_points(self, coordinates: Node, matrix: Float64Array) -> tuple[int, int]:
        """Return the index of the first transformed point and their number; sets of equal coordinates share points."""
        key = (id(coordinates), matrix.tobytes())
        if key not in self.point_ranges:
            points = coordinates.numbers.get("point", Numbers(coordinates.line, "")).floats(3)
            self._count(points.size, coordinates.line)
            if not np.array_equal(matrix, np.eye(4)):
                points = points @ matrix[:3, :3].T + matrix[:3, 3]
            self.point_ranges[key] = self.n_points, len(points)
            self.points.append(points)
            self.n_points += len(points)
        return self.point_ranges[key]

    def build(self) -> Mesh:
        """Return the mesh of all sets that were added."""
        if not self.corners:
            raise MeshError("no IndexedFaceSet and no IndexedLineSet with coordinates")
        sizes = np.concatenate(self.sizes)
        offsets = np.concatenate([[0], np.cumsum(sizes)])
        return Mesh.from_offsets(np.concatenate(self.points), offsets, np.concatenate(self.corners))


def _walk_vrml97(roots: list[Node], builder: _MeshBuilder) -> None:
    """Add the sets of a VRML 97 scene, in the order of the file."""
    pending = [(node, np.eye(4)) for node in reversed(roots)]
    while pending:
        node, matrix = pending.pop()
        builder.visit(node)
        children: list[Node] = []
        if node.kind in _SHAPE_SETS:
            builder.add(node, next(iter(node.nodes("coord")), None), matrix)
        elif node.kind == "Shape":
            children = node.nodes("geometry")
        elif node.kind == "Transform":
            matrix = matrix @ _make_matrix(node, "scale")
            children = node.nodes("children")
        elif node.kind in _VRML97_GROUPS:
            children = node.nodes("children")
        elif node.kind == "LOD":
            children = node.nodes("level")[:1]
        elif node.kind == "Switch":
            choices, which = node.nodes("choice"), node.integer("whichChoice", -1)
            children = choices[which : which + 1] if which >= 0 else []
        pending += [(child, matrix) for child in reversed(children)]


@dataclass(frozen=True)
class _TraversalState:
    """The state that VRML 1.0 nodes change for the nodes after them."""

    matrix: Float64Array
    coordinates: Node | None = None


def _walk_vrml1(roots: list[Node], builder: _MeshBuilder) -> None:
    """Add the sets of a VRML 1.0 scene; nodes change the state, and a separator restores it at its end."""
    state = _TraversalState(np.eye(4))
    # Entries are nodes to visit, or functions that restore the state.
    pending: list[Node | Callable[[_TraversalState], _TraversalState]] = [*reversed(roots)]
    while pending:
        node = pending.pop()
        if not isinstance(node, Node):
            state = node(state)
            continue
        builder.visit(node)
        children: list[Node] = []
        if node.kind in _SHAPE_SETS:
            builder.add(node, state.coordinates, state.matrix)
        elif node.kind == "Coordinate3":
            state = replace(state, coordinates=node)
        elif node.kind in ("Separator", "WWWAnchor"):
            pending.append(lambda _, saved=state: saved)  # type: ignore[misc]
            children = node.children
        elif node.kind == "TransformSeparator":
            pending.append(lambda last, saved=state: replace(last, matrix=saved.matrix))  # type: ignore[misc]
            children = node.children
        elif node.kind == "Group":
            children = node.children
        elif node.kind in ("LOD", "LevelOfDetail"):
            children = node.children[:1]
        elif node.kind == "Switch":
            which = node.integer("whichChild", -1)
            children = node.children if which == -3 else node.children[which : which + 1] if which >= 0 else []
        elif (local := _make_vrml1_matrix(node)) is not None:
            state = replace(state, matrix=state.matrix @ local)
        pending += reversed(children)


def _make_vrml1_matrix(node: Node) -> Float64Array | None:
    """Return the matrix of a VRML 1.0 transform node; None for any other node."""
    if node.kind in ("Transform", "Translation", "Rotation", "Scale"):
        return _make_matrix(node, "scaleFactor")
    if node.kind != "MatrixTransform":
        return None
    # VRML 1.0 has row vectors: the translation is in the last row.
    matrix = node.floats("matrix", tuple(np.eye(4).ravel())).reshape(4, 4).T
    if (matrix[3] != (0.0, 0.0, 0.0, 1.0)).any():
        raise MeshError(f"line {node.line}: a MatrixTransform must end its rows with 0 0 0 1")
    return matrix


def _make_matrix(node: Node, scale_name: str) -> Float64Array:
    """Return T C R Q S Q^-1 C^-1 of a node's translation, center, rotation, scale and scaleOrientation: (4, 4)."""
    center = node.floats("center", (0.0, 0.0, 0.0))
    rotation = _make_rotation(node, "rotation")
    scale_axes = _make_rotation(node, "scaleOrientation")
    matrix = np.eye(4)
    matrix[:3, :3] = rotation @ scale_axes @ np.diag(node.floats(scale_name, (1.0, 1.0, 1.0))) @ scale_axes.T
    matrix[:3, 3] = node.floats("translation", (0.0, 0.0, 0.0)) + center - matrix[:3, :3] @ center
    return matrix


def _make_rotation(node: Node, name: str) -> Float64Array:
    """Return the matrix of an axis and an angle in radians: (3, 3)."""
    *axis, angle = node.floats(name, (0.0, 0.0, 1.0, 0.0)).tolist()
    if angle == 0.0:
        return np.eye(3)
    if not any(axis):
        raise MeshError(f"line {node.numbers[name].line}: {name} by {angle} needs an axis that is not zero")
    return rotate(axis, angle)[:3, :3]
