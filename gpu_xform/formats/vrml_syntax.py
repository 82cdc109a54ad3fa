"""The syntax that VRML 1.0 and VRML 97 share: text becomes nodes with fields.

The meaning of nodes is the subject of `vrml`. Nothing here recurses, so no depth of nesting can exhaust the stack. The
parser is written by hand, because one from a grammar (Lark's) takes three times as long.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, cast

from ..errors import MeshError
from ._text import quote
from .limits import budget
from .vrml_names import resolve_names
from .vrml_values import Binding, Node, Numbers, Prototype, Use, Value, add_slots

# What the functions of `_Parser` read. A name is a word that begins with a letter or so; words may begin with anything.
#   statement  object | ROUTE word TO word
#              | PROTO word [ interface* ] { member* } | EXTERNPROTO word [ interface* ] value
#   object     name { member* } | DEF word name { member* } | USE word
#   member     name value | statement | interface
#   value      numbers | string | name | mask | object | [ item* ] | IS name
#   interface  (eventIn | eventOut) name name (IS name)? | (field | exposedField) name name value
_SKIP = r"(?:[ \t\n,]++|#[^\n]*+)*+"  # possessive: no run of blanks is divided in more than one way
_IN_WORD = r"""[^\x00-\x20"#',\[\]\\{}]"""
_NUMERIC = rf"[+\-.0-9]{_IN_WORD}*"
# A bracketed list of plain numbers is one token, and so are numbers that follow one another, because NumPy parses them
# much faster.
_TOKENS = {
    "name": rf"""[^\x00-\x20"#',.\[\]\\{{}}()|+\-0-9]{_IN_WORD}*""",
    "number": rf"{_NUMERIC}(?:[ \t\n,]+{_NUMERIC})*",
    "numbers": r"\[[-+.,0-9eE \t\n]*(?:#[^\n]*\n[-+.,0-9eE \t\n]*)*\]",
    "brace": r"[\[\]{}]",
    "string": r'"[^"\\]*(?:\\(?:.|\n)[^"\\]*)*"',
    "mask": r"""\([^()\[\]{}"]*\)""",
    "end": r"\Z",
}
_TOKEN = re.compile(_SKIP + "(?:" + "|".join(f"({pattern})" for pattern in _TOKENS.values()) + ")")
_NAME, _NUMBER, _NUMBERS, _BRACE, _STRING, _MASK, _END = range(1, len(_TOKENS) + 1)
_WORD_AFTER = re.compile(f"{_SKIP}({_IN_WORD}+)")
_SKIPPED = re.compile(_SKIP)
_EVENTS, _FIELDS = ("eventIn", "eventOut"), ("field", "exposedField")
# What the parser takes some microseconds for: strings, lists and runs of numbers, words, braces; never twice through
# the same text, whatever it is.
_PART = re.compile(
    r"""
    \#[^\n]* | "[^"\\]*(?:\\.[^"\\]*)*(?:"|\\?\Z) | \[[-+.,0-9eE\s]*\]
    | [-+.0-9][^\s"\#',\[\]{}]*(?:[\s,]+[-+.0-9][^\s"\#',\[\]{}]*)* | [\[\]{}] | [^\s"\#',\[\]{}]+
    """,
    re.VERBOSE | re.DOTALL,
)


class _NumberText(str):
    """Numbers in a list, and the line that they begin on."""

    __slots__ = ("line",)
    line: int

    @classmethod
    def at(cls, text: str, line: int) -> "_NumberText":
        """Return numbers that begin on a line."""
        made = cls(text)
        made.line = line
        return made


def _as_value(items: list[Any]) -> Value:
    """Return the value of a field: its numbers, or its nodes and words."""
    if items and all(type(item) is _NumberText for item in items):
        first: _NumberText = items[0]
        return Numbers(first.line, str(first) if len(items) == 1 else _join_numbers(items))
    return items


def _join_numbers(parts: list[_NumberText]) -> str:
    """Return numbers as one text, with the line breaks between them."""
    text, line = [], parts[0].line
    for part in parts:
        gap = part.line - line
        text += ["\n" * gap if gap else " ", part]
        line += gap + part.count("\n")
    return "".join(text)


@dataclass(eq=False, slots=True)
class _Place:
    """What the parser is in the middle of: the top of the file, a node, a list, a prototype's interface or its body.

    owner : what the members belong to; None at the top and in a list
    items : what stands at the top, in a list or in a body
    take : gets the value that comes next, None where something else comes
    """

    outer: "_Place | None"
    owner: Node | Prototype | None = None
    items: list[Any] = field(default_factory=list)
    take: Callable[[Value], object] | None = None
    is_interface: bool = False


def _ignore(_: Value) -> None:
    """Take a value that means nothing here."""


class _Parser:
    """A text, and how far it is parsed."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._kind = _END
        self._lexeme = ""
        self._line = 1  # of the token
        self._start = self._end = 0
        self._line_end = self._find_line_end(0)  # of this line
        self._before = 0  # the end of the token before it
        self._is_held = False  # the token is to be read again

    def parse(self) -> list[Any]:
        """Return the nodes, uses and prototypes at the top of the text; raise MeshError for what is no VRML."""
        place = _Place(None)
        while True:
            self._go_on()
            if place.take is not None:
                place = self._read_value(place)
            elif place.is_interface:
                place = self._read_interface(place)
            elif place.owner is None and place.outer is not None:
                place = self._read_item(place)
            elif self._kind == _NAME:
                place = self._read_member(place)
            elif self._kind == _BRACE and self._lexeme == "}" and place.outer is not None:
                place = self._close(place)
            elif self._kind == _END and place.outer is None:
                return place.items
            else:
                raise self._unexpected()

    def _find_line_end(self, start: int) -> int:
        end = self._text.find("\n", start)
        return len(self._text) if end < 0 else end

    def _go_on(self) -> None:
        """Go to the next token."""
        if self._is_held:
            self._is_held = False
            return
        self._before = self._end
        match = _TOKEN.match(self._text, self._end)
        if match is None:
            raise self._unexpected()
        self._kind = match.lastindex or _END
        self._lexeme = match[self._kind]
        self._move(*match.span(self._kind))

    def _move(self, start: int, end: int) -> None:
        if start > self._line_end:
            self._line += self._text.count("\n", self._start, start)
            self._line_end = self._find_line_end(start)
        self._start, self._end = start, end

    def _take_name(self) -> str:
        """Go to the next token, which must be a name, and return it."""
        self._go_on()
        if self._kind != _NAME:
            raise self._unexpected()
        return self._lexeme

    def _take_word(self) -> str:
        """Go to the next word, whatever it begins with, and return it."""
        self._before = self._end
        match = _WORD_AFTER.match(self._text, self._end)
        if match is None:
            raise self._unexpected()
        self._lexeme = match[1]
        self._move(*match.span(1))
        return self._lexeme

    def _take_brace(self, brace: str) -> None:
        """Go to the next token, which must be a brace."""
        self._go_on()
        if self._kind == _NUMBERS and brace == "[":
            self._end = self._start + 1
        elif self._lexeme != brace or self._kind != _BRACE:
            raise self._unexpected()

    def _unexpected(self) -> MeshError:
        """Return the error that names what stands behind the last token that was right."""
        start = cast("re.Match[str]", _SKIPPED.match(self._text, self._before)).end()
        if start == len(self._text):
            return MeshError(f"line {self._text.rstrip().count(chr(10)) + 1}: unexpected end of the file")
        match = _TOKEN.match(self._text, start) or _WORD_AFTER.match(self._text, start)
        found = self._text[start : start + 41] if match is None else match[0]
        return MeshError(f"line {self._text.count(chr(10), 0, start) + 1}: unexpected {quote(found)}")

    def _read_member(self, place: _Place) -> _Place:
        """Read a name at the top, in a node or in the body of a prototype; return the place that goes on."""
        name, line = self._lexeme, self._line
        match name:
            case "DEF" | "USE":
                return self._read_reference(place)
            case "PROTO":
                prototype = Prototype(self._take_word(), self._line)
                self._take_brace("[")
                return _Place(place, prototype, is_interface=True)
            case "EXTERNPROTO":
                return self._read_external(place)
            case "ROUTE":
                self._take_word()
                if self._take_word() != "TO":
                    raise self._unexpected()
                self._take_word()
                return place
        if place.owner is not None and name in (*_EVENTS, *_FIELDS):
            return self._read_interface(place)
        self._go_on()
        if self._kind == _BRACE and self._lexeme == "{":
            return _Place(place, Node(name, line))
        if place.owner is None:
            raise self._unexpected()
        self._is_held = True
        place.take = partial(place.owner.set_field, name) if isinstance(place.owner, Node) else _ignore
        return place

    def _read_reference(self, place: _Place) -> _Place:
        """Read DEF and the beginning of its node, or USE."""
        word = self._lexeme
        name = self._take_word()
        if word == "USE":
            return self._deliver(place, Use(name, self._line))
        node = Node(self._take_name(), self._line, name=name)
        self._take_brace("{")
        return _Place(place, node)

    def _read_external(self, place: _Place) -> _Place:
        """Read an external prototype, up to the places where it may be found, which are not read."""
        prototype = Prototype(self._take_word(), self._line, is_external=True)
        self._take_brace("[")
        while self._take_interface_word():
            self._take_name()
            self._take_name()
        place.take = lambda _: self._deliver(place, prototype)
        return place

    def _take_interface_word(self) -> str:
        """Go to the next token, and return the word that begins a line of an interface; "" at its end."""
        self._go_on()
        if self._kind == _BRACE and self._lexeme == "]":
            return ""
        if self._kind != _NAME or self._lexeme not in (*_EVENTS, *_FIELDS):
            raise self._unexpected()
        return self._lexeme

    def _read_interface(self, place: _Place) -> _Place:
        """Read a line of the interface of a prototype or of a script, or the end of it."""
        self._is_held = True
        word = self._take_interface_word()
        if not word:
            self._take_brace("{")
            place.is_interface = False
            return place
        self._take_name()
        name = self._take_name()
        if word in _FIELDS:
            is_own = place.is_interface or isinstance(place.owner, Node)
            place.take = partial(_declare, place.owner, name) if is_own else _ignore
            return place
        self._go_on()
        if self._kind == _NAME and self._lexeme == "IS":
            self._take_name()
        else:
            self._is_held = True
        return place

    def _read_value(self, place: _Place) -> _Place:
        """Read the value of a field."""
        lexeme, line = self._lexeme, self._line
        if self._kind == _NAME:
            if lexeme in ("DEF", "USE"):
                return self._read_reference(place)
            if lexeme == "IS":
                return self._set(place, Binding(self._take_name()))
            return self._read_name(place)
        if self._kind == _NUMBERS:
            return self._set(place, Numbers(line, lexeme[1:-1]))
        if self._kind == _NUMBER:
            self._go_on()
            self._is_held = True
            if self._kind != _NUMBER:
                return self._set(place, Numbers(line, lexeme))
            parts = [_NumberText.at(lexeme, line)]
            while self._kind == _NUMBER:
                parts.append(_NumberText.at(self._lexeme, self._line))
                self._is_held = False
                self._go_on()
            self._is_held = True
            return self._set(place, _as_value(parts))
        if self._kind in (_STRING, _MASK):
            return self._set(place, [lexeme])
        if self._kind == _BRACE and lexeme == "[":
            return _Place(place)
        raise self._unexpected()

    def _read_item(self, place: _Place) -> _Place:
        """Read an item of a list, or its end."""
        if self._kind == _NAME:
            return self._read_reference(place) if self._lexeme in ("DEF", "USE") else self._read_name(place)
        if self._kind == _NUMBER:
            place.items.append(_NumberText.at(self._lexeme, self._line))
        elif self._kind in (_STRING, _MASK):
            place.items.append(self._lexeme)
        elif self._kind == _BRACE and self._lexeme == "]":
            return self._set(cast("_Place", place.outer), _as_value(place.items))
        else:
            raise self._unexpected()
        return place

    def _read_name(self, place: _Place) -> _Place:
        """Read a name that is a value or an item, or begins a node."""
        name, line = self._lexeme, self._line
        self._go_on()
        if self._kind == _BRACE and self._lexeme == "{":
            return _Place(place, Node(name, line))
        self._is_held = True
        return self._deliver(place, name)

    def _close(self, place: _Place) -> _Place:
        """End a node, or the body of a prototype."""
        made, outer = place.owner, place.outer
        if isinstance(made, Prototype):
            made.body_slots = add_slots(made.body, place.items)
        return self._deliver(outer or place, made)

    def _deliver(self, place: _Place, item: Any) -> _Place:
        """Put an object or a name where it belongs."""
        if place.take is not None:
            return self._set(place, [item])
        if isinstance(place.owner, Node):
            place.owner.add_child(item)
        else:
            place.items.append(item)
        return place

    def _set(self, place: _Place, value: Value) -> _Place:
        """Give a value to what waits for it."""
        take, place.take = place.take, None
        if take is not None:
            take(value)
        return place


def _declare(owner: Node | Prototype | None, name: str, value: Value) -> None:
    """Keep the default of a prototype's field; of a field that a node declares, only what is to be resolved."""
    if isinstance(owner, Prototype):
        kept = value
        if not isinstance(value, Numbers):
            kept = list[Any]()
            owner.default_slots += [] if isinstance(value, Binding) else add_slots(kept, value)
        owner.defaults[name] = kept, None
    elif owner is not None and isinstance(value, list):
        owner.slots += add_slots([], value)


def parse_nodes(text: str) -> list[Node]:
    """Return the top-level nodes of a file, with every USE replaced by the node that it names.

    Raises MeshError with the line for malformed syntax, and for a USE of a name that no node before it has. A node has
    its name from its closing brace on, so that none can contain itself.
    """
    n_parts = n_nodes = 0
    for part in _PART.finditer(text):
        n_parts += 1
        n_nodes += part[0] == "{"
    budget().require_parts(n_parts, n_nodes)
    roots = _Parser(text).parse()
    budget().spell_nodes(resolve_names(roots))
    return [root for root in roots if isinstance(root, Node)]
