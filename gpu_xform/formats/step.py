"""STEP (ISO 10303-21), through cascadio: triangles in the unit of the file, which know their face of the B-rep."""

import math
import re
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError, MeshError
from ..geometry.attributes import Attributes
from ..geometry.edges import BREP_FACE
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from ._warn import warn
from .gltf import merge_scene
from .gltf_accessors import Accessors, get_count
from .gltf_document import Document, read_glb, understand
from .gltf_meshes import Primitive
from .gltf_nodes import build_scene
from .limits import budget
from .step_process import make_glb
from .step_text import StepText, read_text

_DEFAULT_TOLERANCE = 2e-3  # of the size of the file
_MIN_TOLERANCE = 1e-6  # of the size: a sphere has some three million triangles then
_SINGLE = 2.0**-24  # what single precision, in which the library answers, may change a number by
_UNNAMED_USE = re.compile(r"NAUO\s*\d*|\d+|=>\[.*\]|", re.IGNORECASE)


def read(data: bytes, tolerance: float | None = None) -> Mesh:
    """Return all parts where the assembly puts them, in the unit of the file. Raises as `read_scene` does."""
    scene = read_scene(data, tolerance)
    mesh = merge_scene(scene)
    return mesh.with_attributes(mesh.attributes, metadata={"step": dict(scene.metadata["step"])})


def read_scene(data: bytes, tolerance: float | None = None) -> Scene:
    """Return a node per part and assembly, in the unit of the file; parts that are alike are one mesh.

    Raises MeshError for a damaged file, MissingExtraError if the extra `cad` is not installed, ArgumentError for a
    tolerance that is too fine for the size of the file.
    """
    text = read_text(data)
    if text.other_units:
        warn(f"parts in {', '.join(text.other_units)} are converted to {text.unit}")
    glb = make_glb(text.data, 1000.0 * text.metres * _choose_tolerance(text, tolerance))
    budget().allow_bytes(len(glb))
    document = read_glb(glb)
    metadata = {"step": {"unit": text.unit, "metres": text.metres}}

    def build() -> Scene:
        accessors = Accessors(document.content, document.buffers)
        parts = _read_parts(document, accessors, 1.0 / text.metres)
        _place_nodes(document.content, 1.0 / text.metres)
        scene = build_scene(document, parts, accessors, whole=False)
        placed = Scene(metadata=metadata)
        for node in scene:
            copied = placed.add(name=node.name, parent=node.parent, transform=node.transform)
            for shown in node.models:
                copied.show(shown.model)
        return placed

    return understand(build, document.content)


def _choose_tolerance(text: StepText, tolerance: float | None) -> float:
    """Return the tolerance in the unit of the file."""
    if tolerance is None:
        return _DEFAULT_TOLERANCE * text.size or _DEFAULT_TOLERANCE
    if tolerance < _MIN_TOLERANCE * text.size:
        expected = f"be at least {_MIN_TOLERANCE * text.size:.3g}, a millionth of the size of the file"
        raise ArgumentError.expecting("tolerance", expected, f"{tolerance:g}")
    return tolerance


def _read_parts(document: Document, accessors: Accessors, scale: float) -> list[list[Primitive]]:
    """Return the mesh of each mesh of a document, one object for those that are alike."""
    content = document.content
    materials = content.get("materials", [])
    colors = np.array([*map(_read_color, materials), _read_color({})])
    known: dict[Any, list[Primitive]] = {}
    found = []
    n_before = 0
    for i, part in enumerate(content.get("meshes", [])):
        faces = [face for face in part["primitives"] if face.get("mode", 4) == 4]
        arrays = [
            (
                accessors.floats(get_count(face["attributes"], "POSITION"), "VEC3"),
                accessors.floats(get_count(face["attributes"], "NORMAL"), "VEC3"),
                accessors.indices(get_count(face, "indices")).astype(np.int64).reshape(-1, 3),
            )
            for face in faces
        ]
        if not arrays:
            found.append(list[Primitive]())
            continue
        budget().take_numbers(sum(6 * len(points) + corners.size for points, _, corners in arrays), f"part {i}")
        of_face = [get_count(face, "material") if "material" in face else -1 for face in faces]
        if max(of_face) >= len(materials):
            raise MeshError(f"part {i} names a material that it does not have")
        key = part.get("name"), *of_face, *(array.tobytes() for own in arrays for array in own)
        if key not in known:
            mesh = _weld(arrays, colors[of_face] if materials else None, n_before, scale, f"part {i}")
            n_before += len(arrays)
            metadata = {"step": {"product": part["name"]}} if part.get("name") else None
            known[key] = [Primitive(mesh.with_attributes(mesh.attributes, metadata=metadata), (), None)]
        found.append(known[key])
    return found


def _weld(
    arrays: list[tuple[Float64Array, Float64Array, IndexArray]],
    colors: npt.NDArray[np.uint8] | None,
    n_before: int,
    scale: float,
    owner: str,
) -> Mesh:
    """Return the faces of a part as one mesh, in which adjacent faces share their points.

    The library gives each face points of its own, the same along an edge, so what coincides is one.

    colors : (faces, 4), of the faces
    n_before : the number of the first face
    """
    points_before = np.cumsum([0, *(len(points) for points, _, _ in arrays)])
    points = np.concatenate([points for points, _, _ in arrays])
    normals = np.concatenate([normals for _, normals, _ in arrays])
    corners = np.concatenate([corners + n for (_, _, corners), n in zip(arrays, points_before, strict=False)])
    if len(corners) and (corners.max() >= len(points) or len(normals) != len(points)):
        raise MeshError(f"{owner}: the triangles do not fit the points")
    unique, numbers = np.unique(_round(points * scale), axis=0, return_inverse=True)
    welded = numbers.reshape(-1)[corners]
    has_area = (welded != np.roll(welded, 1, axis=1)).all(axis=1)
    of_triangle = np.repeat(np.arange(len(arrays), dtype=np.int32), [len(corners) for _, _, corners in arrays])[
        has_area
    ]
    face = {BREP_FACE: of_triangle + np.int32(n_before)}
    if colors is not None:
        face["color"] = colors[of_triangle]
    normal = normals[corners[has_area].ravel()].astype(np.float32)
    return Mesh(unique, welded[has_area], attributes=Attributes(corner={"normal": normal}, face=face))


def _read_color(material: Any) -> npt.NDArray[np.uint8]:
    """Return the colour of a material as the file has it: glTF's are linear, those of STEP are shown as they are."""
    *rgb, alpha = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
    linear = np.clip(np.array(rgb, np.float64), 0.0, 1.0)
    shown = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)  # IEC 61966-2-1
    return np.round(255.0 * np.append(shown, min(max(alpha, 0.0), 1.0))).astype(np.uint8)


def _place_nodes(content: Any, scale: float) -> None:
    """Put the matrices of nodes into the unit of the file, and give nodes that have no name that of their part."""
    meshes = content.get("meshes", [])
    for node in content.get("nodes", []):
        if "matrix" in node:
            node["matrix"][12:15] = _round(scale * np.array(node["matrix"][12:15], np.float64)).tolist()
        if _UNNAMED_USE.fullmatch(node.get("name") or ""):
            node["name"] = (meshes[get_count(node, "mesh")].get("name") if "mesh" in node else None) or node.get("name")


def _round(values: Float64Array) -> Float64Array:
    """Return values without the digits that single precision has made up: 10 in place of 9.999999776."""
    largest = float(np.abs(values).max(initial=0.0))
    if not 0.0 < largest < math.inf:
        return values
    rounded: Float64Array = np.round(values, -math.ceil(math.log10(largest * _SINGLE)))
    return rounded
