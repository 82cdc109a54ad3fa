"""VRML 1.0 and VRML 97 (`.wrl`): the shapes, moved by the transforms above them.

Prototypes are expanded, and files beside this one that it names are read. Nodes of both versions may stand in one file.
What holds geometry and cannot be shown, such as text, is counted and named in one warning.
"""

import gzip
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from typing import TypeAlias

from .._core.error_context import prefix_errors
from .._core.git_lfs import POINTER_WORDS, is_lfs_pointer
from .._core.types import Float64Array
from ..errors import MeshError
from ..geometry.mesh import Mesh
from ._beside import find_beside
from ._text import plain_text, quote
from .limits import budget, spend_own
from .vrml_attributes import NO_APPEARANCE, Appearance
from .vrml_builder import KnownAppearance, MeshBuilder, State
from .vrml_names import ITSELF
from .vrml_nodes import PlacedNode
from .vrml_primitives import PRIMITIVES
from .vrml_syntax import parse_nodes
from .vrml_transforms import make_matrix, read_matrix

_MAX_DECOMPRESSED_BYTES = 1 << 28
_MAX_GZIP_RATIO = 100  # text shrinks to a twentieth at best, bombs to a thousandth
_GROUPS = {"Group", "Anchor", "Billboard", "Collision", "StaticGroup", "Separator", "WWWAnchor"}
_INDEXED = {"IndexedFaceSet", "IndexedLineSet"}
_INLINES = {"Inline": "url", "WWWInline": "name"}
# Where nodes of unknown kinds keep what they show.
_CHILD_FIELDS = ("children", "humanoidBody", "skeleton")
# Nodes that show nothing themselves.
_SILENT_KINDS = """
Appearance Arc AudioClip Background BackgroundColor BaseColor Color ColorInterpolator Coordinate
CoordinateInterpolator CylinderSensor DirectionalLight Environment Fog FontStyle ImageTexture Info Label LightModel
Material MaterialBinding MovieTexture NavigationInfo Normal NormalBinding NormalInterpolator OrientationInterpolator
OrthographicCamera PerspectiveCamera PixelTexture PlaneSensor PointLight PositionInterpolator ProximitySensor
ScalarInterpolator SceneInfo Script Sound SphereSensor SpotLight Texture2 Texture2Transform TextureCoordinate
TextureCoordinate2 TextureTransform TimeSensor TouchSensor Units Viewpoint VisibilitySensor WorldInfo
"""
# Nodes that may change the state for what follows.
_CHANGE_KINDS = """
Coordinate3 Material MaterialBinding MatrixTransform Normal NormalBinding Rotation Scale ShapeHints Texture2
TextureCoordinate2 Transform Translation
"""
_CHANGES = frozenset(_CHANGE_KINDS.split())
_SILENT = frozenset(_SILENT_KINDS.split())


def read(data: bytes, folder: Path | None = None) -> Mesh:
    """Return the mesh of a VRML file, gzip-compressed or not.

    folder : where files that it names may lie

    Raises MeshError with the line of malformed content, for text that unpacks to more than 100 times its bytes, and if
    USE multiplies the scene beyond the budget of the file. Warns of what holds geometry and is not shown.
    """
    with spend_own(len(data)):
        roots, is_vrml1 = _parse(data)
        builder = MeshBuilder()
        _walk(roots, builder, _Inlines(folder), State(is_vrml1=is_vrml1, folder=folder))
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


@dataclass
class _Inlines:
    """The files that a file names, each parsed once."""

    root: Path | None
    parsed: dict[Path, tuple[list[PlacedNode], bool]] = field(default_factory=dict)
    found: dict[tuple[PlacedNode, Path | None], Path | None] = field(default_factory=dict)

    def find(self, node: PlacedNode, folder: Path | None) -> Path | None:
        """Return the first file beside the model that a node names."""
        if (node, folder) not in self.found:
            self.found[node, folder] = self._find(node.words(_INLINES[node.kind]), folder)
        return self.found[node, folder]

    def _find(self, names: list[str], folder: Path | None) -> Path | None:
        plain = [name.partition("#")[0].removeprefix("file:") for name in names]
        paths = (find_beside(self.root, folder, name) for name in plain if name)
        return next((path for path in paths if path is not None), None)

    def parse(self, path: Path) -> tuple[list[PlacedNode], bool]:
        """Return the nodes at the top of a file, and whether it is of VRML 1.0."""
        if path not in self.parsed:
            data = budget().read_beside(path)
            with prefix_errors(path.name):
                if is_lfs_pointer(data):
                    raise MeshError(POINTER_WORDS)
                self.parsed[path] = _parse(data)
        return self.parsed[path]


_Entry: TypeAlias = PlacedNode | Callable[[State], State]


def _walk(roots: list[PlacedNode], builder: MeshBuilder, inlines: _Inlines, state: State) -> None:
    """Add the shapes of a scene, in the order of the file. Nodes change the state, groups restore it at their end."""
    pending: list[_Entry] = [*reversed(roots)]
    while pending:
        entry = pending.pop()
        if not isinstance(entry, PlacedNode):
            builder.depth -= 1
            state = entry(state)
            continue
        node = entry.expanded(builder.budget.take_nodes)
        if node is None:
            continue
        if _add_shape(node, builder, state):
            continue
        if node.node.kind in _CHANGES and (changed := _change_state(node, builder, state)) is not None:
            state = changed
            continue
        children, inner = _enter(node, builder, inlines, state)
        if node.kind == "TransformSeparator" or inner is not None:
            builder.depth += 1
            budget().require_depth(builder.depth)
        if node.kind == "TransformSeparator":
            pending.append(lambda last, saved=state: last._replace(placement=saved.placement))  # type: ignore[misc]
        elif inner is not None:
            pending.append(lambda _, saved=state: saved)  # type: ignore[misc]
            state = inner
        pending += reversed(children)


def _add_shape(node: PlacedNode, builder: MeshBuilder, state: State) -> bool:
    """Add a node that is a shape; return whether it is one."""
    kind = node.node.kind
    if kind in _INDEXED or kind == "PointSet":
        own = node.first("coord")
        coordinates = state.coordinates if own is None else own.expanded(builder.budget.take_nodes)
        if kind in _INDEXED:
            builder.add_indexed(node, coordinates, state)
        elif coordinates is not None:
            builder.add_point_set(node, coordinates, state)
    elif kind in PRIMITIVES or kind == "Extrusion":
        builder.add_primitive(node, state)
    else:
        return False
    return True


def _change_state(node: PlacedNode, builder: MeshBuilder, state: State) -> State | None:
    """Return the state after a node that changes it for what follows; None for other nodes."""
    match node.node.kind:
        case "Coordinate3":
            return state._replace(coordinates=node)
        case "ShapeHints":
            return state._replace(is_clockwise=node.once(_says_clockwise))
        case "Translation" | "Rotation" | "Scale":
            return state.then(node.once(_make_matrix_1))
        case "Transform":
            is_group = not state.is_vrml1 or node.first("children") is not None
            return None if is_group else state.then(node.once(_make_matrix_1))
        case "MatrixTransform":
            return None if node.first("children") is not None else state.then(node.once(read_matrix))
    appearance = _change_appearance(node, state.appearance) if state.is_vrml1 else None
    return None if appearance is None else state.with_appearance(builder.share(appearance))


def _make_matrix_1(node: PlacedNode) -> Float64Array:
    return make_matrix(node, "scaleFactor")


def _make_matrix_97(node: PlacedNode) -> Float64Array:
    return make_matrix(node, "scale" if node.kind != "Transform" or "scale" in node.node.fields else "scaleFactor")


def _says_clockwise(node: PlacedNode) -> bool:
    return node.words("vertexOrdering") == ["CLOCKWISE"]


def _change_appearance(node: PlacedNode, appearance: Appearance) -> Appearance | None:
    """Return the appearance after a node of VRML 1.0 that changes it; None for other nodes."""
    match node.node.kind:
        case "Material":
            return replace(appearance, material=node)
        case "MaterialBinding":
            return replace(appearance, material_binding=_read_binding(node))
        case "Normal":
            return replace(appearance, normal=node)
        case "NormalBinding":
            return replace(appearance, normal_binding=_read_binding(node))
        case "TextureCoordinate2":
            return replace(appearance, texcoord=node)
        case "Texture2":
            return replace(appearance, texture=node)
    return None


def _read_binding(node: PlacedNode) -> str:
    binding = node.first_word("value")
    return "DEFAULT" if binding is None else binding


def _read_appearance(shape: PlacedNode, builder: MeshBuilder) -> Appearance:
    """Return how the geometry of a Shape of VRML 97 looks; shapes that USE one node share it."""
    placed = shape.first("appearance")
    if placed is None:
        return NO_APPEARANCE
    # Shapes of one body count its nodes once; when the body is shown again, they are counted again.
    n_entered = 0 if placed.scope is None else placed.scope.n_entered
    known = builder.appearances_of_nodes.get(id(placed.node))
    if known is not None and known.placed.scope is placed.scope and known.n_entered == n_entered:
        return known.appearance
    node = placed.expanded(builder.budget.take_nodes)
    if node is None:
        return NO_APPEARANCE
    material, texture = _read_style(node, "material", builder), _read_style(node, "texture", builder)
    appearance = builder.share(Appearance(material=material, texture=texture))
    builder.appearances_of_nodes[id(placed.node)] = KnownAppearance(placed, n_entered, appearance)
    return appearance


def _read_style(appearance: PlacedNode, name: str, builder: MeshBuilder) -> PlacedNode | None:
    """Return the material or the texture of an Appearance, None if it has none."""
    placed = appearance.first(name)
    node = None if placed is None else placed.expanded(builder.budget.take_nodes)
    return None if node is None else node.settled()


def _enter(
    node: PlacedNode, builder: MeshBuilder, inlines: _Inlines, state: State
) -> tuple[list[PlacedNode], State | None]:
    """Return what a node shows, and the state inside it; None if what it changes lasts beyond its end."""
    is_scoped = not state.is_vrml1
    match node.kind:
        case "Shape":
            shown, appearance = node.nodes("geometry") + node.nodes("children"), _read_appearance(node, builder)
            return shown, state if appearance is state.appearance else state.with_appearance(appearance)
        case "Transform":
            return node.nodes("children"), state.then(node.once(_make_matrix_97))
        case "Separator":
            return node.nodes("children"), state._replace(is_vrml1=True)
        case "TransformSeparator":
            return node.nodes("children"), None
        case "Group":
            return node.nodes("children"), state if is_scoped else None
        case "LOD" | "LevelOfDetail":
            return node.once(_choose_level), state if is_scoped else None
        case "Switch":
            return node.once(_choose), state if is_scoped else None
        case kind if kind in _GROUPS:
            return node.nodes("children"), state
        case kind if kind in _INLINES:
            return _read_inline(node, builder, inlines, state)
        case kind if kind in _SILENT:
            return [], None
    children = [child for name in _CHILD_FIELDS for child in node.nodes(name)]
    if not children:
        builder.left_out[_describe(node)] += 1
        return [], None
    builder.as_groups[_describe(node)] += 1
    return children, state.then(node.once(_make_matrix_97))


def _describe(node: PlacedNode) -> str:
    if node.node.prototype is ITSELF:
        return f"{node.kind} (a part of itself)"
    return f"{node.kind} (EXTERNPROTO)" if node.node.prototype else node.kind


def _choose_level(node: PlacedNode) -> list[PlacedNode]:
    level = node.first("level") or node.first("children")
    return [] if level is None else [level]


def _choose(node: PlacedNode) -> list[PlacedNode]:
    """Return the choice of a Switch; by default, none."""
    choices = node.nodes("choice") or node.nodes("children")
    which = node.integer("whichChoice", node.integer("whichChild", -1))
    if which == -3 and "whichChild" in node.node.fields:
        return choices
    return choices[which : which + 1] if which >= 0 else []


def _read_inline(
    node: PlacedNode, builder: MeshBuilder, inlines: _Inlines, state: State
) -> tuple[list[PlacedNode], State | None]:
    """Return the nodes of a file that lies beside this one, and the state for them."""
    path = inlines.find(node, state.folder)
    if path is None or path in state.inlined:
        why = "not a file beside it" if path is None else "of itself"
        name = node.first_word(_INLINES[node.kind])
        builder.left_out[f"{node.kind} ({why}: {'no name' if name is None else quote(name)})"] += 1
        return [], None
    roots, is_vrml1 = inlines.parse(path)
    inlined = (*state.inlined, path)
    return roots, State(state.placement, is_vrml1=is_vrml1, folder=path.parent, inlined=inlined)
