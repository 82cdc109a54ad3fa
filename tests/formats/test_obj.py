import io
import tracemalloc
import warnings
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import example, given
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import load_mesh, obj, save_mesh
from gpu_xform.formats.obj_blocks import read_regular
from gpu_xform.formats.obj_lines import read_lines
from gpu_xform.geometry.mesh import Mesh
from gpu_xform.matrices import scale

POINTS = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\n"


def faces(data: bytes) -> list[list[int]]:
    return [face.tolist() for face in obj.read(data).faces]


def both(data: bytes) -> tuple[Any, Any]:
    """What the bulk path (None where it declines) and the careful path make of a file."""
    try:
        careful: Any = read_lines(data)
    except MeshError as error:
        careful = str(error)
    return read_regular(data), careful


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("f 1 2 3", [[0, 1, 2]]),
        ("f 1 2 3 4", [[0, 1, 2, 3]]),
        ("f 1 2 3 5 4\nf 1 2 3", [[0, 1, 2, 4, 3], [0, 1, 2]]),
        ("f 1/7 2/8 3/9", [[0, 1, 2]]),
        ("f 1//7 2//8 3//9", [[0, 1, 2]]),
        ("f 1/7/1 2/8/2 3/9/3", [[0, 1, 2]]),
        ("f 1/7/1 2//2 3 4/1", [[0, 1, 2, 3]]),
        ("f 1/ 2// 3", [[0, 1, 2]]),
        ("f -5 -4 -1", [[0, 1, 4]]),
        ("f -5/-1 -4/-2 -1//-3", [[0, 1, 4]]),
        ("f -5 2 -1", [[0, 1, 4]]),
        ("f\t1\t2  3   ", [[0, 1, 2]]),
        ("fo 1 2 3", [[0, 1, 2]]),
        ("  f 1 2 3", [[0, 1, 2]]),
        ("f 1 2 3 # not 4", [[0, 1, 2]]),
        ("f 1 2 \\\n3 \\\n  4\nf 1 2 3", [[0, 1, 2, 3], [0, 1, 2]]),
        ("# a comment may end in a backslash \\\nf 1 2 3", [[0, 1, 2]]),
        ("f 1 2 3 \\", [[0, 1, 2]]),
        ("f +1 +2 +3", [[0, 1, 2]]),
        ("f 01 002 3", [[0, 1, 2]]),
        ("l 1 2", [[0, 1]]),
        ("l 1 2 3 -1", [[0, 1], [1, 2], [2, 4]]),
        ("l 3", []),
        ("l 1 2 3\nf -1 -2 -3\nl -1\nl -3 2 -2", [[0, 1], [1, 2], [4, 3, 2], [2, 1], [1, 3]]),
        ("l 1/1 2/2\nf 1 2 3\nl 3 4", [[0, 1], [0, 1, 2], [2, 3]]),
        ("f 1 2", [[0, 1]]),
        ("p 1 2 3", []),
        ("g a \\\nf 1 2 3", []),
        ("g a b\ns 1\nusemtl C:\\x\\\no 1\nvt 0 0\nvn 0 0 1\nvp 1\nmtllib a.mtl\nlod 1\nf 1 2 3", [[0, 1, 2]]),
        ("\n\n   \nf 1 2 3\n\n", [[0, 1, 2]]),
    ],
)
def test_statements(statement: str, expected: list[list[int]]) -> None:
    for end in ("\n", "\r\n", "\r"):
        for bom in (b"", b"\xef\xbb\xbf"):
            data = bom + (POINTS.decode() + statement).replace("\n", end).encode()
            if statement.startswith("g a b"):
                data = data.replace(b"x\\" + end.encode(), b"x" + end.encode())
            assert faces(data) == expected
            assert faces(data + end.encode()) == expected


def test_continuation_joins_words_of_two_lines() -> None:
    assert obj.read(b"v 0 0 \\\n 1\n").positions.tolist() == [[0, 0, 1]]


@pytest.mark.parametrize(
    "tail", [b"", b" 1", b" 0.5 0.25 1e-1", b" 1 2 3 4", b" 0.5  \t"], ids=["plain", "w", "rgb", "wrgb", "spaces"]
)
def test_words_after_the_coordinates_of_a_vertex_are_ignored(tail: bytes) -> None:
    data = b"v 1.5 -2e3 .25" + tail + b"\nv 0 1 2" + tail + b"\n"
    assert read_regular(data) == obj.read(data)
    assert obj.read(data).positions.tolist() == [[1.5, -2000, 0.25], [0, 1, 2]]


def test_vertices_may_come_after_the_faces_and_with_other_lengths() -> None:
    mesh = obj.read(b"f 1 2 3\nv 0 0 0\nv 1 0 0 1 1 1\nv 1 1 0 1\n")
    assert mesh.positions.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2]]


def test_relative_indices_count_from_where_they_stand() -> None:
    data = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 2 0 0\nv 2 1 0\nv 3 3 3\nf -3 -2 -1\nf -6 -1 1"
    assert faces(data) == [[0, 1, 2], [3, 4, 5], [0, 5, 0]]


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig"])
@pytest.mark.parametrize("end", [b"", b"\x1a", b"\0\0\0", b"\r\n\x1a\r\n"])
def test_encodings_and_what_old_tools_put_at_the_end(encoding: str, end: bytes) -> None:
    text = "\ufeff" if encoding in ("utf-16-le", "utf-16-be") else ""
    text += "# a ball, by \u03a3\n" + POINTS.decode() + "f 1 2 3 4\n" + end.decode()
    assert faces(text.encode(encoding)) == [[0, 1, 2, 3]]


def test_a_comment_behind_a_one_is_a_comment() -> None:
    assert obj.read(b"v 0 0 1.#INFO\nv 0 0 1.# IND\nv 0 0 -1.#\n").positions[:, 2].tolist() == [1, 1, -1]


@given(st.data())
def test_relative_indices_and_lines_read_the_same_both_ways(data: st.DataObject) -> None:
    text, n_points = "", 0
    for _ in range(data.draw(st.integers(1, 5))):
        n_new = data.draw(st.integers(1, 4))
        text += "v 1 2 3\n" * n_new
        n_points += n_new
        for _ in range(data.draw(st.integers(0, 3))):
            index = st.integers(-n_points, n_points).filter(bool)
            corners = data.draw(st.lists(index, min_size=2, max_size=5))
            form = data.draw(st.sampled_from(["%d", "%d/1", "%d//-2", "%d/-3/4"]))
            text += data.draw(st.sampled_from("fl")) + " " + " ".join(form % corner for corner in corners) + "\n"
    bulk, careful = both(text.encode())
    assert bulk is not None
    assert bulk == careful


def test_relative_indices_are_those_of_trimesh() -> None:
    # All faces are behind all vertices: trimesh counts back from the last of the file.
    mesh = samples.icosphere(2)
    data = b"".join(b"v %r %r %r\n" % tuple(row) for row in mesh.positions.tolist())
    data += b"".join(b"f %d %d %d\n" % tuple(face) for face in (np.asarray(mesh.faces) - mesh.n_points).tolist())
    bulk, _ = both(data)
    other = trimesh.load_mesh(io.BytesIO(data), file_type="obj", process=False)
    assert np.array_equal(bulk.positions[bulk.indices].reshape(-1, 3, 3), other.triangles)


def test_a_point_cloud_loads() -> None:
    mesh = obj.read(POINTS)
    assert (mesh.n_points, mesh.n_faces) == (5, 0)


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("f 0 1 2", "line 6: index 0 is out of range, OBJ counts from 1"),
        ("f 1 2 6", "line 6: index 6 is out of range, there are 5 vertices"),
        ("f 1 2 3\n\nf 1 2 99999999999999999999", "line 8: index 99999999999999999999 is out of range"),
        ("f 1 2 -6", "line 6: index -6 is out of range, there are 5 vertices so far"),
        ("f 1", "line 6: 'f' needs at least 2 corners, got 1"),
        ("f", "line 6: 'f' needs at least 2 corners, got 0"),
        ("l", "line 6: 'l' needs at least 2 corners, got 0"),
        ("f 1/-1/-1/-1 2 3", "got '1/-1/-1/-1'"),
        ("f 1/-1//-1 2 3", "got '1/-1//-1'"),
        ("f -1 -2 --3", "got '--3'"),
        ("f -1 -2 -3-4", "got '-3-4'"),
        ("v 1 2 1.#QNAN0", "line 6: a coordinate must be finite, got '1 2 +nan'"),
        ("v 1 2 -1.#INF", "line 6: a coordinate must be finite, got '1 2 -inf'"),
        ("f 1 2 3.5", "line 6: expected an index such as 1, 1/2 or 1/2/3, got '3.5'"),
        ("f 1 2 x", "got 'x'"),
        ("f 1 2 1_0", "got '1_0'"),
        ("f 1 2 /3", "got '/3'"),
        ("f 1 2 3/x", "got '3/x'"),
        ("f 1 2 3/1/1/1", "got '3/1/1/1'"),
        ("f 1/2/3/4 2/2/3/4 3/2/3/4", "got '1/2/3/4'"),
        ("f 1//2//3 1//2//3 1//2//3", "got '1//2//3'"),
        ("f 1f2 3 4", "got '1f2'"),
        ("f 1 2 3 f 1 2 3", "got 'f'"),
        ("f 1 2 - 3", "got '-'"),
        ("v 1 2", "line 6: a vertex needs 3 numbers, got 2"),
        ("v 1 2 x", "line 6: expected a number, got 'x'"),
        ("v 1 2 1_0", "line 6: expected a number, got '1_0'"),
        ("v 1 2 3 v 4 5 6", "line 6: expected a number, got 'v'"),
        ("v 1 2 " + "1" * 400, "line 6: a coordinate must be finite, got '1 2 111111111111111111111111111111111..."),
        ("v 1 2 nan", "line 6: a coordinate must be finite, got '1 2 nan'"),
        ("v 1 -inf 2", "line 6: a coordinate must be finite, got '1 -inf 2'"),
        ("v 1e999 1 2", "line 6: a coordinate must be finite"),
        ("v1 2 3", "line 6: expected a statement such as v, f or l, got 'v1'"),
        ("12 3", "line 6: expected a statement such as v, f or l, got '12'"),
        ("\x00\x01", "line 6: expected a statement"),
    ],
)
def test_errors_name_the_line_and_what_came(statement: str, message: str) -> None:
    with pytest.raises(MeshError) as caught:
        obj.read(POINTS + statement.encode())
    assert message in str(caught.value)


def test_a_file_without_vertices_is_refused() -> None:
    with pytest.raises(MeshError, match="no vertices"):
        obj.read(b"# nothing here\n")


def test_numbers_are_read_to_the_last_bit() -> None:
    values = np.random.default_rng(5).integers(0, 2**63, 3000, dtype=np.int64).view(np.float64)
    values = values[np.isfinite(values)][:2997].reshape(-1, 3)
    data = b"".join(b"v %a %a %a\n" % tuple(row) for row in values.tolist())
    bulk, careful = both(data)
    assert np.array_equal(bulk.positions, values)
    assert np.array_equal(careful.positions, values)


@pytest.mark.parametrize(
    "data",
    [
        POINTS + b"f 1 2 3\nf 2 3 4\n",
        POINTS + b"f 1 2 3 4\ng x\nf 2 3 4\nusemtl y\nf 1 5 3 2 4",
        POINTS + b"vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf 1/1/1 2/1/1 3/1/1\n",
        POINTS + b"f 1//1 2//1 3//1\n",
        POINTS + b"f 1/1 2/1 3/1\n",
        b"# head\n\no thing\n" + POINTS + b"\ns off\nf 1 2 3\n" + POINTS + b"f 8 9 10 1\n",
        POINTS,
        POINTS + b"f -1 -2 -3\nf -5/-1 2/7 +3/1 -1/2\n" + POINTS + b"f 1//2 -1//-3 -7//1\nf -1/2/3 4/5/-6 7/8/9\n",
        POINTS + b"f -5 2/-1 3//-1 4/-2/-3  \t\n",
        POINTS + b"l 1 2 3\nf 1 2 3 4\nl 4 5\nl 1 2 3 4 5 1\n",
        POINTS + b"l -1 -2 -3\nf -1 2 3 4\nl 4/-1 5/-2\n",
    ],
)
def test_regular_files_take_the_bulk_path(data: bytes) -> None:
    bulk, careful = both(data)
    assert bulk is not None
    assert bulk == careful


WORDS = r"""
v f l vt vn g # 1 2 3 4 -1 0 0.5 1e1 nan inf / // \ x 1/2 1//2 1/2/3 2/1 3//1 2/3/1 1/ /1 1_0 v1
"""
LINES = """
|||v |f |v 1 2 3|f 1 2 3|f 1/1/1 2/2/2 3/3/3|f 1//1 2//2 3//3|"""
words = st.sampled_from(WORDS.split() + LINES.replace("|", "|\n").split("|"))
gaps = st.sampled_from(["", " ", " ", " ", "  ", "\t", "\r", "\v", "\f"])
texts = st.lists(st.tuples(words, gaps), max_size=40).map(lambda parts: "".join(map("".join, parts)))


@given(texts, st.booleans())
@example("\nf 1 2 3x", True)
@example("\nf 1 /2 3", True)
@example("\nf 1 2 3/ 1", True)
@example("\nf 1 2 + 3", True)
@example("\nf 0f1 2 3", True)
@example("\ng a \\\nf 1 2 3", True)
@example("\nf 1//2 2/3 3\n", True)
@example("\nf 1f2 3 4\nf\n", True)
@example("\nf 1 2 3 f 2 3\nf \n", True)
@example("\nv 1 2 3 v 4 5 6\nv \n", True)
def test_both_paths_accept_the_same_language(text: str, with_points: bool) -> None:
    data = (POINTS if with_points else b"") + text.encode()
    with warnings.catch_warnings(action="ignore", category=MeshWarning):  # about vt and vn, and about points of p
        bulk, careful = both(data)
    if bulk is not None:
        assert bulk == careful


@given(
    st.lists(st.lists(st.integers(1, 5), min_size=2, max_size=6), max_size=8),
    st.sampled_from(["%d", "%d/1", "%d//2", "%d/3/4"]),
    st.integers(0, 2**32 - 1),
)
def test_regular_files_read_the_same_both_ways(polygons: list[list[int]], form: str, seed: int) -> None:
    rows = np.random.default_rng(seed).normal(size=(5, 3)) * 10.0 ** np.arange(-10, 5).reshape(5, 3)
    text = "".join(f"v {x!r} {y:.5e} {z:f}\n" for x, y, z in rows.tolist())
    text += "".join("f " + " ".join(form % corner for corner in polygon) + "\n" for polygon in polygons)
    bulk, careful = both(text.encode())
    assert bulk is not None
    assert bulk == careful
    assert [face.tolist() for face in bulk.faces] == [[corner - 1 for corner in polygon] for polygon in polygons]


def test_triangles_are_those_of_trimesh() -> None:
    file = io.BytesIO()
    sphere = samples.icosphere(3)
    obj.write(sphere, file)
    other = trimesh.load_mesh(io.BytesIO(file.getvalue()), file_type="obj", process=False, maintain_order=True)
    mine = load_mesh(io.BytesIO(file.getvalue()), file_type="obj")
    assert np.array_equal(mine.positions, other.vertices)
    assert np.array_equal(mine.faces, other.faces)


def test_writing_is_plain() -> None:
    file = io.BytesIO()
    obj.write(obj.read(b"v 0 0 0\nv 1 0 0\nv 1e-300 1 0.1\nf 1 2 3\nl 1 3 2"), file)
    assert file.getvalue() == b"v 0.0 0.0 0.0\nv 1.0 0.0 0.0\nv 1e-300 1.0 0.1\nf 1 2 3\nl 1 3\nl 3 2\n"


ATTRIBUTED = b"""# made by hand
mtllib house.mtl trees.mtl
o house
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0.123456789 1
vn 0 0 1
vn 0.6 0 0.8
g wall front
usemtl white paint
s 1
f 1/1/1 2/2/1 3/3/2 4/4/2
usemtl glass
s off
f 1/1 2/2 3/3
# between
g
f 1//1 3//2 4//1
f 2 3 4
l 1/1 2/2 3/4
"""


def test_normals_that_are_not_finite_are_named() -> None:
    text = b"v 0 0 0\nv 1 0 0\nv 0 2 0\nvn nan 0 1\nvn 0 0 1\nvn inf 0 0\nf 1//1 2//2 3//3\n"
    with pytest.warns(
        MeshWarning, match=r"^normals that are not three finite numbers: 2; they are left out where the mesh moves$"
    ):
        read = obj.read(text)
    np.testing.assert_array_equal(read.attributes.corner["normal"], [(np.nan, 0, 1), (0, 0, 1), (np.inf, 0, 0)])
    moved = read.transformed(scale(2)).attributes.corner["normal"]
    np.testing.assert_array_equal(moved, [(np.nan,) * 3, (0, 0, 1), (np.nan,) * 3])


def test_attributes_of_an_obj_file() -> None:
    mesh = obj.read(ATTRIBUTED)
    held = mesh.attributes
    nothing: list[float] = [np.nan, np.nan]
    quad: list[list[float]] = [[0, 0], [1, 0], [1, 1], [0.123456789, 1]]
    assert np.array_equal(
        held.corner["texcoord"],
        [*quad, *quad[:3], *[nothing] * 6, *quad[:2], quad[1], quad[3]],
        equal_nan=True,
    )
    assert held.corner["normal"][:4].tolist() == [[0, 0, 1], [0, 0, 1], [0.6, 0, 0.8], [0.6, 0, 0.8]]
    assert np.isnan(held.corner["normal"][10:]).all()
    named = {name: [held.labels[name][i] for i in held.face[name]] for name in held.labels}
    assert named == {
        "object": ["house"] * 6,
        "group": ["wall front"] * 2 + [""] * 4,
        "material": ["white paint"] + ["glass"] * 5,
        "smooth": ["1"] + ["off"] * 5,
    }
    assert held.material == {"mtllib": ("house.mtl trees.mtl",)}
    assert mesh.metadata["obj"]["comments"] == (" made by hand", " between")


def saved(mesh: Mesh) -> bytes:
    file = io.BytesIO()
    obj.write(mesh, file)
    return file.getvalue()


@pytest.mark.parametrize(
    "data",
    [
        ATTRIBUTED,
        ATTRIBUTED.replace(b"f 2 3 4", b"f 2 3 \\\n4"),  # read line by line
        ATTRIBUTED.replace(b"f 1/1/1 2/2/1 3/3/2 4/4/2", b"f -4/-4/-2 2/2/1 -2/-2/-1 4/4/2"),
        ATTRIBUTED.replace(b" 0\nvt", b" 0 0.5\nvt").replace(
            b"v 0 0 0\nv 1 0 0\nv 1 1 0", b"v 0 0 0 1\nv 1 0 0 2\nv 1 1 0 3"
        ),
    ],
)
def test_what_is_read_and_written_again_is_equal(data: bytes) -> None:
    mesh = obj.read(data)
    assert mesh.attributes.labels == obj.read(ATTRIBUTED).attributes.labels
    assert np.array_equal(mesh.indices, obj.read(ATTRIBUTED).indices)
    for name in ("texcoord", "normal"):
        expected = obj.read(ATTRIBUTED).attributes.corner[name]
        width = expected.shape[1]
        assert np.array_equal(mesh.attributes.corner[name][:, :width], expected, equal_nan=True)
    assert obj.read(saved(mesh)) == mesh
    assert saved(obj.read(saved(mesh))) == saved(mesh)


def lines_of(data: bytes, *keywords: bytes) -> list[list[bytes]]:
    return [line.split() for line in data.splitlines() if line.split()[:1] and line.split()[0] in keywords]


def test_a_file_whose_rows_are_all_used_in_order_comes_back_line_by_line() -> None:
    plain = ATTRIBUTED.replace(b"l 1/1 2/2 3/4\n", b"l 1/1 2/2\n")
    again = saved(obj.read(plain))
    for keyword in (b"v", b"vt", b"vn"):
        found = [[float(word) for word in line[1:]] for line in lines_of(again, keyword)]
        assert found == [[float(word) for word in line[1:]] for line in lines_of(plain, keyword)]
    kept = (b"f", b"l", b"o", b"g", b"usemtl", b"s", b"mtllib")
    assert lines_of(again, *kept)[:3] == lines_of(plain, *kept)[:3]
    assert sorted(lines_of(again, *kept)) == sorted(lines_of(plain, *kept))


@pytest.mark.parametrize(
    ("data", "lines"),
    [
        (b"vn nan 0 1\nvn 0 0 1\nf 1//1 2//2 3//2\n", b"vn nan 0.0 1.0\nvn 0.0 0.0 1.0\n"),
        (b"vn 0 0 nan\nf 1//1 2//1 3//1\n", b"vn 0.0 0.0 nan\n"),
        (b"vt nan .5\nf 1/1 2/1 3/1\n", b"vt nan 0.5\n"),
        (b"vt .5 nan\nf 1/1 2/1 3/1\n", b"vt 0.5 nan\n"),
        (b"vt .5\nvt .5 1\nf 1/1 2/1 3/2\n", b"vt 0.5\nvt 0.5 1.0\n"),
        (b"vn nan nan nan\nvn 0 0 1\nvn 1 0 nan\n", b"vn nan nan nan\nvn 0.0 0.0 1.0\nvn 1.0 0.0 nan\n"),
        (b"vt nan nan\nvt 1 2\nvt 1\n", b"vt nan nan\nvt 1.0 2.0\nvt 1.0\n"),
    ],
)
def test_numbers_that_are_nan_keep_their_places(data: bytes, lines: bytes) -> None:
    with warnings.catch_warnings(action="ignore", category=MeshWarning):  # of normals
        mesh = obj.read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + data)
        assert b"\n" + lines in saved(mesh)
        assert obj.read(saved(mesh)) == mesh


def test_colors_that_are_nan_keep_their_places() -> None:
    mesh = obj.read(b"v 0 0 0 nan 0 0\nv 1 0 0 1 0 nan\nv 0 1 0 nan nan nan\nv 1 1 0\nv 1 0 1 1 1 0\n")
    assert lines_of(saved(mesh), b"v")[0] == b"v 0.0 0.0 0.0 nan 0.0 0.0".split()
    assert obj.read(saved(mesh)) == mesh


@given(st.sampled_from(["mesh", "cloud"]), st.data())
def test_nan_anywhere_is_read_as_it_was_written(kind: str, data: st.DataObject) -> None:
    """In normals, texture coordinates, colours and weights."""
    number = st.floats(width=32, allow_infinity=False) | st.just(np.nan)

    def draw(n_rows: int, width: int) -> Any:
        row = st.lists(number, min_size=width, max_size=width)
        return np.array(data.draw(st.lists(row, min_size=n_rows, max_size=n_rows))).reshape(n_rows, width)

    faces = [(0, 1, 2), (3, 2, 1, 0)] if kind == "mesh" else []
    place, n_rows = ("corner", 7) if kind == "mesh" else ("point", 4)
    attributes: dict[str, Any] = {"point": {}, "corner": {}}
    beside = data.draw(st.sampled_from(["none", "weight", "color", "rgba"]))
    if beside == "weight":
        attributes["point"]["weight"] = draw(4, 1)[:, 0]
    elif beside != "none":
        attributes["point"]["color"] = draw(4, 3 + (beside == "rgba"))
    for name, width in (("texcoord", data.draw(st.integers(1, 3))), ("normal", 3)):
        if data.draw(st.booleans()):
            attributes[place][name] = draw(n_rows, width)
    mesh = Mesh(np.eye(4, 3), faces, attributes=attributes)
    absent = [name for name, rows in mesh.attributes.corner.items() if np.isnan(rows).all()]
    assert obj.list_losses(mesh) == [f"{name} per corner" for name in absent]
    attributes["corner"] = {name: rows for name, rows in attributes["corner"].items() if name not in absent}
    with warnings.catch_warnings(action="ignore", category=MeshWarning):  # of normals
        assert obj.read(saved(mesh)) == mesh.with_attributes(attributes)
        assert read_lines(saved(mesh)) == mesh.with_attributes(attributes)


def test_a_weight_beside_a_color_is_named() -> None:
    mesh = Mesh(np.eye(3), attributes={"point": {"weight": np.ones(3), "color": np.eye(3)}})
    assert obj.list_losses(mesh) == ["weight per point beside color"]


@st.composite
def textured(draw: st.DrawFn) -> Mesh:
    polygons = draw(st.lists(st.lists(st.integers(0, 4), min_size=2, max_size=5), max_size=6))
    n_corners, n_faces = sum(map(len, polygons)), len(polygons)
    number = st.floats(-10, 10)
    attributes: dict[str, Any] = {"corner": {}, "face": {}, "labels": {}, "point": {}}
    is_segment = np.repeat([len(polygon) == 2 for polygon in polygons], [len(polygon) for polygon in polygons])
    for name, width in (("texcoord", draw(st.integers(1, 3))), ("normal", 3)):
        row = st.lists(number, min_size=width, max_size=width) | st.just([np.nan] * width)
        rows = np.array(draw(st.lists(row, min_size=n_corners, max_size=n_corners))).reshape(n_corners, width)
        if name == "normal":
            rows[is_segment.astype(bool)] = np.nan  # lines have none
        if not np.isnan(rows).all():
            attributes["corner"][name] = rows
    for name in ("material", "group", "object", "smooth"):
        values = draw(st.none() | st.lists(st.integers(0, 2), min_size=n_faces, max_size=n_faces))
        if values:
            order = list(dict.fromkeys(values))
            attributes["face"][name] = np.array([order.index(value) for value in values], np.int32)
            attributes["labels"][name] = [f"{name} {value}" for value in order]
    if draw(st.booleans()):
        width = draw(st.sampled_from([3, 4]))
        colors = draw(st.lists(st.lists(number, min_size=width, max_size=width), min_size=5, max_size=5))
        attributes["point"]["color"] = np.array(colors)
    if draw(st.booleans()):
        attributes["material"] = {"mtllib": ["a.mtl"]}
    points = draw(st.lists(st.lists(number, min_size=3, max_size=3), min_size=5, max_size=5))
    return Mesh(points, polygons, attributes=attributes)


@given(textured())
def test_any_attributes_are_read_as_they_were_written(mesh: Mesh) -> None:
    assert obj.list_losses(mesh) == []
    found = obj.read(saved(mesh))
    assert found == mesh
    by_lines = read_lines(saved(mesh))
    assert by_lines == mesh


def test_texture_coordinates_and_materials_are_those_of_trimesh() -> None:
    grid = samples.grid(4)
    triangles = np.array([[(a, b, c), (a, c, d)] for a, b, c, d in np.asarray(grid.faces)]).reshape(-1, 3)
    uv = np.random.default_rng(1).random((len(triangles) * 3, 2)).round(5)
    material = np.arange(len(triangles)) % 2
    attributes = {"corner": {"texcoord": uv}, "face": {"material": material}, "labels": {"material": ["a", "b"]}}
    mesh = Mesh(grid.positions, triangles, attributes=attributes)
    scene = trimesh.load_scene(io.BytesIO(saved(mesh)), file_type="obj", process=False)
    parts = list(scene.geometry.values())
    assert len(parts) == 2
    parts.sort(key=lambda part: not np.array_equal(part.vertices[part.faces[0]], mesh.positions[triangles[0]]))
    for i, part in enumerate(parts):
        chosen = np.repeat(material == i, 3)
        assert np.array_equal(part.vertices[part.faces].reshape(-1, 3), mesh.positions[mesh.indices][chosen])
        assert np.allclose(part.visual.uv[part.faces].reshape(-1, 2), uv[chosen])


def test_corners_of_a_mirrored_file_keep_their_texture() -> None:
    mesh = obj.read(ATTRIBUTED)
    moved = obj.read(saved(mesh.transformed(np.diag([-1.0, 1, 1, 1]))))
    assert lines_of(saved(moved), b"f")[0] == b"f 1/1/1 4/2/2 3/3/2 2/4/1".split()
    assert moved.attributes.corner["texcoord"][:4].tolist() == [[0, 0], [0.123456789, 1], [1, 1], [1, 0]]
    assert np.allclose(moved.attributes.corner["normal"][1], [-0.6, 0, 0.8])


def test_references_to_what_is_not_there_are_named() -> None:
    for data in (
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/7 3/1\n",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/7 \\\n3/1\n",
    ):
        with pytest.warns(MeshWarning, match="^1 corners name texture coordinates that the file does not hold$"):
            mesh = obj.read(data)
        assert np.isnan(mesh.attributes.corner["texcoord"][1]).all()
    with pytest.warns(MeshWarning, match="^the lines vt are left out, for they are not all numbers$"):
        assert not obj.read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt a b\nf 1/1 2/1 3/1\n").attributes


def test_what_obj_cannot_hold_is_listed() -> None:
    attributes = {
        "point": {"intensity": [1] * 5, "normal": np.eye(5, 3)},
        "face": {"material": [0, 0], "area": [1.0, 2.0]},
        "material": {"texture": "a.png"},
    }
    mesh = Mesh(np.eye(5, 3), [(0, 1, 2), (2, 3)], attributes=attributes)
    lost = ["intensity per point", "material per face", "area per face", "normals of segments", "material (texture)"]
    assert obj.list_losses(mesh) == lost
    assert obj.list_losses(obj.read(ATTRIBUTED)) == []
    assert obj.read(saved(mesh)).attributes.corner["normal"][:3].tolist() == np.eye(3).tolist()


@pytest.mark.parametrize(
    ("names", "written"),
    [
        (["m\nv 9 9 9", "a\rf 1 2 5", "\v\f\0\x1a\x85\u2028"], ["m_v 9 9 9", "a_f 1 2 5", "______"]),
        (["\ud800", "a\udc80", "a\tb", " a  b ", "  "], ["_", "a_", "a_b", "_a  b_", "__"]),
        (["a_", "a\n", "a\r", "a__2", "a\v"], ["a_", "a__3", "a__4", "a__2", "a__5"]),
        (
            ["1.#INF", "a,-1.#IND00]", "+inf", "1.#b", "#", "a#b"],
            ["1._INF", "a,-1._IND00]", "+inf", "1.#b", "#", "a#b"],
        ),
        (["", "v 9 9 9", "\u3000"], ["", "v 9 9 9", "\u3000"]),
    ],
)
@pytest.mark.parametrize("kind", ["object", "group", "material", "smooth"])
def test_names_stay_in_their_lines_and_differ(kind: str, names: list[str], written: list[str]) -> None:
    if kind == "smooth":  # behind which a number sign begins a comment
        written = [name.replace("#", "_") for name in written]
    attributes = {"face": {kind: range(len(names))}, "labels": {kind: names}}
    mesh = Mesh(np.eye(3), [(0, 1, 2)] * len(names), attributes=attributes)
    changed = [name for name, found in zip(names, written, strict=True) if name != found]
    assert obj.list_losses(mesh) == [f"some names of {kind}, such as {name!r}" for name in changed[:1]]
    again = obj.read(saved(mesh))
    assert (again.n_points, again.n_faces) == (3, len(names))
    assert again.attributes.labels == {kind: tuple(written)}
    assert again == read_lines(saved(mesh))


@pytest.mark.parametrize("text", ["m.mtl\nv 9 9 9", "m.mtl\\", "m.mtl\r", " m.mtl", "\ud800"])
def test_libraries_and_comments_stay_in_their_lines(text: str) -> None:
    attributes = {"material": {"mtllib": [text]}}
    mesh = Mesh(np.eye(3), [(0, 1, 2)], attributes=attributes, metadata={"obj": {"comments": [text]}})
    losses = [f"some names of material libraries, such as {text!r}"] if not text.endswith("\\") else []
    assert obj.list_losses(mesh) == ["line ends in comments"] * (text[-1] not in "l\\" and text[0] != " ") + losses
    again = obj.read(saved(mesh))
    assert (again.n_points, again.n_faces) == (3, 1)
    assert len(again.attributes.material["mtllib"]) == len(again.metadata["obj"]["comments"]) == 1
    assert saved(again).splitlines() == saved(mesh).splitlines()


hostile = st.text(st.sampled_from("ab_#\\ \t\n\r\v\f\0\x1a\x1c\x85\u2028\ufeff\ud800\udfff1.INDv")) | st.text()


@given(st.lists(st.tuples(*[st.integers(-1, 4)] * 4), min_size=1, max_size=8), st.data())
def test_any_names_leave_points_and_faces_as_they_are(numbers: list[tuple[int, ...]], data: st.DataObject) -> None:
    """Different labels stay different, and all stay as they are if no loss is named."""
    kinds = ("object", "group", "material", "smooth")
    labels = {kind: data.draw(st.lists(hostile, min_size=5, max_size=5, unique=True)) for kind in kinds}
    faces = np.random.default_rng(1).integers(0, 4, (len(numbers), 3))
    attributes = {"face": dict(zip(kinds, np.array(numbers).T, strict=True)), "labels": labels}
    comments = data.draw(st.lists(hostile, max_size=2))
    libraries = data.draw(st.lists(hostile, max_size=2))
    mesh = Mesh(
        np.eye(4, 3),
        faces,
        attributes={**attributes, "material": {"mtllib": libraries}},
        metadata={"obj": {"comments": comments}},
    )
    losses = "; ".join(obj.list_losses(mesh))
    again = obj.read(saved(mesh))
    assert again == read_lines(saved(mesh))
    assert np.array_equal(again.positions, mesh.positions)
    assert np.array_equal(again.faces, faces)
    assert len(again.metadata.get("obj", {}).get("comments", ())) == len(comments)
    assert "libraries" in losses or again.attributes.material.get("mtllib", ()) == tuple(libraries)
    for kind, column in zip(kinds, np.array(numbers).T, strict=True):
        before = [labels[kind][number] if number >= 0 else None for number in column]
        if f"faces without {kind}" in losses or before[0] is None:
            continue
        held = again.attributes.labels[kind]
        after = [held[number] for number in again.attributes.face[kind]]
        assert len(set(zip(before, after, strict=True))) == len(set(before)) == len(set(after))
        assert f"names of {kind}" in losses or before == after


def test_faces_without_a_label_behind_others_are_named() -> None:
    """They were read again with the label of the face before, for no statement takes it back."""
    attributes: dict[str, Any] = {"face": {"material": [-1, 0, 0]}, "labels": {"material": ["a"]}}
    mesh = Mesh(np.eye(3), [(0, 1, 2)] * 3, attributes=attributes)
    assert obj.list_losses(mesh) == []
    for column in ([0, -1, 0], [0, 0, 1]):
        attributes["face"]["material"] = column
        assert obj.list_losses(mesh.with_attributes(attributes)) == ["faces without material behind others"]


@pytest.mark.parametrize("corners", [[], [2], [3, 4], [0, 1], [0, 1, 2, 3, 4]])
def test_normals_of_segments_are_named(corners: list[int]) -> None:
    """A line of OBJ has none."""
    normals = np.full((5, 3), np.nan)
    normals[corners] = 1.0
    mesh = Mesh(np.eye(3), [(0, 1, 2), (1, 2)], attributes={"corner": {"normal": normals}})
    is_lost = not {3, 4}.isdisjoint(corners)
    assert ("normals of segments" in obj.list_losses(mesh)) == is_lost
    assert (obj.read(saved(mesh)) == mesh) == (not is_lost and len(corners) > 0)


def test_a_name_that_ends_in_a_backslash_does_not_continue_on_the_next_line() -> None:
    attributes = {"face": {"material": [0, 1]}, "labels": {"material": ["a\\", "\\"]}}
    mesh = Mesh(np.eye(3), [(0, 1, 2), (2, 1, 0)], attributes=attributes)
    assert obj.list_losses(mesh) == []
    again = obj.read(saved(mesh))
    assert np.array_equal(again.indices, mesh.indices)
    assert again.attributes.labels == {"material": ("a\\", "\\")}


def test_a_material_of_the_name_of_a_statement_names_no_library() -> None:
    """As glTF may have one."""
    mesh = Mesh(np.eye(3), [(0, 1, 2)], attributes={"material": {"mtllib": {"name": "a"}}})
    assert b"mtllib" not in saved(mesh)
    assert obj.list_losses(mesh) == ["material (mtllib)"]


BY_LINES = b"f 1 2 \\\n3\n"  # which only `_read_lines` reads


@pytest.mark.parametrize("end", [b"", BY_LINES])
def test_points_that_are_drawn_come_back(end: bytes) -> None:
    # As in "testpoints.obj" of assimp's tests, with a relative index.
    mesh = obj.read(b"v 0 0 0\nv 1 0 0\np 2 1\nv 1 1 0\np -1\n" + end)
    assert lines_of(saved(mesh), b"p") == [[b"p", b"2", b"1", b"3"]]
    assert lines_of(saved(mesh.transformed(np.diag([2.0, 3.0, 4.0, 1.0]))), b"p") == [[b"p", b"2", b"1", b"3"]]
    with pytest.warns(MeshWarning, match="2 points that p names are left out"):
        obj.read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\np 7\np x 1\n" + end)


@pytest.mark.parametrize("end", [b"", b"# \\\n"])
def test_normals_of_a_cloud_are_those_of_its_points(end: bytes) -> None:
    # As MeshLab writes clouds.
    mesh = obj.read(b"vn 1 0 0\nv 0 0 0\nvn 0 0.6 0.8\nv 1 0 0\nvn 1 0 0\nv 1 1 0\n" + end)
    normals: list[list[float]] = [[1, 0, 0], [0, 0.6, 0.8], [1, 0, 0]]
    assert mesh.attributes.point["normal"].tolist() == normals
    assert lines_of(saved(mesh), b"vn") == [[b"vn", *(repr(float(x)).encode() for x in row)] for row in normals]
    assert obj.read(saved(mesh)) == mesh


@pytest.mark.parametrize("end", [b"", BY_LINES])
def test_points_without_a_color_may_stand_among_others(end: bytes) -> None:
    # As in "only_a_part_of_vertexcolors.obj" of assimp's tests.
    data = b"v 0 0 0\nv 1 0 0 1 0.5 0.25\nv 1 1 0\nf 1 2 3\n"
    mesh = obj.read(data + end)
    nothing: list[float] = [np.nan] * 3
    assert np.array_equal(mesh.attributes.point["color"], [nothing, [1, 0.5, 0.25], nothing], equal_nan=True)
    assert lines_of(saved(mesh), b"v")[1] == b"v 1.0 0.0 0.0 1.0 0.5 0.25".split()
    assert lines_of(saved(mesh), b"v")[2] == b"v 1.0 1.0 0.0".split()


@pytest.mark.parametrize("end", [b"", BY_LINES])
def test_what_no_face_names_is_named_when_it_is_lost(end: bytes) -> None:
    data = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nlod 3\nf 1/1 2/2 3/2\n"
    mesh = obj.read(data + end)
    words = "left out: 1 texture coordinates that no face names, 1 normals that no face names, 1 lod"
    for kind in ("obj", "ply"):
        with pytest.warns(MeshWarning, match=words):
            save_mesh(mesh, io.BytesIO(), file_type=kind)
    with pytest.warns(MeshWarning, match="left out: 3 texture coordinates that no face names, 1 normals"):
        save_mesh(obj.read(data.replace(b"/1", b"").replace(b"/2", b"") + end), io.BytesIO(), file_type="obj")


def test_curves_and_surfaces_that_cannot_be_shown_are_named() -> None:
    data = b"v 0 0 0\nv 1 0 0\nv 1 1 0\ncstype taylor\ndeg 2\ncurv 0 1 1 2 3\nparm u 0 1\nend\nl 1 2\n"
    with pytest.warns(MeshWarning, match="not shown: 1 curv; line 6: curv of type taylor is none of curv and surf of"):
        mesh = obj.read(data)
    assert mesh.metadata["obj"]["left_out"] == ("1 curv",)


@pytest.mark.parametrize("end", [b"", BY_LINES])
def test_comments_behind_statements_and_number_signs_in_names_are_kept(end: bytes) -> None:
    data = b"# first\nv 0 0 0\nv 1 0 0\nv 1 1 0\no a  b\nusemtl Material #25\ng x#1\ns 1 # smooth\nf 1 2 3\n"
    mesh = obj.read(data + end)
    assert mesh.attributes.labels["material"] == ("Material #25",)
    assert mesh.attributes.labels["group"] == ("x#1",)
    assert mesh.attributes.labels["object"] == ("a  b",)
    assert mesh.attributes.labels["smooth"] == ("1",)
    assert mesh.metadata["obj"]["comments"] == (" first", " smooth")
    commented = obj.read(data.replace(b"v 1 0 0", b"v 1 0 0 # right") + end)
    assert commented.metadata["obj"]["comments"] == (" first", " right", " smooth")


def test_references_beyond_any_integer_are_those_to_nothing() -> None:
    with pytest.warns(MeshWarning, match="1 corners name texture coordinates that the file does not hold"):
        mesh = obj.read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nf 1/1 2/99999999999999999999 3/1\n" + BY_LINES)
    assert np.isnan(mesh.attributes.corner["texcoord"][1]).all()


WIDE = b" 0" * 100_000  # numbers in a line
LONG = b" 1 2 3" * 100_000  # corners of a face


@pytest.mark.parametrize(
    ("text", "n_faces", "message"),
    [
        (
            POINTS + b"v 0 0 0" + WIDE + b"\n" + b"v 0 0 1\n" * 4000 + b"f 1 2 3\n",
            1,
            "100000 numbers behind each point",
        ),
        (POINTS * 4000 + b"v 0 0 0" + WIDE + b"\nf 1 2 3\n", 1, "100000 numbers behind each point"),
        (b"v 0 0 0" + WIDE + WIDE + WIDE + b"\n" + POINTS * 9000 + b"f 1 2 3\n", 1, "300000 numbers behind each point"),
        ((b"v 0 0 0" + WIDE + b"\n") * 4 + b"f 1 2 3\n", 1, "100000 numbers behind each point"),
        (POINTS + b"f" + LONG + b"\n" + b"f 1 2 3\n" * 40_000, 40_001, None),
    ],
)
def test_one_long_line_among_short_ones_takes_no_memory_for_each(
    text: bytes, n_faces: int, message: str | None
) -> None:
    """A megabyte took 11 GB, and 70 GB were asked for where such a line came first."""
    tracemalloc.start()
    try:
        mesh = obj.read(text)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert mesh.n_faces == n_faces
    assert peak < 60e6
    assert mesh.metadata.get("obj", {}).get("left_out", ()) == (() if message is None else (message,))
