import gzip
import math
import time

import numpy as np
import pytest

from gpu_xform import samples
from gpu_xform.errors import MeshError
from gpu_xform.formats import vrml
from gpu_xform.geometry.mesh import Mesh

POINT_97 = "coord Coordinate { point [0 0 0, 1 0 0, 0 1 0] }"
SHAPE_97 = f"Shape {{ geometry IndexedFaceSet {{ {POINT_97} coordIndex [0 1 2] }} }}"
POINT_1 = "Coordinate3 { point [0 0 0, 1 0 0, 0 1 0] }"
FACE_1 = "IndexedFaceSet { coordIndex [0, 1, 2, -1] }"


def v1(body: str) -> Mesh:
    body = body.replace("<points>", POINT_1).replace("<faces>", FACE_1)
    return vrml.read(f"#VRML V1.0 ascii\n{body}".encode())


def v2(body: str) -> Mesh:
    return vrml.read(("#VRML V2.0 utf8\n" + body.replace("<shape>", SHAPE_97)).encode())


def with_shape(old: str, new: str) -> str:
    """Return the shape with a piece of its text replaced."""
    assert old in SHAPE_97
    return SHAPE_97.replace(old, new)


def faces(mesh: Mesh) -> list[list[int]]:
    return [face.tolist() for face in mesh.faces]


HART = """#VRML V1.0 ascii

Separator {
  Info { string "made by # \\"hand\\"" }
  Coordinate3 { point [
    %s ] }
%s
}
"""
HART_FACES = """
  Material { diffuseColor 0.5 1 0 }
  IndexedFaceSet { coordIndex [
    %s ]
  }
"""


def in_hart_style(mesh: Mesh) -> str:
    """Return a solid as one Coordinate3 and one IndexedFaceSet for each size of face, a colour before each."""
    points = ",\n    ".join("{!r} {!r} {!r}".format(*point) for point in mesh.positions.tolist())
    sets = ""
    for size in np.unique(np.diff(mesh.offsets)):
        rows = [", ".join(map(str, face)) + ", -1" for face in mesh.faces if len(face) == size]
        sets += HART_FACES % ",\n    ".join(rows)
    return HART % (points, sets)


@pytest.mark.parametrize("mesh", [samples.snub_dodecahedron(), samples.house()])
def test_solids_in_the_style_of_hart(mesh: Mesh) -> None:
    read = vrml.read(in_hart_style(mesh).encode())
    assert np.array_equal(read.positions, mesh.positions)
    assert np.array_equal(read.edges, mesh.edges)
    assert sorted(faces(read)) == sorted(faces(mesh))


@pytest.mark.slow
def test_a_hundred_thousand_vertices_take_no_token_each() -> None:
    mesh = samples.icosphere(7)
    text = in_hart_style(mesh).encode()
    start = time.process_time()
    assert vrml.read(text) == mesh
    assert time.process_time() - start < 10.0


def test_state_of_vrml_1() -> None:
    # Each separator restores the coordinates and the matrix; a group does not.
    mesh = v1("""
    Separator {
      <points>
      Translation { translation 5 0 0 }
      Separator { Translation { translation 0 7 0 } <faces> }
      <faces>
    }
    <points>
    Group { Translation { translation 0 0 9 } }
    TransformSeparator { Translation { translation 100 0 0 } Coordinate3 { point [1 1 1, 2 2 2] } }
    IndexedLineSet { coordIndex [0, 1] }
    """)
    assert mesh.positions.tolist() == [
        *([5, 7, 0], [6, 7, 0], [5, 8, 0]),
        *([5, 0, 0], [6, 0, 0], [5, 1, 0]),
        *([1, 1, 10], [2, 2, 11]),
    ]
    assert faces(mesh) == [[0, 1, 2], [3, 4, 5], [6, 7]]


def test_later_transforms_of_vrml_1_apply_first() -> None:
    turn = f"Rotation {{ rotation 0 0 1 {math.pi / 2!r} }}"
    move, grow = "Translation { translation 10 0 0 }", "Scale { scaleFactor 2 3 4 }"
    mesh = v1(f"{turn} {move} {grow} Coordinate3 {{ point 1 1 1 }} IndexedLineSet {{ coordIndex [0 0] }}")
    assert mesh.positions[0].tolist() == pytest.approx([-3, 12, 4])


@pytest.mark.parametrize("length", [1e-200, 1.0, 1.5e308])
def test_an_axis_may_have_any_length(length: float) -> None:
    turn = f"Rotation {{ rotation {length!r} {length!r} 0 {math.pi!r} }}"
    mesh = v1(f"{turn} Coordinate3 {{ point 1 0 3 }} IndexedLineSet {{ coordIndex [0 0] }}")
    assert mesh.positions[0].tolist() == pytest.approx([0, 1, -3], abs=1e-14)


def test_matrix_transform_is_for_row_vectors() -> None:
    mesh = v1(
        "MatrixTransform { matrix 0 1 0 0  -1 0 0 0  0 0 2 0  5 6 7 1 }"
        "Coordinate3 { point [1 2 3] } IndexedLineSet { coordIndex [0, 0] }"
    )
    assert mesh.positions.tolist() == [[-2 + 5, 1 + 6, 6 + 7]]


@pytest.mark.parametrize(("version", "scale"), [(1, "scaleFactor"), (2, "scale")])
def test_all_fields_of_a_transform(version: int, scale: str) -> None:
    fields = (
        f"center 1 2 3 rotation 0 1 0 {math.pi / 2!r} {scale} 2 3 4 scaleOrientation 0 0 1 {math.pi / 2!r} "
        "translation 10 20 30"
    )
    if version == 1:
        mesh = v1(f"Transform {{ {fields} }} Coordinate3 {{ point [2 4 6] }} IndexedLineSet {{ coordIndex [0 0] }}")
    else:
        line = "Shape { geometry IndexedLineSet { coord Coordinate { point [2 4 6] } coordIndex [0 0] } }"
        mesh = v2(f"Transform {{ {fields} children {line} }}")
    # From the center (1, 2, 3), then x scaled by 3 and y by 2, z by 4, (x, y, z) -> (z, y, -x), back and on.
    assert mesh.positions[0].tolist() == pytest.approx([3 * 4 + 1 + 10, 2 * 2 + 2 + 20, -1 * 3 + 3 + 30])


@pytest.mark.parametrize(
    ("switch", "expected"),
    [("", 0), ("whichChild 1", 1), ("whichChild -3", 3), ("whichChild -1", 0), ("whichChild 9", 0)],
)
def test_switch_of_vrml_1(switch: str, expected: int) -> None:
    mesh = v1(f"<points> <faces> Switch {{ {switch} <faces> <faces> <faces> }}")
    assert mesh.n_faces == 1 + expected


def test_groups_of_vrml_1_that_show_one_child() -> None:
    assert v1('<points> LOD { range [1] <faces> <faces> } WWWAnchor { name "x" <faces> }').n_faces == 2


def test_nodes_of_vrml_97() -> None:
    mesh = v2("""
    PROTO Thing [ field SFFloat x 3 eventIn SFBool b exposedField MFNode c [] field SFNode n NULL ]
      { DEF Hidden Group { children IS c } <shape> ROUTE a.b TO c.d }
    EXTERNPROTO Other [ field SFInt32 x eventIn SFTime t ] [ "urn:x" "b.wrl" ]
    WorldInfo { title "a \\" # } ]" info [ "x", "y" ] }
    Script {
      url "javascript: f() { x = [1, 2]; }"
      eventIn SFBool in field SFNode n NULL eventOut SFInt32 o directOutput TRUE
    }
    DEF S <shape>
    Thing { x 4 n Group { children [ <shape> ] } }
    Anchor { url "x" children [ <shape> ] }
    Billboard { axisOfRotation 0 0 0 children <shape> }
    Collision { collide FALSE children [ <shape> ] proxy <shape> }
    LOD { range [ 1 2 ] level [ <shape> <shape> Group { } ] }
    Switch { whichChoice 1 choice [ Group { } <shape> <shape> ] }
    Switch { choice [ <shape> ] }
    Switch { whichChoice 7 choice [ <shape> ] }
    Transform { translation 0 0 1 children [ USE S Transform { scale 2 2 2 children USE S } ] }
    Shape { appearance Appearance { material Material { diffuseColor 1 0 0 } } }
    Shape { geometry Box { size 1 2 3 } }
    ROUTE S.out TO S.in
    """)
    assert mesh.n_faces == 8
    assert mesh.positions[-6:].tolist() == [[0, 0, 1], [1, 0, 1], [0, 1, 1], [0, 0, 1], [2, 0, 1], [0, 2, 1]]


def test_names_in_a_prototype_stay_there() -> None:
    body = "PROTO P [] { DEF A Group { } } Transform { children USE A } <shape>"
    with pytest.raises(MeshError, match="line 2: USE 'A', but no node before it has that name"):
        v2(body)


def test_coordinates_that_are_used_again_give_no_new_points() -> None:
    mesh = v2(
        "Shape { geometry IndexedFaceSet { coord DEF C Coordinate { point [0 0 0 1 0 0 0 1 0] } coordIndex [0 1 2] } }"
        "Shape { geometry IndexedLineSet { coord USE C coordIndex [0 1 2 0 -1 1 2] } }"
    )
    assert mesh.n_points == 3
    assert faces(mesh) == [[0, 1, 2], [0, 1], [1, 2], [2, 0], [1, 2]]
    assert len(mesh.edges) == 3


@pytest.mark.parametrize(
    "index",
    [
        *("[0 1 2]", "[0 1 2 -1]", "[-1 0 1 2 -1 -1]", "[0,1,2]", "[0x0 0X1 2]", "[+0 1 2]"),
        "[ 0 # a [ } comment\n,, 1\t2 # 3\n]",
    ],
)
def test_lists_of_numbers(index: str) -> None:
    for end in ("\n", "\r\n", "\r"):
        text = f"#VRML V1.0 ascii\nCoordinate3{{point[0 0 0,1e0 .0 0.#x\n0 1 0]}}IndexedFaceSet{{coordIndex{index}}}"
        mesh = vrml.read(text.replace("\n", end).encode())
        assert mesh == Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])


def test_encodings() -> None:
    text = f"#VRML V2.0 utf8\n# \xe9\nDEF \xe9 {SHAPE_97}"
    expected = v2(SHAPE_97)
    for encoding in ("utf-8", "latin-1", "utf-8-sig"):
        assert vrml.read(text.encode(encoding)) == expected
    packed = gzip.compress(text.encode())
    assert vrml.read(packed) == expected
    assert vrml.read(packed + gzip.compress(b"# more")) == expected
    for damaged in (packed[:-9], packed[:40] + b"\xff" + packed[41:], packed[:5]):
        with pytest.raises(MeshError, match="gzip compression is damaged"):
            vrml.read(damaged)


def test_what_gzip_unpacks_to_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vrml, "_MAX_DECOMPRESSED_BYTES", 1 << 20)
    with pytest.raises(MeshError, match="decompresses to more than 1048576 bytes"):
        vrml.read(gzip.compress(b"#VRML V2.0 utf8" + b" " * (1 << 20)))


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("Group { children [ USE X ] }", "line 2: USE 'X', but no node before it has that name"),
        ("DEF A Group {\nchildren USE A }", "line 3: USE 'A', but no node before it has that name"),
        ("Group {\n\nchildren [\n", "line 4: unexpected end of the file"),
        ("Group }", "line 2: unexpected '}'"),
        ('Group { children [ "abc ] }', "line 2: unexpected '\"abc ] }'"),
        (with_shape("1 0 0", "1 0"), "line 2: the number of values must be a multiple of 3, got 8"),
        (with_shape("1 0 0", "1 0\n0.0.0"), "line 3: expected a number, got '0.0.0'"),
        (with_shape("1 0 0", "1 0 1e999"), "line 2: a number must be finite, got inf"),
        (with_shape("1 0 0", "1 0 -nan"), "line 2: a number must be finite, got nan"),
        (with_shape("0 1 2", "0 1\n3"), "line 3: index 3 is out of range, there are 3 points"),
        (with_shape("0 1 2", "0 1\n-2 2"), "line 3: index -2 is out of range"),
        (with_shape("0 1 2", "0x0 1\n# 2\n9"), "line 4: index 9 is out of range"),
        (with_shape("0 1 2", "0 1 2.0"), "line 2: expected an integer, got '2.0'"),
        (with_shape("0 1 2", "0 1 0xg"), "line 2: expected an integer, got '0xg'"),
        (with_shape("0 1 2", "0 1 -1 \n 2 -1"), "line 3: IndexedFaceSet needs at least 2 indices before each -1"),
        (with_shape(POINT_97, ""), "line 2: IndexedFaceSet has no coordinates"),
        (with_shape("point", "nopoint"), "line 2: index 0 is out of range, there are 0 points"),
        ("Transform { rotation 0 0 0 1 children <shape> }", "line 2: rotation by 1.0 needs an axis"),
        ("Transform { translation 0 0 children <shape> }", "the number of values must be a multiple of 3"),
        ("Transform { scale 0 0 0 1 1 1 children <shape> }", "line 2: scale needs 3 numbers, got 6"),
        ("Group { }", "no IndexedFaceSet and no IndexedLineSet with coordinates"),
        ("", "no IndexedFaceSet"),
    ],
)
def test_errors_of_vrml_97_name_the_line(body: str, message: str) -> None:
    with pytest.raises(MeshError) as caught:
        v2(body)
    assert message in str(caught.value)


def test_errors_of_vrml_1() -> None:
    with pytest.raises(MeshError, match="line 2: IndexedFaceSet has no coordinates"):
        v1("Separator { <points> } <faces>")
    with pytest.raises(MeshError, match="line 2: a MatrixTransform must end its rows with 0 0 0 1"):
        v1("<points> MatrixTransform { matrix 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1 } <faces>")
    for text in ("", "#VRML V3.0 utf8\n", "#X3D V3.0 utf8", "Group { }"):
        with pytest.raises(MeshError, match=r"line 1: expected '#VRML V1\.0 ascii' or '#VRML V2\.0 utf8', got"):
            vrml.read(text.encode())


@pytest.mark.slow
@pytest.mark.parametrize("depth", [300, 10_000])
def test_no_depth_of_nesting_exhausts_a_stack(depth: int) -> None:
    assert v2("Group { children [ " * depth + SHAPE_97 + " ] }" * depth).n_faces == 1
    assert v1(POINT_1 + "Separator { " * depth + FACE_1 + " }" * depth).n_faces == 1
    with pytest.raises(MeshError, match="unexpected end"):
        v2("Group { children [ " * depth)


@pytest.mark.slow
def test_use_cannot_multiply_without_bound() -> None:
    nest = "".join(f"DEF L{i} Group {{ children [ {f'USE L{i - 1} ' * 10} ] }}\n" for i in range(1, 40))
    start = time.process_time()
    with pytest.raises(MeshError, match="USE multiplies the scene beyond 262144 nodes"):
        v2(f"DEF L0 <shape>\n{nest}")
    big = with_shape("0 1 2", "0 1 2 -1 " * 50_000)
    moved = "".join(f"Transform {{ translation {i} 0 0 children USE B }}\n" for i in range(1000))
    with pytest.raises(MeshError, match="USE multiplies the scene beyond 33554432 numbers"):
        v2(f"DEF B {big}\n{moved}")
    assert time.process_time() - start < 20.0
