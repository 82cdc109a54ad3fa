"""The syntax that VRML 1.0 and VRML 97 share: text becomes nodes with fields, and names become the nodes they mean.

The meaning of nodes is the subject of `vrml`. Nothing here recurses, so no depth of nesting can exhaust the stack.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ._text import parse_float, parse_int, parse_numbers, quote
from .limits import budget

if TYPE_CHECKING:
    from lark import Lark, Token

# A bracketed list of plain numbers is one terminal, and so are numbers that follow one another, because NumPy parses
# them much faster.
_GRAMMAR = r"""
start: _statement*
_statement: _object | proto | externproto | route
_object: node | definition | use
node: NAME "{" _member* "}"
definition: "DEF" ANY_NAME node
use: "USE" ANY_NAME
_member: field | _object | proto | externproto | route | _interface
field: NAME _value
_value: NUMBERS | NUMBER+ | STRING | NAME | BIT_MASK | _object | "[" _item* "]" | binding
binding: "IS" NAME
_item: NUMBER | STRING | NAME | BIT_MASK | _object

proto: "PROTO" ANY_NAME "[" declarations "]" "{" body "}"
declarations: _interface*
body: _member*
externproto: "EXTERNPROTO" ANY_NAME "[" extern_interface* "]" _value
route: "ROUTE" ANY_NAME "TO" ANY_NAME
_interface: event | declaration
event: ("eventIn" | "eventOut") NAME NAME ["IS" NAME]
declaration: ("field" | "exposedField") NAME NAME _value
extern_interface: ("eventIn" | "eventOut" | "field" | "exposedField") NAME NAME

NAME: /[^\x00-\x20"#',.\[\]\\{}()|+\-0-9][^\x00-\x20"#',\[\]\\{}]*/
ANY_NAME: /[^\x00-\x20"#',\[\]\\{}]+/
NUMBER: /[+\-.0-9][^\x00-\x20"#',\[\]\\{}]*(?:[ \t\n,]+[+\-.0-9][^\x00-\x20"#',\[\]\\{}]*)*/
NUMBERS.2: /\[[-+.,0-9eE \t\n]*(?:#[^\n]*\n[-+.,0-9eE \t\n]*)*\]/
STRING: /"[^"\\]*(?:\\(?:.|\n)[^"\\]*)*"/
BIT_MASK: /\([^()\[\]{}"]*\)/
%ignore /[ \t\n,]+/
%ignore /#[^\n]*/
"""
# What the parser takes some microseconds for: strings, lists and runs of numbers, words, braces; never twice through
# the same text, whatever it is.
_PART = re.compile(
    r"""
    \#[^\n]* | "[^"\\]*(?:\\.[^"\\]*)*(?:"|\\?\Z) | \[[-+.,0-9eE\s]*\]
    | [-+.0-9][^\s"\#',\[\]{}]*(?:[\s,]+[-+.0-9][^\s"\#',\[\]{}]*)* | [\[\]{}] | [^\s"\#',\[\]{}]+
    """,
    re.VERBOSE | re.DOTALL,
)
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


Value: TypeAlias = Numbers | list[Any]
Slot: TypeAlias = tuple[list[Any], int]


@dataclass(eq=False, slots=True)
class Prototype:
    """A prototype: the defaults of its fields, and its nodes; an external one has neither.

    slots : the places of nodes, uses and prototypes in the defaults and in the body, in the order of the file
    """

    name: str
    line: int
    is_external: bool = False
    defaults: dict[str, Value] = field(default_factory=dict)
    default_slots: list[Slot] = field(default_factory=list)
    body: list[Any] = field(default_factory=list)
    body_slots: list[Slot] = field(default_factory=list)


@dataclass(eq=False, slots=True)
class Node:
    """A node and its fields. Nodes among the fields, as VRML 1.0 has them, belong to the field `children`.

    slots : the places of nodes, uses and prototypes in the fields, in the order of the file
    prototype : what defines this kind of node, if that is not the language
    """

    kind: str
    line: int
    fields: dict[str, Value] = field(default_factory=dict)
    slots: list[Slot] = field(default_factory=list)
    name: str | None = None
    prototype: Prototype | None = None

    def set_field(self, name: str, value: Value) -> None:
        """Set a field; a list adds to the one before it, which an empty one does not replace."""
        known = self.fields.get(name)
        if isinstance(known, list) and isinstance(value, list):
            self.slots += _add_slots(known, value)
        elif isinstance(value, list):
            self.fields[name] = values = list[Any]()
            self.slots += _add_slots(values, value)
        elif not (isinstance(known, list) and not value.text.strip()):
            self.fields[name] = value


def _add_slots(values: list[Any], added: list[Any]) -> list[Slot]:
    """Append to a list, and return the places of what is to be resolved."""
    first = len(values)
    values += added
    return [(values, i) for i in range(first, len(values)) if isinstance(values[i], Node | Use | Prototype)]


class _Builder:
    """The functions that the parser calls at the end of each rule of the grammar."""

    def start(self, parts: list[Any]) -> list[Any]:
        return [part for part in parts if part is not None]

    def node(self, parts: list[Any]) -> Node:
        node = Node(str(parts[0]), parts[0].line)
        for part in parts[1:]:
            if isinstance(part, _Declaration):
                if isinstance(part.value, list):
                    node.slots += _add_slots([], part.value)
            elif isinstance(part, tuple):
                node.set_field(*part)
            elif part is not None:
                node.set_field("children", [part])
        return node

    def definition(self, parts: list[Any]) -> Node:
        name, node = parts
        node.name = str(name)
        return cast("Node", node)

    def use(self, parts: "list[Token]") -> Use:
        return Use(str(parts[0]), cast("int", parts[0].line))

    def field(self, parts: list[Any]) -> tuple[str, Value]:
        name, *items = parts
        return str(name), _as_value(items)

    def binding(self, parts: "list[Token]") -> Binding:
        return Binding(str(parts[0]))

    def declaration(self, parts: list[Any]) -> "_Declaration":
        _, name, *items = parts
        return _Declaration(str(name), _as_value(items))

    def proto(self, parts: list[Any]) -> Prototype:
        name, declarations, body = parts
        prototype = Prototype(str(name), name.line)
        for declared in declarations:
            value = declared.value
            if isinstance(value, list):
                value = list[Any]()
                prototype.default_slots += _add_slots(value, declared.value)
            prototype.defaults[declared.name] = value
        prototype.body_slots = _add_slots(prototype.body, body)
        return prototype

    def declarations(self, parts: list[Any]) -> list[Any]:
        return [part for part in parts if part is not None]

    def body(self, parts: list[Any]) -> list[Any]:
        return [part for part in parts if isinstance(part, Node | Use | Prototype)]

    def externproto(self, parts: list[Any]) -> Prototype:
        return Prototype(str(parts[0]), parts[0].line, is_external=True)

    def event(self, parts: list[Any]) -> None:
        """Ignore an event, a route, and the interface of an external prototype."""

    route = extern_interface = event


@dataclass(eq=False, slots=True)
class _Declaration:
    """The declaration of a field, with its value."""

    name: str
    value: Value


def _as_value(items: list[Any]) -> Value:
    """Return the value of a field: its numbers, or its nodes and words."""
    if items and all(getattr(item, "type", "") in ("NUMBER", "NUMBERS") for item in items):
        text = items[0][1:-1] if items[0].type == "NUMBERS" else _join_tokens(items)
        return Numbers(items[0].line, text)
    return items


def _join_tokens(tokens: "list[Token]") -> str:
    """Return the tokens as text, with the line breaks between them."""
    text, line = [], cast("int", tokens[0].line)
    for token in tokens:
        gap = cast("int", token.line) - line
        text += ["\n" * gap if gap else " ", str(token)]
        line += gap + token.count("\n")
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

    n_parts = n_nodes = 0
    for part in _PART.finditer(text):
        n_parts += 1
        n_nodes += part[0] == "{"
    budget().require_parts(n_parts, n_nodes)
    try:
        roots = cast("list[Any]", _make_parser().parse(text))
    except UnexpectedToken as error:
        if error.token.type == "$END":
            raise MeshError(f"line {text.rstrip().count(chr(10)) + 1}: unexpected end of the file") from None
        raise MeshError(f"line {error.line}: unexpected {quote(str(error.token))}") from None
    except UnexpectedInput as error:
        rest = text[cast("int", error.pos_in_stream) :][:41]
        raise MeshError(f"line {error.line}: unexpected {quote(rest)}") from None
    budget().spell_nodes(_resolve_names(roots))
    return [root for root in roots if isinstance(root, Node)]


class _Names:
    """The nodes and prototypes that have a name at some place of a file."""

    def __init__(self) -> None:
        self._nodes: list[dict[str, Node]] = [{}]
        self._prototypes: dict[str, list[Prototype]] = {}
        self._declared: list[list[str]] = [[]]

    def enter_scope(self) -> None:
        """Begin the body of a prototype, whose names are its own."""
        self._nodes.append({})
        self._declared.append([])

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


def _resolve_names(roots: list[Any]) -> int:
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
            pending += [names.enter_scope, *reversed(item.default_slots)]
    return n_nodes
