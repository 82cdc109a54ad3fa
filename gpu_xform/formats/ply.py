"""PLY, ASCII and binary: every element with all its properties, comments and types.

An ASCII body is first converted to a binary one of float64, so that one reader suffices.
"""

import struct
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray
from ..errors import MeshError
from ..geometry.attributes import NO_ATTRIBUTES, Attributes, RaggedArray
from ..geometry.mesh import Mesh, take_over
from ._text import parse_float, parse_numbers, plain_text, without_mark
from .ply_header import (
    CORNER_LISTS,
    LINE_END,
    MAX_BLANK_BYTES,
    Element,
    Header,
    Property,
    Statement,
    group_properties,
    parse_header,
    warn_of_bytes_behind,
)
from .ply_writer import list_losses as list_losses
from .ply_writer import write as write

Values: TypeAlias = npt.NDArray[np.number]


@dataclass(frozen=True)
class _Column:
    """The values of a property, row by row, and the number of values in each row.

    rows : (n,), or (n, k) in the memory of the file if all rows have k values
    """

    rows: Values
    sizes: IndexArray

    @property
    def values(self) -> Values:
        """All values, one row after the other."""
        return self.rows.reshape(-1)


def read(data: bytes) -> Mesh:
    """Return the mesh of a PLY file: faces first, then edges as segments.

    Raises MeshError with the line of the header, or the row of the element, that is malformed.
    """
    data = without_mark(data)
    header = parse_header(data)
    body: bytes | memoryview = memoryview(data)[header.end :]
    elements = header.elements
    if header.encoding == "ascii":
        body, elements = _to_binary(bytes(body), header.n_lines, elements)
    _require_room(elements, len(body))
    columns: dict[str, dict[str, _Column]] = {}
    position = 0
    for element in elements:
        columns[element.name], position = _read_element(body, position, element)
    if header.encoding != "ascii":
        warn_of_bytes_behind(len(body) - position, bytes(body[position:][:MAX_BLANK_BYTES]))
    elif position != len(body):
        raise MeshError(f"{(len(body) - position) // 8} numbers are left over after the last element")
    return _build_mesh(header, columns)


def _to_binary(body: bytes, line: int, elements: list[Element]) -> tuple[bytes, list[Element]]:
    """Return an ASCII body and its elements with float64 for every type."""
    body = plain_text(body)
    try:
        values = parse_numbers(body, "float")
    except ValueError:
        words = [(word, i) for i, text in enumerate(LINE_END.split(body), line + 1) for word in text.split()]
        values = np.array([parse_float(word, i) for word, i in words])
    double = np.dtype("<f8")
    same = [
        Element(e.name, e.count, [Property(p.name, double, p.count_dtype and double) for p in e.properties])
        for e in elements
    ]
    return values.astype(double).tobytes(), same


def _require_room(elements: list[Element], n_bytes: int) -> None:
    """Raise MeshError if the declared rows cannot fit into the bytes, before anything is allocated."""
    needed = 0
    for element in elements:
        min_row_bytes = sum((p.count_dtype or p.dtype).itemsize for p in element.properties)
        needed += element.count * min_row_bytes
        if element.count and not min_row_bytes:
            raise MeshError(f"the element {element.name} has no properties")
        if needed > n_bytes:
            raise MeshError(f"declares {element.count} rows of {element.name}, more than the rest of the file can hold")


def _read_element(body: bytes | memoryview, position: int, element: Element) -> tuple[dict[str, _Column], int]:
    """Return the columns of an element that starts at `position`, and the end of the element."""
    return _read_equal_rows(body, position, element) or _read_rows(body, position, element)


def _read_equal_rows(
    body: bytes | memoryview, position: int, element: Element
) -> tuple[dict[str, _Column], int] | None:
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
        p.name: _Column(table[f"v{i}"], np.broadcast_to(np.int64(sizes[i]), element.count))
        for i, p in enumerate(element.properties)
    }
    return columns, position + element.count * itemsize


def _read_rows(body: bytes | memoryview, position: int, element: Element) -> tuple[dict[str, _Column], int]:
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
    except (EOFError, OverflowError, struct.error):  # a count of a float may lie beyond what Python can address
        raise MeshError(f"{element.name} {row}: the file ends within this row, of {element.count} declared") from None
    columns = {}
    for p, begins, counts in zip(element.properties, starts, sizes, strict=True):
        lengths = np.array(counts, np.int64)
        columns[p.name] = _Column(_gather(body, np.array(begins, np.int64), lengths, p.dtype), lengths)
    return columns, position


def _gather(body: bytes | memoryview, starts: IndexArray, sizes: IndexArray, dtype: np.dtype[np.number]) -> Values:
    """Return the concatenated runs of `sizes` values that start at `starts`."""
    ends = starts + sizes * dtype.itemsize
    gaps = starts - np.concatenate([np.zeros(1, np.int64), ends])[:-1]
    is_value = np.repeat(np.tile([False, True], len(starts)), np.stack([gaps, ends - starts], axis=1).ravel())
    values: Values = np.frombuffer(body, np.uint8)[: len(is_value)][is_value].view(dtype)
    return values


def _build_mesh(header: Header, columns: dict[str, dict[str, _Column]]) -> Mesh:
    """Return the mesh of the elements."""
    if "vertex" not in columns:
        raise MeshError("the header declares no element vertex")
    axes = [_get_scalars(columns, "vertex", axis) for axis in "xyz"]
    positions = np.empty((len(axes[0]), 3))
    with np.errstate(invalid="ignore"):  # of signalling NaNs
        for column, values in zip(positions.T, axes, strict=True):
            column[:] = values
    if not np.isfinite(positions).all():
        row = int(np.argmax(~np.isfinite(positions).all(axis=1)))
        raise MeshError(f"vertex {row}: coordinates must be finite, got {positions[row].tolist()}")
    sizes: list[IndexArray] = [np.zeros(0, np.int64)]
    indices: list[npt.NDArray[np.integer]] = [np.zeros(0, np.int64)]
    used = {"vertex": {*"xyz"}, "edge": {"vertex1", "vertex2"}, "face": set[str]()}
    if "face" in columns:
        corners = _get_corners(columns["face"], "face")
        used["face"] = {name for name in CORNER_LISTS if columns["face"].get(name) is corners}
        sizes.append(corners.sizes)
        indices.append(_as_indices(corners.rows, "face"))
    n_strip_triangles, n_edges = 0, 0
    if "tristrips" in columns:
        strips = _get_corners(columns["tristrips"], "tristrips")
        triangles = _split_strips(_as_indices(strips.values, "tristrips").astype(np.int64), strips.sizes)
        n_strip_triangles = len(triangles)
        sizes.append(np.full(n_strip_triangles, 3))
        indices.append(triangles.ravel())
    if "edge" in columns:
        ends = [_as_indices(_get_scalars(columns, "edge", name), "edge") for name in ("vertex1", "vertex2")]
        n_edges = len(ends[0])
        sizes.append(np.full(n_edges, 2))
        indices.append(np.stack(ends, axis=1).ravel())
    rest = {
        element.name: _restore_types(element, columns[element.name], used.get(element.name, set()))
        for element in header.elements
        if element.name != "tristrips"
    }
    face_sizes = sizes[1] if "face" in columns else sizes[0]
    attributes, elements = _sort_columns(header, rest, face_sizes, n_strip_triangles, n_edges)
    is_table = len(indices) == 2 and indices[1].ndim == 2 and indices[1].shape[1] > 1  # faces of one size, alone
    return take_over(
        positions,
        indices[1] if is_table else _join_faces(sizes, indices),
        attributes=attributes,
        metadata={"ply": _describe_file(header, elements, len(face_sizes) + n_strip_triangles, n_edges)},
    )


def _join_faces(
    sizes: list[IndexArray], indices: list[npt.NDArray[np.integer]]
) -> tuple[IndexArray, npt.NDArray[np.integer]]:
    """Return the offsets and indices of lists of faces."""
    offsets = np.concatenate([[0], np.cumsum(np.concatenate(sizes))])
    return offsets, np.concatenate([part.reshape(-1) for part in indices])


def _describe_file(header: Header, elements: dict[str, Any], n_faces: int, n_edges: int) -> dict[str, Any]:
    """Return what the writer needs to write a file as it was, and words for what other formats would lose."""
    n_comments = sum(statement[0] in ("comment", "obj_info") for statement in header.statements)
    holds = [f"{n_comments} comment{'s'[: n_comments - 1]}"] if n_comments else []
    return {
        "encoding": header.encoding,
        "header": _drop_element(header.statements, "tristrips"),
        "elements": elements,
        "n_faces": n_faces,
        "n_edges": n_edges,
        "holds": [*holds, *(f"element {name}" for name in elements)],
    }


def _drop_element(statements: list[Statement], element: str) -> list[Statement]:
    """Return the statements of a header without those of an element."""
    kept: list[Statement] = []
    current = ""
    for statement in statements:
        current = statement[1] if statement[0] == "element" else current
        if current != element or statement[0] not in ("element", "property"):
            kept.append(statement)
    return kept


def _restore_types(element: Element, columns: dict[str, _Column], used: set[str]) -> dict[str, Any]:
    """Return the columns that are not `used` as arrays of the declared types; rows of a list are rows of an array."""
    arrays: dict[str, Any] = {}
    for declared in element.properties:
        if declared.name in used:
            continue
        column = columns[declared.name]
        values = _cast(column.values, declared.dtype.newbyteorder("="))
        if declared.count_dtype is None:
            arrays[declared.name] = values
        elif len(column.sizes) and (column.sizes == column.sizes[0]).all():
            arrays[declared.name] = values.reshape(len(column.sizes), int(column.sizes[0]))
        else:
            arrays[declared.name] = RaggedArray(values, np.concatenate([[0], np.cumsum(column.sizes)]))
    return arrays


def _cast(values: Values, dtype: np.dtype[np.number]) -> Values:
    """Return values in the type that the header declares, or as they are if it cannot hold what ASCII says."""
    if values.dtype == dtype:
        return values
    with np.errstate(over="ignore", invalid="ignore"):
        cast = values.astype(dtype)
    if dtype.kind == "f":
        return cast if np.array_equal(np.isfinite(cast), np.isfinite(values)) else values
    return cast if np.array_equal(cast, values) else values


def _sort_columns(
    header: Header, rest: dict[str, dict[str, Any]], face_sizes: IndexArray, n_strip_triangles: int, n_edges: int
) -> tuple[Attributes, dict[str, Any]]:
    """Return the attributes, and the columns of what is neither a point nor a face, by element."""
    corner, face = _find_corner_lists(rest.pop("face", {}), face_sizes)
    face = group_properties(face)
    elements = rest
    n_faces, n_corners = len(face_sizes), int(face_sizes.sum())
    if n_strip_triangles:
        corner = {name: _stack_rows(column, None, n_corners, 3 * n_strip_triangles) for name, column in corner.items()}
        face = {name: _stack_rows(column, None, n_faces, n_strip_triangles) for name, column in face.items()}
        n_faces, n_corners = n_faces + n_strip_triangles, n_corners + 3 * n_strip_triangles
    if n_edges:
        edge = group_properties(elements.pop("edge"))
        corner = {name: _stack_rows(column, None, n_corners, 2 * n_edges) for name, column in corner.items()}
        unlike = [name for name in edge if name in corner or not _are_alike(face.get(name), edge[name])]
        left = {name: edge.pop(name) for name in unlike}
        face = {name: _stack_rows(face.get(name), edge.get(name), n_faces, n_edges) for name in {**face, **edge}}
        if left:
            elements["edge"] = left
    else:
        elements.pop("edge", None)
    comments = [statement[1] for statement in header.statements if statement[0] == "comment"]
    textures = [text.removeprefix("TextureFile ") for text in comments if text.startswith("TextureFile ")]
    point = group_properties(elements.pop("vertex"))
    if not (point or corner or face or textures):
        return NO_ATTRIBUTES, elements
    return Attributes(point, corner, face, material={"texture": textures[0]} if textures else None), elements


def _find_corner_lists(face: dict[str, Any], sizes: IndexArray) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the lists of faces with one or more values per corner, and the other properties of faces."""
    corner: dict[str, Any] = {}
    n_corners = int(sizes.sum())
    for name, column in list(face.items()):
        if n_corners == 0 or not (isinstance(column, RaggedArray) or column.ndim == 2):
            continue
        lengths = np.diff(column.offsets) if isinstance(column, RaggedArray) else np.full(len(column), column.shape[1])
        width = int(lengths.sum()) // n_corners
        if width and (lengths == width * sizes).all():
            values = (column.values if isinstance(column, RaggedArray) else face[name]).ravel()
            corner[name] = values if width == 1 else values.reshape(-1, width)
            del face[name]
    return corner, face


def _are_alike(a: Any, b: Any) -> bool:
    """Return whether two columns can be stacked."""
    if a is None or isinstance(a, RaggedArray):
        return a is None or isinstance(b, RaggedArray)
    return isinstance(b, np.ndarray) and a.shape[1:] == b.shape[1:]


def _stack_rows(a: Any, b: Any, n_a: int, n_b: int) -> Any:
    """Return two columns as one; zeros, or empty rows, stand for a column that is None."""
    parts = []
    other = b if a is None else a
    for column, count in ((a, n_a), (b, n_b)):
        if column is not None:
            parts.append(column)
        elif isinstance(other, RaggedArray):
            parts.append(RaggedArray(other.values[:0], np.zeros(count + 1, np.int64)))
        else:
            parts.append(np.zeros((count, *other.shape[1:]), other.dtype))
    if not isinstance(other, RaggedArray):
        return np.concatenate(parts)
    offsets = np.concatenate([parts[0].offsets, parts[1].offsets[1:] + parts[0].offsets[-1]])
    return RaggedArray(np.concatenate([part.values for part in parts]), offsets)


def _get_corners(columns: dict[str, _Column], element: str) -> _Column:
    """Return the list of corners of an element."""
    corners = next((columns[name] for name in CORNER_LISTS if name in columns), None)
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


def _as_indices(values: Values, element: str) -> npt.NDArray[np.integer]:
    """Return values as integers, and as a copy in 32 bits if none is negative; raise MeshError for a fraction."""
    if values.dtype.kind == "f":
        wrong = ~(np.abs(values) < 2**53) | (values != np.floor(values))
        if wrong.any():
            raise MeshError(f"an index of an element {element} must be an integer, got {values.flat[np.argmax(wrong)]}")
        return values.astype(np.int64)
    return values.astype(np.int64 if values.min(initial=0) < 0 else np.uint32)
