"""What a file format cannot hold of a mesh, in words for warnings."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from ..geometry.mesh import Mesh
from ._warn import warn

ListLosses = Callable[[Mesh], list[str]]

_FAMILIES = {"glb": "gltf"}
_NAMES = {"gltf": "glTF"}


def list_attributes(mesh: Mesh) -> list[str]:
    """Return every attribute of a mesh, for formats that hold none."""
    attributes = mesh.attributes
    tables = (("point", attributes.point), ("corner", attributes.corner), ("face", attributes.face))
    lost = [f"{name} per {what}" for what, table in tables for name in table]
    return lost + [f"material ({name})" for name in attributes.material]


def warn_of_losses(mesh: Mesh, file_type: str, list_losses: ListLosses | None) -> None:
    """Issue one MeshWarning that lists what a format cannot hold, and what the reader left out, if there is anything.

    list_losses : lists what the format cannot hold of the attributes; None if the writer warns itself
    """
    if list_losses is not None:
        warn_of(list_losses(mesh), [mesh.metadata], file_type)


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
