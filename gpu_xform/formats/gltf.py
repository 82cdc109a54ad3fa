"""glTF 2.0 as text (`.gltf`), and what it shares with `.glb`."""

from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..errors import ArgumentError, MeshError
from ..geometry.deformable_mesh import DeformableMesh
from ..geometry.instances import find_visible
from ..geometry.mesh import Mesh, count_corners
from ..geometry.nodes import Node
from ..geometry.scene import Scene
from ._concatenate import concatenate_placed
from .gltf_accessors import Accessors
from .gltf_document import Document, read_document, understand, write_gltf
from .gltf_meshes import read_meshes
from .gltf_nodes import build_scene, list_unheld
from .gltf_write import make_document
from .limits import Budget, budget

# Numbers that take as long to make as it takes to pose a mesh of no points by each joint of a point.
_NUMBERS_PER_INFLUENCE = 1 << 8
_NUMBERS_PER_MATRIX = 16


def read_scene(data: bytes, folder: Path | None = None) -> Scene:
    """Return the nodes of a document, each with the meshes that it shows; what several show is one mesh.

    folder : where its buffers may lie, if they are files
    """
    return make_scene(read_document(data, folder))


def read(data: bytes, folder: Path | None = None) -> Mesh:
    """Return all triangles, lines and points of a document, each mesh where its nodes put it."""
    return read_mesh(read_document(data, folder))


def read_mesh(document: Document) -> Mesh:
    """Return all that a document shows as one mesh in the world."""
    mesh = merge_scene(make_scene(document, whole=False))
    content = document.content
    unheld = understand(partial(list_unheld, content), content)
    if not unheld:
        return mesh
    holds = [*mesh.metadata.get("gltf", {}).get("holds", ()), *unheld]
    return mesh.with_attributes(mesh.attributes, metadata={"gltf": {"holds": holds}})


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write a scene of one node that shows the mesh."""
    write_gltf(make_document(mesh), file)


def make_scene(document: Document, *, whole: bool = True) -> Scene:
    """Return the scene that a document shows.

    Unless `whole`, its animations and its metadata are left out, which have no place in a mesh.
    """

    def make() -> Scene:
        accessors = Accessors(document.content, document.buffers)
        primitives = read_meshes(document.content, accessors)
        return build_scene(document, primitives, accessors, whole=whole)

    return understand(make, document.content)


def merge_scene(scene: Scene) -> Mesh:
    """Return all that a scene of meshes shows as one mesh in the world."""
    file = budget()  # a new one each time where no file is read by its name or type
    for node in find_visible(scene):
        for shown in node.models:
            _count(node, shown.model, file)
    try:
        placed = [(layer.model, layer.transform) for layer in scene.layers() if isinstance(layer.model, Mesh)]
    except ArgumentError as error:  # a world matrix that overflows
        raise MeshError(str(error)) from None
    if not placed:
        raise MeshError("it shows no triangles, no lines and no points")
    merged = concatenate_placed(placed)
    holds = [f"{len(scene)} nodes"] if len(scene) > 1 else []
    holds += [f"animation {name!r}" for name in scene.animations]
    return merged.with_attributes(merged.attributes, metadata={"gltf": {"holds": holds}} if holds else None)


def _count(node: Node, model: Any, file: Budget) -> None:
    """Count the points and corners of a model's copies where a node shows it, and what is made to place them."""
    mesh = model.mesh if isinstance(model, DeformableMesh) else model
    if not isinstance(mesh, Mesh):
        return
    size, n_copies, n_values = mesh.positions.size, 1, 0
    if isinstance(model, DeformableMesh):
        n_values += size * int(np.count_nonzero(model.weights if node.weights is None else node.weights))
        if model.skin is not None and model.influences is not None:
            n_values += model.influences.weights.shape[1] * (size + _NUMBERS_PER_INFLUENCE)
            n_values += len(model.skin.joints) * _NUMBERS_PER_MATRIX
    if node.instances is not None:
        n_copies = len(node.instances)
        n_values += n_copies * _NUMBERS_PER_MATRIX
    file.take_numbers(n_copies * (size + count_corners(mesh)), "its nodes")
    file.take_values(n_values, f"node {node.name!r}")
