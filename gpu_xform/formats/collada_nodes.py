"""Nodes of COLLADA scenes: the shapes that they show, and the matrix of each."""

import functools
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ._text import quote
from .limits import budget

_TRANSFORMS = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3, "lookat": 9}
# A geometry's URL, and the symbol and the target of each material that it is bound to.
Shape = tuple[str, tuple[tuple[str | None, str], ...]]


@dataclass
class Placed:
    """What a scene shows, in the order of its nodes: the number of a shape, and that of a matrix, each."""

    shapes: list[Shape]
    shape_numbers: IndexArray
    matrices: Float64Array
    matrix_numbers: IndexArray
    lost: list[str]


@dataclass(slots=True)
class _Node:
    """A node: its matrix, if it has one, and its nodes and shapes, in their order."""

    matrix: Float64Array | None
    items: list[Any]  # elements of nodes, and numbers of shapes
    size: int | None = None  # of its nodes and shapes in all; None while it is open
    shows: bool = False


@dataclass
class _Reader:
    """The nodes of a file, each read once however often it is shown."""

    by_id: dict[str, Any]
    nodes: dict[Any, _Node] = field(default_factory=dict)
    shapes: dict[Shape, int] = field(default_factory=dict)
    lost: dict[str, None] = field(default_factory=dict)

    def read(self, first: Any) -> _Node:
        """Return a node, when all nodes within it have been read."""
        waiting = [first]
        while waiting:
            element = waiting[-1]
            node = self.nodes.get(element)
            if node is None:
                node = self.nodes[element] = self._read_node(element)
                waiting += [item for item in node.items if not isinstance(item, int) and item not in self.nodes]
                if waiting[-1] is not element:
                    continue
            waiting.pop()
            if node.size is not None:
                continue
            inner = [self.nodes[item] for item in node.items if not isinstance(item, int)]
            if any(each.size is None for each in inner):
                raise MeshError("a node is a part of itself")
            node.size = 1 + len(node.items) - len(inner) + sum(each.size or 0 for each in inner)
            node.shows = len(inner) < len(node.items) or any(each.shows for each in inner)
        return self.nodes[first]

    def _read_node(self, element: Any) -> _Node:
        matrices: list[Float64Array] = []
        items: list[Any] = []
        for child in element.iterchildren("{*}*"):
            tag = child.tag.rpartition("}")[2]
            if tag == "node":
                items.append(child)
            elif tag == "instance_node":
                url = child.get("url") or ""
                if url[1:] in self.by_id and url.startswith("#"):
                    items.append(self.by_id[url[1:]])
                else:
                    self.lost[f"node {quote(url)}, which is not there"] = None
            elif tag == "instance_geometry":
                items.append(self.shapes.setdefault(_read_shape(child), len(self.shapes)))
            elif tag in _TRANSFORMS:
                matrices.append(_read_matrix(tag, child.text or ""))
            elif tag in ("skew", "instance_controller"):
                self.lost["skins" if tag == "instance_controller" else "skew transforms"] = None
        with np.errstate(over="ignore", invalid="ignore"):
            return _Node(functools.reduce(np.dot, matrices) if matrices else None, items)


def place_shapes(root: Any) -> Placed:
    """Return what the scene of a file shows.

    Raises MeshError for no scene, a node within itself, and transforms that are not numbers.
    """
    budget().spell_nodes(sum(1 for _ in root.iter("{*}node", "{*}instance_node", "{*}instance_geometry")))
    reader = _Reader({node.get("id"): node for node in root.iter("{*}node") if node.get("id") is not None})
    roots = list(_find_scene(root).iterchildren("{*}node"))
    budget().take_nodes(sum(reader.read(element).size or 0 for element in roots), "its nodes")
    matrices: list[Float64Array] = [np.eye(4)]
    shape_numbers: list[int] = []
    matrix_numbers: list[int] = []
    waiting: list[tuple[Any, int, int]] = [(element, 0, 1) for element in reversed(roots)]
    while waiting:
        item, above, depth = waiting.pop()
        if isinstance(item, int):
            shape_numbers.append(item)
            matrix_numbers.append(above)
            continue
        budget().require_depth(depth)
        node = reader.nodes[item]
        if not node.shows:
            continue
        if node.matrix is not None:
            with np.errstate(over="ignore", invalid="ignore"):
                matrices.append(matrices[above] @ node.matrix)
            above = len(matrices) - 1
        waiting += [(inner, above, depth + 1) for inner in reversed(node.items)]
    return Placed(
        list(reader.shapes),
        np.array(shape_numbers, np.int64),
        np.array(matrices),
        np.array(matrix_numbers, np.int64),
        list(reader.lost),
    )


def _find_scene(root: Any) -> Any:
    """Return the visual scene that a file shows."""
    urls = [
        instance.get("url") or ""
        for scene in root.iterchildren("{*}scene")
        for instance in scene.iterchildren("{*}instance_visual_scene")
    ]
    scenes = {
        scene.get("id"): scene
        for library in root.iterchildren("{*}library_visual_scenes")
        for scene in library.iterchildren("{*}visual_scene")
    }
    if not urls:
        raise MeshError("it is not COLLADA, or shows no scene")
    if urls[0][1:] not in scenes:
        raise MeshError(f"it is not COLLADA: there is no scene {quote(urls[0])}")
    return scenes[urls[0][1:]]


def _read_shape(instance: Any) -> Shape:
    bindings = [
        (material.get("symbol"), material.get("target") or "")
        for bound in instance.iterchildren("{*}bind_material")
        for technique in bound.iterchildren("{*}technique_common")
        for material in technique.iterchildren("{*}instance_material")
    ]
    return instance.get("url") or "", tuple(dict(bindings).items())


def _read_matrix(tag: str, text: str) -> Float64Array:
    """Return the matrix of a transform, for column vectors."""
    try:
        numbers = np.array([float(word) for word in text.split()])
    except ValueError:
        numbers = np.empty(0)
    if len(numbers) != _TRANSFORMS[tag] or not np.isfinite(numbers).all():
        raise MeshError(f"<{tag}> must be {_TRANSFORMS[tag]} numbers, got {quote(text)}")
    if tag == "matrix":
        return numbers.reshape(4, 4)
    matrix = np.eye(4)
    if tag == "translate":
        matrix[:3, 3] = numbers
    elif tag == "scale":
        matrix[[0, 1, 2], [0, 1, 2]] = numbers
    elif tag == "rotate":
        matrix[:3, :3] = _rotate(*numbers.tolist())
    else:
        matrix[:3] = _look_at(*numbers.reshape(3, 3))
    return matrix


def _look_at(eye: Float64Array, interest: Float64Array, up: Float64Array) -> Float64Array:
    """Return the axes and the place (3, 4) of what stands at `eye` and has `interest` before it, along -z."""
    with np.errstate(all="ignore"):
        back = (eye - interest) / np.linalg.norm(eye - interest)
        side = np.cross(up, back)
        side /= np.linalg.norm(side)
        return np.stack([side, np.cross(back, side), back, eye], axis=1)


def _rotate(x: float, y: float, z: float, degrees: float) -> Float64Array:
    """Return the rotation (3, 3) about an axis of unit length, as Rodrigues' formula gives it."""
    angle = math.radians(degrees)
    c, s = math.cos(angle), math.sin(angle)
    t = 1.0 - c
    return np.array(
        [
            [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
            [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
        ]
    )
