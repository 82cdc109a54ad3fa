"""What the text of a STEP file (ISO 10303-21) says of itself: its unit of length, its size, its assembly.

The library that makes triangles of it always answers in metres, and takes a tolerance that knows nothing of the size.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import MeshError
from .limits import budget

DEFAULT_METRES = 1e-3  # of a file that names no unit, which the library takes to be in millimetres
_MAX_DEPTH = 256
_MAX_UNIT_STEPS = 8  # units that are defined by one another
_COMMENT = re.compile(rb"/\*.*?\*/", re.DOTALL)
_START = re.compile(rb"\s*ISO-10303-21\s*;")
_PREFIXES = {
    name.encode("ascii"): 10.0**exponent
    for names, exponents in (
        ("EXA PETA TERA GIGA MEGA KILO HECTO DECA", (18, 15, 12, 9, 6, 3, 2, 1)),
        ("DECI CENTI MILLI MICRO NANO PICO FEMTO ATTO", (-1, -2, -3, -6, -9, -12, -15, -18)),
    )
    for name, exponent in zip(names.split(), exponents, strict=True)
}
# No pattern looks for an end beyond where the next match may begin: a file without ends would take its square of time.
_TEXT = rb"'(?:[^']|'')*+'"
_UNIT_OR_MEASURE = re.compile(rb";\s*#\s*(\d+)\s*=\s*((?:\(|(?:LENGTH_)?MEASURE_WITH_UNIT\b)[^;]*+)")
_LENGTH_UNIT = re.compile(rb"\bLENGTH_UNIT\s*\(\s*\)")
_CONTEXT_UNITS = re.compile(rb"\bGLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^()]*+)\)")
_SI = re.compile(rb"\bSI_UNIT\s*\(\s*(?:\.(\w+)\.|\$|\*)\s*,\s*\.METRE\.\s*\)")
_CONVERSION = re.compile(rb"\bCONVERSION_BASED_UNIT\s*\(\s*(" + _TEXT + rb")\s*,\s*#\s*(\d+)")
_MEASURE = re.compile(
    rb"\b(?:LENGTH_)?MEASURE_WITH_UNIT\s*\(\s*(?:\w*MEASURE\s*\(\s*)?([-+.\dEe]+)\s*+\)?\s*,\s*#\s*(\d+)"
)
_USAGE = re.compile(
    rb"\bNEXT_ASSEMBLY_USAGE_OCCURRENCE\s*\(\s*(?:" + _TEXT + rb"|\$)\s*,\s*(?:" + _TEXT + rb"|\$)\s*,\s*"
    rb"(?:" + _TEXT + rb"|\$)\s*,\s*#\s*(\d+)\s*,\s*#\s*(\d+)"
)
_POINT = re.compile(rb"#\s*(\d+)\s*=\s*CARTESIAN_POINT\s*\(\s*(?:" + _TEXT + rb"|\$)\s*,\s*\(([^()]*)\)")
_VERTEX = re.compile(rb"\bVERTEX_POINT\s*\(\s*(?:" + _TEXT + rb"|\$)\s*,\s*#\s*(\d+)")
_RADII = re.compile(
    rb"\b(?:CIRCLE|\w+_SURFACE)\s*\(\s*(?:" + _TEXT + rb"|\$)\s*,\s*#\s*\d+\s*,\s*([-+.\dEe]+)\s*"
    rb"(?:,\s*([-+.\dEe]+)\s*)?\)"
)
_REFERENCE = re.compile(rb"#\s*(\d+)")


@dataclass(frozen=True)
class StepText:
    """What the text of a STEP file says.

    data : the text, without comments, and with a unit of length that the library understands
    unit : the name of the unit of length; None for a file that names none
    metres : of this unit
    other_units : the names of further units of length, in which some of its parts are
    size : the diagonal of the box around its vertices, each where its own part has it, in its unit
    """

    data: bytes
    unit: str | None
    metres: float
    other_units: tuple[str, ...]
    size: float


def read_text(data: bytes) -> StepText:
    """Return what the text of a STEP file says of itself, and count its parts.

    Raises MeshError for what is no such text, and for assemblies within themselves or beyond the limits.
    """
    end = data.rfind(b"*/") + 2  # what begins behind it has no end, which would be looked for each time
    if -1 < data.find(b"/*") < end:
        data = _COMMENT.sub(b"", data[:end]) + data[end:]
    if not _START.match(data):
        raise MeshError("it is not STEP: it does not begin with ISO-10303-21;")
    try:
        _count_parts(data)
        data, units = _read_units(data)
        size = _measure(data)
    except MeshError:
        raise
    except ValueError:  # of more digits than Python converts
        raise MeshError("a number of an entity is too long") from None
    unit, metres = units[0] if units else (None, DEFAULT_METRES)
    return StepText(data, unit, metres, tuple(name for name, _ in units[1:]), size)


def _count_parts(data: bytes) -> None:
    """Count the nodes that the assembly expands to, which the library makes without a limit, and their depth."""
    children: dict[int, Counter[int]] = {}
    n_usages = 0
    for match in _USAGE.finditer(data):
        parent, child = int(match[1]), int(match[2])
        children.setdefault(parent, Counter())[child] += 1
        n_usages += 1
    budget().spell_nodes(n_usages + 1)
    within = {child for counts in children.values() for child in counts}
    depths, sizes = dict[int, int](), dict[int, int]()
    for part in _list_children_first(children):
        counts = children.get(part, Counter())
        depths[part] = 1 + max((depths[child] for child in counts), default=-1)
        sizes[part] = 1 + sum(count * sizes[child] for child, count in counts.items())
    if children:
        budget().require_depth(max(depths.values()), _MAX_DEPTH)
        budget().take_nodes(sum(sizes[part] for part in children if part not in within), "its assembly")


def _list_children_first(children: dict[int, Counter[int]]) -> Iterator[int]:
    """Yield the parts of assemblies, each after all that it is made of; raise MeshError if one is part of itself."""
    done, open_ = set[int](), set[int]()
    waiting = [(part, False) for part in children]
    while waiting:
        part, is_left = waiting.pop()
        if is_left:
            open_.discard(part)
            done.add(part)
            yield part
        elif part in open_:
            raise MeshError(f"its assembly #{part} is a part of itself")
        elif part not in done:
            open_.add(part)
            waiting.append((part, True))
            waiting += [(child, False) for child in children.get(part, ())]


_Definition = tuple[re.Match[bytes] | None, re.Match[bytes] | None]
"""What defines a unit of length: an SI unit, or a conversion from another unit."""


@dataclass(frozen=True)
class _Measure:
    """A number of units, and where the text says so, without its own number."""

    value: float
    unit: int
    span: tuple[int, int]
    is_simple: bool


def _read_units(data: bytes) -> tuple[bytes, list[tuple[str, float]]]:
    """Return the name of each unit of length that shapes are in, and its metres, in the order of the file.

    The library takes a unit to be a millimetre, without a word, if it is defined by another that is not an SI unit, as
    a foot of twelve inches. Such a definition is written anew, in the text that is returned.
    """
    definitions = dict[int, _Definition]()
    measures = dict[int, _Measure]()
    for match in _UNIT_OR_MEASURE.finditer(data):
        text = match[2]
        if text.startswith(b"(") and _LENGTH_UNIT.search(text):
            definitions[int(match[1])] = _SI.search(text), _CONVERSION.search(text)
        if found := _MEASURE.search(text):
            try:
                value = float(found[1])
            except ValueError:
                raise MeshError("a measure must be a number") from None
            measures[int(match[1])] = _Measure(value, int(found[2]), match.span(2), text.startswith(b"LENGTH"))
    used = [int(n) for match in _CONTEXT_UNITS.finditer(data) for n in _REFERENCE.findall(match[1])]
    named = dict[str, float]()
    edits = dict[tuple[int, int], bytes]()
    for number in dict.fromkeys(used):
        if number in definitions:
            name, metres, edit = _define(number, definitions, measures)
            named.setdefault(name, metres)
            edits |= edit
    pieces, last = list[bytes](), 0
    for (start, end), written in sorted(edits.items()):
        pieces += data[last:start], written
        last = end
    return b"".join([*pieces, data[last:]]), list(named.items())


def _define(
    number: int, definitions: dict[int, _Definition], measures: dict[int, _Measure]
) -> tuple[str, float, dict[tuple[int, int], bytes]]:
    """Return the name of a unit of length, its metres, and what to write instead of its definition.

    It is an SI unit, or a multiple of another unit (ISO 10303-41).
    """
    name, factor, first = "", 1.0, number
    steps: list[_Measure] = []
    while len(steps) < _MAX_UNIT_STEPS:
        si, conversion = definitions.get(number, (None, None))
        if si:
            prefix = si[1].upper() if si[1] else b""
            if prefix and prefix not in _PREFIXES:
                break
            own = f"{prefix.decode('ascii').lower()}metre"
            metres = float(f"{factor * (_PREFIXES[prefix] if prefix else 1.0):.15g}")
            if len(steps) < 2 and all(step.is_simple for step in steps):
                return name or own, metres, {}
            written = f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({_write_real(factor)}),#{number})"
            return name or own, metres, {steps[0].span: written.encode("ascii")}
        if conversion is None or int(conversion[2]) not in measures:
            break
        name = name or conversion[1][1:-1].decode("ascii", "replace").strip().lower()
        steps.append(measures[int(conversion[2])])
        factor, number = factor * steps[-1].value, steps[-1].unit
        if not 0.0 < factor < float("inf"):
            break
    raise MeshError(f"its unit of length #{first} is neither an SI unit nor a multiple of one")


def _write_real(value: float) -> str:
    """Return a number as the format has it, with a point."""
    text = repr(value).upper()
    return text if "." in text else text.replace("E", ".E")


def _measure(data: bytes) -> float:
    """Return the diagonal of the box around the vertices, or around all points if there are none.

    A ball or a torus may have a single vertex: then it is the largest radius.
    """
    vertices = {int(number) for number in _VERTEX.findall(data)}
    try:
        points = [
            [float(word) for word in match[2].split(b",")]
            for match in _POINT.finditer(data)
            if not vertices or int(match[1]) in vertices
        ]
        array = np.array([point for point in points if len(point) == 3]).reshape(-1, 3)
        radii = [float(word) for words in _RADII.findall(data) for word in words if word]
    except ValueError:
        raise MeshError("its points must be three numbers each") from None
    if not np.isfinite(array).all():
        raise MeshError("its points must be finite")
    with np.errstate(over="ignore"):
        diagonal = float(np.linalg.norm(array.max(axis=0) - array.min(axis=0))) if len(array) else 0.0
    size = diagonal or max(radii, default=0.0)
    if not math.isfinite(size):
        raise MeshError("its size must be finite")
    return size
