"""COLLADA (`.dae`), through trimesh and pycollada: triangles in metres, with the axes of the file."""

import logging
import re
from io import BytesIO
from typing import Any

import numpy as np

from ..errors import MeshError, MissingExtraError
from ..geometry.mesh import Mesh
from ._concatenate import concatenate_placed
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

    _count_nodes(root)
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
        meshes = {id(shape): _convert(shape) for shape in {id(shape): shape for shape, _ in found}.values()}
        scale = np.diag([*[metres] * 3, 1.0])
        return concatenate_placed((meshes[id(shape)], scale @ matrix) for shape, matrix in found)
    except (ValueError, TypeError) as error:
        raise MeshError(f"it is not COLLADA: {error}") from None


def _count_nodes(root: Any) -> None:
    """Count the nodes that the scenes expand to, which pycollada makes without a limit."""
    nodes = list(root.iter("{*}node"))
    by_id = {node.get("id"): node for node in nodes}
    sizes: dict[Any, int | None] = {}  # None while a node is open
    budget().spell_nodes(sum(1 for _ in root.iter("{*}node", "{*}instance_node", "{*}instance_geometry")))
    for first in nodes:
        waiting = [first]
        while waiting:
            node = waiting[-1]
            uses = [by_id.get((use.get("url") or "")[1:]) for use in node.iterchildren("{*}instance_node")]
            inner = [*node.iterchildren("{*}node"), *(use for use in uses if use is not None)]
            new = [each for each in inner if each not in sizes]
            if node in sizes and sizes[node] is not None:
                waiting.pop()
            elif new and node not in sizes:
                sizes[node] = None
                waiting += new
            else:
                found = [sizes.get(each) for each in inner]
                if None in found:
                    raise MeshError("a node is a part of itself")
                n_shapes = sum(1 for _ in node.iterchildren("{*}instance_geometry", "{*}instance_controller"))
                sizes[node] = 1 + n_shapes + sum(size for size in found if size is not None)
                waiting.pop()
    of_scenes = (node for scene in root.iter("{*}visual_scene") for node in scene.iterchildren("{*}node"))
    budget().take_nodes(sum(sizes[node] or 0 for node in of_scenes), "its nodes")


def _convert(shape: Any) -> Mesh:
    """Return a mesh of trimesh with a colour per face: that of its material, where it has no others."""
    material = getattr(shape.visual, "material", None)
    color = getattr(material, "main_color", None)
    if color is None:
        return Mesh.from_trimesh(shape)
    colors = np.tile(np.asarray(color, np.uint8), (len(shape.faces), 1))
    return Mesh(shape.vertices, np.asarray(shape.faces), attributes={"face": {"color": colors}})
