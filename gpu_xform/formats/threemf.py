"""3MF, a ZIP container of XML. Section numbers are those of the 3MF core specification 1.3."""

import zipfile
import zlib
from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np

from .._core.types import Float64Array
from ..errors import ArgumentError, MeshError
from ..geometry.mesh import Mesh
from ..geometry.nodes import Node
from ..geometry.scene import Scene
from ._text import quote
from .gltf import merge_scene
from .gltf_placements import make_names
from .limits import BYTES_PER_NODE, NODES_PER_NODE, budget
from .threemf_parts import MILLIMETRES, ObjectKey, Package, PartReader, RelationshipReader, parse_part

_MAX_BYTES = 1 << 30
_MAX_RATIO = 40  # 3MF's XML shrinks to a tenth or less; bombs to a thousandth
_MAX_DEPTH = 256

_Placed = tuple[ObjectKey, Float64Array, str | None, int | None, int]
"""An object in its parent: its matrix, its name, the index of the parent, and how many objects it is in."""


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
            # Components may show as many nodes as a file of its size spells out, compressed as it is.
            shown = max(package.n_places, min(NODES_PER_NODE * package.n_places, len(data) // BYTES_PER_NODE))
            budget().spell_nodes(-(-shown // NODES_PER_NODE))
    except MeshError:
        raise
    except (zipfile.BadZipFile, ValueError, NotImplementedError, EOFError, OSError, RuntimeError, zlib.error) as error:
        raise MeshError(f"not a ZIP container: {error}") from None
    return _build_scene(package)


def _read_package(entries: dict[str, zipfile.ZipInfo], container: zipfile.ZipFile) -> Package:
    """Return the objects of the model part, and of the parts that its components name."""
    package = Package()
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
        reader = PartReader(part, package, is_root=part == root)
        parse_part(open_part(part), reader)
        new = sorted(reader.named.keys() - seen)
        seen.update(new)
        waiting.extend(reader.named[key] for key in new)
    return package


def _unpack(container: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bytes:
    """Return the content of a part; raise MeshError for a method of compression that OPC does not allow."""
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise MeshError(f"part {quote(entry.filename)} is compressed by method {entry.compress_type}, not by DEFLATE")
    with container.open(entry) as file:
        # With a size, for without one all is unpacked before it is cut to the size that the container declares. One
        # byte more, so that the end is met and the checksum compared.
        return file.read(entry.file_size + 1)


def _find_model(by_lower_case: dict[str, str], open_part: Callable[[str], bytes]) -> str:
    """Return the part that the container starts with."""
    if "_rels/.rels" in by_lower_case:
        found = RelationshipReader("_rels/.rels")
        parse_part(open_part("_rels/.rels"), found)
        if found.target is not None:
            return found.target.strip("/")
    return "3D/3dmodel.model"


def _build_scene(package: Package) -> Scene:
    """Return the items of the build as trees of nodes."""
    to_millimetres = np.diag([*[MILLIMETRES[package.unit]] * 3, 1.0])
    placed: list[_Placed] = []
    waiting: list[_Placed] = [
        (key, to_millimetres @ matrix, name, None, 0) for key, matrix, name in reversed(package.items)
    ]
    above: dict[ObjectKey, None] = {}  # the objects that the one at hand is in, from the outermost on
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


def _describe(package: Package) -> dict[str, Any]:
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
