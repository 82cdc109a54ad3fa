"""The writer of PLY: a file that was read is written as it was, other meshes in binary with exact coordinates."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, IndexArray
from ..geometry.attributes import Columns, RaggedArray
from ..geometry.mesh import Mesh
from .ply_header import (
    CORNER_LISTS,
    LINE_END,
    MAX_HEADER_LINE_BYTES,
    NAMES_OF_TYPES,
    ORDERS,
    TYPES,
    Statement,
    list_new_names,
    split_attribute,
    split_attributes,
)

Values: TypeAlias = npt.NDArray[Any]

_PLAIN: tuple[Statement, ...] = (
    ("element", "vertex"),
    *(("property", "double", axis) for axis in "xyz"),
    ("element", "face"),
    ("property", "list", "uchar", "int", "vertex_indices"),
)
_PLAIN_EDGES: tuple[Statement, ...] = (
    ("element", "edge"),
    ("property", "int", "vertex1"),
    ("property", "int", "vertex2"),
)
_AXES = ("x", "y", "z")
_FACE_ELEMENTS = {"face": ("face", "edge"), "edge": ("edge", "face")}  # each, and the other
_OF_FACES = frozenset({*CORNER_LISTS, "vertex1", "vertex2"})
_MAX_TEXTURE_BYTES = MAX_HEADER_LINE_BYTES - 100
_BLANKS = {ord("\n"): " ", ord("\r"): " "}
_MAX_EXACT_IN_FLOAT = 2**53


@dataclass(frozen=True)
class _Cells:
    """The values of a property in all rows; for a list, one row after another with their lengths."""

    name: str
    values: Values
    sizes: IndexArray | None
    type: str
    count_type: str = ""

    @property
    def statement(self) -> str:
        """The line of the header."""
        types = self.type if self.sizes is None else f"list {self.count_type} {self.type}"
        return f"property {types} {self.name}\n"


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write points, polygons as faces, segments as edges, and attributes.

    A mesh that was read from PLY keeps the encoding, the comments, the other elements and the types of properties.
    """
    layout = mesh.metadata.get("ply", {})
    encoding = layout.get("encoding", "binary_little_endian")
    header = [f"ply\nformat {encoding} 1.0\n"]
    bodies: list[bytes] = []
    statements = _complete_statements(mesh, layout)
    for statement, properties in _split_elements(statements):
        if statement[0] != "element":
            header.append(_format_statement(statement))
            continue
        count, cells = _list_cells(mesh, layout, statement[1], properties)
        header.append(f"element {statement[1]} {count}\n")
        header.extend(
            cell.statement if isinstance(cell, _Cells) else _format_statement(cell)
            for cell in (cells if count else properties)
        )
        if count:
            columns = [cell for cell in cells if isinstance(cell, _Cells)]
            bodies.append(_format_rows(columns) if encoding == "ascii" else _pack_rows(columns, ORDERS[encoding]))
    file.write(("".join(header) + "end_header\n").encode("latin-1", "replace"))
    for body in bodies:
        file.write(body)


def _format_statement(statement: Statement) -> str:
    """Return a line of the header: a comment may have what ends lines in other files."""
    return " ".join(statement).translate(_BLANKS) + "\n"


def list_losses(mesh: Mesh) -> list[str]:
    """Return what of a mesh PLY cannot hold."""
    attributes, layout = mesh.attributes, mesh.metadata.get("ply", {})
    of_face = _split_faces(mesh, layout, "face")
    tables = (
        ("point", attributes.point, _split_points(mesh, layout)),
        ("corner", attributes.corner, _split_corners(mesh, layout, of_face)),
        ("face", attributes.face, _split_faces(mesh, layout, "edge") | of_face),
    )
    lost = [f"{name} per {what}" for what, table, held in tables for name in table if name not in held]
    sizes = np.diff(mesh.offsets)
    of_edges = np.repeat(_find_edges(sizes, layout), sizes)
    lost += [
        f"{name} per corner of segments" for name in tables[1][2] if _has_values(attributes.corner[name], of_edges)
    ]
    lost += [text for what, _, held in tables for text in list_new_names(held, what)]
    lost += [f"labels of {name}" for name in attributes.labels]
    is_written = _find_texture(mesh) is not None
    return lost + [f"material ({name})" for name in attributes.material if name != "texture" or not is_written]


def _split_points(mesh: Mesh, layout: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the properties of the element vertex that hold the attributes per point, by attribute."""
    return split_attributes(_keep_held(mesh.attributes.point), _list_properties(layout, "vertex"), _AXES)


def _split_faces(mesh: Mesh, layout: Mapping[str, Any], element: str) -> dict[str, dict[str, Any]]:
    """Return the properties of the element face or edge that hold its attributes per face, by attribute."""
    of_face, of_edge = _list_properties(layout, "face"), _list_properties(layout, "edge")
    known = {"face": of_face - {_find_corner_list(of_face)}, "edge": of_edge - {"vertex1", "vertex2"}}
    own, other = (known[name] - mesh.attributes.corner.keys() for name in _FACE_ELEMENTS[element])
    table = {
        name: column
        for name, column in _keep_held(mesh.attributes.face).items()
        # What the file has for the other element alone was filled up for this one.
        if own.issuperset(split_attribute(name, column, own))
        or not other.issuperset(split_attribute(name, column, other))
    }
    return split_attributes(table, own, _OF_FACES - own)


def _split_corners(
    mesh: Mesh, layout: Mapping[str, Any], of_face: Mapping[str, Mapping[str, Any]]
) -> dict[str, dict[str, Any]]:
    """Return the names of the lists of the element face that hold the attributes per corner, by attribute."""
    known = _list_properties(layout, "face")
    taken = _OF_FACES - known | {_find_corner_list(known)}
    names = [name for name, column in _keep_held(mesh.attributes.corner).items() if not isinstance(column, RaggedArray)]
    return split_attributes(dict.fromkeys(names), known, taken.union(*of_face.values()))


def _find_corner_list(names: Collection[str]) -> str:
    return next((name for name in CORNER_LISTS if name in names), CORNER_LISTS[0])


def _keep_held(table: Columns) -> dict[str, Any]:
    return {name: column for name, column in table.items() if _can_hold(column)}


def _find_texture(mesh: Mesh) -> str | None:
    """Return the name of the texture, if there is one that a line of the header takes."""
    texture = mesh.attributes.material.get("texture")
    if not isinstance(texture, str):
        return None
    line = texture.encode("latin-1", "replace")
    is_held = line.decode("latin-1") == texture and len(line) <= _MAX_TEXTURE_BYTES and not LINE_END.search(line)
    return texture if is_held else None


def _can_hold(column: Any) -> bool:
    """Return whether PLY has a type for a column."""
    if isinstance(column, RaggedArray):
        return _can_hold(column.values)
    if column.ndim > 2 or column.dtype.kind not in "biuf":
        return False
    return column.dtype.itemsize < 8 or column.dtype.kind == "f" or not (np.abs(column) > _MAX_EXACT_IN_FLOAT).any()


def _has_values(column: Any, chosen: BoolArray) -> bool:
    """Return whether chosen rows have other values than zeros, which are read for absent ones, and NaN."""
    return bool(chosen.any() and np.nan_to_num(column[chosen]).any())


def _complete_statements(mesh: Mesh, layout: Mapping[str, Any]) -> list[Statement]:
    """Return the statements of the header, with elements and a comment that the mesh needs and they lack."""
    statements = list(layout.get("header", _PLAIN))
    names = [statement[1] for statement in statements if statement[0] == "element"]
    if "vertex" not in names:
        statements += _PLAIN[:4]
    if "face" not in names and (mesh.n_faces or "ply" not in mesh.metadata) and not _are_edges(mesh, names):
        statements += _PLAIN[4:]
    if "ply" not in mesh.metadata and (np.diff(mesh.offsets) == 2).any():
        statements += _PLAIN_EDGES
    texture = _find_texture(mesh)
    if texture is not None and ("comment", f"TextureFile {texture}") not in statements:
        statements.insert(0, ("comment", f"TextureFile {texture}"))
    return statements


def _are_edges(mesh: Mesh, elements: Sequence[str]) -> bool:
    """Return whether all faces are segments that the element edge takes."""
    return "edge" in elements and bool((np.diff(mesh.offsets) == 2).all())


def _split_elements(statements: Sequence[Statement]) -> Iterator[tuple[Statement, list[Statement]]]:
    """Yield every statement but properties, and with an element the statements up to the next one."""
    starts = [i for i, statement in enumerate(statements) if statement[0] == "element"]
    for statement in statements[: starts[0]]:
        yield statement, []
    for start, end in zip(starts, [*starts[1:], len(statements)], strict=True):
        yield statements[start], list(statements[start + 1 : end])


def _list_cells(
    mesh: Mesh, layout: Mapping[str, Any], element: str, statements: list[Statement]
) -> tuple[int, list[_Cells | Statement]]:
    """Return the number of rows of an element, its properties, and the comments among them, in order."""
    names = {statement[-1] for statement in statements if statement[0] == "property"}
    if element == "vertex":
        count, columns = mesh.n_points, _list_point_columns(mesh, layout)
    elif element in ("face", "edge"):
        count, columns = _list_face_columns(mesh, layout, element, names)
    else:
        columns = dict(layout["elements"].get(element, {}))
        count = len(next(iter(columns.values()))) if columns else 0
    cells: list[_Cells | Statement] = []
    for statement in statements:
        if statement[0] != "property":
            cells.append(statement)
        elif statement[-1] in columns:
            cells.append(_make_cells(statement[-1], columns.pop(statement[-1]), statement[1:-1]))
    return count, cells + [_make_cells(name, column, ()) for name, column in columns.items()]


def _list_point_columns(mesh: Mesh, layout: Mapping[str, Any]) -> dict[str, Any]:
    """Return the properties of the element vertex."""
    columns: dict[str, Any] = dict(zip(_AXES, mesh.positions.T, strict=True))
    for parts in _split_points(mesh, layout).values():
        columns |= parts
    return columns


def _list_face_columns(
    mesh: Mesh, layout: Mapping[str, Any], element: str, names: set[str]
) -> tuple[int, dict[str, Any]]:
    """Return the number of rows and the properties of the element face or edge."""
    sizes = np.diff(mesh.offsets)
    is_edge = _find_edges(sizes, layout)
    chosen = is_edge if element == "edge" else ~is_edge
    of_chosen = slice(None) if chosen.all() else np.repeat(chosen, sizes)
    corners = mesh.indices[of_chosen]
    columns: dict[str, Any] = {}
    if element == "edge":
        columns |= {"vertex1": corners[::2], "vertex2": corners[1::2]}
        held = layout.get("elements", {}).get("edge", {})
        columns |= {name: column for name, column in held.items() if len(column) == chosen.sum()}
    else:
        columns[_find_corner_list(names)] = corners, sizes[chosen]
    of_face = _split_faces(mesh, layout, element)
    for parts in of_face.values():
        for part, values in parts.items():
            columns.setdefault(part, _select_rows(values, chosen))
    if element == "face":
        for name, parts in _split_corners(mesh, layout, of_face).items():
            column = mesh.attributes.corner[name]
            width = column.shape[1] if column.ndim == 2 else 1
            columns |= dict.fromkeys(parts, (column[of_chosen].ravel(), sizes[chosen] * width))
    return int(chosen.sum()), columns


def _find_edges(sizes: IndexArray, layout: Mapping[str, Any]) -> BoolArray:
    """Return which faces belong to the element edge: those that did in the file, else the segments."""
    is_edge: BoolArray = sizes == 2
    if layout and ("element", "edge") not in layout["header"]:
        is_edge = np.zeros(len(sizes), bool)
    elif layout and len(sizes) == layout["n_faces"] + layout["n_edges"] and is_edge[layout["n_faces"] :].all():
        is_edge[: layout["n_faces"]] = False
    return is_edge


def _list_properties(layout: Mapping[str, Any], element: str) -> set[str]:
    """Return the names of the properties that the file has for an element."""
    found: set[str] = set()
    current = ""
    for statement in layout.get("header", ()):
        if statement[0] == "element":
            current = statement[1]
        elif statement[0] == "property" and current == element:
            found.add(statement[-1])
    return found


def _select_rows(column: Any, chosen: BoolArray) -> Any:
    if not isinstance(column, RaggedArray):
        return column[chosen]
    sizes = np.diff(column.offsets)
    return column.values[np.repeat(chosen, sizes)], sizes[chosen]


def _make_cells(name: str, column: Any, types: Statement) -> _Cells:
    """Return a property with the types that its statement says, if its values fit."""
    if isinstance(column, RaggedArray):
        column = column.values, np.diff(column.offsets)
    elif not isinstance(column, tuple) and column.ndim == 2:
        column = column.ravel(), np.full(len(column), column.shape[1])
    values, sizes = column if isinstance(column, tuple) else (column, None)
    if values.dtype == bool:
        values = values.astype(np.uint8)
    declared = types[-1] if types else ""
    kind = declared if declared and _fits(values, TYPES[declared]) else _choose_type(values)
    if sizes is None:
        return _Cells(name, values, None, kind)
    counted = types[1] if len(types) == 3 else "uchar"
    return _Cells(name, values, sizes, kind, counted if _fits(sizes, TYPES[counted]) else "uint")


def _fits(values: Values, dtype: str) -> bool:
    """Return whether values keep their meaning in a type: float64 may be rounded to float32, nothing else changes."""
    target = np.dtype(dtype)
    if values.dtype == target or values.size == 0:
        return True
    if target.kind != "f" and values.dtype.kind in "iu":
        limits = np.iinfo(target)
        return bool(limits.min <= values.min() and values.max() <= limits.max)
    with np.errstate(over="ignore", invalid="ignore"):
        cast = values.astype(target)
    if target.kind == "f" and values.dtype.kind == "f":
        return bool(np.array_equal(np.isfinite(cast), np.isfinite(values)))
    if not np.isfinite(values).all() or (values.dtype.kind == "f" and np.abs(values).max() >= 2.0**63):
        return False
    return bool((cast.astype(values.dtype) == values).all())


def _choose_type(values: Values) -> str:
    """Return the name of a type that holds values without loss."""
    own = f"{values.dtype.kind}{values.dtype.itemsize}"
    if own in NAMES_OF_TYPES:
        return NAMES_OF_TYPES[own]
    if own == "f2":
        return "float"
    return next(
        (name for name in ("int", "uint") if values.dtype.kind in "iu" and _fits(values, TYPES[name])), "double"
    )


def _pack_rows(cells: list[_Cells], order: str) -> bytes:
    """Return the rows of an element in binary."""
    n_rows = len(cells[0].values if cells[0].sizes is None else cells[0].sizes)
    if all(cell.sizes is None or (cell.sizes == cell.sizes[0]).all() for cell in cells):
        return _pack_equal_rows(cells, order, n_rows)
    parts: list[tuple[IndexArray, IndexArray, Values]] = []  # bytes before it in its row, bytes in each row, values
    length = np.zeros(n_rows, np.int64)
    for cell in cells:
        values = cell.values.astype(order + TYPES[cell.type])
        if cell.sizes is not None:
            counts = cell.sizes.astype(order + TYPES[cell.count_type])
            parts.append((length.copy(), np.full(n_rows, counts.itemsize), counts))
            length += counts.itemsize
        n_bytes = (1 if cell.sizes is None else cell.sizes) * np.full(n_rows, values.itemsize)
        parts.append((length.copy(), n_bytes, values))
        length += n_bytes
    ends = np.cumsum(length)
    packed = np.empty(int(ends[-1]), np.uint8)
    for before, n_bytes, values in parts:
        starts = ends - length + before
        runs = np.cumsum(n_bytes)
        places = np.repeat(starts - (runs - n_bytes), n_bytes) + np.arange(runs[-1])
        packed[places] = values.view(np.uint8)
    return packed.tobytes()


def _pack_equal_rows(cells: list[_Cells], order: str, n_rows: int) -> bytes:
    """Return the rows of an element whose lists all have the same length, in binary."""
    fields: list[Any] = []
    for i, cell in enumerate(cells):
        if cell.sizes is not None:
            fields.append((f"n{i}", order + TYPES[cell.count_type]))
        fields.append((f"v{i}", order + TYPES[cell.type], () if cell.sizes is None else (int(cell.sizes[0]),)))
    table = np.empty(n_rows, np.dtype(fields))
    for i, cell in enumerate(cells):
        if cell.sizes is not None:
            table[f"n{i}"] = cell.sizes
        table[f"v{i}"] = cell.values.reshape(table[f"v{i}"].shape)
    return table.tobytes()


def _format_rows(cells: list[_Cells]) -> bytes:
    """Return the rows of an element in ASCII, with the shortest decimals that give the same numbers back."""
    columns: list[list[str]] = []
    for cell in cells:
        texts = _format_values(cell)
        if cell.sizes is not None:
            ends = np.cumsum(cell.sizes).tolist()
            texts = [
                " ".join([str(size), *texts[end - size : end]])
                for size, end in zip(cell.sizes.tolist(), ends, strict=True)
            ]
        columns.append(texts)
    return "".join([" ".join(row) + "\n" for row in zip(*columns, strict=True)]).encode()


def _format_values(cell: _Cells) -> list[str]:
    if TYPES[cell.type][0] != "f":
        return list(map(str, cell.values.astype(np.int64).tolist()))
    if cell.values.dtype.itemsize <= 4:  # its own shortest decimals, which are fewer than those of float64
        return [str(value) for value in cell.values]
    return list(map(repr, cell.values.astype(np.float64).tolist()))
