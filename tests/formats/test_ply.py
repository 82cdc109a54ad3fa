import io
import time
from typing import Any

import numpy as np
import plyfile
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.errors import MeshError
from gpu_xform.formats import ply
from gpu_xform.geometry.mesh import Mesh

SQUARE = Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)], [(0, 1, 2, 3), (0, 1, 2), (1, 3)])
HEADER = """ply
format ascii 1.0
comment made by hand
obj_info 1
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
element edge 1
property int vertex1
property int vertex2
end_header
"""
TEXT = HEADER + "0 0 0\n1 0 0\n1 1 .5\n0 1 0\n4 0 1 2 3\n3 0 1 2\n1 3\n"
HOUSE = samples.house()


def by_plyfile(mesh: Mesh, *, text: bool, order: str, index: str = "i4", extra: bool = False) -> bytes:
    """Return a mesh as plyfile writes it, with elements and properties that a reader must pass over if `extra`."""
    dtype: list[Any] = [("x", "f8"), ("y", "f8"), ("z", "f8")]
    points = np.array([tuple(point) for point in mesh.positions.tolist()], dtype)
    faces = np.empty(mesh.n_faces, [("vertex_index", "O")] + ([("red", "u1"), ("uv", "O")] if extra else []))
    faces["vertex_index"] = [face.astype(index) for face in mesh.faces]
    elements = [plyfile.PlyElement.describe(points, "vertex")]
    types, counts = {"vertex_index": index}, {"vertex_index": "u2"}
    if extra:
        faces["red"] = 7
        faces["uv"] = [np.arange(i % 3, dtype="f4") for i in range(mesh.n_faces)]
        elements.append(plyfile.PlyElement.describe(np.array([(1.5, 2)], [("a", "f4"), ("b", "i2")]), "other"))
        types["uv"], counts["uv"] = "f4", "u1"
    elements.append(plyfile.PlyElement.describe(faces, "face", val_types=types, len_types=counts))
    file = io.BytesIO()
    plyfile.PlyData(elements, text=text, byte_order=order).write(file)
    return file.getvalue()


@pytest.mark.parametrize(("text", "order"), [(True, "="), (False, "<"), (False, ">")])
@pytest.mark.parametrize("extra", [False, True])
@pytest.mark.parametrize("mesh", [HOUSE, samples.cube(), samples.icosphere(1)])
def test_what_plyfile_writes(mesh: Mesh, text: bool, order: str, extra: bool) -> None:
    assert ply.read(by_plyfile(mesh, text=text, order=order, extra=extra)) == mesh


@pytest.mark.parametrize("index", ["i1", "u1", "i2", "u2", "u4"])
def test_types_of_an_index(index: str) -> None:
    assert ply.read(by_plyfile(HOUSE, text=False, order=">", index=index)) == HOUSE


def test_what_is_written_is_what_plyfile_reads() -> None:
    file = io.BytesIO()
    ply.write(SQUARE, file)
    assert ply.read(file.getvalue()) == SQUARE
    file.seek(0)
    other = plyfile.PlyData.read(file)
    assert [other["vertex"][axis].tolist() for axis in "xyz"] == SQUARE.positions.T.tolist()
    assert [face.tolist() for face in other["face"]["vertex_indices"]] == [[0, 1, 2, 3], [0, 1, 2]]
    assert other["edge"].data.tolist() == [(1, 3)]


def test_a_polygon_of_many_corners() -> None:
    angle = np.arange(300) / 300 * 2 * np.pi
    mesh = Mesh(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), [range(300), (0, 1, 2)])
    file = io.BytesIO()
    ply.write(mesh, file)
    assert ply.read(file.getvalue()) == mesh


@pytest.mark.parametrize(
    "text",
    [
        TEXT,
        TEXT.replace("\n", "\r\n"),
        TEXT.replace("\n", "\r"),
        TEXT.replace("vertex_indices", "vertex_index"),
        TEXT.replace("float", "float64").replace("uchar", "uint8").replace("int ", "int32 "),
        TEXT.replace("property float z\n", "property float z\nproperty uchar red\n").replace(
            "0\n1 0 0\n1 1 .5\n0 1 0\n4", "0 9\n1 0 0 9\n1 1 .5 9\n0 1 0 9\n4"
        ),
    ],
)
def test_variants_of_a_square(text: str) -> None:
    assert ply.read(text.encode()) == SQUARE


def test_carriage_returns_before_a_body_that_begins_with_a_line_feed() -> None:
    mesh = Mesh(np.array([[10, 1, 2], [3, 4, 5]], np.int8).astype(np.float64))
    header = "ply\rformat binary_little_endian 1.0\relement vertex 2\r"
    header += "property char x\rproperty char y\rproperty char z\rend_header\r"
    body = bytes([10, 1, 2, 3, 4, 5])
    assert ply.read(header.encode() + body) == mesh
    for end in ("\n", "\r\n"):
        assert ply.read(header.replace("\r", end).encode() + body) == mesh


def test_elements_anywhere_are_passed_over() -> None:
    header = """ply
format {} 1.0
element camera 2
property list uchar double pose
property short id
element vertex 3
property float x
property list uint char tags
property float y
property float z
element nothing 0
property int a
element face 1
property list uchar uint vertex_index
element range_grid 2
property list uchar int vertex_indices
end_header
"""
    mesh = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    text = "2 .5 .5 7\n1 1 8\n0 1 9 0 0\n1 2 9 9 0 0\n0 1 9 1 0\n3 0 1 2\n1 5\n2 0 1\n"
    data = (header.format("ascii") + text).encode()
    assert ply.read(data) == mesh
    data = data.replace(b"element nothing 0\nproperty int a\n", b"")  # of which plyfile warns
    other = plyfile.PlyData.read(io.BytesIO(data))
    other.text, other.byte_order = False, "<"
    file = io.BytesIO()
    other.write(file)
    assert ply.read(file.getvalue()) == mesh


@pytest.mark.parametrize(
    ("lists", "expected"),
    [
        ([[0, 1, 2, 3, 4]], [[0, 1, 2], [2, 1, 3], [2, 3, 4]]),
        ([[0, 1, 2, -1, 1, 2, 3, 4, -1]], [[0, 1, 2], [1, 2, 3], [3, 2, 4]]),
        ([[0, 1, 2], [1, 2, 3, 4], [0, 1], []], [[0, 1, 2], [1, 2, 3], [3, 2, 4]]),
        ([[0, 1, 2, 2, 3, 4]], [[0, 1, 2], [3, 2, 4]]),  # a corner given twice turns the strip
        ([[-1, -1, 3, 2, 1]], [[3, 2, 1]]),
    ],
)
def test_triangle_strips(lists: list[list[int]], expected: list[list[int]]) -> None:
    header = HEADER.replace("element face 2", f"element tristrips {len(lists)}").split("element edge")[0]
    body = "0 0 0\n1 0 0\n1 1 .5\n0 1 0\n2 2 2\n" + "".join(f"{len(row)} {' '.join(map(str, row))}\n" for row in lists)
    mesh = ply.read((header.replace("vertex 4", "vertex 5") + "end_header\n" + body).encode())
    assert [face.tolist() for face in mesh.faces] == expected


def test_a_point_cloud() -> None:
    header = HEADER.split("element face")[0]
    assert ply.read((header + "end_header\n0 0 0 1 0 0 1 1 .5 0 1 0").encode()) == Mesh(SQUARE.positions)
    assert ply.read(
        (TEXT.replace("face 2", "face 0").replace("edge 1", "edge 0")[: -len("4 0 1 2 3\n3 0 1 2\n1 3\n")]).encode()
    ) == Mesh(SQUARE.positions)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ply\n", "plx\n", "line 1: expected 'ply', got 'plx'"),
        ("ascii", "utf8", "line 2: not a statement of a PLY header: 'format utf8 1.0'"),
        ("1.0", "2.0", "line 2: not a statement"),
        ("element vertex 4", "element vertex -4", "line 5: not a statement"),
        ("element vertex 4", "element vertex four", "line 5: not a statement"),
        ("element vertex 4", "element vertex 4000000000", "declares 4000000000 rows of vertex, more than the rest"),
        ("element face 2", "element face 900000000000000000", "declares 900000000000000000 rows of face, more than"),
        ("element face 2", "element vertex 2", "line 9: a second element vertex"),
        ("float y", "float x", "line 7: a second property x of vertex"),
        ("float y", "half y", "line 7: not a statement"),
        ("end_header", "end_headed", "line 14: not a statement"),
        ("float z", "float w", "the element vertex has no property z of one value"),
        ("vertex 4", "vertices 4", "the header declares no element vertex"),
        ("vertex_indices", "corners", "the element face has no list vertex_indices or vertex_index"),
        ("element edge", "element tristrips", "the element tristrips has no list vertex_indices or vertex_index"),
        ("1 1 .5", "1 1 1.#INF", "vertex 2: coordinates must be finite, got [1.0, 1.0, inf]"),
        ("vertex2", "b", "the element edge has no property vertex2"),
        ("1 1 .5", "1 1 x", "line 17: expected a number, got 'x'"),
        ("1 1 .5", "1 1 nan", "vertex 2: coordinates must be finite, got [1.0, 1.0, nan]"),
        ("3 0 1 2\n", "3 0 1 4\n", "face 1 names point 4, outside 0..3"),
        ("3 0 1 2\n", "3 0 1 -1\n", "face 1 names point -1"),
        ("3 0 1 2\n", "3 0 1 2.5\n", "an index of an element face must be an integer, got 2.5"),
        ("3 0 1 2\n", "3 0 1 nan\n", "an index of an element face must be an integer, got nan"),
        ("3 0 1 2\n", "-3 0 1 2\n", "face 1: a list cannot have -3.0 values"),
        ("3 0 1 2\n", "2.5 0 1 2\n", "face 1: a list cannot have 2.5 values"),
        ("3 0 1 2\n", "nan 0 1 2\n", "face 1: a list cannot have nan values"),
        ("3 0 1 2\n", "inf 0 1 2\n", "face 1: a list cannot have inf values"),
        ("3 0 1 2\n", "1e300 0 1 2\n", "face 1: the file ends within this row, of 2 declared"),
        ("3 0 1 2\n", "9 0 1 2\n", "face 1: the file ends within this row, of 2 declared"),
        ("4 0 1 2 3\n", "nan 0 1 2 3\n", "face 0: a list cannot have nan values"),
        ("3 0 1 2\n", "1 0\n", "face 1 has 1 corners"),
        ("1 3\n", "1 3 0\n", "1 numbers are left over after the last element"),
        ("1 3\n", "1\n", "edge 0: the file ends within this row"),
        ("element edge 1\nproperty int vertex1\nproperty int vertex2", "element edge 9", "edge has no properties"),
    ],
)
def test_errors_say_where(old: str, new: str, message: str) -> None:
    assert old in TEXT
    with pytest.raises(MeshError) as caught:
        ply.read((new.join(TEXT.rsplit(old, 1))).encode())
    assert message in str(caught.value)


def test_a_header_without_end() -> None:
    for text in ("ply\nformat ascii 1.0\n", "ply\nformat ascii 1.0\n" + "comment x" * 10_000, "ply"):
        with pytest.raises(MeshError, match=r"line [13]: expected a header that ends with end_header"):
            ply.read(text.encode())


def test_a_binary_list_longer_than_the_file_allocates_nothing() -> None:
    header = (
        HEADER.replace("ascii", "binary_little_endian").replace("uchar int", "uint int").replace("face 2", "face 1")
    )
    data = header.replace("vertex 4", "vertex 0").encode() + b"\xff\xff\xff\xff" + b"\0" * 40
    start = time.perf_counter()
    with pytest.raises(MeshError, match="face 0: the file ends within this row, of 1 declared"):
        ply.read(data)
    assert time.perf_counter() - start < 1.0


@given(st.lists(st.lists(st.integers(0, 9), min_size=2, max_size=6), max_size=9), st.booleans())
def test_rows_of_any_length_read_as_plyfile_reads_them(polygons: list[list[int]], text: bool) -> None:
    mesh = Mesh(HOUSE.positions, polygons)
    assert ply.read(by_plyfile(mesh, text=text, order="<", extra=True)) == mesh
