"""Names and texts that a header of PLY holds."""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import plyfile
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gpu_xform.formats import ply
from gpu_xform.formats._text import quote
from gpu_xform.formats.ply_header import GROUPS, group_properties
from gpu_xform.geometry.mesh import Mesh

POSITIONS = np.arange(12.0).reshape(4, 3) ** 2
FACES = [(0, 1, 2, 3), (0, 1, 2)]
PROPERTIES = [part for choices in GROUPS.values() for parts in choices for part in parts]
WRITTEN = ["x", "y", "z", "vertex_indices", "vertex_index", "vertex1", "vertex2", *PROPERTIES, *GROUPS]
ODD = [" ", "_", "a b", "a_b", "a_b_2", "a\nend_header\n", "\r", "\0", "\x1b", "\x85", "\xa0", "é", "温度", "x_2"]
KNOWN = """ply
format ascii 1.0
element vertex 4
property double y
property double u
property double v
property double alpha
property double x
property double z
element face 2
property double vertex1
property list uchar int vertex_index
property list uchar double weight
element edge 1
property double length
property int vertex1
property int vertex2
end_header
0 1 2 3 0 0
1 4 5 6 4 9
2 7 8 9 8 8
3 1 2 3 5 6
.5 4 0 1 2 3 4 9 8 7 6
.25 3 0 1 2 3 5 4 3
.75 1 3
"""

names = st.one_of(st.text(min_size=1, max_size=3), st.sampled_from([*WRITTEN, *ODD]))
tables = st.dictionaries(names, st.tuples(st.sampled_from(["f8", "u1"]), st.integers(1, 4)), max_size=8)


def saved(mesh: Mesh) -> bytes:
    file = io.BytesIO()
    ply.write(mesh, file)
    return file.getvalue()


def make_columns(table: Mapping[str, tuple[str, int]], n: int, first: int, kinds: str | None = None) -> dict[str, Any]:
    """Return columns of which no two have one value."""
    columns = {}
    for i, (name, (kind, width)) in enumerate(table.items(), first):
        values = (1 + i * 4 * n + np.arange(n * width)).astype(kinds or kind)
        columns[name] = values if width == 1 else values.reshape(n, width)
    return columns


def name_as_told(columns: Mapping[str, Any], what: str, lost: list[str]) -> dict[str, Any]:
    """Return columns by the names that `list_losses` tells."""
    new = {}
    for name in columns:
        told = [text for text in lost if text.startswith(f"the name {quote(name)} per {what} (now ")]
        assert len(told) <= 1
        new[name] = told[0].rpartition(" (now ")[2].removesuffix(")") if told else name
    assert len({*new.values()}) == len(new)
    return {new[name]: column for name, column in columns.items()}


def assert_same(found: Mapping[str, Any], expected: dict[str, Any]) -> None:
    assert found.keys() == expected.keys()
    for name, column in expected.items():
        assert np.array_equal(found[name], column), name


@given(tables, tables, tables)
@example({"color": ("f8", 3), "alpha": ("f8", 1)}, {}, {"color": ("u1", 3), "red": ("u1", 1)})
@example({"texcoord": ("f8", 2), "s": ("f8", 1), "t": ("f8", 1)}, {"a b": ("f8", 1), "a_b": ("f8", 1)}, {})
@example({}, {"texture_u": ("u1", 1), "texture_v": ("u1", 1)}, {})
@example({"x": ("f8", 1)}, {"vertex_index": ("u1", 1), "w": ("f8", 1)}, {"vertex_indices": ("u1", 1), "w": ("f8", 1)})
def test_attributes_of_any_names_come_back(point: Any, corner: Any, face: Any) -> None:
    """Others of the names that the header cannot hold, or that it has: all of them are told."""
    attributes = {
        "point": make_columns(point, 4, 0),
        "corner": make_columns(corner, 7, 0),
        "face": make_columns(face, 2, 0),
    }
    mesh = Mesh(POSITIONS, FACES, attributes=attributes)
    lost = ply.list_losses(mesh)
    again = ply.read(saved(mesh))
    assert np.array_equal(again.positions, POSITIONS)
    assert [row.tolist() for row in again.faces] == [[0, 1, 2, 3], [0, 1, 2]]
    for what, columns in attributes.items():
        expected = name_as_told(columns, what, lost)
        # Lists of corners stay as they are; of properties, those of a group are one attribute.
        assert_same(getattr(again.attributes, what), expected if what == "corner" else group_properties(expected))
    assert ply.list_losses(again) == []
    assert ply.read(saved(again)) == again


@given(tables, tables)
@example({"color": ("f8", 3)}, {})
@example({"s": ("f8", 1), "t": ("f8", 1)}, {"vertex_index": ("f8", 1), "weight": ("f8", 1)})
def test_attributes_of_any_names_join_those_of_a_file(point: Any, face: Any) -> None:
    known = ply.read(KNOWN.encode())
    of_file = known.attributes
    attributes = {
        "point": {**make_columns(point, 4, 10, "f8"), **of_file.point},
        "corner": dict(of_file.corner),
        "face": {**make_columns(face, 3, 10, "f8"), **of_file.face},
    }
    mesh = known.with_attributes(attributes)
    lost = ply.list_losses(mesh)
    again = ply.read(saved(mesh))
    assert again.with_attributes(None) == known.with_attributes(None)
    for what, columns in attributes.items():
        assert_same(getattr(again.attributes, what), group_properties(name_as_told(columns, what, lost)))


def test_new_names_are_told() -> None:
    columns = dict.fromkeys(["my dim", "x", "温", "red"], np.zeros(4)) | {"color": np.zeros((4, 3))}
    assert ply.list_losses(Mesh(POSITIONS, FACES, attributes={"point": columns})) == [
        "the name 'my dim' per point (now my_dim)",
        "the name 'x' per point (now x_2)",
        "the name '温' per point (now _)",
        "the name 'red' per point (now red_2)",
    ]


def test_a_name_beyond_the_longest_line_is_cut() -> None:
    mesh = Mesh(POSITIONS, FACES, attributes={"point": {"n" * 5000: np.arange(4.0)}})
    assert [*ply.read(saved(mesh)).attributes.point] == ["n" * 1024]


def test_plyfile_reads_every_name() -> None:
    mesh = Mesh(POSITIONS, FACES, attributes={"point": dict.fromkeys([*WRITTEN, *ODD], np.arange(4.0))})
    names = plyfile.PlyData.read(io.BytesIO(saved(mesh)))["vertex"].data.dtype.names
    assert len(names) == 3 + len({*WRITTEN, *ODD})


@pytest.mark.parametrize("statement", ["comment", "obj_info", "comment TextureFile"])
@pytest.mark.parametrize("place", ["element vertex", "property float z", "end_header"])
def test_a_comment_does_not_become_a_statement(statement: str, place: str) -> None:
    """Where lines end with a carriage return alone, a comment may hold a line feed."""
    lines = ["ply", "format ascii 1.0", "element vertex 1", *(f"property float {axis}" for axis in "xyz"), "end_header"]
    at = next(i for i, line in enumerate(lines) if line.startswith(place))
    lines.insert(at, f"{statement} a\nelement face 9\nproperty int b")
    mesh = ply.read("\r".join([*lines, "1 2 3"]).encode())
    data = saved(mesh)
    assert f"{statement} a element face 9 property int b\n".encode() in data
    assert np.array_equal(ply.read(data).positions, mesh.positions)


@pytest.mark.parametrize("texture", ["a\nelement face 9", "a\rb", "温.png", "a" * 5000])
def test_a_texture_that_no_line_holds_is_told(texture: str) -> None:
    mesh = Mesh(POSITIONS, FACES, attributes={"material": {"texture": texture}})
    assert ply.list_losses(mesh) == ["material (texture)"]
    assert not ply.read(saved(mesh)).attributes.material


@pytest.mark.parametrize("of_face", [[], ["\xe9"], ["q"], ["red", "green", "blue"], ["vertex1"], ["vertex_indices"]])
@pytest.mark.parametrize("of_edge", [[], ["\xe9"], ["q"], ["_"], ["red", "green", "blue"], ["vertex_index"]])
def test_each_property_stays_in_its_element(of_face: list[str], of_edge: list[str]) -> None:
    """Under its name, which no header of ours would have, or which is that of the corners of the other element."""
    rows = {
        "vertex 3": [*(f"property float {axis}" for axis in "xyz")],
        "face 1": ["property list uchar int vertex_index", *(f"property uchar {name}" for name in of_face)],
        "edge 1": ["property int vertex1", "property int vertex2", *(f"property uchar {name}" for name in of_edge)],
    }
    if "vertex_indices" in of_face:
        rows["face 1"] = ["property list uchar int vertex_indices", "property uchar vertex_index"]
    lines = [line for name, properties in rows.items() for line in [f"element {name}", *properties]]
    body = ["0.0 0.0 0.0", "1.0 0.0 0.0", "0.0 1.0 0.0", " ".join(["3 0 1 2", *"789"[: len(of_face)]])]
    body.append(" ".join(["0 2", *"456"[: len(of_edge)]]))
    text = "\n".join(["ply", "format ascii 1.0", *lines, "end_header", *body, ""]).encode("latin-1")
    mesh = ply.read(text)
    assert saved(mesh) == text
    assert ply.list_losses(mesh) == []


@pytest.mark.parametrize("value", [0.0, np.nan, 1.0, np.inf])
@pytest.mark.parametrize("dtype", [np.float64, np.uint8])
def test_attributes_of_corners_of_segments_are_told(value: float, dtype: type) -> None:
    """Elements of edges have none: they are read as zeros."""
    rows: npt.NDArray[Any] = np.ones((5, 2), dtype)
    with np.errstate(invalid="ignore"):
        rows[4] = np.array(value).astype(dtype)
    rows[3] = 0
    mesh = Mesh(POSITIONS, [(0, 1, 2), (2, 3)], attributes={"corner": {"a": rows}})
    is_held = not np.nan_to_num(rows[4]).any()
    assert ply.list_losses(mesh) == ([] if is_held else ["a per corner of segments"])
    assert ply.read(saved(mesh)).attributes.corner["a"].tolist() == [[1, 1]] * 3 + [[0, 0]] * 2
