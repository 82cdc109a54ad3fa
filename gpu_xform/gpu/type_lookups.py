"""Fast lookups of C types in wgpu's bindings, which otherwise take half the time of a first picture.

cffi parses the text of each type once, and lets its parser read all the type names of wgpu.h before each text. Only the
names in the text matter.
"""

import re
from typing import Any

from .binding import ffi

_KINDS = ("typedef", "struct", "union", "enum")


def narrow_type_lookups() -> None:
    """Let cffi read only the names that the text of a type contains; do nothing with a cffi made otherwise."""
    parser: Any = getattr(ffi, "_parser", None)
    declarations = getattr(parser, "_declarations", None)
    if not isinstance(declarations, dict) or not hasattr(type(parser), "parse_type_and_quals"):
        return
    parse_after_all_names = parser.parse_type_and_quals

    def parse_type_and_quals(text: str) -> Any:
        """Parse with few names declared; cffi holds its lock meanwhile."""
        words = re.findall(r"\w+", text)
        names = {f"{kind} {word}" for kind in _KINDS for word in words} & declarations.keys()
        parser._declarations = {name: declarations[name] for name in names}
        try:
            return parse_after_all_names(text)
        finally:
            declarations.update(parser._declarations)
            parser._declarations = declarations

    parser.parse_type_and_quals = parse_type_and_quals
