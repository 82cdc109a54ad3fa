"""3MF, a ZIP container of XML, read through lxml. Section numbers are those of the 3MF core specification 1.3."""

import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any

import numpy as np

from .._core.interrupts import defer_interrupts
from .._core.types import Float64Array
from ..errors import ArgumentError, MeshError, MissingExtraError
from ..geometry.attributes import Attributes
from ..geometry.mesh import Mesh
from ..geometry.nodes import Node
from ..geometry.scene import Scene
from ._text import quote
from .gltf import merge_scene
from .gltf_placements import make_names
from .limits import BYTES_PER_NODE, NODES_PER_NODE, budget
from .threemf_properties import GROUPS, Group, build_attributes, read_group

_MAX_BYTES = 1 << 30
_MAX_RATIO = 40  # 3MF's XML shrinks to a tenth or less; bombs to a thousandth
_MAX_ALLOWED_RATIO = 3  # of what it unpacks to, which copies of its objects are counted by
_MAX_DEPTH = 256
_MILLIMETRES = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
# Extensions that may be required: what they add is read, or leaves the triangles of each object as they are.
_KNOWN_EXTENSIONS = tuple(
    f"http://schemas.microsoft.com/3dmanufacturing/{name}/"
    for name in ("core", "material", "production", "beamlattice", "slice", "trianglesets")
)
_MODEL_RELATIONSHIP = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"

_Key = tuple[str, str]
"""An object's part and id."""

_Placed = tuple[_Key, Float64Array, str | None, int | None, int]
"""An object in its parent: its matrix, its name, the index of the parent, and how many objects it is in."""


@dataclass
class _Object:
    """A mesh, or components that name other objects."""

    name: str | None
    mesh: Mesh | None
    components: list[tuple[_Key, Float64Array]]


@dataclass
class _Package:
    """The objects of all parts that are needed, and what is built of them."""

    objects: dict[_Key, _Object] = field(default_factory=dict)
    items: list[tuple[_Key, Float64Array, str | None]] = field(default_factory=list)
    unit: str = "millimeter"
    metadata: dict[str, str] = field(default_factory=dict)
    n_textures: int = 0
    n_slice_stacks: int = 0
    n_places: int = 0  # objects, components and items that it spells out

    def spell(self, n_places: int) -> None:
        """Count objects, components or items before they are read; raise MeshError for too many for its size."""
        self.n_places += n_places
        budget().require_parts(0, self.n_places)


def read(data: bytes) -> Mesh:
    """Return all triangles, in millimetres, where the items of the build put them. Raises as `read_scene` does."""
    scene = read_scene(data)
    mesh = merge_scene(scene)
    held = scene.metadata["3mf"]
    holds = [*mesh.metadata.get("gltf", {}).get("holds", ()), *held.get("holds", ())]
    return mesh.with_attributes(mesh.attributes, metadata={"3mf": {**held, "holds": holds}})


def read_scene(data: bytes) -> Scene:
    """Return a node per item of the build and per component in it, in millimetres.

    Raises MeshError for a container that unpacks to more than 1 GiB or 40 times its size, MissingExtraError if the
    extra `3mf` is not installed.
    """
    try:
        with zipfile.ZipFile(BytesIO(data)) as container:
            unpacked = sum(entry.file_size for entry in container.infolist())
            if unpacked > _MAX_BYTES:
                raise MeshError(f"unpacks to {unpacked} bytes, more than the {_MAX_BYTES} that are allowed")
            budget().take_bytes(unpacked, _MAX_RATIO, "the container")
            package = _read_package({entry.filename.strip("/"): entry for entry in container.infolist()}, container)
            # Before more bytes are allowed: components may show as many nodes as a file of its size spells out.
            shown = max(package.n_places, min(NODES_PER_NODE * package.n_places, len(data) // BYTES_PER_NODE))
            budget().spell_nodes(-(-shown // NODES_PER_NODE))
            budget().allow_bytes(min(unpacked, _MAX_ALLOWED_RATIO * len(data)))
    except MeshError:
        raise
    except (zipfile.BadZipFile, ValueError, NotImplementedError, EOFError, OSError, RuntimeError, zlib.error) as error:
        raise MeshError(f"not a ZIP container: {error}") from None
    return _build_scene(package)


def _read_package(entries: dict[str, zipfile.ZipInfo], container: zipfile.ZipFile) -> _Package:
    """Return the objects of the model part, and of the parts that its components name."""
    package = _Package()
    by_lower_case = {name.lower(): name for name in entries}

    def open_part(part: str) -> bytes:
        name = by_lower_case.get(part.lower())
        if name is None:
            raise MeshError(f"the container has no part {quote(part)}")
        return _unpack(container, entries[name])

    root = _find_model(by_lower_case, open_part)
    waiting, seen = [root], {root.lower()}
    while waiting:
        part = waiting.pop()
        found = _read_part(part, open_part(part), package, is_root=part == root)
        new = sorted(found.keys() - seen)
        seen.update(new)
        waiting.extend(found[key] for key in new)
    return package


def _unpack(container: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bytes:
    """Return the content of a part; raise MeshError for a method of compression that OPC does not allow."""
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise MeshError(f"part {quote(entry.filename)} is compressed by method {entry.compress_type}, not by DEFLATE")
    with container.open(entry) as file:
        # With a size, for without one all is unpacked before it is cut to the size that the container declares. One
        # byte more, so that the end is met and the checksum compared.
        return file.read(entry.file_size + 1)


def _find_model(by_lower_case: dict[str, str], open_part: Any) -> str:
    """Return the part that the container starts with."""
    if "_rels/.rels" in by_lower_case:
        for element in _parse("_rels/.rels", open_part("_rels/.rels"), "Relationship"):
            if element.get("Type") == _MODEL_RELATIONSHIP and element.get("Target"):
                return str(element.get("Target")).strip("/")
    return "3D/3dmodel.model"


def _read_part(part: str, content: bytes, package: _Package, *, is_root: bool) -> dict[str, str]:
    """Add the objects of a part, and of the first part the build; return the parts that it names, by lower case."""
    named: dict[str, str] = {}
    groups: dict[str, Group] = {}
    for element in _parse(part, content, "model", "object", "build", "metadata", "texture2d", "slicestack", *GROUPS):
        tag = _local_name(element)
        if tag in GROUPS:
            groups[element.get("id", "")] = read_group(element, groups)
            del element[:]
        elif tag == "metadata" and is_root:
            package.metadata.setdefault(element.get("name") or "", element.text or "")
        elif tag == "texture2d":
            package.n_textures += 1
        elif tag == "slicestack":
            package.n_slice_stacks += 1
        elif tag == "object":
            identifier = element.get("id")
            package.spell(1 + sum(len(child) for child in element if _local_name(child) == "components"))
            mesh = next((child for child in element if _local_name(child) == "mesh"), None)
            components = [
                (_name_object(child, part, named), _read_transform(child, part))
                for group in element
                if _local_name(group) == "components"
                for child in group
                if _local_name(child) == "component"
            ]
            owner = f"object {quote(str(identifier))}"
            read = (
                None if mesh is None else _read_mesh(mesh, owner, groups, (element.get("pid"), element.get("pindex")))
            )
            package.objects[part.lower(), str(identifier)] = _Object(element.get("name"), read, components)
            for child in element:
                for group in child:
                    del group[:]  # while no child of it is an object of Python, which would make it slow
        elif tag == "build" and is_root:
            package.spell(len(element))
            for item in element:
                if _local_name(item) == "item":
                    key = _name_object(item, part, named)
                    package.items.append((key, _read_transform(item, part), item.get("partnumber")))
        elif tag == "model" and is_root:
            _require_known_extensions(element)
            package.unit = element.get("unit", "millimeter")
            if package.unit not in _MILLIMETRES:
                raise MeshError(f"the unit must be one of {', '.join(_MILLIMETRES)}, got {quote(package.unit)}")
    return named


def _parse(part: str, content: bytes, *tags: str) -> Iterator[Any]:
    """Yield the elements of these names, each when it ends; no other file is opened."""
    try:
        with defer_interrupts():
            from lxml import etree
    except ImportError:
        raise MissingExtraError("3MF needs lxml: pip install 'gpu_xform[3mf]'") from None
    budget().take_elements(content.count(b"<") - content.count(b"</"), content.count(b"="))
    # Undefined prefixes, which samples of the format itself have, are forgiven, and no other error.
    options = {"resolve_entities": False, "no_network": True, "load_dtd": False, "recover": True}
    context = etree.iterparse(BytesIO(content), tag=[f"{{*}}{tag}" for tag in tags], **options)
    try:
        for _, element in context:
            if element.getroottree().docinfo.internalDTD is not None:  # which the format forbids
                raise MeshError(f"part {quote(part)} declares a document type")
            yield element
    except etree.XMLSyntaxError as error:
        raise MeshError(f"part {quote(part)} is not XML: {error}") from None
    for entry in context.error_log:
        if entry.domain_name != "NAMESPACE":
            raise MeshError(f"part {quote(part)} is not XML: {entry.message}, line {entry.line}")


def _local_name(element: Any) -> str:
    """Return the name of an element without its namespace; comments have none."""
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


def _name_object(element: Any, part: str, named: dict[str, str]) -> _Key:
    """Return the object that a component or an item means, which may be in another part ("production extension")."""
    path = next((value for key, value in element.attrib.items() if key.rpartition("}")[2] == "path"), None)
    if path is not None:
        part = path.strip("/")
        named.setdefault(part.lower(), part)
    return part.lower(), str(element.get("objectid"))


def _read_transform(element: Any, part: str) -> Float64Array:
    """Return a matrix, which the file holds for row vectors, as twelve numbers (3.3)."""
    text = element.get("transform")
    matrix = np.eye(4)
    if text is None:
        return matrix
    try:
        matrix[:3] = np.array([float(word) for word in text.split()]).reshape(4, 3).T
    except ValueError:
        raise MeshError(f"part {quote(part)}: a transform must be 12 numbers, got {quote(text)}") from None
    if not np.isfinite(matrix).all():
        raise MeshError(f"part {quote(part)}: a transform must be finite, got {quote(text)}")
    return matrix


def _require_known_extensions(model: Any) -> None:
    """Raise MeshError for an extension that the file says it cannot be read without (2.3.1), if it is unknown."""
    namespaces = model.nsmap  # which lxml makes anew
    for prefix in (model.get("requiredextensions") or "").split():
        name = namespaces.get(prefix) or prefix
        if not name.startswith(_KNOWN_EXTENSIONS):
            raise MeshError(f"it requires the extension {quote(name)}, which cannot be read")


def _read_mesh(mesh: Any, owner: str, groups: dict[str, Group], default: tuple[str | None, str | None]) -> Mesh:
    """Return the vertices, triangles and beams of an object (4.1), with their properties.

    default : the group of properties, and the member of it, for triangles that name none
    """
    points: list[tuple[Any, ...]] = []
    triangles: list[tuple[Any, ...]] = []
    beams: list[tuple[Any, ...]] = []
    properties: list[tuple[Any, ...]] = []
    for group in mesh:
        name = _local_name(group)
        if name == "vertices":
            points += [(v.get("x"), v.get("y"), v.get("z")) for v in group if _local_name(v) == "vertex"]
        elif name == "triangles":
            elements = [t for t in group if _local_name(t) == "triangle"]
            triangles += [(t.get("v1"), t.get("v2"), t.get("v3")) for t in elements]
            properties += [(t.get("pid"), t.get("p1"), t.get("p2"), t.get("p3")) for t in elements] if groups else []
            del elements
        elif name == "beamlattice":
            beams += [(b.get("v1"), b.get("v2")) for part in group for b in part if _local_name(b) == "beam"]
    try:
        corners = np.array(triangles or np.empty((0, 3)), dtype=np.int64)
        segments = np.array(beams or np.empty((0, 2)), dtype=np.int64)
        attributes = _read_properties(groups, properties, default) if groups else None
        positions = np.array(points or np.empty((0, 3)), dtype=np.float64)
        if not len(segments):
            return Mesh(positions, corners, attributes=attributes)
        offsets = np.concatenate([3 * np.arange(len(corners)), 3 * len(corners) + 2 * np.arange(len(segments) + 1)])
        found = Mesh.from_offsets(positions, offsets, np.concatenate([corners.ravel(), segments.ravel()]))
        return found if attributes is None else found.with_attributes(_append_rows(attributes, len(segments)))
    except (ValueError, TypeError, OverflowError) as error:
        reason = error if isinstance(error, MeshError) else "its coordinates and indices must be numbers"
        raise MeshError(f"{owner}: {reason}") from None


def _read_properties(
    groups: dict[str, Group], rows: list[tuple[Any, ...]], default: tuple[str | None, str | None]
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


def _build_scene(package: _Package) -> Scene:
    """Return the items of the build as trees of nodes."""
    to_millimetres = np.diag([*[_MILLIMETRES[package.unit]] * 3, 1.0])
    placed: list[_Placed] = []
    waiting: list[_Placed] = [
        (key, to_millimetres @ matrix, name, None, 0) for key, matrix, name in reversed(package.items)
    ]
    above: dict[_Key, None] = {}  # the objects that the one at hand is in, from the outermost on
    while waiting:
        key, matrix, name, parent, depth = waiting.pop()
        while len(above) > depth:
            above.popitem()
        if key not in package.objects:
            raise MeshError(f"there is no object {quote(key[1])} in part {quote(key[0])}")
        if key in above:
            raise MeshError(f"object {quote(key[1])} is a component of itself")
        budget().require_depth(depth, _MAX_DEPTH)
        budget().take_nodes(1, "its components")
        found = package.objects[key]
        waiting += [(component, local, None, len(placed), depth + 1) for component, local in reversed(found.components)]
        placed.append((key, matrix, name or found.name, parent, depth))
        above[key] = None
    names = make_names([name for _, _, name, _, _ in placed], "item")
    scene = Scene(metadata={"3mf": _describe(package)})
    nodes: list[Node] = []
    for (key, matrix, _, parent, _), name in zip(placed, names, strict=True):
        try:
            nodes.append(scene.add(name=name, parent=None if parent is None else nodes[parent], transform=matrix))
        except ArgumentError as error:
            raise MeshError(str(error)) from None
        mesh = package.objects[key].mesh
        if mesh is not None and mesh.n_points:
            nodes[-1].show(mesh)
    return scene


def _describe(package: _Package) -> dict[str, Any]:
    """Return the unit and the metadata of a file, and words for what other formats would lose."""
    counts = (
        (len(package.metadata), "metadata entry", "metadata entries"),
        (package.n_textures, "texture", "textures"),
        (package.n_slice_stacks, "stack of slices", "stacks of slices"),
    )
    holds = [f"{count} {one if count == 1 else many}" for count, one, many in counts if count]
    described: dict[str, Any] = {"unit": package.unit}
    if package.metadata:
        described["metadata"] = package.metadata
    return {**described, "holds": holds} if holds else described
