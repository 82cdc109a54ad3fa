"""What a scene draws: each model with its style, once, and the matrices of all its instances."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
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
    found: dict[Any, tuple[Shown, list[Float64Array], list[str]]] = {}
    skins: dict[int, Float64Array] = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for node in nodes:
            worlds[node.name] = worlds[node.parent] @ node.transform
        for node in find_visible(nodes):
            for shown in node.models:
                placed, copies = _place(shown, node, worlds, skins)
                _, places, names = found.setdefault(_make_key(placed), (placed, [], []))
                places.append(require_finite_world(copies, node))
                names += [node.name] * len(copies)
    return [
        Instances(names[0], shown.model, shown.style, np.concatenate(places), tuple(names))
        for shown, places, names in found.values()
        if names
    ]


def find_visible(nodes: Iterable[Node]) -> Iterator[Node]:
    """Yield the nodes that are visible, and in none that is not; every node comes after its parent."""
    hidden: set[str | None] = set()
    for node in nodes:
        if node.parent in hidden or not node.visible:
            hidden.add(node.name)
        else:
            yield node


def _place(
    shown: Shown, node: Node, worlds: Mapping[str | None, Float64Array], skins: dict[int, Float64Array]
) -> tuple[Shown, Float64Array]:
    """Return what a node shows as a mesh that is not deformed any more, and where its copies are in the world.

    skins : the matrices of their joints, by `id`, of those that were met before
    """
    world, model = worlds[node.name], shown.model
    if isinstance(model, DeformableMesh):
        skin = model.skin
        if skin is not None and id(skin) not in skins:
            missing = [name for name in skin.joints if name not in worlds]
            if missing:
                raise ArgumentError.expecting("skin", "have its joints in the scene", repr(missing[0]))
            skins[id(skin)] = np.stack([worlds[name] for name in skin.joints])
        with prefix_errors(f"node {node.name!r}"):
            shown = shown._replace(model=model.posed(node.weights, None if skin is None else skins[id(skin)]))
        if skin is not None:
            # The joints have put it into the world, whatever the matrix of its node (glTF 2.0, 3.7.3.3).
            world = np.eye(4)
    return shown, world[np.newaxis] if node.instances is None else world @ node.instances


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
