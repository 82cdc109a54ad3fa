"""The nodes of a glTF document, as a scene."""

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .._core.arguments import as_unit_vector, as_vector, require_affine
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from ._text import printable
from .gltf_meshes import whole


def scene(document: Any, meshes: Sequence[Sequence[Mesh]]) -> Scene:
    """Return the scene that the document shows first, or, where it lists none, all its nodes.

    Each node shows the one or several of `meshes` that it names. Raises MeshError unless the nodes form trees (3.5.2).
    """
    nodes = document.get("nodes", [])
    if not nodes:
        raise MeshError("it has no nodes")
    parents = _parents(nodes)
    names = _names(nodes)
    found = Scene()
    for i in _depth_first(nodes, _roots(document, parents)):
        above = parents[i]
        try:
            node = found.add(name=names[i], parent=None if above is None else names[above], transform=_local(nodes[i]))
        except (ArgumentError, ArgumentTypeError, MeshError) as error:
            raise MeshError(f"node {i}: {error}") from None
        for mesh in meshes[whole(nodes[i], "mesh")] if "mesh" in nodes[i] else ():
            node.show(mesh)
    return found


def _parents(nodes: Sequence[Any]) -> list[int | None]:
    """Return the parent of each node; raise MeshError where one has two, or is in itself."""
    parents: list[int | None] = [None] * len(nodes)
    for i, node in enumerate(nodes):
        for child in node.get("children", []):
            if child < 0 or parents[child] is not None:
                raise MeshError(f"node {i} has the child {child}, which is no node or has a parent already")
            parents[child] = i
    roots = [i for i, parent in enumerate(parents) if parent is None]
    n_reached = sum(1 for _ in _depth_first(nodes, roots))
    if n_reached < len(nodes):
        raise MeshError(f"{len(nodes) - n_reached} nodes are descendants of themselves")
    return parents


def _depth_first(nodes: Sequence[Any], roots: Sequence[int]) -> Iterator[int]:
    """Yield `roots` and all that is below them, each node after its parent."""
    waiting = list(reversed(roots))
    while waiting:
        i = waiting.pop()
        yield i
        waiting.extend(reversed(nodes[i].get("children", [])))


def _roots(document: Any, parents: Sequence[int | None]) -> list[int]:
    """Return the nodes that stand directly in the scene."""
    scenes = document.get("scenes", [])
    if not scenes:
        return [i for i, parent in enumerate(parents) if parent is None]
    listed = scenes[whole(document, "scene", 0)].get("nodes", [])
    for i in listed:
        if parents[i] is not None:
            raise MeshError(f"the scene lists node {i}, which is in node {parents[i]}")
    if len(set(listed)) < len(listed) or min(listed, default=0) < 0:
        raise MeshError("the scene must list each node once, by a number of at least 0")
    return list(listed)


def _names(nodes: Sequence[Any]) -> list[str]:
    """Return a name for each node that no other has.

    The first of a name keeps it; the others become "wheel 2", "wheel 3", ... as far as those are free. Node 7, where it
    has no name, becomes "node 7".
    """
    given = [node.get("name") for node in nodes]
    taken, used = set(given), set[str]()
    variants: dict[str, Iterator[str]] = {}
    names: list[str] = []
    for i, name in enumerate(given):
        if name is not None and not isinstance(name, str):
            raise MeshError(f"node {i}: name must be a text, got {printable(repr(name))}")
        if not name or name in used:
            stem = name or f"node {i}"
            name = next(new for new in variants.setdefault(stem, _variants(stem)) if new not in taken)
        taken.add(name)
        used.add(name)
        names.append(name)
    return names


def _variants(stem: str) -> Iterator[str]:
    yield stem
    yield from (f"{stem} {number}" for number in itertools.count(2))


def _local(node: Any) -> Float64Array:
    """Return the matrix of a node, given as such or as T R S (3.5.3)."""
    if "matrix" in node:
        if "translation" in node or "rotation" in node or "scale" in node:
            raise MeshError("it has both a matrix and a translation, rotation or scale")
        matrix = as_vector(node["matrix"], "matrix", 16).reshape(4, 4).T
        require_affine(matrix, "matrix")
        return matrix
    matrix = np.eye(4)
    if "rotation" in node:
        matrix[:3, :3] = _rotation(node["rotation"])
    if "scale" in node:
        matrix[:3, :3] *= as_vector(node["scale"], "scale", 3)
    if "translation" in node:
        matrix[:3, 3] = as_vector(node["translation"], "translation", 3)
    return matrix


def _rotation(quaternion: Any) -> Float64Array:
    """Return the rotation (3, 3) of a quaternion (x, y, z, w): I + 2 w K + 2 K^2, where K v = (x, y, z) x v."""
    x, y, z, w = as_unit_vector(quaternion, "rotation", 4)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Float64Array = np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
    return rotation
