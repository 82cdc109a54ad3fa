"""COLLADA (`.dae`), through trimesh and pycollada: triangles in metres, with the axes of the file."""

import logging
import re
from io import BytesIO
from typing import Any

import numpy as np

from ..errors import MeshError, MissingExtraError
from ..geometry.mesh import Mesh
from ._concatenate import concatenate
from ._warn import warn
from ._xml import parse_xml
from .limits import budget

_BINDINGS = re.compile(rb"<bind_material>.*?</bind_material>", re.DOTALL)


def read(data: bytes) -> Mesh:
    """Return all triangles where the nodes of the scene put them, in the colours of their materials.

    Raises MeshError for a damaged file, MissingExtraError if the extra `robots` is not installed.
    """
    root = parse_xml(data, "COLLADA")
    try:
        import collada
        import trimesh
    except ImportError:
        raise MissingExtraError("COLLADA needs pycollada: pip install 'gpu_xform[robots]'") from None
    from lxml import etree

    data = etree.tostring(root)  # which pycollada parses without our care
    log = logging.getLogger("trimesh")
    was_disabled, log.disabled = log.disabled, True
    try:
        document = collada.Collada(BytesIO(data), ignore=[collada.common.DaeError])
        metres = document.assetInfo.unitmeter or 1.0
        is_broken = bool(document.errors)
        if is_broken:  # pycollada drops what has a material that it does not find
            data = _BINDINGS.sub(b"", data)
        scene = trimesh.load_scene(BytesIO(data), file_type="dae", process=False)
        found = [
            (scene.geometry[name], np.asarray(matrix, np.float64))
            for matrix, name in map(scene.graph.get, scene.graph.nodes_geometry)
        ]
    except MemoryError:
        raise
    except Exception as error:  # whatever damaged content brings the libraries to
        raise MeshError(f"it is not COLLADA: {type(error).__name__}: {error}") from None
    finally:
        log.disabled = was_disabled
    found = [(shape, matrix) for shape, matrix in found if isinstance(shape, trimesh.Trimesh) and len(shape.faces)]
    if not found:
        raise MeshError("it shows no triangles")
    if is_broken:
        warn("its materials are broken, and left out")
    budget().take_numbers(sum(shape.vertices.size + shape.faces.size for shape, _ in found), "its nodes")
    try:
        return concatenate([_convert(shape).transformed(np.diag([*[metres] * 3, 1.0]) @ m) for shape, m in found])
    except (ValueError, TypeError) as error:
        raise MeshError(f"it is not COLLADA: {error}") from None


def _convert(shape: Any) -> Mesh:
    """Return a mesh of trimesh with a colour per face: that of its material, where it has no others."""
    material = getattr(shape.visual, "material", None)
    color = getattr(material, "main_color", None)
    if color is None:
        return Mesh.from_trimesh(shape)
    colors = np.tile(np.asarray(color, np.uint8), (len(shape.faces), 1))
    return Mesh(shape.vertices, np.asarray(shape.faces), attributes={"face": {"color": colors}})
