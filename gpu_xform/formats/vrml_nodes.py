"""Nodes of VRML in their place: fields with the values that instances of prototypes give them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias, TypeVar

import numpy as np

from .._core.types import Float64Array
from ..errors import MeshError
from ._text import quote
from .vrml_values import Binding, Node, Numbers, Prototype, Value

_T = TypeVar("_T")


_FEW_DIGITS = 16
_STRIDE = 8
_NO_VALUE: "Found" = None, None


class Scope:
    """An instance of a prototype as the nodes of its body see it; `outer` is that in whose body it stands itself."""

    __slots__ = ("_defaults", "_found", "_node", "_outer", "n_entered")

    def __init__(self, node: Node, outer: "Scope | None") -> None:
        self.n_entered = 0  # how often the body was shown
        self._node, self._outer = node, outer
        self._defaults: Mapping[str, Found] = {} if node.prototype is None else node.prototype.defaults
        self._found: dict[str, Found] | None = None  # what other scopes say

    def find(self, name: str) -> "Found":
        """Return the value of a field, None if it has none, and the scope that the value was written in."""
        default = self._defaults.get(name, _NO_VALUE)
        value = None if default is _NO_VALUE else self._node.fields.get(name)
        if value is None:
            return default
        return self._find_bound(name) if type(value) is Binding else (value, self._outer)

    def _find_bound(self, name: str) -> "Found":
        """Return what `find` does, where the instance has the name from the prototype around it, or one around that."""
        asked: list[tuple[Scope, str]] = []
        scope = self
        while (found := None if scope._found is None else scope._found.get(name)) is None:
            asked.append((scope, name))
            value = scope._node.fields.get(name) if name in scope._defaults else None
            if type(value) is not Binding:
                found = scope.find(name)
                break
            if scope._outer is None:
                found = _NO_VALUE
                break
            scope, name = scope._outer, value.name
        for known, of_name in asked[::_STRIDE]:  # prototypes may stand thousands deep within one another
            if known._found is None:
                known._found = {}
            known._found[of_name] = found
        return found


@dataclass(slots=True, unsafe_hash=True)
class PlacedNode:
    """A node, and the values of the names in its `IS name` fields.

    Nobody may change one; as a `NamedTuple` or frozen it would take twice as long to make, and shapes make a dozen.
    """

    node: Node
    scope: Scope | None = None

    @property
    def kind(self) -> str:
        """The name of its type."""
        return self.node.kind

    @property
    def line(self) -> int:
        """The line that it begins on."""
        return self.node.line

    def get(self, name: str) -> "Found":
        """Return the value of a field, None if it has none, and the scope of the value."""
        value, scope = self.node.fields.get(name), self.scope
        if type(value) is Binding:
            return _NO_VALUE if scope is None else scope.find(value.name)
        return value, scope

    def numbers(self, name: str) -> Numbers | None:
        """Return a field of numbers."""
        value = self.node.fields.get(name)
        if type(value) is Binding:
            value = None if self.scope is None else self.scope.find(value.name)[0]
        return value if isinstance(value, Numbers) else None

    def floats(self, name: str, default: tuple[float, ...]) -> Float64Array:
        """Return a field of as many numbers as its default has: (len(default),) float64."""
        numbers = self.numbers(name)
        if numbers is None:
            return np.array(default)
        rows = numbers.floats(len(default))
        if len(rows) != 1:
            raise MeshError(f"line {numbers.line}: {name} needs {len(default)} numbers, got {rows.size}")
        row: Float64Array = rows[0]
        return row

    def table(self, name: str, width: int) -> Float64Array:
        """Return a field of rows of equally many numbers: (n, width), without rows if it has none."""
        numbers = self.numbers(name)
        return np.empty((0, width)) if numbers is None else numbers.floats(width)

    def number(self, name: str, default: float) -> float:
        """Return a field of one number."""
        return default if self.numbers(name) is None else float(self.floats(name, (default,))[0])

    def rows(self, name: str, default: tuple[tuple[float, ...], ...]) -> Float64Array:
        """Return a field of rows as long as its default has, or the default if it has none; nobody may write to it."""
        numbers = self.numbers(name)
        rows = np.empty((0, len(default[0]))) if numbers is None else numbers.floats(len(default[0]))
        return rows if len(rows) else _as_table(default)

    def integer(self, name: str, default: int) -> int:
        """Return a field of one integer."""
        numbers = self.numbers(name)
        if numbers is None:
            return default
        if len(numbers.text) < _FEW_DIGITS and numbers.text.isdecimal() and numbers.text.isascii():
            return int(numbers.text)
        values = numbers.integers()
        if len(values) != 1:
            raise MeshError(f"line {numbers.line}: {name} needs one integer, got {len(values)}")
        return int(values[0])

    def flag(self, name: str, default: bool) -> bool:
        """Return a field that is TRUE or FALSE."""
        value, _ = self.get(name)
        if value is None or isinstance(value, Binding):
            return default
        text = value.text.strip() if isinstance(value, Numbers) else str(value[0]) if value else ""
        if text not in ("TRUE", "FALSE", "1", "0"):
            raise MeshError(f"line {self.line}: {name} of {self.kind} must be TRUE or FALSE, got {quote(text)}")
        return text in ("TRUE", "1")

    def words(self, name: str) -> list[str]:
        """Return the words and the texts of a field, without quotation marks."""
        value, _ = self.get(name)
        if not isinstance(value, list):
            return []
        return [_unquote(str(item)) for item in value if isinstance(item, str)]

    def nodes(self, name: str) -> "list[PlacedNode]":
        """Return the nodes of a field."""
        value, scope = self.get(name)
        return [PlacedNode(item, scope) for item in value if isinstance(item, Node)] if isinstance(value, list) else []

    def first_word(self, name: str) -> str | None:
        """Return the first word or text of a field, without quotation marks; None if there is none."""
        value, _ = self.get(name)
        found = next((item for item in value if isinstance(item, str)), None) if isinstance(value, list) else None
        return None if found is None else _unquote(str(found))

    def first(self, name: str) -> "PlacedNode | None":
        """Return the first node of a field, None if it has none."""
        value, scope = self.get(name)
        if isinstance(value, list):
            for item in value:
                if isinstance(item, Node):
                    return PlacedNode(item, scope)
        return None

    def settled(self) -> "PlacedNode":
        """Return the node without a scope, if all of its fields are written out; the nodes among them lose theirs."""
        is_bound = self.scope is not None and any(type(value) is Binding for value in self.node.fields.values())
        return self if is_bound else PlacedNode(self.node)

    def once(self, read: "Callable[[PlacedNode], _T]") -> _T:
        """Return what `read` makes of the node; a node that is shown often is read twice at most."""
        key = read if self.scope is None else (read, self.scope)
        value: _T | None = self.recall(key)
        if value is None:
            value = read(self)
            self.keep(key, value)
        return value

    def recall(self, key: object) -> Any:
        """Return what was kept for the node with an equal key, if that was the last; else None."""
        node = self.node
        return node.kept if node.key_of_kept == key else None

    def keep(self, key: object, value: Any) -> None:
        """Keep what the node means, but only if its key comes a second time: most nodes are shown once."""
        node = self.node
        node.kept = value if node.key_of_kept == key else None
        node.key_of_kept = key

    def expanded(self, visit: "Visit") -> "PlacedNode | None":
        """Return the first node of the prototype that it is an instance of, None if there is none; else itself.

        visit : is called with 1 and the line of each node on the way
        """
        visit(1, self.node.line)
        placed = self
        while (prototype := placed.node.prototype) is not None and not prototype.is_external:
            body = prototype.find_shown()
            if body is None:
                return None
            scope = _scope_of(placed, prototype)
            scope.n_entered += 1
            visit(1, body.line)
            placed = PlacedNode(body, scope)
        return placed


def _scope_of(instance: PlacedNode, prototype: Prototype) -> Scope:
    """Return the scope of an instance; those that are alike share one, so that what is read in it can be kept."""
    if instance.node.fields:
        return instance.once(_make_scope)
    if prototype.plain_scope is None:
        prototype.plain_scope = _make_scope(instance)
    scope: Scope = prototype.plain_scope
    return scope


def _make_scope(instance: PlacedNode) -> Scope:
    return Scope(instance.node, instance.scope)


def _unquote(word: str) -> str:
    return word[1:-1].replace('\\"', '"').replace("\\\\", "\\") if word[:1] == '"' else word


@cache
def _as_table(rows: tuple[tuple[float, ...], ...]) -> Float64Array:
    return np.array(rows)


Found: TypeAlias = tuple[Value | None, Scope | None]
Visit: TypeAlias = Callable[[int, int], None]
