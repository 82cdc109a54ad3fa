"""Scripts and WGSL as tokens, without spaces and comments; and tokens as the shortest text that means the same.

A token is a word, a number, a sign or a text: a string, a regular expression, a part of a template, a line `#import`.
"""

import re
from collections.abc import Sequence

_COMMON = r"[A-Za-z_$][\w$]*|0x[\da-fA-F]+[iu]?|(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?[fhiu]?"
_WGSL = re.compile(rf"\s+|//[^\n]*|(^\#[^\n]*|{_COMMON}|[-+*/&|=!<>]=|&&|\|\||->|\+\+|--|.)", re.MULTILINE)
_SCRIPT = re.compile(
    r"\s+|//[^\n]*|(`[^`]*`|\"[^\"\n]*\""
    r"|(?:(?<=[=(,:] )|(?<=[=(,:]))/(?![ /*])(?:\\.|\[(?:\\.|[^\]])*\]|[^/\n])+/\w*"
    rf"|{_COMMON}|\.\.\.|[=!]==|>>>|[?|&*]{{2}}=?|[-+*/&|^!<>=]=|=>|\+\+|--|\?\.|<<|>>|.)"
)
_HOLE = re.compile(r"\$\{([^}]*)\}")
# Of tokens that end in \0: separators before closing brackets, zeros before and after points, and what needs a space.
_NEEDLESS = re.compile(r"[,;]\0(?=\}\0)|,\0(?=[\])]\0)|(?<=\0)0(?=\.\d)")
_WHOLE = re.compile(r"(?<=\0)([1-9]\d*\.)0(?=\0)")
_NEEDLESS_IN_WGSL = re.compile(r",\0(?=[\])}]\0)|(?<=\0)0(?=\.\d)")
_SPACE = re.compile(r"(?<=[\w$])\0(?=[\w$])|(?<=[+])\0(?=[+])|(?<=-)\0(?=-)|(?<=>)\0(?==)")
_VECTOR = re.compile(r"\b(vec[234]|mat[234]x[234])<([fiu])32>")


def is_word(part: str) -> bool:
    """Return whether a token is a name or a word of the language."""
    return part[:1].isalpha() or part[:1] in ("_", "$")


def is_text(part: str) -> bool:
    """Return whether a token is a text."""
    return part[:1] in ('"', "`", "#") or (len(part) > 1 and part[0] in "}/" and part != "/=")


def split_wgsl(text: str) -> list[str]:
    """Return the tokens of a WGSL file."""
    return [token for token in _WGSL.findall(text) if token]


def split_script(text: str) -> list[str]:
    """Return the tokens of a script; the holes of templates are tokens of their own."""
    tokens: list[str] = []
    for token in _SCRIPT.findall(text):
        if token[:1] == "`":
            tokens += _split_template(token)
        elif token:
            tokens.append(token)
    return tokens


def _split_template(text: str) -> list[str]:
    tokens: list[str] = []
    parts = _HOLE.split(text)
    for i, part in enumerate(parts):
        if i % 2:
            tokens += split_script(part)
        else:
            tokens.append(("}" if i else "") + part + ("${" if i + 1 < len(parts) else ""))
    return tokens


def join_script(tokens: Sequence[str]) -> str:
    """Return a script in one line; nothing in it is declared to be constant."""
    joined = _NEEDLESS.sub("", "\0" + "\0".join(tokens) + "\0").replace("\0const\0", "\0let\0")
    return _SPACE.sub(" ", joined).replace("\0", "")


def join_wgsl(tokens: Sequence[str]) -> str:
    """Return a WGSL file, in which only `#import` has lines of its own."""
    lines = (f"\n{token}\n" if token[0] == "#" else token for token in tokens)
    joined = _WHOLE.sub(r"\1", _NEEDLESS_IN_WGSL.sub("", "\0" + "\0".join(lines) + "\0"))
    return _VECTOR.sub(r"\1\2", _SPACE.sub(" ", joined).replace("\0", "").replace("\n\n", "\n"))
