"""Nodes of VRML in their place: fields with the values that instances of prototypes give them."""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, TypeAlias, TypeGuard, TypeVar

import numpy as np

from .._core.types import Float64Array
from ..errors import MeshError
from ._text import quote
from .vrml_values import Binding, Node, Numbers, Prototype, Value

_T = TypeVar("_T")


class Scope:
    """An instance of a prototype as the nodes of its body see it; `outer` is that in whose body it stands itself."""

    __slots__ = ("_found", "_node", "_outer", "n_entered")

    def __init__(self, node: Node, outer: "Scope | None") -> None:
        self.n_entered = 0  # how often the body was shown
        self._node, self._outer = node, outer
        self._found: dict[str, tuple[Value | None, Scope | None]] = {}

    def find(self, name: str) -> "tuple[Value | None, Scope | None]":
        """Return the value of a field, None if it has none, and the scope that the value was written in."""
        asked: list[tuple[dict[str, tuple[Value | None, Scope | None]], str]] = []
        scope = self
        while (found := scope._found.get(name)) is None:
            asked.append((scope._found, name))
            defaults = {} if scope._node.prototype is None else scope._node.prototype.defaults
            if name not in defaults:
                found = _NO_VALUE
                break
            if name not in scope._node.fields:
                found = defaults[name], None
                break
            value = scope._node.fields[name]
            if not _is_binding(value):
                found = value, scope._outer
                break
            if scope._outer is None:
                found = _NO_VALUE
                break
            scope, name = scope._outer, value[0].name
        for known, of_name in asked[::_STRIDE]:  # prototypes may stand thousands deep within one another
            known[of_name] = found
        return found


_FEW_DIGITS = 16
_STRIDE = 8
_NO_VALUE: tuple[Value | None, Scope | None] = None, None


def _is_binding(value: Value | None) -> TypeGuard[list[Binding]]:
    return type(value) is list and len(value) == 1 and type(value[0]) is Binding


class PlacedNode(NamedTuple):
    """A node, and the values of the names in its `IS name` fields."""

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

    def get(self, name: str) -> tuple[Value | None, Scope | None]:
        """Return the value of a field, None if it has none, and the scope of the value."""
        value = self.node.fields.get(name)
        if value is not None and _is_binding(value):
            return _NO_VALUE if self.scope is None else self.scope.find(value[0].name)
        return value, self.scope

    def numbers(self, name: str) -> Numbers | None:
        """Return a field of numbers."""
        value = self.node.fields.get(name)
        if value is None or isinstance(value, Numbers):
            return value
        value, _ = self.get(name)
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
        if name not in self.node.fields:
            return default
        value, _ = self.get(name)
        if value is None:
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
        if name not in self.node.fields:
            return []
        value, scope = self.get(name)
        return [PlacedNode(item, scope) for item in value if isinstance(item, Node)] if isinstance(value, list) else []

    def first_word(self, name: str) -> str | None:
        """Return the first word or text of a field, without quotation marks; None if there is none."""
        value, _ = self.get(name)
        found = next((item for item in value if isinstance(item, str)), None) if isinstance(value, list) else None
        return None if found is None else _unquote(str(found))

    def first(self, name: str) -> "PlacedNode | None":
        """Return the first node of a field, None if it has none."""
        if name not in self.node.fields:
            return None
        value, scope = self.get(name)
        if not isinstance(value, list):
            return None
        for item in value:
            if isinstance(item, Node):
                return PlacedNode(item, scope)
        return None

    def settled(self) -> "PlacedNode":
        """Return the node without a scope, if all of its fields are written out; the nodes among them lose theirs."""
        is_bound = self.scope is not None and any(map(_is_binding, self.node.fields.values()))
        return self if is_bound else PlacedNode(self.node)

    def once(self, read: "Callable[[PlacedNode], _T]") -> _T:
        """Return what `read` makes of the node; a node that is shown often is read twice at most."""
        key = read, self.scope
        value: _T | None = self.recall(key)
        if value is None:
            value = read(self)
            self.keep(key, value)
        return value

    def recall(self, key: tuple[Any, ...]) -> Any:
        """Return what was kept for the node with an equal key, if that was the last; else None."""
        kept = self.node.kept
        return kept[1] if kept is not None and kept[0] == key else None

    def keep(self, key: tuple[Any, ...], value: Any) -> None:
        """Keep what the node means, but only if its key comes a second time: most nodes are shown once."""
        kept = self.node.kept
        self.node.kept = key, value if kept is not None and kept[0] == key else None

    def expanded(self, visit: "Visit") -> "PlacedNode | None":
        """Return the first node of the prototype that it is an instance of, None if there is none; else itself.

        visit : is called with each node on the way
        """
        placed = self
        visit(placed)
        while (prototype := placed.node.prototype) is not None and not prototype.is_external:
            body = prototype.find_shown()
            if body is None:
                return None
            scope = _scope_of(placed, prototype)
            scope.n_entered += 1
            placed = PlacedNode(body, scope)
            visit(placed)
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


Visit: TypeAlias = Callable[[PlacedNode], None]
