"""Nodes of VRML in their place: fields with the values that instances of prototypes give them."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._core.types import Float64Array
from ..errors import MeshError
from ._text import quote
from .vrml_values import Binding, Node, Numbers, Value

# The values of a prototype's fields, each with the scope that it was written in.
Scope: TypeAlias = Mapping[str, tuple[Value | None, Any]]

_NO_SCOPE: Scope = {}


class PlacedNode(NamedTuple):
    """A node, and the values of the names in its `IS name` fields."""

    node: Node
    scope: Scope = _NO_SCOPE

    @property
    def kind(self) -> str:
        """The name of its type."""
        return self.node.kind

    @property
    def line(self) -> int:
        """The line that it begins on."""
        return self.node.line

    def get(self, name: str) -> tuple[Value | None, Scope]:
        """Return the value of a field, None if it has none, and the scope of the value."""
        value = self.node.fields.get(name)
        if isinstance(value, list) and len(value) == 1 and isinstance(value[0], Binding):
            return self.scope.get(value[0].name, (None, _NO_SCOPE))
        return value, self.scope

    def numbers(self, name: str) -> Numbers | None:
        """Return a field of numbers."""
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
        values = numbers.integers()
        if len(values) != 1:
            raise MeshError(f"line {numbers.line}: {name} needs one integer, got {len(values)}")
        return int(values[0])

    def flag(self, name: str, default: bool) -> bool:
        """Return a field that is TRUE or FALSE."""
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
        words = [str(item) for item in value if isinstance(item, str)]
        return [word[1:-1].replace('\\"', '"').replace("\\\\", "\\") if word[:1] == '"' else word for word in words]

    def nodes(self, name: str) -> "list[PlacedNode]":
        """Return the nodes of a field."""
        value, scope = self.get(name)
        return [PlacedNode(item, scope) for item in value if isinstance(item, Node)] if isinstance(value, list) else []

    def expanded(self, visit: "Visit") -> "PlacedNode | None":
        """Return the first node of the prototype that it is an instance of, None if there is none; else itself.

        visit : is called with each node on the way
        """
        placed = self
        visit(placed)
        while (prototype := placed.node.prototype) is not None and not prototype.is_external:
            body = next((item for item in prototype.body if isinstance(item, Node)), None)
            if body is None:
                return None
            scope = {
                name: placed.get(name) if name in placed.node.fields else (default, _NO_SCOPE)
                for name, default in prototype.defaults.items()
            }
            placed = PlacedNode(body, scope)
            visit(placed)
        return placed


@cache
def _as_table(rows: tuple[tuple[float, ...], ...]) -> Float64Array:
    return np.array(rows)


Visit: TypeAlias = Callable[[PlacedNode], None]
