"""PLY, ASCII and binary: the elements `vertex`, `face` and `edge`; other elements and properties are ignored.

An ASCII body is first converted to a binary one of float64, so that one reader suffices.
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
from ._text import parse_float, parse_numbers, plain_text, quote, without_mark

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
_CARRIAGE_RETURN = re.compile(rb"\r")
_MAX_HEADER_LINE_BYTES = 4096

Values: TypeAlias = npt.NDArray[np.number]


@dataclass(frozen=True)
class _Property:
    """A property: the type of its values and, for a list, of its count."""

    name: str
    dtype: np.dtype[np.number]
    count_dtype: np.dtype[np.number] | None


@dataclass(frozen=True)
class _Element:
    """An element: a number of rows with the same properties."""

    name: str
    count: int
    properties: list[_Property]


@dataclass(frozen=True)
class _Column:
    """The values of a property in all rows, and the number of values in each row."""

    values: Values
    sizes: IndexArray


def read(data: bytes) -> Mesh:
    """Return the mesh of a PLY file: faces first, then edges as segments.

    Raises MeshError with the line of the header, or the row of the element, that is malformed.
    """
    data = without_mark(data)
    layout, elements, start, line = _parse_header(data)
    body = data[start:]
    if layout == "ascii":
        body, elements = _to_binary(body, line, elements)
    _require_room(elements, len(body))
    columns: dict[str, dict[str, _Column]] = {}
    position = 0
    for element in elements:
        columns[element.name], position = _read_element(body, position, element)
    if layout == "ascii" and position != len(body):
        raise MeshError(f"{(len(body) - position) // 8} numbers are left over after the last element")
    return _build_mesh(columns)


def _parse_header(data: bytes) -> tuple[str, list[_Element], int, int]:
    """Return the format, the elements, the start of the body, and the number of lines of the header."""
    layout = ""
    elements: list[_Element] = []
    start, line = 0, 0
    # Where lines end with a carriage return alone, a byte 10 behind the last one belongs to the body.
    line_end = _CARRIAGE_RETURN if re.match(rb"ply[ \t]*\r(?!\n)", data) else _LINE_END
    while True:
        line += 1
        found = line_end.search(data, start, start + _MAX_HEADER_LINE_BYTES)
        if found is None:
            raise MeshError(f"line {line}: expected a header that ends with end_header, got the end of the file")
        text = data[start : found.start()].decode("latin-1")
        start, words = found.end(), text.split()
        match words:
            case ["ply"] if line == 1:
                pass
            case _ if line == 1:
                raise MeshError(f"line 1: expected 'ply', got {quote(text)}")
            case ["format", name, "1.0"] if name in _ORDERS and not layout:
                layout = name
            case ["element", name, count] if layout and count.isdecimal() and len(count) < 19:
                if any(element.name == name for element in elements):
                    raise MeshError(f"line {line}: a second element {name}")
                elements.append(_Element(name, int(count), []))
            case ["property", dtype, name] if elements and dtype in _TYPES:
                _add_property(elements[-1], _Property(name, np.dtype(_ORDERS[layout] + _TYPES[dtype]), None), line)
            case ["property", "list", count, dtype, name] if elements and {count, dtype} <= _TYPES.keys():
                order = _ORDERS[layout]
                types = np.dtype(order + _TYPES[dtype]), np.dtype(order + _TYPES[count])
                _add_property(elements[-1], _Property(name, *types), line)
            case ["end_header"] if layout:
                return layout, elements, start, line
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise MeshError(f"line {line}: not a statement of a PLY header: {quote(text)}")


def _add_property(element: _Element, added: _Property, line: int) -> None:
    if any(known.name == added.name for known in element.properties):
        raise MeshError(f"line {line}: a second property {added.name} of {element.name}")
    element.properties.append(added)


def _to_binary(body: bytes, line: int, elements: list[_Element]) -> tuple[bytes, list[_Element]]:
    """Return an ASCII body and its elements with float64 for every type."""
    body = plain_text(body)
    try:
        values = parse_numbers(body, "float")
    except ValueError:
        words = [(word, i) for i, text in enumerate(_LINE_END.split(body), line + 1) for word in text.split()]
        values = np.array([parse_float(word, i) for word, i in words])
    double = np.dtype("<f8")
    same = [
        _Element(e.name, e.count, [_Property(p.name, double, p.count_dtype and double) for p in e.properties])
        for e in elements
    ]
    return values.astype(double).tobytes(), same


def _require_room(elements: list[_Element], n_bytes: int) -> None:
    """Raise MeshError if the declared rows cannot fit into the bytes, before anything is allocated."""
    needed = 0
    for element in elements:
        min_row_bytes = sum((p.count_dtype or p.dtype).itemsize for p in element.properties)
        needed += element.count * min_row_bytes
        if element.count and not min_row_bytes:
            raise MeshError(f"the element {element.name} has no properties")
        if needed > n_bytes:
            raise MeshError(f"declares {element.count} rows of {element.name}, more than the rest of the file can hold")


def _read_element(body: bytes, position: int, element: _Element) -> tuple[dict[str, _Column], int]:
    """Return the columns of an element that starts at `position`, and the end of the element."""
    return _read_equal_rows(body, position, element) or _read_rows(body, position, element)


def _read_equal_rows(body: bytes, position: int, element: _Element) -> tuple[dict[str, _Column], int] | None:
    """Return the same as `_read_element` if the lists are as long in every row as in the first, else None."""
    fields: list[tuple[str, np.dtype[np.number]] | tuple[str, np.dtype[np.number], tuple[int]]] = []
    sizes: list[int] = []
    itemsize = 0
    for i, p in enumerate(element.properties):
        size = 1
        if p.count_dtype:
            if element.count == 0 or position + itemsize + p.count_dtype.itemsize > len(body):
                return None
            count = np.frombuffer(body, p.count_dtype, 1, position + itemsize)[0]
            if not 0 <= count <= len(body) or count % 1 != 0:
                return None
            size = int(count)
            fields.append((f"n{i}", p.count_dtype))
            itemsize += p.count_dtype.itemsize
        fields.append((f"v{i}", p.dtype, (size,)))
        itemsize += size * p.dtype.itemsize
        sizes.append(size)
    if position + element.count * itemsize > len(body):
        return None
    table = np.frombuffer(body, np.dtype(fields), element.count, position)
    for i, p in enumerate(element.properties):
        if p.count_dtype and not (table[f"n{i}"] == sizes[i]).all():
            return None
    columns = {
        p.name: _Column(table[f"v{i}"].ravel(), np.full(element.count, sizes[i]))
        for i, p in enumerate(element.properties)
    }
    return columns, position + element.count * itemsize


def _read_rows(body: bytes, position: int, element: _Element) -> tuple[dict[str, _Column], int]:
    """Return the same as `_read_element`, row by row, because the start of a row depends on those before it."""
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
                    (count,) = unpacker.unpack_from(body, position)
                    position += unpacker.size
                    if not count >= 0 or count % 1 != 0:  # a NaN fails the first test, an infinity the second
                        raise MeshError(f"{element.name} {row}: a list cannot have {count} values")
                    count = int(count)
                row_starts.append(position)
                row_sizes.append(count)
                position += count * itemsize
            if position > len(body):
                raise EOFError
    except (EOFError, struct.error):
        raise MeshError(f"{element.name} {row}: the file ends within this row, of {element.count} declared") from None
    columns = {}
    for p, begins, counts in zip(element.properties, starts, sizes, strict=True):
        lengths = np.array(counts, np.int64)
        columns[p.name] = _Column(_gather(body, np.array(begins, np.int64), lengths, p.dtype), lengths)
    return columns, position


def _gather(body: bytes, starts: IndexArray, sizes: IndexArray, dtype: np.dtype[np.number]) -> Values:
    """Return the concatenated runs of `sizes` values that start at `starts`."""
    ends = starts + sizes * dtype.itemsize
    gaps = starts - np.concatenate([np.zeros(1, np.int64), ends])[:-1]
    is_value = np.repeat(np.tile([False, True], len(starts)), np.stack([gaps, ends - starts], axis=1).ravel())
    values: Values = np.frombuffer(body, np.uint8)[: len(is_value)][is_value].view(dtype)
    return values


def _build_mesh(columns: dict[str, dict[str, _Column]]) -> Mesh:
    """Return the mesh of the elements."""
    if "vertex" not in columns:
        raise MeshError("the header declares no element vertex")
    positions = np.stack([_get_scalars(columns, "vertex", axis).astype(np.float64) for axis in "xyz"], axis=1)
    if not np.isfinite(positions).all():
        row = int(np.argmax(~np.isfinite(positions).all(axis=1)))
        raise MeshError(f"vertex {row}: coordinates must be finite, got {positions[row].tolist()}")
    sizes, indices = [], []
    if "face" in columns:
        corners = _get_corners(columns["face"], "face")
        sizes.append(corners.sizes)
        indices.append(_as_indices(corners.values, "face"))
    if "tristrips" in columns:
        strips = _get_corners(columns["tristrips"], "tristrips")
        triangles = _split_strips(_as_indices(strips.values, "tristrips"), strips.sizes)
        sizes.append(np.full(len(triangles), 3))
        indices.append(triangles.ravel())
    if "edge" in columns:
        ends = [_as_indices(_get_scalars(columns, "edge", name), "edge") for name in ("vertex1", "vertex2")]
        sizes.append(np.full(len(ends[0]), 2))
        indices.append(np.stack(ends, axis=1).ravel())
    offsets = np.concatenate([[0], np.cumsum(np.concatenate([*sizes, np.zeros(0, np.int64)]))])
    return Mesh.from_offsets(positions, offsets, np.concatenate([*indices, np.zeros(0, np.int64)]))


def _get_corners(columns: dict[str, _Column], element: str) -> _Column:
    """Return the list of corners of an element."""
    corners = next((columns[name] for name in _CORNERS if name in columns), None)
    if corners is None:
        raise MeshError(f"the element {element} has no list vertex_indices or vertex_index")
    return corners


def _split_strips(values: IndexArray, sizes: IndexArray) -> IndexArray:
    """Return the triangles (t, 3) of triangle strips, each of which ends at a -1 or with its list.

    Every second triangle of a strip is turned. Those with equal corners, which only join strips, are left out.
    """
    ends = np.cumsum(sizes)
    values = np.insert(values, ends, -1)
    is_break = values < 0
    if (values < -1).any():
        raise MeshError(f"an index of an element tristrips must be -1 or more, got {values.min()}")
    places = np.arange(len(values))
    begins = np.maximum.accumulate(np.where(is_break, places + 1, 0)) if len(values) else places
    a, b, c = values[:-2], values[1:-1], values[2:]
    is_triangle = (a >= 0) & (b >= 0) & (c >= 0) & (a != b) & (b != c) & (a != c)
    is_turned = ((places - begins)[:-2] % 2 == 1)[:, np.newaxis]
    triangles: IndexArray = np.where(is_turned, np.stack([b, a, c], axis=1), np.stack([a, b, c], axis=1))[is_triangle]
    return triangles


def _get_scalars(columns: dict[str, dict[str, _Column]], element: str, name: str) -> Values:
    """Return a property with one value per row."""
    column = columns[element].get(name)
    if column is None or (column.sizes != 1).any():
        raise MeshError(f"the element {element} has no property {name} of one value")
    return column.values


def _as_indices(values: Values, element: str) -> IndexArray:
    """Return values as int64; raise MeshError for a value that is not an integer."""
    if values.dtype.kind == "f":
        wrong = ~(np.abs(values) < 2**53) | (values != np.floor(values))
        if wrong.any():
            raise MeshError(f"an index of an element {element} must be an integer, got {values[np.argmax(wrong)]}")
    return values.astype(np.int64)


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write binary little-endian PLY: float64 points, polygons as faces, then segments as edges."""
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
    file.write(_interleave_lists(sizes[~is_segment].astype(count_type), corners))
    file.write(segments.tobytes())


def _interleave_lists(sizes: Values, corners: Values) -> bytes:
    """Return each size, followed by as many corners."""
    ends = np.cumsum(sizes.astype(np.int64) * corners.itemsize + sizes.itemsize)
    starts = np.concatenate([np.zeros(1, np.int64), ends])[:-1]
    is_size = np.zeros(sizes.nbytes + corners.nbytes, bool)
    for byte in range(sizes.itemsize):
        is_size[starts + byte] = True
    lists = np.empty(len(is_size), np.uint8)
    lists[is_size] = sizes.view(np.uint8)
    lists[~is_size] = corners.view(np.uint8)
    return lists.tobytes()
