"""What a file format cannot hold of a mesh, in words for warnings."""

from collections.abc import Callable, Collection, Iterable, Mapping
from itertools import islice
from typing import Any

import numpy as np

from .._core.types import Float64Array
from ..geometry.mesh import Mesh
from ._text import quote
from ._warn import warn

ListLosses = Callable[[Mesh], list[str]]

_FAMILIES = {"glb": "gltf"}
_NAMES = {"gltf": "glTF"}
_MAX_NAMED = 4
_MAX_ROUNDING = 8 * 2.0**-24


def list_attributes(mesh: Mesh) -> list[str]:
    """Return every attribute of a mesh, for formats that hold none."""
    attributes = mesh.attributes
    tables = (("point", attributes.point), ("corner", attributes.corner), ("face", attributes.face))
    lost = [f"{name} per {what}" for what, table in tables for name in table]
    return lost + [f"material ({name})" for name in attributes.material]


def list_rounding(positions: Float64Array) -> list[str]:
    """Return by how much float32 changes coordinates, if it does so more than for a model around the origin.

    Half of float32's spacing at the extent of a model is what every model loses; several times that is named.
    """
    if len(positions) == 0:
        return []
    with np.errstate(over="ignore", invalid="ignore"):
        change = float(np.abs(positions.astype(np.float32) - positions).max())
        extent = float((positions.max(axis=0) - positions.min(axis=0)).max())
    if extent == 0.0 or not change > _MAX_ROUNDING * extent:
        return []
    return [f"all digits of coordinates, which change by up to {change:.2g}"]


def list_material_losses(materials: Mapping[str, Any], kept_names: Collection[str]) -> list[str]:
    """Return what is lost of materials by a format that holds the names alone of those in `kept_names`."""
    lost: dict[str, list[str]] = {}
    for name, content in materials.items():
        if name not in kept_names or not isinstance(content, Mapping):
            lost.setdefault(f"material ({name})", [])
            continue
        surface = content.get("pbrMetallicRoughness", {})
        rest = {key for key in content if key not in ("name", "pbrMetallicRoughness", "alphaMode")}
        rest |= {key for key in surface if key not in ("baseColorFactor", "metallicFactor")}
        if "baseColorFactor" in surface:
            lost.setdefault("colour of ", []).append(name)
        textures = {key for key in rest if key.endswith("Texture")}
        if textures:
            lost.setdefault("textures of ", []).append(name)
        if rest - textures:
            lost.setdefault("other properties of ", []).append(name)
    return [what + (name_materials(names) if names else "") for what, names in lost.items()]


def name_materials(names: Collection[str]) -> str:
    """Return such as "material 'steel'", or "materials 'steel', 'paint'"."""
    some = list(map(quote, islice(names, _MAX_NAMED)))
    more = [f"{len(names) - _MAX_NAMED} more"] if len(names) > _MAX_NAMED else []
    return f"material{'s' if len(names) > 1 else ''} {', '.join(some + more)}"


def warn_of(lost: Collection[str], metadata: Iterable[Mapping[str, Any]], file_type: str) -> None:
    """Issue one MeshWarning of what a format cannot hold, and of what readers left out, if there is anything.

    Metadata of a format say with "holds" what other formats lose, and with "left_out" what is lost in any case.

    lost : what the format cannot hold of the attributes
    metadata : those of all that is written
    """
    family = _FAMILIES.get(file_type, file_type)
    lost, left_out = list(lost), []
    for described in metadata:
        for source, held in described.items():
            if isinstance(held, Mapping):
                lost += held.get("holds", ()) if source != family else ()
                left_out += held.get("left_out", ())
    name = _NAMES.get(family, file_type.upper())
    parts = [f"{name} does not hold {', '.join(dict.fromkeys(lost))}"] if lost else []
    parts += [f"left out: {', '.join(dict.fromkeys(left_out))}"] if left_out else []
    if parts:
        warn("; ".join(parts))
