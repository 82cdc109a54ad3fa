"""The nodes of a glTF document as a scene."""

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .._core.arguments import as_unit_vector, as_vector, require_affine
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from ._text import quote
from .gltf_meshes import get_count


def build_scene(document: Any, meshes: Sequence[Sequence[Mesh]]) -> Scene:
    """Return the default scene of the document, or all its nodes if it lists no scenes.

    meshes : the meshes that each mesh of the document became, one per primitive

    Raises MeshError unless the nodes form trees (3.5.2).
    """
    nodes = document.get("nodes", [])
    if not nodes:
        raise MeshError("it has no nodes")
    parents = _find_parents(nodes)
    names = _assign_names(nodes)
    found = Scene()
    for i in _traverse(nodes, _find_roots(document, parents)):
        above = parents[i]
        try:
            parent = None if above is None else names[above]
            node = found.add(name=names[i], parent=parent, transform=_read_matrix(nodes[i]))
        except (ArgumentError, ArgumentTypeError, MeshError) as error:
            raise MeshError(f"node {i}: {error}") from None
        for mesh in meshes[get_count(nodes[i], "mesh")] if "mesh" in nodes[i] else ():
            node.show(mesh)
    return found


def _find_parents(nodes: Sequence[Any]) -> list[int | None]:
    """Return the parent of each node; raise MeshError for a node with two parents, or within itself."""
    parents: list[int | None] = [None] * len(nodes)
    for i, node in enumerate(nodes):
        for child in node.get("children", []):
            if child < 0 or parents[child] is not None:
                raise MeshError(f"node {i} has the child {child}, which is no node or has a parent already")
            parents[child] = i
    roots = [i for i, parent in enumerate(parents) if parent is None]
    n_reached = sum(1 for _ in _traverse(nodes, roots))
    if n_reached < len(nodes):
        raise MeshError(f"{len(nodes) - n_reached} nodes are descendants of themselves")
    return parents


def _traverse(nodes: Sequence[Any], roots: Sequence[int]) -> Iterator[int]:
    """Yield `roots` and their descendants, depth first, each node after its parent."""
    waiting = list(reversed(roots))
    while waiting:
        i = waiting.pop()
        yield i
        waiting.extend(reversed(nodes[i].get("children", [])))


def _find_roots(document: Any, parents: Sequence[int | None]) -> list[int]:
    """Return the nodes of the scene that have no parent."""
    scenes = document.get("scenes", [])
    if not scenes:
        return [i for i, parent in enumerate(parents) if parent is None]
    listed = scenes[get_count(document, "scene", 0)].get("nodes", [])
    for i in listed:
        if parents[i] is not None:
            raise MeshError(f"the scene lists node {i}, which is in node {parents[i]}")
    if len(set(listed)) < len(listed) or min(listed, default=0) < 0:
        raise MeshError("the scene must list each node once, by a number of at least 0")
    return list(listed)


def _assign_names(nodes: Sequence[Any]) -> list[str]:
    """Return a unique name for each node.

    The first node with a name keeps it; the others become "wheel 2", "wheel 3", ... if those are unused. Node 7, if it
    has no name, becomes "node 7".
    """
    given = [node.get("name") for node in nodes]
    taken, used = set(given), set[str]()
    variants: dict[str, Iterator[str]] = {}
    names: list[str] = []
    for i, name in enumerate(given):
        if name is not None and not isinstance(name, str):
            raise MeshError(f"node {i}: name must be a text, got {quote(repr(name))}")
        if not name or name in used:
            stem = name or f"node {i}"
            name = next(new for new in variants.setdefault(stem, _generate_variants(stem)) if new not in taken)
        taken.add(name)
        used.add(name)
        names.append(name)
    return names


def _generate_variants(stem: str) -> Iterator[str]:
    yield stem
    yield from (f"{stem} {number}" for number in itertools.count(2))


def _read_matrix(node: Any) -> Float64Array:
    """Return the matrix of a node, which holds the matrix itself or T, R and S (3.5.3)."""
    if "matrix" in node:
        if "translation" in node or "rotation" in node or "scale" in node:
            raise MeshError("it has both a matrix and a translation, rotation or scale")
        matrix = as_vector(node["matrix"], "matrix", 16).reshape(4, 4).T
        require_affine(matrix, "matrix")
        return matrix
    matrix = np.eye(4)
    if "rotation" in node:
        matrix[:3, :3] = _convert_quaternion(node["rotation"])
    if "scale" in node:
        matrix[:3, :3] *= as_vector(node["scale"], "scale", 3)
    if "translation" in node:
        matrix[:3, 3] = as_vector(node["translation"], "translation", 3)
    return matrix


def _convert_quaternion(quaternion: Any) -> Float64Array:
    """Return the rotation (3, 3) of a quaternion (x, y, z, w): I + 2 w K + 2 K^2, where K v = (x, y, z) x v."""
    x, y, z, w = as_unit_vector(quaternion, "rotation", 4)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: Float64Array = np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
    return rotation
