"""The nodes of a glTF document, as a scene. Section numbers are those of the glTF 2.0 specification."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.deformable_mesh import DeformableMesh, Skin
from ..geometry.mesh import Mesh
from ..geometry.nodes import as_read_only, share_instances
from ..geometry.scene import Scene
from ..geometry.scene_animation import rotation_from_quaternion
from ._text import quote
from .gltf_accessors import Accessors, get_count
from .gltf_animations import read_animations
from .gltf_document import Document, guess_type, read_image
from .gltf_meshes import Primitive
from .gltf_placements import local_matrix, make_names
from .limits import budget

_REBUILT = frozenset(
    {"accessors", "animations", "buffers", "bufferViews", "meshes", "nodes", "scene", "scenes", "skins"}
)
_OF_NODES = frozenset({"children", "matrix", "mesh", "name", "rotation", "scale", "skin", "translation", "weights"})
# Extensions whose content becomes that of the scene.
_UNPACKED = frozenset(
    {
        *("EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "KHR_draco_mesh_compression"),
        *("KHR_mesh_quantization", "KHR_node_visibility"),
    }
)
_INSTANCING = "EXT_mesh_gpu_instancing"
_NUMBERS_PER_MATRIX = 16
_INSTANCE_TYPES = {"TRANSLATION": "VEC3", "ROTATION": "VEC4", "SCALE": "VEC3"}


def build_scene(
    source: Document, primitives: Sequence[Sequence[Primitive]], accessors: Accessors, *, whole: bool = True
) -> Scene:
    """Return the scene that the document shows first, or, if it lists none, all its nodes.

    Each node shows the `primitives` of the mesh that it names. Unless `whole`, animations and metadata are left out.
    Raises MeshError unless the nodes form trees (3.5.2).
    """
    document = source.content
    nodes = document.get("nodes", [])
    if not nodes:
        raise MeshError("it has no nodes")
    parents = _find_parents(nodes)
    names = make_names([node.get("name") for node in nodes], "node")
    order = list(_traverse(nodes, _find_roots(document, parents)))
    _require_few(len(nodes), order, parents)
    shown = {names[i]: i for i in order}
    animations = read_animations(document, names, shown, accessors) if whole else ()
    found = Scene(animations=animations, metadata=_collect_metadata(source, accessors) if whole else None)
    models = _Models(document, names, primitives, accessors)
    instances: dict[tuple[tuple[str, int], ...], Float64Array] = {}
    for i in order:
        above = parents[i]
        try:
            node = found.add(
                name=names[i], parent=None if above is None else names[above], transform=local_matrix(nodes[i])
            )
            extensions = nodes[i].get("extensions", {})
            if whole:
                node.metadata = _collect_node_metadata(nodes[i])
            if extensions.get("KHR_node_visibility", {}).get("visible", True) is False:
                node.visible = False
            if "weights" in nodes[i]:
                node.weights = nodes[i]["weights"]
            if _INSTANCING in extensions:
                share_instances(node, _read_instances(extensions[_INSTANCING], accessors, instances))
            for model in models.of(nodes[i]):
                node.show(model)
        except (ArgumentError, ArgumentTypeError, MeshError) as error:
            raise MeshError(f"node {i}: {error}") from None
    return found


def _collect_metadata(source: Document, accessors: Accessors) -> dict[str, Any]:
    """Return what a document holds beside nodes and what they show, with the bytes of its images."""
    content = {name: value for name, value in source.content.items() if name not in _REBUILT}
    for key in ("extensionsUsed", "extensionsRequired"):
        if key in content:
            content[key] = [name for name in content[key] if name not in _UNPACKED]
            if not content[key]:
                del content[key]
    images: list[dict[str, Any]] = []
    files = dict[Path, bytes]()
    data: list[bytes | None] = []
    for image in content.get("images", []):
        kept = {**image}  # unlike `dict`, a TypeError for all else
        if "bufferView" in kept:
            data.append(accessors.copy_view(get_count(kept, "bufferView")))
            del kept["bufferView"]
        else:
            found = read_image(kept, source.folder, files)
            data.append(found)
            if found is not None:
                kind = guess_type(kept.pop("uri"), found)
                kept.setdefault("mimeType", kind)
        images.append(kept)
    if images:
        content |= {"images": images, "image_bytes": data}
    asset = {name: value for name, value in content.pop("asset", {}).items() if name not in ("version", "minVersion")}
    if asset:
        content["asset"] = asset
    scenes = source.content.get("scenes", [])
    scene = scenes[get_count(source.content, "scene", 0)] if scenes else {}
    if described := {name: value for name, value in scene.items() if name != "nodes"}:
        content["scene"] = described
    if left_out := _list_left_out(source.content):
        content["left_out"] = left_out
    return {"gltf": content} if content else {}


def _list_left_out(content: Any) -> list[str]:
    """Return words for what no scene keeps of a document."""
    others = [_count(len(content.get("scenes", [])) - 1, "other scene")]
    skins = [_count(sum("name" in skin for skin in content.get("skins", [])), "name", " of skins")]
    animations = content.get("animations", [])
    described = [_count(sum("extras" in animation for animation in animations), "animation", "'s extras")]
    targets = [
        target
        for mesh in content.get("meshes", [])
        for primitive in mesh["primitives"]
        for target in primitive.get("targets", [])
    ]
    moved = sorted({name for target in targets for name in target} - {"POSITION"})
    morphs = [f"{name} of morph targets" for name in moved]
    return [words for words in others + skins + described + morphs if words]


def list_unheld(content: Any) -> list[str]:
    """Return words for what a document holds and no mesh does, beside its nodes."""
    counts = [_count(len(content.get(f"{name}s", [])), name) for name in ("animation", "camera", "image", "skin")]
    counts.append(_count(len(content.get("scenes", [])) - 1, "other scene"))
    extensions = [
        f"extension {name}"
        for name in content.get("extensionsUsed", [])
        if name not in _UNPACKED and not name.startswith(("KHR_materials_", "KHR_texture_"))
    ]
    parts = [*content.get("nodes", []), *content.get("meshes", []), *content.get("scenes", []), content]
    rest = ["extras"] if any("extras" in part for part in parts) else []
    is_morphed = any(any(part.get("weights", ())) for part in content.get("nodes", []) + content.get("meshes", []))
    primitives = [primitive for mesh in content.get("meshes", []) for primitive in mesh["primitives"]]
    if is_morphed and any("targets" in part and "NORMAL" in part["attributes"] for part in primitives):
        rest.append("normals of morphed meshes")
    return [words for words in counts + extensions + rest if words]


def _count(n: int, name: str, rest: str = "") -> str:
    """Return words for a number of things, no words for none."""
    return f"{n} {name}{'s' if n > 1 else ''}{rest}" if n > 0 else ""


def _collect_node_metadata(node: Any) -> dict[str, Any]:
    """Return what a node holds beside its place and what it shows."""
    kept = {name: value for name, value in node.items() if name not in _OF_NODES}
    extensions = {name: value for name, value in kept.pop("extensions", {}).items() if name not in _UNPACKED}
    if extensions:
        kept["extensions"] = extensions
    return {"gltf": kept} if kept else {}


class _Models:
    """What nodes show: one model per primitive and skin, however many nodes show it."""

    def __init__(
        self, document: Any, names: Sequence[str], primitives: Sequence[Sequence[Primitive]], accessors: Accessors
    ) -> None:
        self._document = document
        self._names = names
        self._primitives = primitives
        self._accessors = accessors
        self._made: dict[tuple[int, int | None], list[Mesh | DeformableMesh]] = {}
        self._skins: dict[int, Skin] = {}

    def of(self, node: Any) -> list[Mesh | DeformableMesh]:
        """Return the models of a node."""
        if "mesh" not in node:
            return []
        key = get_count(node, "mesh"), get_count(node, "skin") if "skin" in node else None
        if key not in self._made:
            self._made[key] = [self._make(part, *key) for part in self._primitives[key[0]]]
        return self._made[key]

    def _make(self, part: Primitive, mesh: int, skin: int | None) -> Mesh | DeformableMesh:
        follows = skin is not None and part.influences is not None
        if not part.targets and not follows:
            return part.mesh
        weights = self._document["meshes"][mesh].get("weights", [0.0] * len(part.targets))
        try:
            return DeformableMesh(
                part.mesh,
                part.targets,
                weights,
                self._skin(skin) if follows and skin is not None else None,
                part.influences if follows else None,
            )
        except (ArgumentError, ArgumentTypeError, MeshError) as error:
            raise MeshError(f"mesh {mesh}: {error}") from None

    def _skin(self, i: int) -> Skin:
        """Return skin i (3.7.3.1); without matrices, the joints themselves are the bind pose."""
        if i not in self._skins:
            skin = self._document["skins"][i]
            joints = skin["joints"]
            if not joints or any(not isinstance(joint, int) or joint < 0 for joint in joints):
                raise MeshError(f"skin {i} must list its joints by numbers of at least 0, got {quote(repr(joints))}")
            matrices = np.broadcast_to(np.eye(4), (len(joints), 4, 4))
            if "inverseBindMatrices" in skin:
                bound = get_count(skin, "inverseBindMatrices")
                if self._accessors.count(bound) < len(joints):
                    raise MeshError(f"skin {i} has {self._accessors.count(bound)} matrices for {len(joints)} joints")
                budget().take_values(matrices.size, f"skin {i}")
                matrices = self._accessors.matrices(bound, len(joints))
            self._skins[i] = Skin(tuple(self._names[joint] for joint in joints), matrices)
        return self._skins[i]


def _read_instances(
    extension: Any, accessors: Accessors, found: dict[tuple[tuple[str, int], ...], Float64Array]
) -> Float64Array:
    """Return the matrices (k, 4, 4) of EXT_mesh_gpu_instancing, those `found` before for the same accessors."""
    attributes = extension["attributes"]
    named = {name: get_count(attributes, name) for name in _INSTANCE_TYPES if name in attributes}
    key = tuple(named.items())
    if key not in found:
        found[key] = as_read_only(_make_instances(named, accessors))
    return found[key]


def _make_instances(named: Mapping[str, int], accessors: Accessors) -> Float64Array:
    counts = {accessors.count(i) for i in named.values()}
    if len(counts) != 1:
        raise MeshError(f"{_INSTANCING} must give one number of instances, got {sorted(counts)}")
    count = counts.pop()
    if count > accessors.n_bytes:
        raise MeshError(f"{_INSTANCING} places {count} copies, its buffers have {accessors.n_bytes} bytes")
    budget().take_values(_NUMBERS_PER_MATRIX * count, _INSTANCING)
    given = {name: accessors.floats(i, _INSTANCE_TYPES[name]) for name, i in named.items()}
    if not all(np.isfinite(rows).all() for rows in given.values()):
        raise MeshError(f"{_INSTANCING} must hold finite numbers")
    matrices = np.tile(np.eye(4), (count, 1, 1))
    if "ROTATION" in given:
        lengths = np.linalg.norm(given["ROTATION"], axis=1, keepdims=True)
        if not lengths.all():
            raise MeshError(f"{_INSTANCING}: the rotation of copy {int(np.argmin(lengths))} is zero")
        matrices[:, :3, :3] = rotation_from_quaternion(given["ROTATION"] / lengths)
    if "SCALE" in given:
        matrices[:, :3, :3] *= given["SCALE"][:, np.newaxis]
    if "TRANSLATION" in given:
        matrices[:, :3, 3] = given["TRANSLATION"]
    return matrices


def _find_parents(nodes: Sequence[Any]) -> list[int | None]:
    """Return the parent of each node; raise MeshError for a node with two parents, or within itself."""
    parents: list[int | None] = [None] * len(nodes)
    for i, node in enumerate(nodes):
        for child in node.get("children", []):
            if child < 0 or parents[child] is not None:
                raise MeshError(f"node {i} has the child {child}, which is no node or has a parent already")
            parents[child] = i
    roots = [i for i, parent in enumerate(parents) if parent is None]
    n_reached = sum(1 for _ in _traverse(nodes, roots))
    if n_reached < len(nodes):
        raise MeshError(f"{len(nodes) - n_reached} nodes are descendants of themselves")
    return parents


def _require_few(n_nodes: int, order: Sequence[int], parents: Sequence[int | None]) -> None:
    """Raise MeshError for more nodes than the limits of the file allow, or deeper ones."""
    file = budget()  # a new one each time where no file is read by its name or type
    file.spell_nodes(n_nodes)
    file.take_nodes(len(order), "its nodes")
    depths: dict[int | None, int] = {None: 0}
    for i in order:
        depths[i] = depths[parents[i]] + 1
    file.require_depth(max(depths.values()))


def _traverse(nodes: Sequence[Any], roots: Sequence[int]) -> Iterator[int]:
    """Yield `roots` and their descendants, depth first, each node after its parent."""
    waiting = list(reversed(roots))
    while waiting:
        i = waiting.pop()
        yield i
        waiting.extend(reversed(nodes[i].get("children", [])))


def _find_roots(document: Any, parents: Sequence[int | None]) -> list[int]:
    """Return the nodes of the scene that have no parent."""
    scenes = document.get("scenes", [])
    if not scenes:
        return [i for i, parent in enumerate(parents) if parent is None]
    listed = scenes[get_count(document, "scene", 0)].get("nodes", [])
    for i in listed:
        if parents[i] is not None:
            raise MeshError(f"the scene lists node {i}, which is in node {parents[i]}")
    if len(set(listed)) < len(listed) or min(listed, default=0) < 0:
        raise MeshError("the scene must list each node once, by a number of at least 0")
    return list(listed)
