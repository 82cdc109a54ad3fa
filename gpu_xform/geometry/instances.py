"""What a scene draws: each model with its style, once, and the matrices of all its instances."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .._core.error_context import prefix_errors
from .._core.types import Float64Array
from ..errors import ArgumentError
from .deformable_mesh import DeformableMesh
from .nodes import Node, Shown, require_finite_world


class Instances(NamedTuple):
    """All instances of a model that have the same style.

    node : the name of the first node that shows the model
    style : keywords of `render`
    transform : (k, 4, 4), from the model to the world, one per instance
    nodes : the name of the node that shows each instance, (k,)
    """

    node: str
    model: Any
    style: Mapping[str, Any]
    transform: Float64Array
    nodes: tuple[str, ...] = ()


def gather_instances(nodes: Sequence[Node]) -> list[Instances]:
    """Return what visible nodes show, grouped by model and style; every node comes after its parent."""
    worlds: dict[str | None, Float64Array] = {None: np.eye(4)}
    hidden: set[str | None] = set()
    found: dict[Any, tuple[Shown, list[Float64Array], list[str]]] = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for node in nodes:
            worlds[node.name] = worlds[node.parent] @ node.transform
            if node.parent in hidden or not node.visible:
                hidden.add(node.name)
        for node in nodes:
            if node.name in hidden:
                continue
            for shown in node.models:
                placed, copies = _place(shown, node, worlds)
                _, places, names = found.setdefault(_make_key(placed), (placed, [], []))
                places += [require_finite_world(copy_matrix, node) for copy_matrix in copies]
                names += [node.name] * (len(places) - len(names))
    return [
        Instances(names[0], shown.model, shown.style, np.stack(places), tuple(names))
        for shown, places, names in found.values()
        if places
    ]


def _place(shown: Shown, node: Node, worlds: Mapping[str | None, Float64Array]) -> tuple[Shown, list[Float64Array]]:
    """Return what a node shows as a mesh that is not deformed any more, and where its copies are in the world."""
    world, model = worlds[node.name], shown.model
    if isinstance(model, DeformableMesh):
        skin = model.skin
        missing = [] if skin is None else [name for name in skin.joints if name not in worlds]
        if missing:
            raise ArgumentError.expecting("skin", "have its joints in the scene", repr(missing[0]))
        joints = None if skin is None else np.stack([worlds[name] for name in skin.joints])
        with prefix_errors(f"node {node.name!r}"):
            shown = shown._replace(model=model.posed(node.weights, joints))
        if skin is not None:
            # The joints have put it into the world, whatever the matrix of its node (glTF 2.0, 3.7.3.3).
            world = np.eye(4)
    return shown, [world] if node.instances is None else list(world @ node.instances)


def _make_key(shown: Shown) -> tuple[Any, ...]:
    """Return a key of the model and its style: what has the same key is drawn as instances of one model."""
    return _make_identity(shown.model), frozenset((name, _make_identity(value)) for name, value in shown.style.items())


def _make_identity(value: Any) -> Any:
    """Return a key that is the same for equal texts and numbers, and otherwise for one object alone."""
    try:
        hash(value)
    except TypeError:
        return object, id(value)
    return value
