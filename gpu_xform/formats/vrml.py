"""VRML 1.0 and VRML 97 (`.wrl`): the face sets and line sets, where the transforms above them put them.

Primitives (Box, Sphere, ...), text, prototypes, scripts and inlined files are passed over.
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
from ._text import printable
from .vrml_syntax import Node, Numbers, parse_nodes

_MOST_DECOMPRESSED_BYTES = 1 << 28
# USE can make a short file mean an endless scene: what may be drawn beyond what the file itself spells out.
_SPARE_NUMBERS = 1 << 25
_SPARE_VISITS = 1 << 18
_GROUPS_97 = {"Group", "Anchor", "Billboard", "Collision"}
_SETS = {"IndexedFaceSet", "IndexedLineSet"}


def read(data: bytes) -> Mesh:
    """Return the mesh of a VRML file, gzip-compressed or not.

    Raises MeshError with the line of whatever is malformed, for more than 256 MiB of compressed text, and where USE
    multiplies the scene without bound.
    """
    if data.startswith(b"\x1f\x8b"):
        data = _decompress(data)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    header = text.lstrip().split("\n", 1)[0].split()
    if header[:2] == ["#VRML", "V1.0"]:
        walk: Callable[[list[Node], _Scene], None] = _walk_1
    elif header[:2] == ["#VRML", "V2.0"]:
        walk = _walk_97
    else:
        got = printable(" ".join(header))
        raise MeshError(f"line 1: expected '#VRML V1.0 ascii' or '#VRML V2.0 utf8', got {got}")
    scene = _Scene(_SPARE_NUMBERS + len(data), _SPARE_VISITS + len(data))
    walk(parse_nodes(text), scene)
    return scene.mesh()


def _decompress(data: bytes) -> bytes:
    try:
        with gzip.GzipFile(fileobj=BytesIO(data)) as file:
            text = file.read(_MOST_DECOMPRESSED_BYTES + 1)
    except (EOFError, OSError, zlib.error) as error:
        raise MeshError(f"the gzip compression is damaged: {error}") from None
    if len(text) > _MOST_DECOMPRESSED_BYTES:
        raise MeshError(f"decompresses to more than {_MOST_DECOMPRESSED_BYTES} bytes")
    return text


@dataclass
class _Scene:
    """What has been drawn so far, and how much more may be."""

    numbers_left: int
    visits_left: int
    points: list[Float64Array] = field(default_factory=list)
    sizes: list[IndexArray] = field(default_factory=list)
    corners: list[IndexArray] = field(default_factory=list)
    n_points: int = 0
    placed: dict[tuple[int, bytes], tuple[int, int]] = field(default_factory=dict)

    def visit(self, node: Node) -> None:
        """Count a visit to a node; raise MeshError where there are too many."""
        self.visits_left -= 1
        if self.visits_left < 0:
            raise MeshError(f"line {node.line}: USE multiplies the scene beyond {_SPARE_VISITS} nodes")

    def _count(self, n_numbers: int, line: int) -> None:
        """Count numbers drawn; raise MeshError where there are too many."""
        self.numbers_left -= n_numbers
        if self.numbers_left < 0:
            raise MeshError(f"line {line}: USE multiplies the scene beyond {_SPARE_NUMBERS} numbers")

    def draw(self, shape: Node, coordinates: Node | None, matrix: Float64Array) -> None:
        """Add a face set or a line set."""
        index = shape.numbers.get("coordIndex")
        if index is None or (values := index.integers()).size == 0:
            return
        if coordinates is None:
            raise MeshError(f"line {shape.line}: {shape.kind} has no coordinates")
        base, count = self._place(coordinates, matrix)
        self._count(len(values), shape.line)
        wrong = (values < -1) | (values >= count)
        if wrong.any():
            place = int(np.argmax(wrong))
            line = index.line_of(place)
            raise MeshError(f"line {line}: index {values[place]} is out of range, there are {count} points")
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

    def _place(self, coordinates: Node, matrix: Float64Array) -> tuple[int, int]:
        """Return the first of the transformed points and their number; sets that share coordinates share points."""
        key = (id(coordinates), matrix.tobytes())
        if key not in self.placed:
            points = coordinates.numbers.get("point", Numbers(coordinates.line, "")).floats(3)
            self._count(points.size, coordinates.line)
            if not np.array_equal(matrix, np.eye(4)):
                points = points @ matrix[:3, :3].T + matrix[:3, 3]
            self.placed[key] = self.n_points, len(points)
            self.points.append(points)
            self.n_points += len(points)
        return self.placed[key]

    def mesh(self) -> Mesh:
        """Return all that was drawn."""
        if not self.corners:
            raise MeshError("no IndexedFaceSet and no IndexedLineSet with coordinates")
        sizes = np.concatenate(self.sizes)
        offsets = np.concatenate([[0], np.cumsum(sizes)])
        return Mesh.from_offsets(np.concatenate(self.points), offsets, np.concatenate(self.corners))


def _walk_97(roots: list[Node], scene: _Scene) -> None:
    """Draw a VRML 97 scene, in the order of the file."""
    pending = [(node, np.eye(4)) for node in reversed(roots)]
    while pending:
        node, matrix = pending.pop()
        scene.visit(node)
        children: list[Node] = []
        if node.kind in _SETS:
            scene.draw(node, next(iter(node.nodes("coord")), None), matrix)
        elif node.kind == "Shape":
            children = node.nodes("geometry")
        elif node.kind == "Transform":
            matrix = matrix @ _placement(node, "scale")
            children = node.nodes("children")
        elif node.kind in _GROUPS_97:
            children = node.nodes("children")
        elif node.kind == "LOD":
            children = node.nodes("level")[:1]
        elif node.kind == "Switch":
            choices, which = node.nodes("choice"), node.integer("whichChoice", -1)
            children = choices[which : which + 1] if which >= 0 else []
        pending += [(child, matrix) for child in reversed(children)]


@dataclass(frozen=True)
class _State:
    """What VRML 1.0 nodes hand on to the nodes after them."""

    matrix: Float64Array
    coordinates: Node | None = None


def _walk_1(roots: list[Node], scene: _Scene) -> None:
    """Draw a VRML 1.0 scene: nodes change the state for those after them, and a separator restores it at its end."""
    state = _State(np.eye(4))
    # Entries are a node to visit, or what restores the state.
    pending: list[Node | Callable[[_State], _State]] = [*reversed(roots)]
    while pending:
        node = pending.pop()
        if not isinstance(node, Node):
            state = node(state)
            continue
        scene.visit(node)
        children: list[Node] = []
        if node.kind in _SETS:
            scene.draw(node, state.coordinates, state.matrix)
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
        elif (local := _local_1(node)) is not None:
            state = replace(state, matrix=state.matrix @ local)
        pending += reversed(children)


def _local_1(node: Node) -> Float64Array | None:
    """Return the matrix of a VRML 1.0 transform node, None for another node."""
    if node.kind in ("Transform", "Translation", "Rotation", "Scale"):
        return _placement(node, "scaleFactor")
    if node.kind != "MatrixTransform":
        return None
    # Row vectors: translation in the last row.
    matrix = node.floats("matrix", tuple(np.eye(4).ravel())).reshape(4, 4).T
    if (matrix[3] != (0.0, 0.0, 0.0, 1.0)).any():
        raise MeshError(f"line {node.line}: a MatrixTransform must end its rows with 0 0 0 1")
    return matrix


def _placement(node: Node, scale_name: str) -> Float64Array:
    """Return T C R Q S Q^-1 C^-1 of a node's translation, center, rotation, scale and scaleOrientation: (4, 4)."""
    center = node.floats("center", (0.0, 0.0, 0.0))
    turn = _rotation(node, "rotation")
    skew = _rotation(node, "scaleOrientation")
    matrix = np.eye(4)
    matrix[:3, :3] = turn @ skew @ np.diag(node.floats(scale_name, (1.0, 1.0, 1.0))) @ skew.T
    matrix[:3, 3] = node.floats("translation", (0.0, 0.0, 0.0)) + center - matrix[:3, :3] @ center
    return matrix


def _rotation(node: Node, name: str) -> Float64Array:
    """Return the matrix of an axis and an angle in radians: (3, 3)."""
    *axis, angle = node.floats(name, (0.0, 0.0, 1.0, 0.0)).tolist()
    if angle == 0.0:
        return np.eye(3)
    if not any(axis):
        raise MeshError(f"line {node.numbers[name].line}: {name} by {angle} needs an axis that is not zero")
    return rotate(axis, angle)[:3, :3]
