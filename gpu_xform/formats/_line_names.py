"""Names and comments in the lines of OBJ and ASCII STL: what is written of a text is what is read again."""

import re
from collections import Counter
from collections.abc import Iterable

from ._text import plain_text, quote

# Line ends and control characters of any reader, and halves of surrogate pairs, which UTF-8 does not hold.
_UNHELD = re.compile("[\0-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
_UNHELD_BY_COMMENTS = re.compile("[\n\r\ud800-\udfff]")


def make_names(texts: Iterable[str], keyword: str) -> dict[str, str]:
    """Return the name to write behind a keyword for each text: other texts have other names.

    What a line does not hold becomes "_". A name that another text has by itself gets a number.
    """
    names = {text: _make_name(text, keyword) for text in texts}
    taken = {name for text, name in names.items() if name == text}
    counts = Counter[str]()
    for text, name in names.items():
        if name != text:
            found = name
            while found in taken:
                counts[name] += 1
                found = f"{name}_{counts[name] + 1}"
            taken.add(found)
            names[text] = found
    return names


def _make_name(text: str, keyword: str) -> str:
    name = _UNHELD.sub("_", text)
    name = name.lstrip(" ").rjust(len(name), "_")
    name = name.rstrip(" ").ljust(len(name), "_")
    line = f" {name}\n".encode()
    if keyword == "s" or (b"#" in line and plain_text(line) != line):  # a comment, or a number as Microsoft writes it
        name = name.replace("#", "_")
    return name


def make_comment(text: str) -> str:
    """Return a comment as one line."""
    return _UNHELD_BY_COMMENTS.sub("_", text)


def make_line(start: str, text: str) -> bytes:
    """Return a line that no backslash continues on the next one."""
    return f"{start}{text}{' ' if text.endswith(chr(92)) else ''}\n".encode()


def list_name_losses(texts: Iterable[str], keyword: str, what: str) -> list[str]:
    """Return words for names that are written as others."""
    changed = (text for text, name in make_names(texts, keyword).items() if name != text)
    return [f"some names of {what}, such as {quote(text)}" for text in changed][:1]
