import io
import warnings
from typing import Any

import numpy as np
import plyfile
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gpu_xform import chain, rotate_z, samples, scale, translate
from gpu_xform.errors import MeshError
from gpu_xform.formats import ply
from gpu_xform.geometry.mesh import Mesh
from tests.support.cost import within_cpu_s

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
    found = ply.read(by_plyfile(mesh, text=text, order=order, extra=extra))
    assert found.with_attributes(None) == mesh
    assert set(found.attributes.face) == ({"red", "uv"} if extra else set())


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
    found = ply.read(text.encode())
    assert found.with_attributes(None) == SQUARE
    if "red" in text:
        assert found.attributes.point["red"].tolist() == [9] * 4
        assert found.attributes.point["red"].dtype == np.uint8


def test_carriage_returns_before_a_body_that_begins_with_a_line_feed() -> None:
    mesh = Mesh(np.array([[10, 1, 2], [3, 4, 5]], np.int8).astype(np.float64))
    header = "ply\rformat binary_little_endian 1.0\relement vertex 2\r"
    header += "property char x\rproperty char y\rproperty char z\rend_header\r"
    body = bytes([10, 1, 2, 3, 4, 5])
    assert ply.read(header.encode() + body) == mesh
    for end in ("\n", "\r\n"):
        assert ply.read(header.replace("\r", end).encode() + body) == mesh


def test_elements_may_be_anywhere() -> None:
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
    assert ply.read(data).with_attributes(None) == mesh
    data = data.replace(b"element nothing 0\nproperty int a\n", b"")  # of which plyfile warns
    other = plyfile.PlyData.read(io.BytesIO(data))
    other.text, other.byte_order = False, "<"
    file = io.BytesIO()
    other.write(file)
    assert ply.read(file.getvalue()).with_attributes(None) == mesh


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
        ("property float x", "property list x", "line 6: not a statement of a PLY header: 'property list x'"),
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
    for _ in within_cpu_s(1.0):
        with pytest.raises(MeshError, match="face 0: the file ends within this row, of 1 declared"):
            ply.read(data)


def test_a_list_beyond_all_memory_before_another_ends_in_an_error() -> None:
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
        "property list float float first\nproperty list uchar float second\nend_header\n"
    )
    body = np.array([1, 2, 3, 1e30, 5], "<f4").tobytes()
    with pytest.raises(MeshError, match="vertex 0: the file ends within this row, of 1 declared"):
        ply.read(head.encode() + body)


@given(st.lists(st.lists(st.integers(0, 9), min_size=2, max_size=6), max_size=9), st.booleans())
def test_rows_of_any_length_read_as_plyfile_reads_them(polygons: list[list[int]], text: bool) -> None:
    mesh = Mesh(HOUSE.positions, polygons)
    found = ply.read(by_plyfile(mesh, text=text, order="<", extra=True))
    assert found.with_attributes(None) == mesh
    lengths = [i % 3 for i in range(len(polygons))]
    if not all(length == lengths[0] for length in lengths) and "uv" in found.attributes.face:
        assert [len(row) for row in found.attributes.face["uv"]] == lengths


TYPES = ["i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"]
N_POINTS = 5


@st.composite
def columns(draw: st.DrawFn, n_rows: int, names: str) -> dict[str, tuple[str, list[Any], bool]]:
    """Return properties by name: the type, the values, and whether it is a list."""
    found: dict[str, tuple[str, list[Any], bool]] = {}
    for name in draw(st.lists(st.sampled_from(names.split()), unique=True, max_size=6)):
        dtype = draw(st.sampled_from(TYPES))
        values = (
            st.floats(width=32 if dtype == "f4" else 64, allow_nan=False)
            if dtype[0] == "f"
            else st.integers(int(np.iinfo(dtype).min), int(np.iinfo(dtype).max))
        )
        is_list = draw(st.integers(0, 3)) == 0
        rows = st.lists(values, max_size=4) if is_list else values
        found[name] = dtype, draw(st.lists(rows, min_size=n_rows, max_size=n_rows)), is_list
    return found


def element(name: str, found: dict[str, tuple[str, list[Any], bool]], n_rows: int) -> plyfile.PlyElement:
    fields = [(key, "O" if is_list else dtype) for key, (dtype, _, is_list) in found.items()]
    table = np.empty(n_rows, fields)
    for key, (dtype, values, is_list) in found.items():
        for i, value in enumerate(values):
            table[key][i] = np.array(value, dtype) if is_list else value
    types = {key: dtype for key, (dtype, _, is_list) in found.items() if is_list}
    return plyfile.PlyElement.describe(table, name, val_types=types, len_types=dict.fromkeys(types, "u1"))


@st.composite
def files(draw: st.DrawFn) -> bytes:
    """Return a file with all that PLY may hold: elements in any order, of any properties, with comments."""
    coordinate = draw(st.sampled_from(["f4", "f8"]))
    floats = st.floats(-1e6, 1e6, width=32 if coordinate == "f4" else 64)
    xyz = {axis: (coordinate, draw(st.lists(floats, min_size=5, max_size=5)), False) for axis in "xyz"}
    names = "nx ny nz red green blue alpha s t u v intensity normal color label"
    vertex = {**draw(columns(N_POINTS, names)), **xyz}
    elements = [element("vertex", vertex, N_POINTS)]
    corner = st.integers(0, N_POINTS - 1)
    if draw(st.booleans()):
        n_faces = draw(st.integers(0, 4))
        polygons = draw(st.lists(st.lists(corner, min_size=2, max_size=5), min_size=n_faces, max_size=n_faces))
        face = {"vertex_indices": (draw(st.sampled_from(["i4", "u1", "u2"])), polygons, True)}
        face |= draw(columns(n_faces, "nx ny nz red green blue texcoord texnumber quality"))
        elements.append(element("face", face, n_faces))
    if draw(st.booleans()):
        n_edges = draw(st.integers(0, 3))
        ends = [draw(st.lists(corner, min_size=n_edges, max_size=n_edges)) for _ in range(2)]
        edge = {f"vertex{i + 1}": ("i4", ends[i], False) for i in range(2)}
        edge |= draw(columns(n_edges, "nx ny nz red green blue quality texcoord crease"))
        elements.append(element("edge", edge, n_edges))
    if draw(st.booleans()):
        n_rows = draw(st.integers(0, 2))
        elements.append(
            element("camera", {"f": ("f4", [1.5] * n_rows, False), **draw(columns(n_rows, "a b c"))}, n_rows)
        )
    lines = st.lists(st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=9), max_size=3)
    data = plyfile.PlyData(
        draw(st.permutations(elements)),
        text=draw(st.booleans()),
        byte_order="<",  # plyfile writes single values beside lists in little-endian whatever it is told
        comments=draw(lines),
        obj_info=draw(lines),
    )
    if data.text:
        data.byte_order = "="
    file = io.BytesIO()
    data.write(file)
    return file.getvalue()


def test_a_list_of_edges_is_no_pair_of_properties_of_faces() -> None:
    header = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    faces = b"element face 1\nproperty list uchar int vertex_indices\n"
    edges = b"element edge 1\nproperty int vertex1\nproperty int vertex2\nproperty list uchar char texcoord\n"
    data = header + faces + edges + b"end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n0 1 2 5 6\n"
    assert_same_by_plyfile(saved(ply.read(data)), data)


def saved(mesh: Mesh) -> bytes:
    file = io.BytesIO()
    ply.write(mesh, file)
    return file.getvalue()


def assert_same_by_plyfile(after: bytes, before: bytes) -> None:
    a, b = plyfile.PlyData.read(io.BytesIO(after)), plyfile.PlyData.read(io.BytesIO(before))
    assert (a.text, a.byte_order, a.comments, a.obj_info) == (b.text, b.byte_order, b.comments, b.obj_info)
    assert [str(held).split("\nproperty") for held in a.elements] == [
        str(held).split("\nproperty") for held in b.elements
    ]
    assert_same_values(a, b)


def assert_same_values(a: plyfile.PlyData, b: plyfile.PlyData) -> None:
    for held, expected in zip(a.elements, b.elements, strict=True):
        for field in expected.properties:
            for value, other in zip(held[field.name], expected[field.name], strict=True):
                assert np.array_equal(value, other), (expected.name, field.name)


LISTED_TEXCOORD = b"""ply
format ascii 1.0
element vertex 2
property float x
property float y
property float z
element edge 1
property int vertex1
property int vertex2
property list uchar char texcoord
end_header
0 0 0
1 1 1
0 1 2 3 4
"""


@pytest.mark.filterwarnings("ignore:loadtxt")  # plyfile reads empty lists
@example(LISTED_TEXCOORD)
@given(files())
def test_what_is_read_and_written_again_is_equal_as_plyfile_sees_it(data: bytes) -> None:
    mesh = ply.read(data)
    after = saved(mesh)
    assert_same_by_plyfile(after, data)
    again = ply.read(after)
    assert again == mesh
    assert saved(again) == after
    for encoding, order in (("ascii", "="), ("binary_little_endian", "<"), ("binary_big_endian", ">")):
        layout = {**mesh.metadata["ply"], "encoding": encoding}
        other = plyfile.PlyData.read(io.BytesIO(saved(mesh.with_attributes(mesh.attributes, metadata={"ply": layout}))))
        assert (other.text, other.byte_order) == (encoding == "ascii", order)
        assert_same_values(other, plyfile.PlyData.read(io.BytesIO(data)))


LISTED_TEXCOORD = b"""ply
format ascii 1.0
element vertex 2
property float x
property float y
property float z
element edge 1
property int vertex1
property int vertex2
property list uchar char texcoord
end_header
0 0 0
1 1 1
0 1 2 3 4
"""


@pytest.mark.filterwarnings("ignore:loadtxt")  # plyfile reads empty lists
@example(LISTED_TEXCOORD)
@given(files())
def test_every_attribute_is_what_plyfile_reads(data: bytes) -> None:
    mesh, other = ply.read(data), plyfile.PlyData.read(io.BytesIO(data))
    held = dict(mesh.attributes.point)
    for name, parts in (
        ("normal", "nx ny nz"),
        ("color", "red green blue alpha"),
        ("texcoord", "s t"),
        ("texcoord", "u v"),
    ):
        column = held.get(name)
        if isinstance(column, np.ndarray) and column.ndim == 2 and parts.split()[0] not in held:
            known = [part for part in parts.split() if part in other["vertex"].data.dtype.names]
            if len(known) == column.shape[1] and name not in other["vertex"].data.dtype.names:
                held |= dict(zip(known, column.T, strict=True))
    for name in set(other["vertex"].data.dtype.names) - {*"xyz"}:
        assert all(np.array_equal(a, b) for a, b in zip(held[name], other["vertex"][name], strict=True)), name


def test_a_moved_scan_keeps_all_but_positions_and_normals() -> None:
    dtype = [(name, "f4") for name in ("x", "y", "z", "nx", "ny", "nz", "intensity")] + [("red", "u1"), ("label", "i2")]
    table = np.array([(1, 2, 3, 0, 0.6, 0.8, 0.25, 200, -7), (4, 5, 6, 1, 0, 0, 0.5, 100, 9)], dtype)
    file = io.BytesIO()
    plyfile.PlyData([plyfile.PlyElement.describe(table, "vertex")], byte_order=">", comments=["a scan"]).write(file)
    moved = ply.read(file.getvalue()).transformed(chain(rotate_z(90, degrees=True), scale(2, 1, 1)))
    other = plyfile.PlyData.read(io.BytesIO(saved(moved)))
    assert (other.byte_order, other.comments) == (">", ["a scan"])
    assert other["vertex"].data.dtype == table.dtype.newbyteorder(">")
    for name in ("intensity", "red", "label"):
        assert np.array_equal(other["vertex"][name], table[name])
    assert np.allclose(other["vertex"]["x"], -2 * table["y"])
    normals = np.stack([other["vertex"][name] for name in ("nx", "ny", "nz")], axis=1)
    expected = np.array([(-0.3, 0, 0.8), (0, 1, 0)])
    assert np.allclose(normals, expected / np.linalg.norm(expected, axis=1, keepdims=True), atol=1e-6)


def test_whole_coordinates_that_move_to_fractions_become_double() -> None:
    text = HEADER.split("element face")[0].replace("float", "short") + "end_header\n" + "1 2 3\n" * 4
    mesh = ply.read(text.encode())
    assert b"property short x" in saved(mesh)
    assert b"property short x" in saved(mesh.transformed(translate(5, 0, 0)))
    halves = mesh.transformed(scale(0.5))
    assert b"property double x\nproperty short y" in saved(halves)
    assert ply.read(saved(halves)) == halves


def test_attributes_of_any_mesh_are_written() -> None:
    attributes = {
        "point": {"normal": np.eye(4, 3, dtype=np.float32), "flag": np.array([True, False] * 2), "id": np.arange(4)},
        "corner": {"texcoord": np.arange(14, dtype=np.float32).reshape(7, 2)},
        "face": {"color": np.arange(8, dtype=np.uint8).reshape(2, 4)},
    }
    mesh = Mesh(SQUARE.positions, SQUARE.faces[:2], attributes=attributes)
    other = plyfile.PlyData.read(io.BytesIO(saved(mesh)))
    assert other["vertex"].data.dtype.names == ("x", "y", "z", "nx", "ny", "nz", "flag", "id")
    assert [row.tolist() for row in other["face"]["texcoord"]] == [[*range(8)], [*range(8, 14)]]
    assert [other["face"][name][1] for name in ("red", "green", "blue", "alpha")] == [4, 5, 6, 7]
    again = ply.read(saved(mesh))
    assert np.array_equal(again.attributes.corner["texcoord"], mesh.attributes.corner["texcoord"])
    assert ply.list_losses(mesh) == []
    odd = {"point": {"name": list("abcd"), "big": [2**60] * 4}, "labels": {"part": ["a"]}, "material": {"a": 1}}
    assert ply.list_losses(mesh.with_attributes(odd)) == [
        "name per point",
        "big per point",
        "labels of part",
        "material (a)",
    ]


@pytest.mark.parametrize(
    "mesh", [SQUARE, HOUSE, Mesh(SQUARE.positions), SQUARE.with_attributes({"face": {"a": [1, 2, 3]}})]
)
@pytest.mark.parametrize("n", [1, 2, 20, 4096])
@pytest.mark.parametrize("byte", [b"\0", b"\n", b"a"])
def test_bytes_behind_a_binary_body_are_told(mesh: Mesh, n: int, byte: bytes) -> None:
    """But for what some programs end files with: a line break or a few blanks."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert ply.read(saved(mesh) + byte * n) == ply.read(saved(mesh))
    told = [f"{n:,} byte{'s' if n > 1 else ''} behind its last element, which are left out"]
    assert [str(each.message) for each in caught] == ([] if byte == b"\n" and n <= 2 else told)


@pytest.mark.parametrize("end", ["", "\n", "\r\n", " ", " \n\n", "\0", "\x1a"])
def test_blanks_behind_a_text_body_are_no_numbers(end: str) -> None:
    assert ply.read((TEXT.rstrip("\n") + end).encode()).with_attributes(None) == SQUARE


@pytest.mark.parametrize(
    ("rest", "message"),
    [("0 0 0\n", "3 numbers are left over after the last element"), ("end\n", "line 22: expected a number, got 'end'")],
)
def test_lines_behind_a_text_body_are_refused(rest: str, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        ply.read((TEXT + rest).encode())
