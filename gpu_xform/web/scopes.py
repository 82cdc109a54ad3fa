"""The names of scripts and WGSL files: what each stands for, where it holds, and which of them the program declares.

No parser of either language: it knows the forms that this package's own sources have.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from .tokens import is_text, is_word

VARIABLE, PROPERTY, BOTH = "variable", "property", "both"  # of `{ name }`, which is a variable and a property
_SCRIPT_WORDS = (
    "arguments async await break case catch class const constructor continue default delete do else eval export extends"
    " false finally for from function get if import in instanceof let new null of return set static super switch this"
    " throw true try typeof undefined var void while with yield Infinity NaN"
)
_WGSL_WORDS = (
    "alias break case const const_assert continue continuing default diagnostic discard else enable false fn for if let"
    " loop override requires return struct switch true var while"
)
SCRIPT_WORDS, WGSL_WORDS = frozenset(_SCRIPT_WORDS.split()), frozenset(_WGSL_WORDS.split())
_DECLARATIONS = frozenset(("fn", "struct", "alias", "override", "const", "var"))
_BEFORE_BLOCK = frozenset((")", "=>", "else", "do", "try", "finally", ";", "{", "}"))
_CONTROLS = frozenset(("if", "for", "while", "switch"))
_BEFORE_PARAMETER = frozenset(("(", "[", "{", ",", ":", "..."))


@dataclass(frozen=True)
class NamedText:
    """A program, and the names that it declares.

    roles : of each token; None for what is no name
    scopes : of each token: the number of the declaration that it is part of, function, method or other
    shared : names of the whole: functions, classes, structs, constants
    properties : of objects and structs
    local : by scope, variables and parameters
    """

    tokens: Sequence[str]
    roles: list[str | None]
    scopes: list[int]
    shared: set[str]
    properties: set[str]
    local: dict[int, set[str]]


def read_wgsl(tokens: Sequence[str]) -> NamedText:
    """Return the names of a WGSL file."""
    padded = [*tokens, "", ""]
    found = NamedText(tokens, [None] * len(tokens), [0] * len(tokens), set(), set(), {})
    depth = scope = 0
    kind, is_first = "", True
    for i, part in enumerate(tokens):
        before, after = padded[i - 1], padded[i + 1]
        if is_first:
            scope, kind, is_first = scope + 1, "", False
        found.scopes[i] = scope
        if part in _DECLARATIONS and depth == 0:
            kind = part
        if is_word(part):
            if part in WGSL_WORDS or before == "@" or padded[i - 2] == "builtin":
                continue
            is_field = kind == "struct" and depth == 1 and after == ":"
            found.roles[i] = PROPERTY if before == "." or is_field else VARIABLE
            if is_field:
                found.properties.add(part)
            elif depth == 0 and (before == kind or (kind == "var" and after == ":")):
                found.shared.add(part)
            elif kind == "fn" and (before in ("let", "var", "const") or (depth == 1 and after == ":")):
                found.local.setdefault(scope, set()).add(part)
            continue
        depth += (part in "([{") - (part in ")]}")
        is_first = depth == 0 and (part in ";}" or is_text(part))
    return found


def read_script(tokens: Sequence[str]) -> NamedText:
    """Return the names of a script: its scopes are what is declared at its top, and the members of classes there."""
    padded = [*tokens, "", ""]
    brackets = _Brackets(padded)
    around, kinds = brackets.around, brackets.kinds
    found = NamedText(tokens, [None] * len(tokens), [0] * len(tokens), set(), set(), {})
    scope = 0
    for i, part in enumerate(tokens):
        outside, before, after = around[i], padded[i - 1], padded[i + 1]
        kind = kinds[outside]
        if kind in ("top", "class") and (outside == i - 1 or (before in (";", "}") and around[i - 1] == outside)):
            scope += 1
        found.scopes[i] = scope
        if not is_word(part):
            continue
        is_in_braces = kind in ("literal", "pattern") and padded[outside] == "{" and before in ("{", ",")
        is_method = kind in ("class", "literal") and after == "(" and kinds[i + 1] == "parameters"
        if before in (".", "?."):
            role = PROPERTY
        elif part in SCRIPT_WORDS:
            continue
        elif is_method or (is_in_braces and after == ":"):
            role = PROPERTY
        else:
            role = BOTH if is_in_braces and after in (",", "}", "=") else VARIABLE
        found.roles[i] = role
        if role is not VARIABLE:
            is_set = before == "." and after == "=" and padded[i - 2] == "this"
            if is_set or (kind in ("literal", "class") and before not in (".", "?.")):
                found.properties.add(part)
        if role is not PROPERTY and _declares(padded, i, brackets):
            is_shared = outside == -1 and after != "=>"
            (found.shared if is_shared else found.local.setdefault(scope, set())).add(part)
    return found


class _Brackets:
    """What the brackets of a script are, by the number of the token that opens them.

    around : for each token, the innermost bracket that is open there; -1 at the top
    """

    def __init__(self, tokens: Sequence[str]) -> None:
        self.around: list[int] = []
        self.partners: dict[int, int] = {}
        stack = [-1]
        for i, part in enumerate(tokens):
            if part and part in ")]}":
                self.partners[stack.pop()] = i
            self.around.append(stack[-1])
            if part and part in "([{":
                stack.append(i)
        self.kinds = {-1: "top"}
        for i in sorted(self.partners):
            self.kinds[i] = self._kind(tokens, i)

    def _kind(self, tokens: Sequence[str], i: int) -> str:
        part, before, after = tokens[i], tokens[i - 1], tokens[self.partners[i] + 1]
        if part == "(":
            is_head = after == "{" and before not in _CONTROLS
            return "parameters" if after == "=>" or is_head else "group"
        if before in ("const", "let"):
            return "pattern"
        is_index = part == "[" and (before in (")", "]") or is_word(before))
        is_inside = self.kinds[self.around[i]] in ("parameters", "pattern") and before != "="
        if not is_index and (after == "=" or is_inside):
            return "pattern"
        if part == "[":
            return "list"
        if "class" in (before, tokens[i - 2]):
            return "class"
        return "block" if before in _BEFORE_BLOCK else "literal"


def _declares(tokens: Sequence[str], i: int, brackets: _Brackets) -> bool:
    """Return whether a name that is a variable is declared where it stands."""
    before, after, outside = tokens[i - 1], tokens[i + 1], brackets.around[i]
    if before in ("const", "let", "class", "function") or after == "=>" or tokens[i - 2] == "function":
        return True
    kind = brackets.kinds[outside]
    if kind in ("parameters", "pattern"):
        return before in _BEFORE_PARAMETER
    if before != "," or after not in ("=", ",", ";") or kind not in ("top", "block", "group"):
        return False
    for k in range(i - 2, outside, -1):  # a list that begins with a word that declares
        if brackets.around[k] == outside and tokens[k] in ("const", "let", ";"):
            return tokens[k] != ";"
    return False
