"""3MF, a ZIP container of XML, read through lxml. Section numbers are those of the 3MF core specification 1.3."""

import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any

import numpy as np

from .._core.types import Float64Array
from ..errors import ArgumentError, MeshError, MissingExtraError
from ..geometry.mesh import Mesh
from ..geometry.scene import Node, Scene
from ._text import quote
from .gltf import merge_scene
from .gltf_placements import make_names

_MAX_BYTES = 1 << 30
_MAX_RATIO = 200  # 3MF's XML shrinks to a tenth or less; bombs to a thousandth
_MAX_NODES = 1 << 17  # components can name components, each several times
_MAX_DEPTH = 256
_MILLIMETRES = {"micron": 1e-3, "millimeter": 1.0, "centimeter": 10.0, "inch": 25.4, "foot": 304.8, "meter": 1000.0}
_MODEL_RELATIONSHIP = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"

_Key = tuple[str, str]
"""An object's part and id."""

_Placed = tuple[_Key, Float64Array, str | None, int | None, tuple[_Key, ...]]
"""An object in its parent: its matrix, its name, the index of the parent, and the objects that it is in."""


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


def read(data: bytes) -> Mesh:
    """Return all triangles, in millimetres, where the items of the build put them. Raises as `read_scene` does."""
    scene = read_scene(data)
    mesh = merge_scene(scene)
    holds = mesh.metadata.get("gltf", {}).get("holds", ())
    return mesh.with_attributes(mesh.attributes, metadata={"3mf": {**scene.metadata["3mf"], "holds": holds}})


def read_scene(data: bytes) -> Scene:
    """Return a node per item of the build and per component in it, in millimetres.

    Raises MeshError for a container that unpacks to more than 1 GiB or 200 times its size, MissingExtraError if the
    extra `3mf` is not installed.
    """
    try:
        with zipfile.ZipFile(BytesIO(data)) as container:
            unpacked = sum(entry.file_size for entry in container.infolist())
            most = min(_MAX_BYTES, _MAX_RATIO * len(data))
            if unpacked > most:
                raise MeshError(f"unpacks to {unpacked} bytes, more than the {most} that are allowed")
            package = _read_package({entry.filename.strip("/"): entry for entry in container.infolist()}, container)
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
        return container.read(entries[name])

    root = _find_model(by_lower_case, open_part)
    waiting, seen = [root], {root}
    while waiting:
        part = waiting.pop()
        found = _read_part(part, open_part(part), package, is_root=part == root)
        new = sorted(found - seen)
        seen.update(new)
        waiting.extend(new)
    return package


def _find_model(by_lower_case: dict[str, str], open_part: Any) -> str:
    """Return the part that the container starts with."""
    if "_rels/.rels" in by_lower_case:
        for element in _parse("_rels/.rels", open_part("_rels/.rels"), "Relationship"):
            if element.get("Type") == _MODEL_RELATIONSHIP and element.get("Target"):
                return str(element.get("Target")).strip("/")
    return "3D/3dmodel.model"


def _read_part(part: str, content: bytes, package: _Package, *, is_root: bool) -> set[str]:
    """Add the objects of a part, and of the first part the build; return the other parts that it names."""
    named: set[str] = set()
    for element in _parse(part, content, "model", "object", "build"):
        tag = _local_name(element)
        if tag == "object":
            identifier = element.get("id")
            mesh = next((child for child in element if _local_name(child) == "mesh"), None)
            components = [
                (_name_object(child, part, named), _read_transform(child, part))
                for group in element
                if _local_name(group) == "components"
                for child in group
                if _local_name(child) == "component"
            ]
            owner = f"object {quote(str(identifier))}"
            read = None if mesh is None else _read_mesh(mesh, owner)
            package.objects[part.lower(), str(identifier)] = _Object(element.get("name"), read, components)
            element.clear()
        elif tag == "build" and is_root:
            for item in element:
                if _local_name(item) == "item":
                    key = _name_object(item, part, named)
                    package.items.append((key, _read_transform(item, part), item.get("partnumber")))
        elif tag == "model" and is_root:
            package.unit = element.get("unit", "millimeter")
            if package.unit not in _MILLIMETRES:
                raise MeshError(f"the unit must be one of {', '.join(_MILLIMETRES)}, got {quote(package.unit)}")
    return named


def _parse(part: str, content: bytes, *tags: str) -> Iterator[Any]:
    """Yield the elements of these names, each when it ends; no other file is opened."""
    try:
        from lxml import etree
    except ImportError:
        raise MissingExtraError("3MF needs lxml: pip install 'gpu_xform[3mf]'") from None
    options = {"resolve_entities": False, "no_network": True, "load_dtd": False}
    try:
        for _, element in etree.iterparse(BytesIO(content), tag=[f"{{*}}{tag}" for tag in tags], **options):
            if element.getroottree().docinfo.internalDTD is not None:  # which the format forbids
                raise MeshError(f"part {quote(part)} declares a document type")
            yield element
    except etree.XMLSyntaxError as error:
        raise MeshError(f"part {quote(part)} is not XML: {error}") from None


def _local_name(element: Any) -> str:
    """Return the name of an element without its namespace; comments have none."""
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


def _name_object(element: Any, part: str, named: set[str]) -> _Key:
    """Return the object that a component or an item means, which may be in another part ("production extension")."""
    path = next((value for key, value in element.attrib.items() if key.rpartition("}")[2] == "path"), None)
    if path is not None:
        part = path.strip("/")
        named.add(part)
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


def _read_mesh(mesh: Any, owner: str) -> Mesh:
    """Return the vertices and triangles of an object (4.1)."""
    rows: dict[str, list[tuple[Any, Any, Any]]] = {"vertices": [], "triangles": []}
    for group in mesh:
        name = _local_name(group)
        if name == "vertices":
            rows[name] += [(v.get("x"), v.get("y"), v.get("z")) for v in group if _local_name(v) == "vertex"]
        elif name == "triangles":
            rows[name] += [(t.get("v1"), t.get("v2"), t.get("v3")) for t in group if _local_name(t) == "triangle"]
    try:
        points = np.array(rows["vertices"] or np.empty((0, 3)), dtype=np.float64)
        triangles = np.array(rows["triangles"] or np.empty((0, 3)), dtype=np.int64)
        return Mesh(points, triangles)
    except (ValueError, TypeError, OverflowError) as error:
        reason = error if isinstance(error, MeshError) else "its coordinates and indices must be numbers"
        raise MeshError(f"{owner}: {reason}") from None


def _build_scene(package: _Package) -> Scene:
    """Return the items of the build as trees of nodes."""
    to_millimetres = np.diag([*[_MILLIMETRES[package.unit]] * 3, 1.0])
    placed: list[_Placed] = []
    waiting: list[_Placed] = [
        (key, to_millimetres @ matrix, name, None, ()) for key, matrix, name in reversed(package.items)
    ]
    while waiting:
        key, matrix, name, parent, above = waiting.pop()
        if key not in package.objects:
            raise MeshError(f"there is no object {quote(key[1])} in part {quote(key[0])}")
        if key in above:
            raise MeshError(f"object {quote(key[1])} is a component of itself")
        if len(above) == _MAX_DEPTH:
            raise MeshError(f"its components are more than {_MAX_DEPTH} deep")
        if len(placed) == _MAX_NODES:
            raise MeshError(f"its items have more than the {_MAX_NODES} components that are allowed")
        found = package.objects[key]
        waiting += [
            (component, local, None, len(placed), (*above, key)) for component, local in reversed(found.components)
        ]
        placed.append((key, matrix, name or found.name, parent, above))
    names = make_names([name for _, _, name, _, _ in placed], "item")
    scene = Scene(metadata={"3mf": {"unit": package.unit}})
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
