"""Geometries of COLLADA files: the triangles of each group of faces, with the points that they share.

Section numbers of the schema are not given: an element is found by its name in the COLLADA 1.4.1 specification.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ._text import parse_numbers, quote

_KINDS = ("triangles", "tristrips", "trifans", "polylist", "polygons")
# Corners are one point where their positions, normals and texture coordinates are equal in so many parts of a unit.
_PARTS_PER_UNIT = {"VERTEX": 1e8, "TEXCOORD": 1e4, "NORMAL": 1e2}
_MAX_KEYS = 2**62
# What inputs are read, and how many numbers are in a row of each, if that matters.
_SEMANTICS: dict[str, tuple[int, ...]] = {"VERTEX": (3,), "NORMAL": (3,), "TEXCOORD": (), "COLOR": (3, 4)}


@dataclass(frozen=True)
class Triangles:
    """Points and the triangles between them, with a colour per point or none."""

    positions: Float64Array
    corners: IndexArray
    colors: npt.NDArray[np.uint8] | None

    @property
    def n_numbers(self) -> int:
        """How many coordinates and indices they hold."""
        return int(self.positions.size + self.corners.size)


class Group:
    """A group of faces with one material: the corners of its triangles, as rows of tables."""

    def __init__(self, material: str | None, tables: "_Tables", columns: dict[str, tuple[str, IndexArray]]) -> None:
        self.material = material
        self._tables = tables
        self._columns = columns  # the table of each kind of value, and the row of it for each corner

    @cached_property
    def colored_by_material(self) -> Triangles:
        """The triangles where a material colours them: points are split where their texture coordinates differ."""
        if "TEXCOORD" in self._columns:
            return self._join_corners("VERTEX", "TEXCOORD", "NORMAL")
        return Triangles(self.bare.positions, self.bare.corners, None)

    @cached_property
    def bare(self) -> Triangles:
        """The triangles without a material, in the colours of their points."""
        return self._join_corners("VERTEX", "NORMAL")

    def _join_corners(self, *kinds: str) -> Triangles:
        """Return the triangles with corners that have equal values of all `kinds` as one point, that of the first."""
        keys, n_keys = np.zeros(len(self._columns["VERTEX"][1]), np.int64), 1
        for kind in kinds:
            if kind not in self._columns:
                continue
            name, rows = self._columns[kind]
            numbers, n_numbers = self._tables.number_rows(name, kind)
            if n_keys * n_numbers > _MAX_KEYS:
                found, keys = np.unique(keys, return_inverse=True)
                n_keys = len(found)
            keys, n_keys = keys * n_numbers + numbers[rows], n_keys * n_numbers
        _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        order = np.argsort(first)
        ranks = np.empty_like(order)
        ranks[order] = np.arange(len(order))
        kept = first[order]
        name, rows = self._columns["VERTEX"]
        colors = None
        if "TEXCOORD" not in kinds and "COLOR" in self._columns:
            source, color_rows = self._columns["COLOR"]
            colors = as_bytes(self._tables.read(source)[color_rows[kept]])
        return Triangles(self._tables.read(name)[rows[kept]], ranks[inverse].reshape(-1, 3), colors)


class _Tables:
    """The sources of a geometry, each read when it is first needed."""

    def __init__(self, elements: dict[str, Any]) -> None:
        self._elements = elements
        self._read: dict[str, Float64Array] = {}
        self._row_numbers: dict[tuple[str, str], tuple[IndexArray, int]] = {}
        self._is_finite: dict[str, npt.NDArray[np.bool_]] = {}

    def read(self, name: str) -> Float64Array:
        """Return a row of floats per item; NaNs are 0."""
        if name not in self._read:
            element = self._elements.get(name)
            array = None if element is None else first_child(element, "float_array")
            if array is None:
                raise MeshError(f"there is no source {quote(name)} of floats")
            width = sum(1 for accessor in _accessors(element) for _ in accessor.iterchildren("{*}param"))
            values = _parse(array.text, f"source {quote(name)}")
            values[np.isnan(values)] = 0.0
            if not width or len(values) % width:
                raise MeshError(f"source {quote(name)} has {len(values)} numbers, for rows of {width}")
            self._read[name] = values.reshape(-1, width)
        return self._read[name]

    def is_finite(self, name: str) -> npt.NDArray[np.bool_]:
        """Return for each row of a table whether all its numbers are finite."""
        if name not in self._is_finite:
            self._is_finite[name] = np.all(np.isfinite(self.read(name)), axis=1)
        return self._is_finite[name]

    def number_rows(self, name: str, kind: str) -> tuple[IndexArray, int]:
        """Return a number per row of a table, the same for rows that are equal, and how many numbers there are."""
        if (name, kind) not in self._row_numbers:
            table = self.read(name)[:, :3]
            numbers, n_numbers = np.zeros(len(table), np.int64), 1
            with np.errstate(over="ignore"):
                rounded = np.round(table * _PARTS_PER_UNIT[kind])
            is_finite = np.isfinite(rounded)
            rounded[~is_finite] = np.ldexp(table[~is_finite], -1030)  # fractions, which nothing that is rounded equals
            for column in rounded.T:
                found, inverse = np.unique(column, return_inverse=True)
                numbers = numbers * len(found) + inverse
                found, numbers = np.unique(numbers, return_inverse=True)
                n_numbers = len(found)
            self._row_numbers[name, kind] = numbers, n_numbers
        return self._row_numbers[name, kind]


def read_groups(geometry: Any) -> list[Group]:
    """Return the groups of a geometry that hold triangles; polygons are split into fans.

    Raises MeshError for what is damaged.
    """
    mesh = first_child(geometry, "mesh")
    if mesh is None:
        raise MeshError("it is no mesh")
    tables = _Tables({source.get("id"): source for source in mesh.iterchildren("{*}source")})
    vertices: dict[str, dict[str, str]] = {}
    for element in mesh.iterchildren("{*}vertices"):
        inputs = [(each.get("semantic"), (each.get("source") or "")[1:]) for each in element.iterchildren("{*}input")]
        named = [("VERTEX" if kind == "POSITION" else kind, name) for kind, name in reversed(inputs)]
        vertices[element.get("id")] = {kind: name for kind, name in named if kind in _SEMANTICS}
    groups = (_read_group(each, tables, vertices) for each in mesh.iterchildren(*(f"{{*}}{kind}" for kind in _KINDS)))
    return [group for group in groups if group is not None]


def _read_group(element: Any, tables: _Tables, vertices: dict[str, dict[str, str]]) -> Group | None:
    """Return the triangles of an element; None if it has none."""
    kind = element.tag.rpartition("}")[2]
    inputs: dict[str, tuple[str, int]] = {}  # the first of each kind: its table, and its column of the indices
    width = 1
    for each in element.iterchildren("{*}input"):
        semantic, name = each.get("semantic"), (each.get("source") or "")[1:]
        column = _parse_offset(each.get("offset"))
        width = max(width, column + 1)
        own = vertices[name] if semantic == "VERTEX" and name in vertices else {semantic: name}
        for what, table in own.items():
            inputs.setdefault(what, (table, column))
    indices, sizes = _read_indices(element, kind, width)
    corners = _list_triangles(sizes // (1 if kind == "polylist" else width), kind)
    if not len(corners):
        return None
    if "VERTEX" not in inputs:
        raise MeshError(f"its {kind} have no positions")
    columns: dict[str, tuple[str, IndexArray]] = {}
    for what, n_values in _SEMANTICS.items():
        if what in inputs:
            name, column = inputs[what]
            table = tables.read(name)
            rows = indices[:, column][corners.ravel()]
            if rows.min() < 0 or rows.max() >= len(table):
                raise MeshError(f"its {kind} name an item of source {quote(name)} that it does not have")
            if what != "COLOR" or table.shape[1] in n_values:
                columns[what] = name, rows
            if what in ("VERTEX", "NORMAL") and table.shape[1] not in n_values:
                raise MeshError(f"source {quote(name)} must have rows of 3 numbers, has {table.shape[1]}")
    name, rows = columns["VERTEX"]
    is_kept = np.repeat(tables.is_finite(name)[rows].reshape(-1, 3).all(axis=1), 3)
    if not is_kept.all():
        columns = {what: (name, rows[is_kept]) for what, (name, rows) in columns.items()}
    return Group(element.get("material"), tables, columns) if len(columns["VERTEX"][1]) else None


def _read_indices(element: Any, kind: str, width: int) -> tuple[IndexArray, IndexArray]:
    """Return rows of `width` indices, and the sizes of the lists: of a polylist in rows, of others in numbers."""
    texts = [each.text or "" for each in element.iterchildren("{*}p")]
    if kind in ("triangles", "polylist"):
        del texts[1:]
    indices = _parse(" ".join(texts), f"its {kind}", "int")
    if kind == "polylist":
        counts = first_child(element, "vcount")
        sizes = _parse(None if counts is None else counts.text, "its polylist", "int")
        if sizes.min(initial=0) < 0 or sizes.sum() * width > len(indices) or sizes.max(initial=0) > len(indices):
            raise MeshError("its polylist has fewer corners than it counts")
    else:
        sizes = np.array([len(indices)] if kind == "triangles" else [len(text.split()) for text in texts], np.int64)
        if (sizes % (3 * width if kind == "triangles" else width)).any():
            raise MeshError(f"its {kind} end within a corner or a triangle")
    if len(indices) % width:
        raise MeshError(f"its {kind} end within a corner")
    return indices.reshape(-1, width), sizes


def _list_triangles(sizes: IndexArray, kind: str) -> IndexArray:
    """Return triangles (f, 3) of corners in lists of so many, one list after another.

    Of a strip, triangles of even numbers come first: the winding of the others is turned.
    """
    if kind == "triangles":
        return np.arange(sizes.sum()).reshape(-1, 3)
    counts = np.maximum(sizes - 2, 0)
    starts = np.repeat(np.cumsum(sizes) - sizes, counts)
    numbers = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    if kind != "tristrips":
        return np.stack([starts, starts + numbers + 1, starts + numbers + 2], axis=1)
    is_odd = numbers % 2
    corners = np.stack([starts + numbers + is_odd, starts + numbers + 1 - is_odd, starts + numbers + 2], axis=1)
    return corners[np.lexsort((is_odd, np.repeat(np.arange(len(sizes)), counts)))]


def as_bytes(colors: Float64Array) -> npt.NDArray[np.uint8]:
    """Return colours of 0 to 1, (n, 3) or (n, 4), as (n, 4) bytes; what is not finite is 0."""
    rgba = np.ones((len(colors), 4))
    rgba[:, : colors.shape[1]] = np.where(np.isfinite(colors), colors, 0.0)
    result: npt.NDArray[np.uint8] = np.rint(np.clip(rgba, 0.0, 1.0) * 255.0).astype(np.uint8)
    return result


def first_child(element: Any, tag: str) -> Any:
    """Return the first child of this name, or None."""
    return next(element.iterchildren(f"{{*}}{tag}"), None)


def _accessors(source: Any) -> Iterator[Any]:
    for technique in source.iterchildren("{*}technique_common"):
        yield from technique.iterchildren("{*}accessor")


def _parse_offset(text: str | None) -> int:
    try:
        offset = int(text or "")
    except ValueError:
        offset = -1
    if not 0 <= offset < 2**31:
        raise MeshError(f"an offset must be a natural number, got {quote(text or '')}")
    return offset


def _parse(text: str | None, owner: str, kind: Any = "float") -> Any:
    try:
        return parse_numbers((text or "").encode(), kind)
    except ValueError:
        raise MeshError(f"{owner}: not a number") from None
