"""The syntax that VRML 1.0 and VRML 97 share: text becomes nodes with fields, and names become the nodes they mean.

The meaning of nodes is the subject of `vrml`. Nothing here recurses, so no depth of nesting can exhaust the stack.
"""

import re
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ._text import parse_float, parse_int, parse_numbers, quote

if TYPE_CHECKING:
    from lark import Lark, Token

# A bracketed list of plain numbers is one terminal, because NumPy parses it much faster.
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
    """The text of a field of numbers that starts on `line`."""

    line: int
    text: str

    def floats(self, width: int) -> Float64Array:
        """Return (n, width) finite float64."""
        try:
            values = parse_numbers(self._plain(), "float")
        except ValueError:
            values = np.array([parse_float(word, line) for word, line in self._words()])
        if not np.isfinite(values).all():
            i = int(np.argmax(~np.isfinite(values)))
            raise MeshError(f"line {self.line_of(i)}: a number must be finite, got {values[i]}")
        if len(values) % width:
            raise MeshError(f"line {self.line}: the number of values must be a multiple of {width}, got {len(values)}")
        return values.reshape(-1, width)

    def integers(self) -> IndexArray:
        """Return (n,) int64."""
        try:
            return parse_numbers(self._plain(), "int")
        except ValueError:
            return np.array(
                [parse_int(word, line, 16 if "x" in word.lower() else 10) for word, line in self._words()], np.int64
            )

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
class Node:
    """A node: fields of numbers, fields of nodes and words, and the children among the fields of VRML 1.0."""

    kind: str
    line: int
    numbers: dict[str, Numbers] = field(default_factory=dict)
    items: dict[str, list[Any]] = field(default_factory=dict)
    children: list[Any] = field(default_factory=list)
    name: str | None = None

    def floats(self, name: str, default: tuple[float, ...]) -> Float64Array:
        """Return a field of as many numbers as its default has: (len(default),) float64."""
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
    """The functions that the parser calls at the end of each rule of the grammar."""

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
            text = items[0][1:-1] if items[0].type == "NUMBERS" else _join_tokens(items)
            return str(name), Numbers(items[0].line, text)
        return str(name), items

    def proto(self, parts: list[Any]) -> None:
        """Ignore a prototype, and the names that it defines."""

    externproto = route = interface = extern_interface = proto


def _join_tokens(tokens: "list[Token]") -> str:
    """Return the tokens as text, with the line breaks between them."""
    text, line = [], cast("int", tokens[0].line)
    for token in tokens:
        gap = cast("int", token.line) - line
        text += ["\n" * gap if gap else " ", str(token)]
        line += gap
    return "".join(text)


@cache
def _make_parser() -> "Lark":
    from lark import Lark

    return Lark(_GRAMMAR, parser="lalr", transformer=cast("Any", _Builder()), maybe_placeholders=False)


def parse_nodes(text: str) -> list[Node]:
    """Return the top-level nodes of a file, with every USE replaced by the node that it names.

    Raises MeshError with the line for malformed syntax, and for a USE of a name that no node before it has. A node has
    its name from its closing brace on, so that none can contain itself.
    """
    from lark.exceptions import UnexpectedInput, UnexpectedToken

    try:
        roots = cast("list[Any]", _make_parser().parse(text))
    except UnexpectedToken as error:
        if error.token.type == "$END":
            raise MeshError(f"line {text.rstrip().count(chr(10)) + 1}: unexpected end of the file") from None
        raise MeshError(f"line {error.line}: unexpected {quote(str(error.token))}") from None
    except UnexpectedInput as error:
        rest = text[cast("int", error.pos_in_stream) :][:41]
        raise MeshError(f"line {error.line}: unexpected {quote(rest)}") from None
    _resolve_uses(roots)
    return roots


def _resolve_uses(roots: list[Any]) -> None:
    """Replace every `Use` by its node, in the order of the file."""
    named: dict[str, Node] = {}
    # Entries are a list and an index in it, or a node whose end is reached.
    pending: list[tuple[list[Any], int] | Node] = [(roots, i) for i in reversed(range(len(roots)))]
    while pending:
        entry = pending.pop()
        if isinstance(entry, Node):
            named[cast("str", entry.name)] = entry
            continue
        parts, i = entry
        item = parts[i]
        if isinstance(item, Use):
            if item.name not in named:
                raise MeshError(f"line {item.line}: USE {quote(item.name)}, but no node before it has that name")
            parts[i] = named[item.name]
        elif isinstance(item, Node):
            if item.name is not None:
                pending.append(item)
            for part in (item.children, *reversed(item.items.values())):
                pending += [(part, i) for i in reversed(range(len(part)))]
