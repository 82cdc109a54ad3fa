"""Names of VRML nodes and prototypes: each use becomes the node it means, in the order of the file."""

from collections.abc import Callable
from functools import partial
from typing import Any, cast

from ..errors import MeshError
from ._text import quote
from .vrml_values import Node, Prototype, Slot, Use

# The prototype of a node in the body of its own: one that nobody gives.
ITSELF = Prototype("", 0, is_external=True)


class _Names:
    """The nodes and prototypes that have a name at some place of a file."""

    def __init__(self) -> None:
        self._nodes: list[dict[str, Node]] = [{}]
        self._prototypes: dict[str, list[Prototype]] = {}
        self._declared: list[list[str]] = [[]]

    def enter_scope(self, prototype: Prototype) -> None:
        """Begin the body of a prototype, whose names are its own; in it, none is of it."""
        self._nodes.append({})
        self._declared.append([])
        if not self._prototypes.get(prototype.name):
            self._prototypes[prototype.name] = [ITSELF]
            self._declared[-1].append(prototype.name)

    def exit_scope(self) -> None:
        """End the body of a prototype."""
        self._nodes.pop()
        for name in self._declared.pop():
            self._prototypes[name].pop()

    def define(self, node: Node) -> None:
        """Let a USE find a node."""
        self._nodes[-1][cast("str", node.name)] = node

    def declare(self, prototype: Prototype) -> None:
        """Let nodes be of a prototype."""
        self._prototypes.setdefault(prototype.name, []).append(prototype)
        self._declared[-1].append(prototype.name)

    def find_node(self, use: Use) -> Node:
        """Return the node of a USE; raise MeshError if no node before it has the name."""
        for names in reversed(self._nodes):
            if use.name in names:
                return names[use.name]
        raise MeshError(f"line {use.line}: USE {quote(use.name)}, but no node before it has that name")

    def find_prototype(self, kind: str) -> Prototype | None:
        """Return the prototype of a kind of node, if it has one."""
        found = self._prototypes.get(kind)
        return found[-1] if found else None


def resolve_names(roots: list[Any]) -> int:
    """Replace every Use by its node, and give instances their prototypes, in the order of the file; count the nodes."""
    names = _Names()
    n_nodes = 0
    # Entries are places to resolve, nodes whose end is reached, or functions that begin or end a body.
    pending: list[Slot | Node | Callable[[], None]] = [(roots, i) for i in reversed(range(len(roots)))]
    while pending:
        entry = pending.pop()
        if isinstance(entry, Node):
            names.define(entry)
            continue
        if not isinstance(entry, tuple):
            entry()
            continue
        values, i = entry
        item = values[i]
        if isinstance(item, Use):
            values[i] = names.find_node(item)
        elif isinstance(item, Node):
            n_nodes += 1
            item.prototype = names.find_prototype(item.kind)
            if item.name is not None:
                pending.append(item)
            pending += reversed(item.slots)
        elif isinstance(item, Prototype):
            pending += [partial(names.declare, item), names.exit_scope, *reversed(item.body_slots)]
            pending += [partial(names.enter_scope, item), *reversed(item.default_slots)]
    return n_nodes
