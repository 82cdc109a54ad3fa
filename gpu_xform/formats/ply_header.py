"""Headers of PLY: elements, their properties, comments, and the properties that make up an attribute."""

import re
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from ..errors import MeshError
from ._text import quote
from ._warn import warn

TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
}
NAMES_OF_TYPES = {dtype: name for name, dtype in TYPES.items()}
TYPES |= {"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
TYPES |= {"float32": "f4", "float64": "f8"}
ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNER_LISTS = ("vertex_indices", "vertex_index")
LINE_END = re.compile(rb"\r\n|\n|\r")
_CARRIAGE_RETURN = re.compile(rb"\r")
MAX_HEADER_LINE_BYTES = 4096
MAX_BLANK_BYTES = 4  # behind the last element, as some programs write them
_MAX_NAME_BYTES = 1024  # of a property that is written

# The properties of one value that make up an attribute of several columns.
GROUPS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "normal": (("nx", "ny", "nz"),),
    "color": (("red", "green", "blue", "alpha"), ("red", "green", "blue")),
    "texcoord": (("s", "t"), ("u", "v"), ("texture_u", "texture_v")),
}

Statement: TypeAlias = tuple[str, ...]


@dataclass(frozen=True)
class Property:
    """A property: the type of its values and, for a list, of its count."""

    name: str
    dtype: np.dtype[np.number]
    count_dtype: np.dtype[np.number] | None


@dataclass(frozen=True)
class Element:
    """An element: a number of rows with the same properties."""

    name: str
    count: int
    properties: list[Property]


@dataclass
class Header:
    """What a header says, and where it ends."""

    encoding: str = ""
    elements: list[Element] = field(default_factory=list)
    statements: list[Statement] = field(default_factory=list)
    """Comments, `obj_info`, elements without their counts, and properties, in the order of the file."""
    end: int = 0
    n_lines: int = 0
    names: set[tuple[str, str]] = field(default_factory=set)
    """Of the elements, and of the properties of each."""


def parse_header(data: bytes) -> Header:
    """Return the header that a file begins with; raise MeshError with the line that is malformed."""
    header = Header()
    # Where lines end with a carriage return alone, a byte 10 behind the last one belongs to the body.
    line_end = _CARRIAGE_RETURN if re.match(rb"ply[ \t]*\r(?!\n)", data) else LINE_END
    while True:
        header.n_lines += 1
        found = line_end.search(data, header.end, header.end + MAX_HEADER_LINE_BYTES)
        if found is None:
            raise MeshError(
                f"line {header.n_lines}: expected a header that ends with end_header, got the end of the file"
            )
        text = data[header.end : found.start()].decode("latin-1")
        header.end = found.end()
        if text.split() == ["end_header"] and header.encoding:
            return header
        _add_statement(header, text)


def _add_statement(header: Header, text: str) -> None:
    """Add what a line of a header says."""
    elements, line = header.elements, header.n_lines
    match text.split():
        case ["ply"] if line == 1:
            return
        case _ if line == 1:
            raise MeshError(f"line 1: expected 'ply', got {quote(text)}")
        case ["format", name, "1.0"] if name in ORDERS and not header.encoding:
            header.encoding = name
        case ["element", name, count] if header.encoding and count.isdecimal() and len(count) < 19:
            if ("", name) in header.names:
                raise MeshError(f"line {line}: a second element {name}")
            header.names.add(("", name))
            elements.append(Element(name, int(count), []))
            header.statements.append(("element", name))
        case ["property", *types, name] if elements and (
            len(types) == 1 or (types[:1] == ["list"] and len(types) == 3)
        ):
            if not TYPES.keys() >= {*types[-2:]}:
                raise MeshError(f"line {line}: not a statement of a PLY header: {quote(text)}")
            if (elements[-1].name, name) in header.names:
                raise MeshError(f"line {line}: a second property {name} of {elements[-1].name}")
            header.names.add((elements[-1].name, name))
            order = ORDERS[header.encoding]
            count_dtype = np.dtype(order + TYPES[types[1]]) if len(types) == 3 else None
            elements[-1].properties.append(Property(name, np.dtype(order + TYPES[types[-1]]), count_dtype))
            header.statements.append(("property", *types, name))
        case ["comment" | "obj_info" as keyword, *_]:
            header.statements.append((keyword, text.lstrip()[len(keyword) + 1 :]))
        case []:
            pass
        case _:
            raise MeshError(f"line {line}: not a statement of a PLY header: {quote(text)}")


def warn_of_bytes_behind(n_bytes: int, first: bytes, path: str = "") -> None:
    """Warn of bytes behind the last element of a binary file, of which are the first, unless they are a few blanks."""
    if n_bytes and not (n_bytes <= MAX_BLANK_BYTES and first.isspace()):
        place = f"{path}: " if path else ""
        warn(f"{place}{n_bytes:,} byte{'s' * (n_bytes > 1)} behind its last element, which are left out")


def group_properties(columns: dict[str, Any]) -> dict[str, Any]:
    """Return attributes: those of `GROUPS` in place of their properties, which have one value and the same type."""
    attributes = dict(columns)
    for name, choices in GROUPS.items():
        for parts in choices:
            found = [attributes.get(part) for part in parts]
            if name in attributes or any(part is None or getattr(part, "ndim", 0) != 1 for part in found):
                continue
            if len({part.dtype for part in found if part is not None}) == 1:
                for part in parts:
                    del attributes[part]
                attributes[name] = np.stack(found, axis=1)  # type: ignore[arg-type]
                break
    return attributes


def split_attribute(name: str, column: Any, known: set[str]) -> dict[str, Any]:
    """Return the properties that hold an attribute, those among `known` first."""
    if getattr(column, "ndim", 1) == 2 and name not in known:
        choices = [parts for parts in GROUPS.get(name, ()) if len(parts) == column.shape[1]]
        choices.sort(key=lambda parts: not known.issuperset(parts))
        if choices:
            return dict(zip(choices[0], column.T, strict=True))
    return {name: column}


def split_attributes(table: Mapping[str, Any], known: set[str], taken: Collection[str]) -> dict[str, dict[str, Any]]:
    """Return the properties that hold each attribute, no two of one name, and none that would join those of another.

    An attribute becomes one property of a new name if no header can hold its own, or another property has it.

    known : the names of properties that the file had, which stay
    taken : names that no property may have
    """
    found, numbers = {*taken}, Counter[str]()
    split: dict[str, dict[str, Any]] = {}
    for name in sorted(table, key=lambda name: name not in GROUPS):
        parts = split_attribute(name, table[name], known)
        if (name in known or name == _make_word(name)) and found.isdisjoint(parts):
            split[name] = parts
            found.update(parts)
            if len(parts) > 1:
                others = {part for choice in GROUPS[name] for part in choice}
                found |= others - known if known.issuperset(parts) else others
    for name in table:
        if name not in split:
            new = word = _make_word(name)
            while new in found:
                numbers[word] += 1
                new = f"{word}_{numbers[word] + 1}"
            split[name] = {new: table[name]}
            found.add(new)
    return {name: split[name] for name in table}


def _make_word(text: str) -> str:
    """Return a text with "_" for what a word of a header has not: blanks, controls, and what other readers refuse."""
    word = "".join(c if "!" <= c <= "~" else "_" for c in text[:_MAX_NAME_BYTES])
    return word or "_"


def list_new_names(split: Mapping[str, Mapping[str, Any]], what: str) -> list[str]:
    """Return, in words for warnings, which attributes of `split_attributes` are written under other names."""
    return [
        f"the name {quote(name)} per {what} (now {new})"
        for name, parts in split.items()
        for new in parts
        if new != name and len(parts) == 1
    ]
