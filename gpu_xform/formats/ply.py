"""PLY, ASCII and binary: the `vertex`, `face` and `edge` elements; every other element and property is passed over.

An ASCII body is turned into a binary one of float64 first, so that there is one way to read.
"""

import re
import struct
from dataclasses import dataclass
from typing import BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray
from ..errors import MeshError
from ..geometry.mesh import Mesh
from ._text import number, parse, printable

_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
}
_TYPES |= {"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
_TYPES |= {"float32": "f4", "float64": "f8"}
_ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")
_LINE_END = re.compile(rb"\r\n|\n|\r")
_LONGEST_HEADER_LINE = 4096

Values: TypeAlias = npt.NDArray[np.number]


@dataclass(frozen=True)
class _Property:
    """A property: the type of its values and, for a list, the type of its count."""

    name: str
    dtype: np.dtype[np.number]
    count_dtype: np.dtype[np.number] | None


@dataclass(frozen=True)
class _Element:
    """An element: how many rows of which properties."""

    name: str
    count: int
    properties: list[_Property]


@dataclass(frozen=True)
class _Column:
    """The values of a property over all rows, and how many each row has."""

    values: Values
    sizes: IndexArray


def read(data: bytes) -> Mesh:
    """Return the mesh of a PLY file: faces first, then edges as segments.

    Raises MeshError with the line of the header or the row of the element that is wrong.
    """
    layout, elements, start, line = _header(data)
    body = data[start:]
    if layout == "ascii":
        body, elements = _as_binary(body, line, elements)
    _check_room(elements, len(body))
    columns: dict[str, dict[str, _Column]] = {}
    place = 0
    for element in elements:
        columns[element.name], place = _read_element(body, place, element)
    if layout == "ascii" and place != len(body):
        raise MeshError(f"{(len(body) - place) // 8} numbers are left over after the last element")
    return _mesh(columns)


def _header(data: bytes) -> tuple[str, list[_Element], int, int]:
    """Return the format, the elements, where the body starts, and how many lines the header has."""
    layout = ""
    elements: list[_Element] = []
    start, line = 0, 0
    while True:
        line += 1
        found = _LINE_END.search(data, start, start + _LONGEST_HEADER_LINE)
        if found is None:
            raise MeshError(f"line {line}: expected a header that ends with end_header, got the end of the file")
        text = data[start : found.start()].decode("latin-1")
        start, words = found.end(), text.split()
        match words:
            case ["ply"] if line == 1:
                pass
            case _ if line == 1:
                raise MeshError(f"line 1: expected 'ply', got {printable(text)}")
            case ["format", name, "1.0"] if name in _ORDERS and not layout:
                layout = name
            case ["element", name, count] if layout and count.isdecimal() and len(count) < 19:
                if any(element.name == name for element in elements):
                    raise MeshError(f"line {line}: a second element {name}")
                elements.append(_Element(name, int(count), []))
            case ["property", dtype, name] if elements and dtype in _TYPES:
                _add(elements[-1], _Property(name, np.dtype(_ORDERS[layout] + _TYPES[dtype]), None), line)
            case ["property", "list", count, dtype, name] if elements and {count, dtype} <= _TYPES.keys():
                order = _ORDERS[layout]
                types = np.dtype(order + _TYPES[dtype]), np.dtype(order + _TYPES[count])
                _add(elements[-1], _Property(name, *types), line)
            case ["end_header"] if layout:
                return layout, elements, start, line
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise MeshError(f"line {line}: not a statement of a PLY header: {printable(text)}")


def _add(element: _Element, added: _Property, line: int) -> None:
    if any(known.name == added.name for known in element.properties):
        raise MeshError(f"line {line}: a second property {added.name} of {element.name}")
    element.properties.append(added)


def _as_binary(body: bytes, line: int, elements: list[_Element]) -> tuple[bytes, list[_Element]]:
    """Return an ASCII body and its elements with float64 for every type."""
    try:
        values = parse(body, "float")
    except ValueError:
        words = [(word, i) for i, text in enumerate(_LINE_END.split(body), line + 1) for word in text.split()]
        values = np.array([number(word, i) for word, i in words])
    double = np.dtype("<f8")
    same = [
        _Element(e.name, e.count, [_Property(p.name, double, p.count_dtype and double) for p in e.properties])
        for e in elements
    ]
    return values.astype(double).tobytes(), same


def _check_room(elements: list[_Element], n_bytes: int) -> None:
    """Raise MeshError where the rows declared cannot fit the bytes there are, before anything is allocated."""
    needed = 0
    for element in elements:
        least = sum((p.count_dtype or p.dtype).itemsize for p in element.properties)
        needed += element.count * least
        if element.count and not least:
            raise MeshError(f"the element {element.name} has no properties")
        if needed > n_bytes:
            raise MeshError(f"declares {element.count} rows of {element.name}, more than the rest of the file can hold")


def _read_element(body: bytes, place: int, element: _Element) -> tuple[dict[str, _Column], int]:
    """Return the columns of an element that starts at `place`, and where it ends."""
    return _read_equal_rows(body, place, element) or _read_rows(body, place, element)


def _read_equal_rows(body: bytes, place: int, element: _Element) -> tuple[dict[str, _Column], int] | None:
    """Return what `_read_element` does if every row has lists as long as the first row's, else None."""
    fields: list[tuple[str, np.dtype[np.number]] | tuple[str, np.dtype[np.number], tuple[int]]] = []
    sizes: list[int] = []
    itemsize = 0
    for i, p in enumerate(element.properties):
        size = 1
        if p.count_dtype:
            if element.count == 0 or place + itemsize + p.count_dtype.itemsize > len(body):
                return None
            count = np.frombuffer(body, p.count_dtype, 1, place + itemsize)[0]
            if not 0 <= count <= len(body) or count % 1 != 0:
                return None
            size = int(count)
            fields.append((f"n{i}", p.count_dtype))
            itemsize += p.count_dtype.itemsize
        fields.append((f"v{i}", p.dtype, (size,)))
        itemsize += size * p.dtype.itemsize
        sizes.append(size)
    if place + element.count * itemsize > len(body):
        return None
    table = np.frombuffer(body, np.dtype(fields), element.count, place)
    for i, p in enumerate(element.properties):
        if p.count_dtype and not (table[f"n{i}"] == sizes[i]).all():
            return None
    columns = {
        p.name: _Column(table[f"v{i}"].ravel(), np.full(element.count, sizes[i]))
        for i, p in enumerate(element.properties)
    }
    return columns, place + element.count * itemsize


def _read_rows(body: bytes, place: int, element: _Element) -> tuple[dict[str, _Column], int]:
    """Return what `_read_element` does, one row after the other: where a row starts depends on those before it."""
    starts: list[list[int]] = [[] for _ in element.properties]
    sizes: list[list[int]] = [[] for _ in element.properties]
    unpackers = [
        (struct.Struct(p.count_dtype.byteorder.replace("|", "=") + p.count_dtype.char) if p.count_dtype else None)
        for p in element.properties
    ]
    steps = list(zip(unpackers, [p.dtype.itemsize for p in element.properties], starts, sizes, strict=True))
    try:
        for row in range(element.count):
            for unpacker, itemsize, row_starts, row_sizes in steps:
                count = 1
                if unpacker:
                    (count,) = unpacker.unpack_from(body, place)
                    place += unpacker.size
                    if not count >= 0 or count % 1 != 0:  # a NaN fails the one, an infinity the other
                        raise MeshError(f"{element.name} {row}: a list cannot have {count} values")
                    count = int(count)
                row_starts.append(place)
                row_sizes.append(count)
                place += count * itemsize
            if place > len(body):
                raise EOFError
    except (EOFError, struct.error):
        raise MeshError(f"{element.name} {row}: the file ends within this row, of {element.count} declared") from None
    columns = {}
    for p, begins, counts in zip(element.properties, starts, sizes, strict=True):
        lengths = np.array(counts, np.int64)
        columns[p.name] = _Column(_gather(body, np.array(begins, np.int64), lengths, p.dtype), lengths)
    return columns, place


def _gather(body: bytes, starts: IndexArray, sizes: IndexArray, dtype: np.dtype[np.number]) -> Values:
    """Return the runs of `sizes` values that lie at `starts`, one behind the other."""
    ends = starts + sizes * dtype.itemsize
    gaps = starts - np.concatenate([np.zeros(1, np.int64), ends])[:-1]
    is_value = np.repeat(np.tile([False, True], len(starts)), np.stack([gaps, ends - starts], axis=1).ravel())
    values: Values = np.frombuffer(body, np.uint8)[: len(is_value)][is_value].view(dtype)
    return values


def _mesh(columns: dict[str, dict[str, _Column]]) -> Mesh:
    """Return the mesh of the elements that were read."""
    if "vertex" not in columns:
        raise MeshError("the header declares no element vertex")
    positions = np.stack([_scalars(columns, "vertex", axis).astype(np.float64) for axis in "xyz"], axis=1)
    if not np.isfinite(positions).all():
        row = int(np.argmax(~np.isfinite(positions).all(axis=1)))
        raise MeshError(f"vertex {row}: coordinates must be finite, got {positions[row].tolist()}")
    sizes, indices = [], []
    if "tristrips" in columns:
        raise MeshError("the element tristrips cannot be read")
    if "face" in columns:
        corners = next((columns["face"][name] for name in _CORNERS if name in columns["face"]), None)
        if corners is None:
            raise MeshError("the element face has no list vertex_indices or vertex_index")
        sizes.append(corners.sizes)
        indices.append(_indices(corners.values, "face"))
    if "edge" in columns:
        ends = [_indices(_scalars(columns, "edge", name), "edge") for name in ("vertex1", "vertex2")]
        sizes.append(np.full(len(ends[0]), 2))
        indices.append(np.stack(ends, axis=1).ravel())
    offsets = np.concatenate([[0], np.cumsum(np.concatenate([*sizes, np.zeros(0, np.int64)]))])
    return Mesh.from_offsets(positions, offsets, np.concatenate([*indices, np.zeros(0, np.int64)]))


def _scalars(columns: dict[str, dict[str, _Column]], element: str, name: str) -> Values:
    """Return a property with one value a row."""
    column = columns[element].get(name)
    if column is None or (column.sizes != 1).any():
        raise MeshError(f"the element {element} has no property {name} of one value")
    return column.values


def _indices(values: Values, element: str) -> IndexArray:
    """Return values as int64; raise MeshError for one that is not an integer."""
    if values.dtype.kind == "f":
        wrong = ~(np.abs(values) < 2**53) | (values != np.floor(values))
        if wrong.any():
            raise MeshError(f"an index of an element {element} must be an integer, got {values[np.argmax(wrong)]}")
    return values.astype(np.int64)


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write binary little-endian PLY: float64 points, polygons as faces, segments as edges behind them."""
    sizes = np.diff(mesh.offsets)
    is_segment = sizes == 2
    of_segment = np.repeat(is_segment, sizes)
    corner_type, corner_name = ("<u4", "uint") if mesh.n_points > 2**31 else ("<i4", "int")
    count_type, count_name = ("<u4", "uint") if sizes.max(initial=0) > 255 else ("u1", "uchar")
    segments, corners = mesh.indices[of_segment].astype(corner_type), mesh.indices[~of_segment].astype(corner_type)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {mesh.n_points}\n"
    header += "".join(f"property double {axis}\n" for axis in "xyz")
    header += f"element face {(~is_segment).sum()}\nproperty list {count_name} {corner_name} vertex_indices\n"
    if len(segments):
        header += f"element edge {is_segment.sum()}\nproperty {corner_name} vertex1\nproperty {corner_name} vertex2\n"
    file.write(f"{header}end_header\n".encode())
    file.write(mesh.positions.astype("<f8").tobytes())
    file.write(_lists(sizes[~is_segment].astype(count_type), corners))
    file.write(segments.tobytes())


def _lists(sizes: Values, corners: Values) -> bytes:
    """Return each size followed by as many corners."""
    ends = np.cumsum(sizes.astype(np.int64) * corners.itemsize + sizes.itemsize)
    starts = np.concatenate([np.zeros(1, np.int64), ends])[:-1]
    is_size = np.zeros(sizes.nbytes + corners.nbytes, bool)
    for byte in range(sizes.itemsize):
        is_size[starts + byte] = True
    lists = np.empty(len(is_size), np.uint8)
    lists[is_size] = sizes.view(np.uint8)
    lists[~is_size] = corners.view(np.uint8)
    return lists.tobytes()
