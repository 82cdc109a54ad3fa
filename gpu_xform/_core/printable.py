"""Printable text: no control character of a file, a file name or an option reaches a terminal."""

import re

# All of C0 but the end of a line, DEL, all of C1, marks that turn the direction of writing, and separators of lines.
_CONTROLS = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff]")


def escape_controls(text: str) -> str:
    r"""Return a text with each control character but the end of a line written as Python does: "\x1b"."""
    return _CONTROLS.sub(lambda found: repr(found[0])[1:-1], text)


def escape_line(text: str) -> str:
    r"""Return a text in one line, with ends of lines as "\n": what it names cannot begin a line of its own."""
    return escape_controls(text).replace("\n", "\\n")
