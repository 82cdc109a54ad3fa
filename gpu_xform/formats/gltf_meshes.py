"""The primitives of a glTF document: triangles, segments and points, with what deforms them.

Section numbers are those of the glTF 2.0 specification.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError, MissingExtraError
from ..geometry.attributes import Attributes, freeze_value
from ..geometry.deformable_mesh import Influences
from ..geometry.mesh import Mesh, count_corners, take_over
from .gltf_accessors import Accessors, get_count
from .gltf_attributes import read_attributes
from .gltf_draco import decode_draco
from .gltf_draco_counts import DracoCounts
from .gltf_placements import make_names
from .limits import budget

_POINTS, _LINES, _LINE_LOOP, _LINE_STRIP, _TRIANGLES, _TRIANGLE_STRIP, _TRIANGLE_FAN = range(7)
_MAX_COMPONENTS = 4  # of an attribute
_DRACO = "KHR_draco_mesh_compression"


@dataclass(frozen=True, eq=False)
class Primitive:
    """A part of a mesh: points with faces of one kind, or alone."""

    mesh: Mesh
    targets: tuple[Float64Array, ...]
    """(n, 3) each: what a morph weight of 1 adds to the points."""
    influences: Influences | None
    """The joints that each point follows, if a skin is given."""


def read_meshes(document: Any, accessors: Accessors) -> list[list[Primitive]]:
    """Return the primitives of each mesh that hold a face, or are points.

    Raises MeshError if buffers, views, accessors and primitives disagree with one another.
    """
    found: list[list[Primitive]] = []
    materials = document.get("materials", [])
    names = make_names([material.get("name") for material in materials], "material")

    @cache
    def describe_material(i: int) -> tuple[str, Any]:
        """Return the name of a material, and the material, which many primitives may share."""
        return names[i], freeze_value(materials[i])

    for i, mesh in enumerate(document.get("meshes", [])):
        shared: dict[str, list[Primitive]] = {}
        said = freeze_value({name: value for name, value in mesh.items() if name not in ("primitives", "weights")})
        for p, part in enumerate(mesh["primitives"]):
            if "POSITION" not in part["attributes"]:  # nothing to show, unless an extension says where (3.7.2.1)
                continue
            budget().take_numbers(_count_numbers(part, accessors) + len(said), f"mesh {i}")
            primitive = _read_primitive(part, accessors, f"mesh {i}")
            is_empty = primitive.mesh.n_faces == 0 and get_count(part, "mode", _TRIANGLES) != _POINTS
            if is_empty or not primitive.mesh.n_points:
                continue
            material = get_count(part, "material") if "material" in part else None
            described = None if material is None else describe_material(material)
            key = _make_key(part) if primitive.mesh.n_faces else str(p)
            shared.setdefault(key, []).append(replace(primitive, mesh=_describe(primitive.mesh, said, part, described)))
        found.append([_join(primitives) for primitives in shared.values()])
    return found


def _count_numbers(part: Any, accessors: Accessors) -> int:
    """Return how many numbers a primitive will hold, as far as its accessors say."""
    attributes = part["attributes"]
    n_points = accessors.count(get_count(attributes, "POSITION"))
    n_corners = accessors.count(get_count(part, "indices")) if "indices" in part else n_points
    width = 3 * (1 + len(part.get("targets", []))) + _MAX_COMPONENTS * (len(attributes) - 1)
    return n_points * width + n_corners


def _make_key(part: Any) -> str:
    """Return a text that is the same for primitives that share their points, and differ in faces and material alone."""
    own = {name: value for name, value in part.items() if name not in ("indices", "material", "mode")}
    return json.dumps(own, sort_keys=True)


def _join(primitives: list[Primitive]) -> Primitive:
    """Return primitives that share their points as one."""
    if len(primitives) == 1:
        return primitives[0]
    meshes = [primitive.mesh for primitive in primitives]
    numbers: dict[str, int] = {}
    materials: dict[str, Any] = {}
    of_face = []
    for mesh in meshes:
        labels = mesh.attributes.labels.get("material")
        number = numbers.setdefault(labels[0], len(numbers)) if labels else -1
        of_face.append(np.full(mesh.n_faces, number, np.int32))
        materials |= mesh.attributes.material
    corners_before = np.cumsum([0, *map(count_corners, meshes)])
    joined = Mesh.from_offsets(
        meshes[0].positions,
        np.concatenate([[0], *(mesh.offsets[1:] + n for mesh, n in zip(meshes, corners_before, strict=False))]),
        np.concatenate([mesh.indices for mesh in meshes]),
        attributes=Attributes(
            meshes[0].attributes.point,
            face={"material": np.concatenate(of_face)} if numbers else {},
            labels={"material": list(numbers)} if numbers else {},
            material=materials,
        ),
        metadata=meshes[0].metadata,
    )
    return replace(primitives[0], mesh=joined)


def _read_primitive(part: Any, accessors: Accessors, owner: str) -> Primitive:
    mode, attributes = get_count(part, "mode", _TRIANGLES), part["attributes"]
    if _DRACO in part.get("extensions", {}):
        mode = _unpack(part, accessors, owner)
    positions = accessors.floats(get_count(attributes, "POSITION"), "VEC3")
    corners = accessors.indices(get_count(part, "indices")) if "indices" in part else np.arange(len(positions))
    still = np.broadcast_to(np.zeros(1), (len(positions), 3))
    targets = tuple(
        _read_target(target, still, accessors, f"{owner}: morph target {t}")
        for t, target in enumerate(part.get("targets", []))
    )
    influences = _read_influences(attributes, len(positions), accessors, owner)
    table = read_attributes(attributes, len(positions), accessors)
    if mode != _POINTS:
        faces = _assemble_faces(corners, mode, owner)
        mesh = take_over(positions, faces, attributes={"point": table} if table else None)
        return Primitive(mesh, targets, influences)
    if "indices" in part:
        if len(corners) and corners.max() >= len(positions):
            raise MeshError(f"{owner} names point {corners.max()}, outside 0..{len(positions) - 1}")
        positions, targets = positions[corners], tuple(target[corners] for target in targets)
        if influences is not None:
            influences = Influences(influences.joints[corners], influences.weights[corners])
        table = {name: column[corners] for name, column in table.items()}
    return Primitive(Mesh(positions, attributes={"point": table} if table else None), targets, influences)


def _describe(mesh: Mesh, said: Mapping[str, Any], part: Any, material: tuple[str, Any] | None) -> Mesh:
    """Return a mesh with its material, and with what the file says of it and, in `said`, of what it is a part of."""
    metadata = said
    own = {name: part[name] for name in ("extras", "extensions") if name in part}
    if _DRACO in own.get("extensions", {}):
        own["extensions"] = {name: value for name, value in own["extensions"].items() if name != _DRACO}
    if own := {name: value for name, value in own.items() if value}:
        metadata = {**said, "primitive": own}
    if material is None and not metadata:
        return mesh
    attributes = mesh.attributes
    if material is not None:
        name, content = material
        face = {"material": np.zeros(mesh.n_faces, np.int32)} if mesh.n_faces else {}
        attributes = Attributes(mesh.attributes.point, face=face, labels={"material": [name]}, material={name: content})
    return mesh.with_attributes(attributes, metadata={"gltf": metadata} if metadata else None)


def _read_target(target: Any, still: Float64Array, accessors: Accessors, name: str) -> Float64Array:
    """Return what a morph target adds to the points: `still`, zeros, if it is one of normals alone (3.7.2.2)."""
    if "POSITION" not in target:
        return still
    i = get_count(target, "POSITION")
    if accessors.count(i) != len(still):
        raise MeshError(f"{name} moves {accessors.count(i)} points, the mesh has {len(still)}")
    return accessors.floats(i, "VEC3")


def _read_influences(attributes: Any, n_points: int, accessors: Accessors, owner: str) -> Influences | None:
    """Return the joints and weights of the points, four in each set (3.7.3.3)."""
    joints: list[IndexArray] = []
    weights: list[Float64Array] = []
    while f"JOINTS_{len(joints)}" in attributes:
        name = len(joints)
        if f"WEIGHTS_{name}" not in attributes:
            raise MeshError(f"{owner}: JOINTS_{name} needs WEIGHTS_{name}")
        i, w = get_count(attributes, f"JOINTS_{name}"), get_count(attributes, f"WEIGHTS_{name}")
        if accessors.count(i) != n_points or accessors.count(w) != n_points:
            raise MeshError(
                f"{owner}: JOINTS_{name} and WEIGHTS_{name} have {accessors.count(i)} and {accessors.count(w)} rows "
                f"for {n_points} points"
            )
        rows = accessors.components(i, "VEC4")
        if rows.dtype.kind != "u":
            raise MeshError(f"{owner}: JOINTS_{name} must be unsigned integers, got {rows.dtype.name}")
        joints.append(rows.astype(np.int64))
        weights.append(accessors.floats(w, "VEC4"))
    if not joints:
        return None
    return Influences(np.concatenate(joints, axis=1), np.concatenate(weights, axis=1))


def _unpack(part: Any, accessors: Accessors, owner: str) -> int:
    """Put the arrays of a primitive packed by Draco in place of its accessors, and return its mode of drawing."""
    packed, positions = part["extensions"][_DRACO], get_count(part["attributes"], "POSITION")
    view = get_count(packed, "bufferView")
    if view not in accessors.draco:
        data = bytes(accessors.view_bytes(view))
        try:
            accessors.draco[view] = decode_draco(
                data,
                lambda counts: _require_declared(counts, part, accessors),
                lambda n_components: _take_components(n_components, part, accessors),
            )
        except ImportError:
            if accessors.has_content(positions):  # the file has both
                return get_count(part, "mode", _TRIANGLES)
            raise MissingExtraError(f"{_DRACO} needs DracoPy: pip install 'gpu_xform[gltf]'") from None
        except MeshError as error:
            raise MeshError(f"{owner}: {_DRACO}: {error}") from None
    mesh = accessors.draco[view]
    for name, unique_id in packed["attributes"].items():
        if unique_id not in mesh.columns:
            raise MeshError(f"{owner}: {_DRACO} has no attribute {unique_id} for {name}")
        accessors.replace(get_count(part["attributes"], name), mesh.columns[unique_id])
    if "indices" in part:
        accessors.replace(get_count(part, "indices"), mesh.corners)
    return _TRIANGLES


def _require_declared(counts: DracoCounts, part: Any, accessors: Accessors) -> None:
    """Raise MeshError for a stream of more than the accessors of its primitive declare, which have been counted."""
    positions = get_count(part["attributes"], "POSITION")
    for i, n_rows in (
        (positions, counts.n_points),
        (get_count(part, "indices") if "indices" in part else positions, 3 * counts.n_faces),
    ):
        if n_rows > accessors.count(i):
            raise MeshError(f"accessor {i} declares {accessors.count(i)} rows, its content has {n_rows}")
    if counts.n_seams > len(part["attributes"]):
        raise MeshError(f"the primitive has {len(part['attributes'])} attributes, its content {counts.n_seams}")


def _take_components(n_components: int, part: Any, accessors: Accessors) -> None:
    """Count the numbers of a stream beyond those that `_count_numbers` has counted: of what the file does not name."""
    n_points = accessors.count(get_count(part["attributes"], "POSITION"))
    n_more = n_points * (n_components - 3 - _MAX_COMPONENTS * (len(part["attributes"]) - 1))
    budget().take_numbers(max(n_more, 0), "its content")


def _assemble_faces(corners: npt.NDArray[Any], mode: int, owner: str) -> npt.NDArray[Any]:
    """Return the triangles (t, 3) or segments (s, 2) that corners form in a primitive mode (3.7.2.1)."""
    first, second, third = corners[:-2], corners[1:-1], corners[2:]
    if mode in (_LINES, _TRIANGLES):
        size = 2 if mode == _LINES else 3
        if len(corners) % size:
            raise MeshError(f"{owner} has {len(corners)} corners, which must be a multiple of {size}")
        return corners.reshape(-1, size)
    if mode == _LINE_STRIP:
        return np.stack([corners[:-1], corners[1:]], axis=1)
    if mode == _LINE_LOOP:
        return np.stack([corners, np.roll(corners, -1)], axis=1)
    if mode == _TRIANGLE_FAN:
        return np.stack([second, third, np.broadcast_to(corners[:1], third.shape)], axis=1)
    if mode == _TRIANGLE_STRIP:
        is_odd = np.arange(len(first)) % 2 == 1
        faces = np.stack([first, np.where(is_odd, third, second), np.where(is_odd, second, third)], axis=1)
        degenerate = (first == second) | (second == third) | (third == first)  # they join strips
        kept: npt.NDArray[Any] = faces[~degenerate]
        return kept
    raise MeshError(f"{owner} must have a mode of at most {_TRIANGLE_FAN}, got {mode}")
