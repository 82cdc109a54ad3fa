"""Parts of 3MF, whose XML lxml reads as it comes, without a tree: one takes thirty times the memory of its text.

Section numbers are those of the 3MF core specification 1.3.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._core.interrupts import defer_interrupts
from .._core.types import Float64Array
from ..errors import MeshError, MissingExtraError
from ..geometry.attributes import Attributes
from ..geometry.mesh import Mesh
from ._text import quote
from .limits import budget
from .threemf_properties import MEMBERS, Group, build_attributes, read_group

_CHUNK_BYTES = 1 << 16
MILLIMETRES = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
# Extensions that may be required: what they add is read, or leaves the triangles of each object as they are.
_KNOWN_EXTENSIONS = tuple(
    f"http://schemas.microsoft.com/3dmanufacturing/{name}/"
    for name in ("core", "material", "production", "beamlattice", "slice", "trianglesets")
)
_MODEL_RELATIONSHIP = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"

ObjectKey = tuple[str, str]
"""An object's part and id."""

_Properties = tuple[str | None, str | None, str | None, str | None]
"""The group of properties of a triangle, and the member of it for each corner."""


@dataclass
class Object:
    """A mesh, or components that name other objects."""

    name: str | None
    mesh: Mesh | None
    components: list[tuple[ObjectKey, Float64Array]]


@dataclass
class Package:
    """The objects of all parts that are needed, and what is built of them."""

    objects: dict[ObjectKey, Object] = field(default_factory=dict)
    items: list[tuple[ObjectKey, Float64Array, str | None]] = field(default_factory=list)
    unit: str = "millimeter"
    metadata: dict[str, str] = field(default_factory=dict)
    n_textures: int = 0
    n_slice_stacks: int = 0
    n_places: int = 0  # objects, components and items that it spells out

    def spell(self) -> None:
        """Count an object, a component or an item; raise MeshError for too many of them for a file of its size."""
        self.n_places += 1
        budget().require_parts(0, self.n_places)


@dataclass
class _OpenGroup:
    """A group of properties that has begun: where, and what it and its members say."""

    depth: int
    kind: str
    attributes: Mapping[str, str]
    members: list[tuple[str | None, ...]] = field(default_factory=list)


@dataclass
class _OpenObject:
    """An object that has begun: what it says, and the words of its first mesh, row by row."""

    attributes: Mapping[str, str]
    n_meshes: int = 0
    components: list[tuple[ObjectKey, Float64Array]] = field(default_factory=list)
    points: list[str | None] = field(default_factory=list)
    triangles: list[str | None] = field(default_factory=list)
    beams: list[str | None] = field(default_factory=list)
    properties: list[_Properties] = field(default_factory=list)


class _Reader:
    """What lxml calls for the elements of a part."""

    def __init__(self, part: str) -> None:
        self.part = part

    def doctype(self, *_: Any) -> None:
        """Raise MeshError: the format forbids a document type."""
        raise MeshError(f"part {quote(self.part)} declares a document type")

    def close(self) -> None:
        """Do nothing, which lxml asks for."""


class RelationshipReader(_Reader):
    """Finds the model part that a container starts with."""

    target: str | None = None

    def start(self, tag: str, attributes: Mapping[str, str]) -> None:
        """Begin an element."""
        is_model = _local_name(tag) == "Relationship" and attributes.get("Type") == _MODEL_RELATIONSHIP
        if is_model and self.target is None:
            self.target = attributes.get("Target") or None


class PartReader(_Reader):
    """Adds the objects of a part to a package, and of the first part the build."""

    def __init__(self, part: str, package: Package, *, is_root: bool) -> None:
        super().__init__(part)
        self.named: dict[str, str] = {}  # the parts that it names, by lower case
        self._package = package
        self._is_root = is_root
        self._path: list[str] = []
        self._groups: dict[str, Group] = {}
        self._group: _OpenGroup | None = None
        self._objects: list[_OpenObject] = []
        self._metadata: tuple[str, list[str]] | None = None

    def start(self, tag: str, attributes: Mapping[str, str], namespaces: Mapping[str | None, str]) -> None:
        """Begin an element, which declares these namespaces."""
        name, path, package = _local_name(tag), self._path, self._package
        if self._group is not None and len(path) == self._group.depth + 1:
            self._group.members.append(tuple(map(attributes.get, MEMBERS[self._group.kind])))
        path.append(name)
        if name in _OF_OBJECT:
            if self._objects:
                self._start_in_object(name, attributes, self._objects[-1])
        elif name == "object":
            package.spell()
            self._objects.append(_OpenObject(attributes))
        elif name in MEMBERS and self._group is None:
            self._group = _OpenGroup(len(path) - 1, name, attributes)
        elif name == "texture2d":
            package.n_textures += 1
        elif name == "slicestack":
            package.n_slice_stacks += 1
        elif self._is_root:
            self._start_in_root(name, attributes, namespaces)

    def _start_in_object(self, name: str, attributes: Mapping[str, str], found: _OpenObject) -> None:
        """Begin a part of an object, where it is one."""
        get, path = attributes.get, self._path
        if name == "mesh":
            found.n_meshes += path[-2] == "object"
        elif name == "component":
            if path[-3:-1] == ["object", "components"]:
                self._package.spell()
                found.components.append((self._name_object(attributes), self._read_transform(attributes)))
        elif found.n_meshes != 1:
            return
        elif name == "vertex":
            if path[-4:-1] == ["object", "mesh", "vertices"]:
                found.points += (get("x"), get("y"), get("z"))
        elif name == "triangle":
            if path[-4:-1] == ["object", "mesh", "triangles"]:
                found.triangles += (get("v1"), get("v2"), get("v3"))
                if self._groups:
                    found.properties.append((get("pid"), get("p1"), get("p2"), get("p3")))
        elif path[-5:-2] == ["object", "mesh", "beamlattice"]:
            found.beams += (get("v1"), get("v2"))

    def _start_in_root(self, name: str, attributes: Mapping[str, str], namespaces: Mapping[str | None, str]) -> None:
        """Begin what the first part alone has."""
        package = self._package
        if name == "item" and self._path[-2:-1] == ["build"]:
            package.spell()
            matrix = self._read_transform(attributes)
            package.items.append((self._name_object(attributes), matrix, attributes.get("partnumber")))
        elif name == "metadata":
            self._metadata = attributes.get("name") or "", []
        elif name == "model":
            _require_known_extensions(attributes.get("requiredextensions") or "", namespaces)
            package.unit = attributes.get("unit", "millimeter")
            if package.unit not in MILLIMETRES:
                raise MeshError(f"the unit must be one of {', '.join(MILLIMETRES)}, got {quote(package.unit)}")

    def data(self, text: str) -> None:
        """Take a piece of text."""
        if self._metadata is not None and self._path[-1] == "metadata":
            self._metadata[1].append(text)

    def end(self, _: str) -> None:
        """End an element."""
        name = self._path.pop()
        if self._group is not None:
            if len(self._path) == self._group.depth:
                group, self._group = self._group, None
                read = read_group(group.kind, group.attributes, group.members, self._groups)
                self._groups[group.attributes.get("id", "")] = read
        elif name == "object":
            found = self._objects.pop()
            key = self.part.lower(), str(found.attributes.get("id"))
            mesh = _build_mesh(found, self._groups) if found.n_meshes else None
            self._package.objects[key] = Object(found.attributes.get("name"), mesh, found.components)
        elif name == "metadata" and self._metadata is not None:
            key_of_text, texts = self._metadata
            self._package.metadata.setdefault(key_of_text, "".join(texts))
            self._metadata = None

    def _name_object(self, attributes: Mapping[str, str]) -> ObjectKey:
        """Return the object that a component or an item means, maybe in another part ("production extension")."""
        part = self.part
        path = next((value for key, value in attributes.items() if _local_name(key) == "path"), None)
        if path is not None:
            part = path.strip("/")
            self.named.setdefault(part.lower(), part)
        return part.lower(), str(attributes.get("objectid"))

    def _read_transform(self, attributes: Mapping[str, str]) -> Float64Array:
        """Return a matrix, which the file holds for row vectors, as twelve numbers (3.3)."""
        text = attributes.get("transform")
        matrix = np.eye(4)
        if text is None:
            return matrix
        where = f"part {quote(self.part)}: a transform must be"
        try:
            matrix[:3] = np.array([float(word) for word in text.split(maxsplit=12)]).reshape(4, 3).T
        except ValueError:
            raise MeshError(f"{where} 12 numbers, got {quote(text)}") from None
        if not np.isfinite(matrix).all():
            raise MeshError(f"{where} finite, got {quote(text)}")
        return matrix


_OF_OBJECT = frozenset({"beam", "component", "mesh", "triangle", "vertex"})


def parse_part(content: bytes, reader: _Reader) -> None:
    """Let a reader have the elements of its part, as they come; no other file is opened."""
    try:
        with defer_interrupts():
            from lxml import etree
    except ImportError:
        raise MissingExtraError("3MF needs lxml: pip install 'gpu_xform[3mf]'") from None
    budget().take_elements(content.count(b"<") - content.count(b"</"), content.count(b"="))
    # Undefined prefixes, which samples of the format itself have, are forgiven, and no other error.
    options = {"resolve_entities": False, "no_network": True, "load_dtd": False, "recover": True}
    parser = etree.XMLParser(target=reader, **options)
    try:
        for begin in range(0, len(content), _CHUNK_BYTES):
            parser.feed(content[begin : begin + _CHUNK_BYTES])
        parser.close()
    except etree.XMLSyntaxError as error:
        raise MeshError(f"part {quote(reader.part)} is not XML: {error}") from None
    for entry in parser.feed_error_log:
        if entry.domain_name != "NAMESPACE":
            raise MeshError(f"part {quote(reader.part)} is not XML: {entry.message.strip()}, line {entry.line}")


def _local_name(name: str) -> str:
    """Return a name without its namespace."""
    return name.rpartition("}")[2]


def _require_known_extensions(prefixes: str, namespaces: Mapping[str | None, str]) -> None:
    """Raise MeshError for an extension that the file says it cannot be read without (2.3.1), if it is unknown."""
    for prefix in prefixes.split():
        name = namespaces.get(prefix) or prefix
        if not name.startswith(_KNOWN_EXTENSIONS):
            raise MeshError(f"it requires the extension {quote(name)}, which cannot be read")


def _build_mesh(found: _OpenObject, groups: dict[str, Group]) -> Mesh:
    """Return the vertices, triangles and beams of an object (4.1), with their properties."""
    default = found.attributes.get("pid"), found.attributes.get("pindex")
    try:
        corners = np.array(found.triangles, dtype=np.int64).reshape(-1, 3)
        segments = np.array(found.beams, dtype=np.int64).reshape(-1, 2)
        attributes = _read_properties(groups, found.properties, default) if groups else None
        positions = np.array(found.points, dtype=np.float64).reshape(-1, 3)
        if not len(segments):
            return Mesh(positions, corners, attributes=attributes)
        offsets = np.concatenate([3 * np.arange(len(corners)), 3 * len(corners) + 2 * np.arange(len(segments) + 1)])
        mesh = Mesh.from_offsets(positions, offsets, np.concatenate([corners.ravel(), segments.ravel()]))
        return mesh if attributes is None else mesh.with_attributes(_append_rows(attributes, len(segments)))
    except (ValueError, TypeError, OverflowError) as error:
        reason = error if isinstance(error, MeshError) else "its coordinates and indices must be numbers"
        raise MeshError(f"object {quote(str(found.attributes.get('id')))}: {reason}") from None


def _read_properties(
    groups: dict[str, Group], rows: Sequence[_Properties], default: tuple[str | None, str | None]
) -> Attributes | None:
    """Return the attributes of triangles, of which each row holds a group and three members, or None (4.1.4)."""
    if default[0] is None and not any(row[1] is not None for row in rows):
        return None
    names = [row[0] or default[0] for row in rows]
    first = [default[1] if row[1] is None else row[1] for row in rows]
    members = [
        (one, one if row[2] is None else row[2], one if row[3] is None else row[3])
        for one, row in zip(first, rows, strict=True)
    ]
    numbers = [[-1 if member is None else int(member) for member in row] for row in members]
    return build_attributes(groups, names, np.array(numbers, np.int64).reshape(-1, 3))


def _append_rows(attributes: Attributes, n_segments: int) -> Attributes:
    """Return the attributes of triangles with rows for beams, which have none: white, or NaN, or -1."""
    tables = []
    for table, n_rows in ((attributes.corner, 2 * n_segments), (attributes.face, n_segments)):
        made: dict[str, Any] = {}
        for name, column in table.items():
            values = np.asarray(column)
            fill = {"u": 255, "i": -1}.get(values.dtype.kind, np.nan)
            made[name] = np.concatenate([values, np.full((n_rows, *values.shape[1:]), fill, values.dtype)])
        tables.append(made)
    return Attributes(corner=tables[0], face=tables[1], labels=attributes.labels)
