import io
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import example, given
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import off, save_mesh
from gpu_xform.geometry.attributes import RaggedArray
from gpu_xform.geometry.mesh import Mesh

SQUARE = Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)], [(0, 1, 2, 3), (0, 1, 2)])
PLAIN = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 .5\n0 1 0\n4 0 1 2 3\n3 0 1 2\n"


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        PLAIN.rstrip(),
        PLAIN.replace("OFF\n", "OFF "),
        PLAIN.replace("4 2 0", "4 2"),
        PLAIN.replace("OFF\n", "# first\n\nOFF # of a square\n# counts\n"),
        PLAIN.replace("\n", "  # x\n"),
        PLAIN.replace("\n", "\n\n \t\n"),
        PLAIN.replace("\n", "\r\n"),
        PLAIN.replace("\n", "\r"),
        "\ufeff" + PLAIN,
        PLAIN + "\x1a",
        PLAIN + "\r\n\0\0",
        PLAIN.replace("OFF\n", "OFF"),
        PLAIN.replace("OFF\n", "OFF").replace("4 2 0", "4 2"),
        PLAIN.replace("OFF", "nOFF 3"),
        PLAIN.replace("OFF", "nOFF\n3"),
        PLAIN.replace("OFF\n4", "nOFF3 4"),
        "4OFF\n4 2 0\n0 0 0 1\n2 0 0 2\n1 1 .5 1\n0 -1 0 -1\n4 0 1 2 3\n3 0 1 2\n",
        "4nOFF 3\n4 2 0\n0 0 0 1 # x\n2 0 0 2\n1 1 .5 1\n\v0 -1 0 -1\n4 0 1 2 3\n3 0 1 2\n",
        "C4OFF\n4 2 0\n0 0 0 1 9 9 9 1\n2 0 0 2 9 9 9 1\n1 1 .5 1 9 9 9 1\n0 2 0 2 9 9 9 1\n4 0 1 2 3\n3 0 1 2\n",
        PLAIN.replace("3 0 1 2\n", "3 0 1 2 255 0 0\n"),
        PLAIN.replace("3 0 1 2\n", "3 0 1 2 0.5 .25 1e-1 1\n").replace("4 0 1 2 3\n", "4 0 1 2 3 7\n"),
        PLAIN.replace("OFF", "COFF").replace("0 0\n", "0 0 255 0 0 255\n", 1).replace("1 0 0\n", "1 0 0 1 2 3 4\n"),
        "NOFF\n4 2 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 .5 0 0 1\n0 1 0 0 0 1\n4 0 1 2 3\n3 0 1 2\n",
        "STCNOFF\n4 2 0\n0 0 0 0 0 1 9 9\n1 0 0 0 0 1 9 9\n1 1 .5 0 0 1 9 9\n0 1 0 0 0 1 9 9\n4 0 1 2 3\n3 0 1 2\n",
    ],
)
def test_variants_of_a_square(text: str) -> None:
    assert off.read(text.encode()).with_attributes(None) == SQUARE


def test_other_encodings() -> None:
    assert off.read(PLAIN.encode("utf-16")) == SQUARE
    assert off.read(PLAIN.encode("utf-16-be").join([b"\xfe\xff", b""])) == SQUARE


def test_fewer_dimensions() -> None:
    assert off.read(b"nOFF 2\n3 1\n0 0\n1 2\n3 4\n3 0 1 2\n") == Mesh([(0, 0, 0), (1, 2, 0), (3, 4, 0)], [(0, 1, 2)])
    assert off.read(b"4nOFF 1\n2 0 0\n1 2\n6 3\n") == Mesh([(0.5, 0, 0), (2, 0, 0)])


@pytest.mark.parametrize("order", [">", "<"])
@pytest.mark.parametrize("flags", ["", "C", "N", "ST", "STCN", "4", "n", "STCN4n"])
def test_binary_files(order: str, flags: str) -> None:
    points = SQUARE.positions * 2 if "4" in flags else SQUARE.positions
    columns = [points]
    columns += [np.full((4, 1), 2.0)] if "4" in flags else []
    columns += [np.full((4, n), 9.0) for flag, n in (("N", 3), ("C", 4), ("ST", 2)) if flag in flags]
    data = f"{flags}OFF BINARY\n".encode() + np.array([*([3] if "n" in flags else []), 4, 2, 5], f"{order}i4").tobytes()
    data += np.hstack(columns).astype(f"{order}f4").tobytes()
    data += np.array([4, 0, 1, 2, 3, 0, 3, 0, 1, 2, 3], f"{order}i4").tobytes() + np.ones(3, f"{order}f4").tobytes()
    mesh = off.read(data)
    assert mesh.with_attributes(None) == SQUARE
    if "4" in flags:
        with pytest.warns(MeshWarning, match="left out: the fourth coordinate of each vertex$"):
            save_mesh(mesh, io.BytesIO(), file_type="off")
    elif "n" not in flags:  # but for the number of edges
        assert saved(mesh) == data.replace(np.array(5, f"{order}i4").tobytes(), bytes(4))
    for end in range(len(data)):
        with pytest.raises(MeshError):
            off.read(data[:end])


def test_point_clouds_and_segments() -> None:
    assert off.read(b"OFF 1 0 0\n1 2 3") == Mesh([(1, 2, 3)])
    assert off.read(b"OFF 2 1 0\n1 2 3\n4 5 6\n2 0 1").faces == pytest.approx(np.array([[0, 1]]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("4 2 0\n", "line 1: expected OFF, COFF, NOFF, STOFF or the like, got '4 2 0'"),
        ("# nothing\n", "line 1: expected OFF"),
        (PLAIN.replace("OFF", "OFFICE"), "line 1: expected OFF"),
        (PLAIN.replace("OFF", "4OFF"), "line 3: a vertex needs 4 numbers, got 3"),
        (
            PLAIN.replace("OFF", "4OFF").replace("0 0 0\n", "0 0 0 0\n"),
            "line 3: a number must be finite, got '0 0 0 0'",
        ),
        (PLAIN.replace("OFF", "nOFF 4"), "line 1: a mesh has up to 3 dimensions, this nOFF has 4"),
        (PLAIN.replace("OFF", "nOFF\n0"), "line 2: a mesh has up to 3 dimensions, this nOFF has 0"),
        (PLAIN.replace("OFF", "nOFF\nx"), "line 2: expected an integer, got 'x'"),
        ("OFF BINARY\n\x00", "the binary header declares more vertices and faces than the file can hold"),
        ("OFF BINARY\n" + "\0\0\0\1" * 5, "declares 1 vertices of 3 numbers, more than the file can hold"),
        ("OFF BINARY\n" + "\0\0\0\1" * 6 + "\0\0\0\2\0\0\0\0", "face 0: 2 corners, at least 2, do not fit the file"),
        (PLAIN.replace("1 1 .5", "1 1 -1.#IND"), "line 5: a number must be finite, got '1 1 -nan'"),
        (PLAIN.replace("4 2 0", "-4 2 0"), "line 2: expected the numbers of vertices, faces and edges, got '-4 2 0'"),
        (PLAIN.replace("4 2 0", "4 -2 0"), "line 2: expected the numbers"),
        (PLAIN.replace("4 2 0", "4 x 0"), "line 2: expected the numbers"),
        ("OFF\n", "line 1: expected the numbers"),
        (PLAIN.replace("4 2 0", "9" * 30 + " 2 0"), "line 2: a count of '999999999999999999999999999999' is out of"),
        (PLAIN.replace("4 2 0", "4000000000 2 0"), "declares 4000000000 vertices and 2 faces, 6 lines follow"),
        (PLAIN.replace("3 0 1 2\n", "# 3 0 1 2\n"), "declares 4 vertices and 2 faces, 5 rows follow"),
        (PLAIN.replace("4 2 0", "4 1 0"), "line 8: expected the end of the file, got '3 0 1 2'"),
        (PLAIN.replace("4 2 0", "3 2 0"), "line 6: a face of 0 corners"),
        (PLAIN.replace("1 1 .5", "1 1"), "line 5: a vertex needs 3 numbers, got 2"),
        (PLAIN.replace("1 1 .5", "1 1 1_0"), "line 5: expected a number, got '1_0'"),
        (PLAIN.replace("1 1 .5", "1 1 nan"), "line 5: a number must be finite, got '1 1 nan'"),
        (PLAIN.replace("1 1 .5", "1 1 1e999"), "line 5: a number must be finite"),
        (PLAIN.replace("3 0 1 2", "3 0 1 4"), "line 8: index 4 is out of range, there are 4 vertices"),
        (PLAIN.replace("3 0 1 2", "3 0 1 -1"), "line 8: index -1 is out of range"),
        (PLAIN.replace("3 0 1 2", "3 0 1 2.0"), "line 8: expected an integer, got '2.0'"),
        (PLAIN.replace("3 0 1 2", "3 0 1"), "line 8: a face of 3 corners, at least 2, needs as many indices, got 2"),
        (PLAIN.replace("3 0 1 2", "1 0"), "line 8: a face of 1 corners"),
        (PLAIN.replace("3 0 1 2", "-3 0 1 2"), "line 8: a face of -3 corners"),
        (PLAIN.replace("3 0 1 2", "3 0 1 2 red"), "line 8: expected a number, got 'red'"),
        (PLAIN.replace("3 0 1 2", "9" * 30 + " 0 1 2"), "line 8: a face of 9223372036854775807 corners"),
    ],
)
def test_errors_name_the_line(text: str, message: str) -> None:
    with pytest.raises(MeshError) as caught:
        off.read(text.encode())
    assert message in str(caught.value)


def both(data: bytes) -> tuple[Any, Any]:
    """What the bulk path (None where it declines) and the careful path make of a file."""
    try:
        rows = off._split_rows(data)
        layout, n_points, n_faces, end = off._parse_header(rows)
    except MeshError:
        return None, None
    try:
        bulk: Any = off._read_regular(data[end:], layout, n_points, n_faces)
    except ValueError:
        bulk = None
    try:
        careful: Any = off._read_rows(rows, layout, n_points, n_faces)
    except MeshError as error:
        careful = str(error)
    return bulk, careful


words = st.sampled_from(
    ["0", "1", "2", "3", "-1", "nan", "1e1", ".5", "#", "x", "1_0", "\n", "\n", "\n", "\n3 0 1 2", "\n0 0 1"]
)


@given(st.integers(0, 4), st.integers(0, 3), st.lists(st.tuples(words, st.sampled_from([" ", " ", "", "\t", "\v"]))))
@example(3, 1, [("\n0 0 1\n0 0 1\n0 0 1\n3 0 1 2", "x")])
@example(1, 1, [("\n0 0 1\n2 0 0", "\v")])
@example(1, 1, [("\n-3 0 0 0\n", "")])
def test_both_paths_accept_the_same_language(n_points: int, n_faces: int, parts: list[tuple[str, str]]) -> None:
    text = f"OFF {n_points} {n_faces}" + "\n0 0 1" * n_points + "".join(map("".join, parts)) + "\n"
    bulk, careful = both(text.encode())
    if bulk is not None:
        assert bulk == careful


def test_a_nan_behind_a_vertex_is_not_taken_for_the_end_of_its_line() -> None:
    bulk, careful = both(b"OFF 2 0 0\n0 0 1 0 0 0 0 nan 5 5 5\n0 0 2\n")
    assert bulk is None
    assert careful.positions.tolist() == [[0, 0, 1], [0, 0, 2]]
    assert [len(row) for row in careful.attributes.point["more"]] == [8, 0]


def test_a_file_that_was_written_takes_the_bulk_path() -> None:
    file = io.BytesIO()
    mesh = samples.snub_dodecahedron()
    off.write(mesh, file)
    bulk, careful = both(file.getvalue())
    assert bulk == careful == mesh
    colored = b"OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 .5\n0 1 0\n4 0 1 2 3 255 0 0\n3 0 1 2 0 0 255\n"
    bulk, careful = both(colored)
    assert (
        bulk == careful == SQUARE.with_attributes({"face": {"color": np.array([(255, 0, 0), (0, 0, 255)], np.uint8)}})
    )


def test_triangles_are_those_of_trimesh() -> None:
    file = io.BytesIO()
    off.write(samples.icosphere(3), file)
    other = trimesh.load_mesh(io.BytesIO(file.getvalue()), file_type="off", process=False)
    mine = off.read(file.getvalue())
    assert np.array_equal(mine.positions, other.vertices)
    assert np.array_equal(mine.faces, other.faces)


def test_writing_is_plain() -> None:
    file = io.BytesIO()
    off.write(Mesh([(0, 0, 0), (1, 0, 0), (1e-300, 1, 0.1)], [(0, 1, 2), (0, 2)]), file)
    assert file.getvalue() == b"OFF\n3 2 0\n0.0 0.0 0.0\n1.0 0.0 0.0\n1e-300 1.0 0.1\n3 0 1 2\n2 0 2\n"


def saved(mesh: Mesh) -> bytes:
    file = io.BytesIO()
    off.write(mesh, file)
    return file.getvalue()


@st.composite
def attributed(draw: st.DrawFn) -> Mesh:
    polygons = draw(st.lists(st.lists(st.integers(0, 3), min_size=2, max_size=5), min_size=1, max_size=5))
    number = st.floats(-10, 10)
    point: dict[str, Any] = {}
    for name, widths in (("normal", [3]), ("texcoord", [2]), ("color", [3, 4])):
        width = draw(st.sampled_from([0, *widths]))
        if width and name == "color" and draw(st.integers(0, 1)):
            whole = st.lists(st.integers(2, 255), min_size=width, max_size=width)
            rows: Any = draw(st.lists(whole, min_size=4, max_size=4))
            point[name] = np.array(rows, np.uint8)
        elif width:
            fractions = st.lists(st.floats(0.01, 0.99), min_size=width, max_size=width)
            rows = draw(st.lists(fractions, min_size=4, max_size=4))
            point[name] = np.array(rows, np.float64)
    face: dict[str, Any] = {}
    kind = draw(st.sampled_from(["", "uint8", "float", "index", "more"]))
    n = len(polygons)
    if kind == "uint8":
        face["color"] = np.arange(2, 2 + 3 * n, dtype=np.uint8).reshape(n, 3)
    elif kind == "float":
        face["color"] = (np.arange(4 * n).reshape(n, 4) + 0.5) / (8 * n)
    elif kind == "index":
        face["color_index"] = np.arange(n)
    elif kind == "more" and n > 1:
        sizes = [5, *([0] * (n - 1))]
        face["more"] = RaggedArray(np.arange(5), np.concatenate([[0], np.cumsum(sizes)]))
    points = draw(st.lists(st.lists(number, min_size=3, max_size=3), min_size=4, max_size=4))
    return Mesh(points, polygons, attributes={"point": point, "face": face})


@given(attributed())
def test_attributes_are_read_as_they_were_written(mesh: Mesh) -> None:
    assert off.list_losses(mesh) == []
    found = off.read(saved(mesh))
    assert found == mesh
    assert saved(found) == saved(mesh)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.longdouble])
def test_numbers_of_all_types_are_written_as_numbers(dtype: type) -> None:
    """Of extended precision, their Python type was written around them."""
    normals: Any = np.array([[0.1, np.nan, 1 / 3]] * 8, dtype)
    again = off.read(saved(samples.cube().with_attributes({"point": {"normal": normals, "texcoord": normals[:, ::2]}})))
    assert np.array_equal(again.attributes.point["normal"], normals.astype(float), equal_nan=True)
    assert np.array_equal(again.attributes.point["texcoord"], normals[:, ::2].astype(float))


def test_colors_normals_and_texture_of_the_variants() -> None:
    text = (
        b"STCNOFF\n# by hand\n3 1 0\n0 0 0 0 0 1 255 0 7 9 0 0.5\n1 0 0 0 0 1 254 0 7 9 1 0.5\n"
        b"0 1 0 0 0 1 253 0 7 9 0 1\n3 0 1 2 9 8 7\n"
    )
    mesh = off.read(text)
    assert mesh.attributes.point["normal"].tolist() == [[0, 0, 1]] * 3
    assert mesh.attributes.point["color"].tolist() == [[255 - i, 0, 7, 9] for i in range(3)]
    assert mesh.attributes.point["color"].dtype == np.uint8
    assert mesh.attributes.point["texcoord"].tolist() == [[0, 0.5], [1, 0.5], [0, 1]]
    assert mesh.attributes.face["color"].tolist() == [[9, 8, 7]]
    assert saved(mesh).split(b"\n")[:3] == [b"STCNOFF", b"# by hand", b"3 1 0"]
    assert [list(map(float, line.split())) for line in saved(mesh).split(b"\n")[3:-1]] == [
        list(map(float, line.split())) for line in text.split(b"\n")[3:-1]
    ]


def test_what_off_cannot_hold_is_listed() -> None:
    attributes = {"point": {"intensity": [1.0] * 8, "color": np.zeros((8, 3))}, "face": {"material": [0] * 6}}
    assert off.list_losses(samples.cube().with_attributes(attributes)) == ["intensity per point", "material per face"]


@pytest.mark.parametrize("table", ["point", "face"])
@pytest.mark.parametrize("largest", [0, 1, 2, 255])
def test_dark_colors_of_bytes_stay_dark(table: str, largest: int) -> None:
    """Whole numbers up to 1 are read as fractions."""
    colors = np.zeros((8 if table == "point" else 6, 3), np.uint8)
    colors[2, 1] = largest
    mesh = samples.cube().with_attributes({table: {"color": colors}})
    assert off.list_losses(mesh) == []
    found = getattr(off.read(saved(mesh)).attributes, table)["color"]
    assert np.array_equal(found if found.dtype == np.uint8 and largest > 1 else found * 255, colors)


@pytest.mark.parametrize(
    ("attributes", "lost"),
    [
        ({"point": {"color": np.eye(8, 3) * 2}}, "color per point"),
        ({"face": {"color": np.eye(6, 4) * 255}}, "color per face"),
        ({"face": {"color_index": np.full(6, 0.5)}}, "color_index per face"),
        ({"point": {"more": np.full((8, 3), 0.5)}}, "more per point"),
        ({"face": {"more": np.eye(6, 4)}}, "more per face"),
        ({"point": {"more": np.ones(8), "color": np.eye(8, 3)}}, "more per point"),
        ({"point": {"more": np.ones((8, 5)), "normal": np.eye(8, 3)}}, "more per point"),
    ],
)
def test_what_would_be_read_as_something_else_is_lost(attributes: Any, lost: str) -> None:
    mesh = samples.cube().with_attributes(attributes)
    assert off.list_losses(mesh) == [lost]
    what, names = next(iter(attributes.items()))
    found = off.read(saved(mesh)).attributes
    assert getattr(found, what).keys() == names.keys() - {lost.split()[0]}


def test_a_binary_file_holds_float32_and_no_more() -> None:
    data = b"COFF BINARY\n" + np.array([1, 0, 0], ">i4").tobytes() + np.arange(7, dtype=">f4").tobytes()
    mesh = off.read(data)
    assert saved(mesh) == data
    of_bytes = mesh.with_attributes({"point": {"color": np.array([[255, 51, 0]], np.uint8), "more": np.ones((1, 2))}})
    assert off.read(saved(of_bytes)).attributes.point["color"].tolist() == [pytest.approx([1, 0.2, 0, 1])]
    assert off.list_losses(of_bytes) == ["more per point"]
    with pytest.raises(MeshError, match="binary OFF holds float32, this mesh has a coordinate of 2e\\+40"):
        saved(mesh.transformed(np.diag([1e40, 1e40, 1e40, 1.0])))


def test_dimensions_that_a_file_lacks_are_named_when_they_are_lost() -> None:
    with pytest.warns(MeshWarning, match="left out: that it has 2 dimensions$"):
        save_mesh(off.read(b"nOFF 2\n3 1\n0 0\n1 2\n3 4\n3 0 1 2\n"), io.BytesIO(), file_type="off")
