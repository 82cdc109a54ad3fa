"""The syntax that VRML 1.0 and VRML 97 share: text to nodes with fields, and names to the nodes they stand for.

What nodes mean is none of this module's business. Nothing here recurses, so no depth of nesting can exhaust a stack.
"""

import re
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ._text import integer, number, parse, printable

if TYPE_CHECKING:
    from lark import Lark, Token

# A bracketed list of plain numbers is one terminal: NumPy parses it, not the grammar.
_GRAMMAR = r"""
start: _statement*
_statement: _object | proto | externproto | route
_object: node | definition | use
node: NAME "{" _member* "}"
definition: "DEF" ANY_NAME node
use: "USE" ANY_NAME
_member: field | _object | proto | externproto | route | interface
field: NAME _value
_value: NUMBERS | NUMBER+ | STRING | NAME | BIT_MASK | _object | "[" _item* "]" | "IS" NAME
_item: NUMBER | STRING | NAME | BIT_MASK | _object

proto: "PROTO" ANY_NAME "[" interface* "]" "{" _member* "}"
externproto: "EXTERNPROTO" ANY_NAME "[" extern_interface* "]" _value
route: "ROUTE" ANY_NAME "TO" ANY_NAME
interface: ("eventIn" | "eventOut") NAME NAME ["IS" NAME]
         | ("field" | "exposedField") NAME NAME _value
extern_interface: ("eventIn" | "eventOut" | "field" | "exposedField") NAME NAME

NAME: /[^\x00-\x20"#',.\[\]\\{}()|+\-0-9][^\x00-\x20"#',\[\]\\{}]*/
ANY_NAME: /[^\x00-\x20"#',\[\]\\{}]+/
NUMBER: /[+\-.0-9][^\x00-\x20"#',\[\]\\{}]*/
NUMBERS.2: /\[[-+.,0-9eE \t\n]*(?:#[^\n]*\n[-+.,0-9eE \t\n]*)*\]/
STRING: /"[^"\\]*(?:\\(?:.|\n)[^"\\]*)*"/
BIT_MASK: /\([^()\[\]{}"]*\)/
%ignore /[ \t\n,]+/
%ignore /#[^\n]*/
"""
_COMMENT = re.compile(r"#[^\n]*")
_WORD = re.compile(r"[^\s,]+")


@dataclass(eq=False, slots=True)
class Numbers:
    """The text of a field of numbers, which starts on `line`."""

    line: int
    text: str

    def floats(self, width: int) -> Float64Array:
        """Return (n, width) finite float64."""
        try:
            values = parse(self._plain(), "float")
        except ValueError:
            values = np.array([number(word, line) for word, line in self._words()])
        if not np.isfinite(values).all():
            place = int(np.argmax(~np.isfinite(values)))
            raise MeshError(f"line {self.line_of(place)}: a number must be finite, got {values[place]}")
        if len(values) % width:
            raise MeshError(f"line {self.line}: the number of values must be a multiple of {width}, got {len(values)}")
        return values.reshape(-1, width)

    def integers(self) -> IndexArray:
        """Return (n,) int64."""
        try:
            return parse(self._plain(), "int")
        except ValueError:
            return np.array(
                [integer(word, line, 16 if "x" in word.lower() else 10) for word, line in self._words()], np.int64
            )

    def line_of(self, place: int) -> int:
        """Return the line of the number at `place`."""
        return [line for _, line in self._words()][place]

    def _plain(self) -> bytes:
        text = _COMMENT.sub("", self.text) if "#" in self.text else self.text
        return text.replace(",", " ").encode("ascii", "replace")

    def _words(self) -> list[tuple[str, int]]:
        lines = enumerate(self.text.split("\n"), self.line)
        return [(word, line) for line, text in lines for word in _WORD.findall(_COMMENT.sub("", text))]


@dataclass(eq=False, slots=True)
class Use:
    """A reference to the node last defined under a name."""

    name: str
    line: int


@dataclass(eq=False, slots=True)
class Node:
    """A node: numbers of a field, or its nodes and words, and the children that stand among the fields in VRML 1.0."""

    kind: str
    line: int
    numbers: dict[str, Numbers] = field(default_factory=dict)
    items: dict[str, list[Any]] = field(default_factory=dict)
    children: list[Any] = field(default_factory=list)
    name: str | None = None

    def floats(self, name: str, default: tuple[float, ...]) -> Float64Array:
        """Return a field of as many numbers as its default: (len(default),) float64."""
        if name not in self.numbers:
            return np.array(default)
        rows = self.numbers[name].floats(len(default))
        if len(rows) != 1:
            raise MeshError(f"line {self.numbers[name].line}: {name} needs {len(default)} numbers, got {rows.size}")
        row: Float64Array = rows[0]
        return row

    def integer(self, name: str, default: int) -> int:
        """Return a field of one integer."""
        if name not in self.numbers:
            return default
        values = self.numbers[name].integers()
        if len(values) != 1:
            raise MeshError(f"line {self.numbers[name].line}: {name} needs one integer, got {len(values)}")
        return int(values[0])

    def nodes(self, name: str) -> "list[Node]":
        """Return the nodes in a field."""
        return [item for item in self.items.get(name, []) if isinstance(item, Node)]


Field: TypeAlias = tuple[str, "Numbers | list[Any]"]


class _Builder:
    """What the parser calls as each rule of the grammar ends."""

    def start(self, parts: list[Any]) -> list[Any]:
        return [part for part in parts if part is not None]

    def node(self, parts: list[Any]) -> Node:
        node = Node(str(parts[0]), parts[0].line)
        for part in parts[1:]:
            if isinstance(part, Node | Use):
                node.children.append(part)
            elif part is not None:
                name, value = part
                if isinstance(value, Numbers):
                    node.numbers[name] = value
                else:
                    node.items[name] = value
        return node

    def definition(self, parts: list[Any]) -> Node:
        name, node = parts
        node.name = str(name)
        return cast("Node", node)

    def use(self, parts: "list[Token]") -> Use:
        return Use(str(parts[0]), cast("int", parts[0].line))

    def field(self, parts: list[Any]) -> Field:
        name, *items = parts
        if items and all(getattr(item, "type", "") in ("NUMBER", "NUMBERS") for item in items):
            text = items[0][1:-1] if items[0].type == "NUMBERS" else _spread(items)
            return str(name), Numbers(items[0].line, text)
        return str(name), items

    def proto(self, parts: list[Any]) -> None:
        """Pass over a prototype, and the names defined in it."""

    externproto = route = interface = extern_interface = proto


def _spread(tokens: "list[Token]") -> str:
    """Return the tokens as text with the line breaks that stood between them."""
    text, line = [], cast("int", tokens[0].line)
    for token in tokens:
        gap = cast("int", token.line) - line
        text += ["\n" * gap if gap else " ", str(token)]
        line += gap
    return "".join(text)


@cache
def _parser() -> "Lark":
    from lark import Lark

    return Lark(_GRAMMAR, parser="lalr", transformer=cast("Any", _Builder()), maybe_placeholders=False)


def parse_nodes(text: str) -> list[Node]:
    """Return the nodes at the top of a file, every USE replaced by the node that it names.

    Raises MeshError with the line for malformed syntax, and for a USE of a name that no node before it bears; a node
    bears its name from its closing brace on, so that none can contain itself.
    """
    from lark.exceptions import UnexpectedInput, UnexpectedToken

    try:
        roots = cast("list[Any]", _parser().parse(text))
    except UnexpectedToken as error:
        if error.token.type == "$END":
            raise MeshError(f"line {text.rstrip().count(chr(10)) + 1}: unexpected end of the file") from None
        raise MeshError(f"line {error.line}: unexpected {printable(str(error.token))}") from None
    except UnexpectedInput as error:
        rest = text[cast("int", error.pos_in_stream) :][:41]
        raise MeshError(f"line {error.line}: unexpected {printable(rest)}") from None
    _resolve(roots)
    return roots


def _resolve(roots: list[Any]) -> None:
    """Replace every Use by its node, in the order of the file."""
    named: dict[str, Node] = {}
    # Entries are a list and a place in it, or a node whose end is reached.
    pending: list[tuple[list[Any], int] | Node] = [(roots, i) for i in reversed(range(len(roots)))]
    while pending:
        entry = pending.pop()
        if isinstance(entry, Node):
            named[cast("str", entry.name)] = entry
            continue
        where, place = entry
        item = where[place]
        if isinstance(item, Use):
            if item.name not in named:
                raise MeshError(f"line {item.line}: USE {printable(item.name)}, but no node before it has that name")
            where[place] = named[item.name]
        elif isinstance(item, Node):
            if item.name is not None:
                pending.append(item)
            for part in (item.children, *reversed(item.items.values())):
                pending += [(part, i) for i in reversed(range(len(part)))]
