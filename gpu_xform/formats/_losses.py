"""What a file format cannot hold of a mesh, in words for warnings."""

from collections.abc import Callable, Mapping

from ..geometry.mesh import Mesh
from ._warn import warn

ListLosses = Callable[[Mesh], list[str]]

_FAMILIES = {"glb": "gltf"}


def list_attributes(mesh: Mesh) -> list[str]:
    """Return every attribute of a mesh, for formats that hold none."""
    attributes = mesh.attributes
    tables = (("point", attributes.point), ("corner", attributes.corner), ("face", attributes.face))
    lost = [f"{name} per {what}" for what, table in tables for name in table]
    return lost + [f"material ({name})" for name in attributes.material]


def warn_of_losses(mesh: Mesh, file_type: str, list_losses: ListLosses | None) -> None:
    """Issue one MeshWarning that lists what a format cannot hold, and what the reader left out, if there is anything.

    Metadata of a format say with "holds" what other formats lose, and with "left_out" what is lost in any case.

    list_losses : lists what the format cannot hold of the attributes; None if the writer warns itself
    """
    lost = [] if list_losses is None else list_losses(mesh)
    for source, held in mesh.metadata.items():
        if source != _FAMILIES.get(file_type, file_type) and isinstance(held, Mapping):
            lost += held.get("holds", ())
    left_out = [
        words for held in mesh.metadata.values() if isinstance(held, Mapping) for words in held.get("left_out", ())
    ]
    parts = [f"{file_type.upper()} does not hold {', '.join(lost)}"] if lost else []
    parts += [f"left out: {', '.join(left_out)}"] if left_out else []
    if parts:
        warn("; ".join(parts))
