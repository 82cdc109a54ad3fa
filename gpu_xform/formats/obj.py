"""Wavefront OBJ: points, polygons and polylines with their attributes; curves and surfaces become such.

`obj_blocks` reads a regular file as a few long runs of numbers. In case of doubt, `obj_lines` reads the file line
by line: it accepts the same language, and reports all errors.
"""

from pathlib import Path

from ..geometry.mesh import Mesh
from ._text import plain_text
from .obj_attributes import add_materials
from .obj_attributes import list_losses as list_losses
from .obj_blocks import read_regular
from .obj_lines import read_lines
from .obj_write import write as write


def read(data: bytes, folder: Path | None = None, tolerance: float | None = None) -> Mesh:
    """Return the mesh of an OBJ file; raise MeshError with the line of malformed content.

    folder : where its materials may lie
    tolerance : how far polygons may be from surfaces; a thousandth of the points' diagonal if it is None
    """
    data = plain_text(data)
    mesh = read_regular(data, tolerance) or read_lines(data, tolerance)
    return add_materials(mesh, folder) if "mtllib" in mesh.attributes.material else mesh
