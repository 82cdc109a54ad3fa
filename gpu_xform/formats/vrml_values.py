"""What a VRML text says: nodes, prototypes, and the values of their fields, in which names are not resolved yet."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ._text import parse_float, parse_int, parse_numbers

_FEW_CHARACTERS = 80
_PLAIN_NUMBERS = re.compile(r"[-+.0-9eE,\s]*", re.ASCII)
_PLAIN_INTEGERS = re.compile(r"[\s,]*(?:-?[0-9]+(?:[\s,]+|$))*", re.ASCII)
_COMMENT = re.compile(r"#[^\n]*")
_WORD = re.compile(r"[^\s,]+")


@dataclass(eq=False, slots=True)
class Numbers:
    """The text of a field of numbers that starts on `line`; what is read twice is kept, as shapes share it."""

    line: int
    text: str
    _was_read: bool = False
    _kept: Float64Array | None = None
    _kept_integers: IndexArray | None = None
    _errors: dict[str, str] | None = None

    def floats(self, width: int) -> Float64Array:
        """Return (n, width) finite float64; nobody may write to them."""
        values = self._kept
        if values is None:
            values = self._read_few()
            if values is None:
                values = self._read_or_fail("float", self._read_finite)
            if self._was_read:
                self._kept = values
            self._was_read = True
        if len(values) % width:
            raise MeshError(f"line {self.line}: the number of values must be a multiple of {width}, got {len(values)}")
        return values.reshape(-1, width)

    def integers(self) -> IndexArray:
        """Return (n,) int64; nobody may write to them."""
        if self._kept_integers is not None:
            return self._kept_integers
        values = self._read_few_integers()
        if values is None:
            values = self._read_or_fail("int", self._read_integers)
        if self._was_read:
            self._kept_integers = values
        self._was_read = True
        return values

    def _read_few_integers(self) -> IndexArray | None:
        """Return the integers of a short plain text, as `_read_few` does."""
        if len(self.text) <= _FEW_CHARACTERS and _PLAIN_INTEGERS.fullmatch(self.text):
            try:
                return np.array([int(word) for word in self.text.replace(",", " ").split()], np.int64)
            except OverflowError:
                pass  # such words become the greatest int64
        return None

    def _read_or_fail(self, kind: str, read: Callable[[], npt.NDArray[Any]]) -> npt.NDArray[Any]:
        """Return what `read` returns; what is malformed for one of many shapes is so for all."""
        if self._errors is not None and kind in self._errors:
            raise MeshError(self._errors[kind])
        try:
            return read()
        except MeshError as error:
            self._errors = {**(self._errors or {}), kind: str(error)}
            raise

    def _read_finite(self) -> Float64Array:
        try:
            values = parse_numbers(self._plain(), "float")
        except ValueError:
            values = np.array([parse_float(word, line) for word, line in self._words()])
        if not np.isfinite(values).all():
            i = int(np.argmax(~np.isfinite(values)))
            raise MeshError(f"line {self.line_of(i)}: a number must be finite, got {values[i]}")
        return values

    def _read_integers(self) -> IndexArray:
        try:
            return parse_numbers(self._plain(), "int")
        except ValueError:
            return np.array(
                [parse_int(word, line, 16 if "x" in word.lower() else 10) for word, line in self._words()], np.int64
            )

    def _read_few(self) -> Float64Array | None:
        """Return finite numbers of a short plain text, for which NumPy takes longer than Python; None for others."""
        if len(self.text) > _FEW_CHARACTERS or _PLAIN_NUMBERS.fullmatch(self.text) is None:
            return None
        try:
            values = [float(word) for word in self.text.replace(",", " ").split()]
        except ValueError:
            return None
        return np.array(values) if math.isfinite(sum(values)) else None

    def is_blank(self) -> bool:
        """Tell whether there are no numbers, and no comments either."""
        return not self.text or self.text.isspace()

    def count_at_most(self) -> int:
        """Return a number that is at least that of the values, and little more."""
        return len(self.text.split()) + self.text.count(",")

    def line_of(self, i: int) -> int:
        """Return the line of number i."""
        return [line for _, line in self._words()][i]

    def _plain(self) -> bytes:
        text = _COMMENT.sub("", self.text) if "#" in self.text else self.text
        return text.replace(",", " ").encode("ascii", "replace")

    def _words(self) -> list[tuple[str, int]]:
        lines = enumerate(self.text.split("\n"), self.line)
        return [(word, line) for line, text in lines for word in _WORD.findall(_COMMENT.sub("", text))]


@dataclass(eq=False, slots=True)
class Use:
    """A reference to the node that was last defined with a name."""

    name: str
    line: int


@dataclass(eq=False, slots=True)
class Binding:
    """The value `IS name` of a field in a prototype: what the instance gives for that name."""

    name: str


Value: TypeAlias = Numbers | Binding | list[Any]
Slot: TypeAlias = tuple[list[Any], int]


@dataclass(eq=False, slots=True)
class Prototype:
    """A prototype: the defaults of its fields, and its nodes; an external one has neither.

    defaults : what `Scope.find` returns for them, without a scope, as they are written in none
    slots : the places of nodes, uses and prototypes in the defaults and in the body, in the order of the file
    plain_scope : that of all instances that give no values
    """

    name: str
    line: int
    is_external: bool = False
    defaults: dict[str, tuple[Value, None]] = field(default_factory=dict)
    default_slots: list[Slot] = field(default_factory=list)
    body: list[Any] = field(default_factory=list)
    body_slots: list[Slot] = field(default_factory=list)
    plain_scope: Any = None
    _shown: "tuple[Node | None] | None" = None

    def find_shown(self) -> "Node | None":
        """Return the first node of its body, which is what instances show; names must be resolved."""
        if self._shown is None:
            self._shown = (next((item for item in self.body if isinstance(item, Node)), None),)
        return self._shown[0]


@dataclass(eq=False, slots=True)
class Node:
    """A node and its fields. Nodes among the fields, as VRML 1.0 has them, belong to the field `children`.

    slots : the places of nodes, uses and prototypes in the fields, in the order of the file
    prototype : what defines this kind of node, if that is not the language
    kept, key_of_kept : what `PlacedNode.keep` keeps
    """

    kind: str
    line: int
    fields: dict[str, Value] = field(default_factory=dict)
    slots: list[Slot] = field(default_factory=list)
    name: str | None = None
    prototype: Prototype | None = None
    kept: Any = None
    key_of_kept: object = None

    def add_child(self, item: Any) -> None:
        """Add a node, a use, a prototype or a word to the field `children`."""
        children = self.fields.get("children")
        if not isinstance(children, list):
            self.fields["children"] = children = []
        if isinstance(item, _RESOLVED):
            self.slots.append((children, len(children)))
        children.append(item)

    def set_field(self, name: str, value: Value) -> None:
        """Set a field; a list adds to the one before it, which an empty one does not replace."""
        known = self.fields.get(name)
        if isinstance(value, list):
            if isinstance(known, list):
                self.slots += add_slots(known, value)
            elif value or not isinstance(known, Binding):
                self.fields[name] = values = list[Any]()
                self.slots += add_slots(values, value)
        elif isinstance(value, Binding):
            if not (isinstance(known, list) and known):
                self.fields[name] = value
        elif not isinstance(known, list | Binding) or value.text.strip():
            self.fields[name] = value


_RESOLVED = (Node, Use, Prototype)


def add_slots(values: list[Any], added: list[Any]) -> list[Slot]:
    """Append to a list, and return the places of what is to be resolved."""
    first = len(values)
    values += added
    return [(values, i) for i in range(first, len(values)) if isinstance(values[i], _RESOLVED)]
