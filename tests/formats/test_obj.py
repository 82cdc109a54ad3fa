import io
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import example, given
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.errors import MeshError
from gpu_xform.formats import load_mesh, obj

POINTS = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\n"


def faces(data: bytes) -> list[list[int]]:
    return [face.tolist() for face in obj.read(data).faces]


def both(data: bytes) -> tuple[Any, Any]:
    """What the bulk path (None where it declines) and the careful path make of a file."""
    try:
        careful: Any = obj._read_lines(data)
    except MeshError as error:
        careful = str(error)
    return obj._read_regular(data), careful


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
    assert obj._read_regular(data) == obj.read(data)
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
        ("v 1 2 1.#QNAN0", "line 6: a coordinate must be finite, got 1 2 +nan"),
        ("v 1 2 -1.#INF", "line 6: a coordinate must be finite, got 1 2 -inf"),
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
        ("v 1 2 nan", "line 6: a coordinate must be finite, got 1 2 nan"),
        ("v 1 -inf 2", "line 6: a coordinate must be finite, got 1 -inf 2"),
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
