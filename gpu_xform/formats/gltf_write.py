"""glTF documents made of meshes and scenes.

Section numbers are those of the glTF 2.0 specification.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, IndexArray
from ..errors import MeshError
from ..geometry.attributes import Attributes, RaggedArray, take_rows, thaw_value
from ..geometry.deformable_mesh import DeformableMesh, Skin
from ..geometry.mesh import Mesh
from ..geometry.nodes import Node
from ..geometry.scene import Scene, require_one_pose
from ..geometry.scene_animation import SceneAnimation
from ..geometry.triangulation import triangulate
from ._losses import list_rounding, name_materials, warn_of
from ._warn import warn
from .gltf_accessors import DTYPES
from .gltf_attributes import fit_attributes, name_semantics
from .gltf_document import Document

_COMPONENTS = {np.dtype(name).newbyteorder("="): code for code, name in DTYPES.items()}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
_POINTS, _LINES, _TRIANGLES = 0, 1, 4
_MAX_FLOAT32 = float(np.finfo(np.float32).max)


def make_document(model: Mesh | Scene) -> Document:
    """Return the document of a scene, or of one node that shows a mesh.

    Polygons become triangles, and coordinates float32. MeshError is raised for a coordinate beyond that, and for a
    model that is no mesh.
    """
    if isinstance(model, Scene):
        return _Writer(model).document()
    lost = model.metadata.get("gltf", {}).get("holds", ())
    if lost:
        warn(f"one mesh does not hold {', '.join(lost)}, as the scene of its file does")
    scene = Scene()
    scene.add(model, name="geometry_0")
    return _Writer(scene).document()


class _Writer:
    """A document that grows."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        kept = thaw_value(scene.metadata.get("gltf", {}))
        self._images: Sequence[bytes | None] = kept.pop("image_bytes", ())
        self._described = _as_lists(kept.pop("scene", {}))
        kept.pop("left_out", None)
        self._content: dict[str, Any] = {"asset": {"version": "2.0"}, **_as_lists(kept)}
        self._content.setdefault("asset", {})["version"] = "2.0"
        self._binary = bytearray()
        self._numbers = {node.name: i for i, node in enumerate(scene)}
        self._meshes: dict[tuple[int, ...], int] = {}
        self._skins: dict[int, int] = {}
        self._n_copies = 0
        self._unwritten: set[str] = set()
        self._metadata: list[Mapping[str, Any]] = [scene.metadata]
        self._used: set[str] = set()

    def document(self) -> Document:
        """Return the whole document."""
        require_one_pose(self._scene)
        children: dict[str | None, list[int]] = {}
        for node in self._scene:
            children.setdefault(node.parent, []).append(self._numbers[node.name])
        animated = {name for animation in self._scene.animations.values() for name in animation.placements}
        nodes = [self._node(node, children.get(node.name, []), node.name in animated) for node in self._scene]
        copies = [copy for node in self._scene for copy in self._copies(node, nodes)]
        self._content["nodes"] = nodes + copies
        self._content["scenes"] = [{**self._described, "nodes": children.get(None, [])}]
        self._content["scene"] = 0
        animations = [self._animation(animation) for animation in self._scene.animations.values()]
        if animations:
            self._content["animations"] = animations
        self._add_images()
        if self._used:
            self._content["extensionsUsed"] = sorted({*self._content.get("extensionsUsed", ()), *self._used})
        warn_of(sorted(self._unwritten), self._metadata, "gltf")
        if self._binary:
            self._content["buffers"] = [{"byteLength": len(self._binary)}]
        return Document(self._content, [bytes(self._binary)] if self._binary else [])

    def _node(self, node: Node, children: list[int], is_animated: bool) -> dict[str, Any]:
        made: dict[str, Any] = {"name": node.name, **_as_lists(thaw_value(node.metadata.get("gltf", {})))}
        if is_animated:
            rest = next(a.placements[node.name] for a in self._scene.animations.values() if node.name in a.placements)
            for key, value, default in (
                ("translation", rest.translation, (0, 0, 0)),
                ("rotation", rest.rotation, (0, 0, 0, 1)),
                ("scale", rest.scale, (1, 1, 1)),
            ):
                if not np.array_equal(value, default):
                    made[key] = value.tolist()
        elif not np.array_equal(node.transform, np.eye(4)):
            made["matrix"] = node.transform.T.ravel().tolist()
        if children:
            made["children"] = list(children)
        if not node.visible:
            made.setdefault("extensions", {})["KHR_node_visibility"] = {"visible": False}
            self._used.add("KHR_node_visibility")
        if node.weights is not None:
            made["weights"] = node.weights.tolist()
        if node.models and node.instances is None:
            self._show(made, node)
        for shown in node.models:
            self._unwritten.update(f"the style {name}" for name in shown.style)
        return made

    def _copies(self, node: Node, nodes: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Return a node for each copy of what a node shows, which become its children."""
        if node.instances is None or not node.models:
            return []
        owner = nodes[self._numbers[node.name]]
        first = len(self._numbers) + self._n_copies
        copies: list[dict[str, Any]] = []
        for i, matrix in enumerate(node.instances):
            copies.append({"name": f"{node.name}, copy {i + 1}", "matrix": matrix.T.ravel().tolist()})
            self._show(copies[-1], node)
        self._n_copies += len(copies)
        owner["children"] = [*owner.get("children", []), *range(first, first + len(copies))]
        return copies

    def _show(self, made: dict[str, Any], node: Node) -> None:
        """Let a node of the document show the models of a node of the scene."""
        models = [shown.model for shown in node.models]
        for model in models:
            if not isinstance(model, Mesh | DeformableMesh):
                raise MeshError(f"node {node.name!r} must show meshes, got {type(model).__name__}")
        meshes = [model.mesh if isinstance(model, DeformableMesh) else model for model in models]
        if not any(mesh.n_points for mesh in meshes):
            return
        key = tuple(map(id, models))
        if key not in self._meshes:
            self._meshes[key] = self._mesh(models, node.name)
        made["mesh"] = self._meshes[key]
        skin = next((model.skin for model in models if isinstance(model, DeformableMesh) and model.skin), None)
        if skin is not None:
            made["skin"] = self._skin(skin)

    def _mesh(self, models: Sequence[Mesh | DeformableMesh], name: str) -> int:
        """Add the mesh of several models, and return its index."""
        primitives: list[dict[str, Any]] = []
        made: dict[str, Any] = {}
        for model in models:
            mesh = model.mesh if isinstance(model, DeformableMesh) else model
            kept = _as_lists(thaw_value(mesh.metadata.get("gltf", {})))
            of_part = kept.pop("primitive", {})
            made = {name: value for name, value in kept.items() if name != "holds"} | made
            self._metadata.append(mesh.metadata)
            parts = self._primitives(mesh, model if isinstance(model, DeformableMesh) else None, name)
            primitives += [of_part | part for part in parts]
            if isinstance(model, DeformableMesh) and model.targets:
                made["weights"] = model.weights.tolist()
        meshes = self._content.setdefault("meshes", [])
        meshes.append({**made, "primitives": primitives})
        return len(meshes) - 1

    def _primitives(self, mesh: Mesh, deformable: DeformableMesh | None, name: str) -> list[dict[str, Any]]:
        """Return one primitive per material, kind of face and set of attributes, or one of points."""
        mesh, unfit = fit_attributes(mesh)
        parts, lost = _split_gaps(mesh)
        self._unwritten.update(unfit + lost + list_rounding(mesh.positions))
        if mesh.n_faces and (len(parts) > 1 or mesh.attributes.corner or _has_colors_of_faces(mesh)):
            n_unused = mesh.n_points - len(np.unique(mesh.indices))
            self._unwritten.update([f"{n_unused} points that no face uses"] if n_unused else [])
        return [made for part in parts for made in self._whole_primitives(part, deformable, name, len(parts) == 1)]

    def _whole_primitives(
        self, mesh: Mesh, deformable: DeformableMesh | None, name: str, has_all_points: bool
    ) -> list[dict[str, Any]]:
        """Return the primitives of a mesh whose attributes are finite; without the points of other parts."""
        vertices, corners, table = _split_corners(mesh)
        if not has_all_points:
            used, corners = np.unique(corners, return_inverse=True)
            vertices, table = vertices[used], {key: column[used] for key, column in table.items()}
        positions = mesh.positions[vertices]
        if len(positions) and np.abs(positions).max() > _MAX_FLOAT32:
            worst = np.abs(positions).max()
            raise MeshError(f"glTF holds float32, the mesh of node {name!r} has a coordinate of {worst:g}")
        attributes = {"POSITION": self._array(positions, "<f4", bounds=True, target=_ARRAY_BUFFER)}
        semantics = name_semantics([key for key, column in table.items() if column.dtype.kind in "iufb"])
        for key, column in table.items():
            self._add_attribute(attributes, semantics.get(key, f"_{key}"), key, column)
        shared: dict[str, Any] = {"attributes": attributes}
        if deformable is not None:
            self._add_deformation(shared, deformable, vertices)
        material_of_face = _find_materials(mesh)
        written = {"material"} if material_of_face is not None else set()
        written |= {"color"} if _has_colors_of_faces(mesh) else set()
        self._unwritten.update(f"{key} per face" for key in mesh.attributes.face if key not in written)
        for place in ("point", "corner"):
            columns = getattr(mesh.attributes, place).items()
            is_kept = place == "point" or mesh.n_faces > 0
            self._unwritten.update(
                f"{key} per {place}" for key, column in columns if isinstance(column, RaggedArray) or not is_kept
            )
        named = set(mesh.attributes.labels.get("material", ()))
        if "libraries" in mesh.metadata.get("obj", {}):  # of which the materials are there
            named.add("mtllib")
        self._unwritten.update(f"material ({key})" for key in mesh.attributes.material if key not in named)
        if mesh.n_faces == 0:
            return [shared | {"mode": _POINTS} | self._material(mesh, 0)]
        triangles, owners = triangulate(positions, mesh.offsets, corners)
        sizes = np.diff(mesh.offsets)
        segments = corners[mesh.offsets[:-1][sizes == 2][:, np.newaxis] + (0, 1)] if (sizes == 2).any() else None
        parts = [(triangles, owners, _TRIANGLES)]
        if segments is not None:
            parts.append((segments, np.flatnonzero(sizes == 2), _LINES))
        found = []
        for faces, of_face, mode in parts:
            values = np.full(len(of_face), -1) if material_of_face is None else material_of_face[of_face]
            for value in np.unique(values).tolist():
                rows = faces if material_of_face is None else faces[values == value]
                dtype = "<u2" if len(positions) < 65535 else "<u4"
                indices = self._array(rows.ravel(), dtype, target=_ELEMENT_ARRAY_BUFFER)
                part = shared | {"indices": indices} | self._material(mesh, value)
                found.append(part if mode == _TRIANGLES else part | {"mode": mode})
        return found

    def _add_attribute(self, attributes: dict[str, int], semantic: str, name: str, column: npt.NDArray[Any]) -> None:
        """Write an attribute per point, in the type that the specification allows (3.7.2.1)."""
        column = column.reshape(len(column), -1)
        is_own = semantic.startswith("_")
        if column.dtype.kind not in "iufb" or column.shape[1] not in _TYPES or len(column) == 0:
            self._unwritten.add(f"{name} per point")
            return
        dtype, normalized = column.dtype.newbyteorder("="), False
        if semantic.startswith("COLOR_") and dtype in (np.uint8, np.uint16):
            normalized = True
        elif not (is_own and dtype in _COMPONENTS and dtype.itemsize < 4) and dtype != np.float32:
            with np.errstate(over="ignore", invalid="ignore"):  # rounded up, the largest integers are beyond their type
                single = column.astype(np.float32)
                again = single.astype(column.dtype)
            if not np.array_equal(again, column, equal_nan=True) and is_own:
                self._unwritten.add(f"all digits of {name}")
            column, dtype = single, np.dtype(np.float32)
        attributes[semantic] = self._array(column, dtype.str, target=_ARRAY_BUFFER, normalized=normalized)

    def _add_deformation(self, shared: dict[str, Any], model: DeformableMesh, vertices: IndexArray) -> None:
        """Write the morph targets and the influences of joints."""
        if model.targets:
            shared["targets"] = [
                {"POSITION": self._array(np.asarray(target)[vertices], "<f4", bounds=True)} for target in model.targets
            ]
        if model.influences is not None:
            joints, weights = model.influences.joints[vertices], model.influences.weights[vertices]
            padding = (0, 0), (0, -joints.shape[1] % 4)
            for name, rows, kind in (
                ("JOINTS", np.pad(joints, padding), "|u1" if joints.max(initial=0) < 256 else "<u2"),
                ("WEIGHTS", np.pad(weights, padding), "<f4"),
            ):
                for i in range(rows.shape[1] // 4):
                    four = rows[:, 4 * i : 4 * i + 4]
                    shared["attributes"][f"{name}_{i}"] = self._array(four, kind, target=_ARRAY_BUFFER)

    def _material(self, mesh: Mesh, value: int) -> dict[str, int]:
        """Return the reference to the material of a face, which is added unless the document has it."""
        labels = mesh.attributes.labels.get("material", ())
        if not 0 <= value < len(labels):
            return {}
        name = labels[value]
        kept = _as_lists(thaw_value(mesh.attributes.material.get(name, {"name": name})))
        if not isinstance(kept, dict):
            kept = {"name": name}
        whole = kept
        kept = _without_missing_textures(whole, len(self._content.get("textures", ())))
        if kept != whole:
            self._unwritten.add(f"textures of {name_materials([name])}")
        materials = self._content.setdefault("materials", [])
        if kept not in materials:
            materials.append(kept)
        extras = kept.get("extras", {})
        images = [key for key in extras.get("mtl", ()) if key.startswith("map_")] if isinstance(extras, dict) else []
        if images:
            self._unwritten.add(f"{', '.join(images)} of {name_materials([name])}")
        return {"material": materials.index(kept)}

    def _skin(self, skin: Skin) -> int:
        """Add a skin unless it is there, and return its index."""
        if id(skin) not in self._skins:
            for joint in skin.joints:
                if joint not in self._numbers:
                    raise MeshError(f"a skin has the joint {joint!r}, which is no node of the scene")
            skins = self._content.setdefault("skins", [])
            self._skins[id(skin)] = len(skins)
            matrices = skin.joint_from_mesh.transpose(0, 2, 1).reshape(-1, 16)
            skins.append(
                {
                    "joints": [self._numbers[joint] for joint in skin.joints],
                    "inverseBindMatrices": self._array(matrices, "<f4", kind="MAT4"),
                }
            )
        return self._skins[id(skin)]

    def _animation(self, animation: SceneAnimation) -> dict[str, Any]:
        samplers, channels = [], []
        for channel in animation.channels:
            values = channel.values[:, np.newaxis]
            if channel.in_tangents is not None and channel.out_tangents is not None:
                values = np.stack([channel.in_tangents, channel.values, channel.out_tangents], axis=1)
            width = 1 if channel.property == "weights" else values.shape[-1]
            samplers.append(
                {
                    "input": self._array(channel.times, "<f4", bounds=True),
                    "output": self._array(values.reshape(-1, width), "<f4"),
                    "interpolation": channel.interpolation,
                }
            )
            target = {"node": self._numbers[channel.node], "path": channel.property}
            channels.append({"sampler": len(samplers) - 1, "target": target})
        return {"name": animation.name, "samplers": samplers, "channels": channels}

    def _add_images(self) -> None:
        """Write the images of which a scene keeps the bytes."""
        views: dict[bytes, int] = {}
        for image, data in zip(self._content.get("images", []), self._images, strict=False):
            if data is not None:
                own = bytes(data)
                if own not in views:
                    views[own] = self._view(own)
                image["bufferView"] = views[own]

    def _array(
        self,
        values: npt.NDArray[Any],
        dtype: str,
        *,
        bounds: bool = False,
        target: int | None = None,
        kind: str | None = None,
        normalized: bool = False,
    ) -> int:
        """Add an accessor of rows (n, columns) or numbers (n,), and return its index."""
        array = np.ascontiguousarray(values, dtype).reshape(len(values), -1)
        rows = array
        stride = array.shape[1] * array.itemsize
        padded = target == _ARRAY_BUFFER and stride % 4 != 0  # rows of vertices are aligned (3.6.2.4)
        if padded:
            rows = np.zeros((len(array), stride + -stride % 4), np.uint8)
            rows[:, :stride] = array.view(np.uint8).reshape(len(array), stride)
        view = self._view(rows.tobytes())
        if target is not None:
            self._content["bufferViews"][view]["target"] = target
        if padded:
            self._content["bufferViews"][view]["byteStride"] = stride + -stride % 4
        accessor: dict[str, Any] = {
            "bufferView": view,
            "componentType": _COMPONENTS[np.dtype(dtype).newbyteorder("=")],
            "count": len(array),
            "type": kind or _TYPES[array.shape[1]],
        }
        if normalized:
            accessor["normalized"] = True
        if bounds and len(array):
            accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        accessors = self._content.setdefault("accessors", [])
        accessors.append(accessor)
        return len(accessors) - 1

    def _view(self, data: bytes) -> int:
        """Add bytes to the buffer, and return the index of their view."""
        views = self._content.setdefault("bufferViews", [])
        views.append({"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(data)})
        self._binary += data + b"\0" * (-len(data) % 4)
        return len(views) - 1


def _without_missing_textures(material: Any, n_textures: int) -> Any:
    """Return plain data without the references to textures that the document does not have."""
    if not isinstance(material, dict):
        return material
    return {
        key: _without_missing_textures(value, n_textures)
        for key, value in material.items()
        if not (key.endswith("Texture") and isinstance(value, dict) and value.get("index", 0) >= n_textures)
    }


def _split_gaps(mesh: Mesh) -> tuple[list[Mesh], list[str]]:
    """Return parts of the faces, each with those attributes that have finite rows at all its corners; and what is lost.

    NaN stands for a row that a corner does not have, which glTF cannot hold (3.6.2.2). All parts have all points.
    """
    attributes = mesh.attributes
    tables = {"point": dict(attributes.point), "corner": dict(attributes.corner)}
    key = np.zeros(mesh.n_faces, np.int64)
    gaps: list[tuple[str, str]] = []
    lost = []
    for what, table in tables.items():
        for name, column in list(table.items()):
            if isinstance(column, RaggedArray) or column.dtype.kind != "f" or np.isfinite(column).all():
                continue
            is_there = np.isfinite(column.reshape(len(column), -1)).all(axis=1)
            if mesh.n_faces == 0:
                lost.append(f"{name} per {what}, which {(~is_there).sum()} of {len(column)} rows lack")
                del table[name]
                continue
            of_corner = is_there[mesh.indices] if what == "point" else is_there
            is_whole = np.logical_and.reduceat(of_corner, mesh.offsets[:-1])
            n_partly = int((np.logical_or.reduceat(of_corner, mesh.offsets[:-1]) & ~is_whole).sum())
            if n_partly:
                lost.append(f"{name} of {n_partly} faces, which some of their corners lack")
            key |= is_whole.astype(np.int64) << len(gaps)
            gaps.append((what, name))
    if not gaps:
        return [mesh if not lost else _take_faces(mesh, np.ones(mesh.n_faces, bool), tables)], lost
    parts = []
    for value in np.unique(key).tolist():
        lacking = {gap for i, gap in enumerate(gaps) if not value >> i & 1}
        held = {
            what: {name: column for name, column in table.items() if (what, name) not in lacking}
            for what, table in tables.items()
        }
        parts.append(_take_faces(mesh, key == value, held))
    return parts, lost


def _take_faces(mesh: Mesh, chosen: BoolArray, tables: Mapping[str, Mapping[str, Any]]) -> Mesh:
    """Return the mesh of some faces and all points, with the attributes of `tables` per point and per corner."""
    sizes = np.diff(mesh.offsets)
    corners = np.flatnonzero(np.repeat(chosen, sizes))
    attributes = mesh.attributes
    return Mesh.from_offsets(
        mesh.positions,
        np.concatenate([[0], np.cumsum(sizes[chosen])]),
        mesh.indices[corners],
        attributes=Attributes(
            tables["point"],
            {name: take_rows(column, corners) for name, column in tables["corner"].items()},
            {name: take_rows(column, np.flatnonzero(chosen)) for name, column in attributes.face.items()},
            labels=attributes.labels,
            material=attributes.material,
        ),
        metadata=mesh.metadata,
    )


def _split_corners(mesh: Mesh) -> tuple[IndexArray, IndexArray, Mapping[str, npt.NDArray[Any]]]:
    """Return vertices that differ in no attribute between the faces that share them.

    Returns the point of each vertex (v,), the vertex of each corner (c,), and the attributes per vertex.
    """
    attributes: Attributes = mesh.attributes
    point = {name: column for name, column in attributes.point.items() if not isinstance(column, RaggedArray)}
    corner = {name: column for name, column in attributes.corner.items() if not isinstance(column, RaggedArray)}
    if _has_colors_of_faces(mesh):
        corner["color"] = np.repeat(np.asarray(attributes.face["color"]), np.diff(mesh.offsets), axis=0)
    if not corner or mesh.n_faces == 0:
        return np.arange(mesh.n_points), mesh.indices, point
    n = len(mesh.indices)
    parts = [mesh.indices.reshape(n, 1), *(np.ascontiguousarray(column).reshape(n, -1) for column in corner.values())]
    keys = np.concatenate([part.view(np.uint8).reshape(n, -1) for part in parts], axis=1)
    whole = np.ascontiguousarray(keys).view(np.dtype((np.void, keys.shape[1])))[:, 0]
    _, firsts, vertex_of_corner = np.unique(whole, return_index=True, return_inverse=True)
    vertices = mesh.indices[firsts]
    table = {name: column[vertices] for name, column in point.items()}
    return vertices, vertex_of_corner.reshape(-1), table | {name: column[firsts] for name, column in corner.items()}


def _find_materials(mesh: Mesh) -> IndexArray | None:
    """Return the number of the material of each face, if there are such numbers, with names."""
    column = mesh.attributes.face.get("material")
    is_held = isinstance(column, np.ndarray) and column.ndim == 1 and column.dtype.kind in "iu"
    return column if is_held and "material" in mesh.attributes.labels else None


def _has_colors_of_faces(mesh: Mesh) -> bool:
    """Return whether the colours of a mesh are those of its faces, which become those of their corners."""
    attributes = mesh.attributes
    column = attributes.face.get("color")
    is_color = isinstance(column, np.ndarray) and column.ndim == 2 and column.shape[1] in (3, 4)
    return is_color and "color" not in attributes.point and "color" not in attributes.corner


def _as_lists(value: Any) -> Any:
    """Return plain data with lists for tuples, as JSON has them."""
    if isinstance(value, Mapping):
        return {key: _as_lists(item) for key, item in value.items()}
    return list(map(_as_lists, value)) if isinstance(value, tuple | list) else value
