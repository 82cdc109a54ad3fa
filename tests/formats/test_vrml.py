import gzip
import io
import math
import re
from pathlib import Path

import numpy as np
import pytest

from gpu_xform import samples
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import limits, load_mesh, vrml, vrml_shapes
from gpu_xform.geometry.mesh import Mesh
from tests.support.cost import within_cpu_s

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
    for _ in within_cpu_s(10.0):
        read = vrml.read(text)
    assert read == mesh.with_attributes({"face": {"color": np.tile([0.5, 1.0, 0.0], (mesh.n_faces, 1))}})


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
    assert mesh.n_faces == 8 + 6
    assert mesh.positions[-14:-8].tolist() == [[0, 0, 1], [1, 0, 1], [0, 1, 1], [0, 0, 1], [2, 0, 1], [0, 2, 1]]


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
        ("Group { }", "no shapes: it needs a face set"),
        ("", "no shapes"),
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
    for _ in within_cpu_s(20.0):
        with pytest.raises(MeshError, match=r"expands to more than .* nodes, the limit FileLimits\(nodes=\.\.\.\)"):
            v2(f"DEF L0 <shape>\n{nest}")
        big = with_shape("0 1 2", "0 1 2 -1 " * 50_000)
        moved = "".join(f"Transform {{ translation {i} 0 0 children USE B }}\n" for i in range(1000))
        with pytest.raises(MeshError, match=r"expands to more than .* numbers, the limit FileLimits\(points=\.\.\.\)"):
            v2(f"DEF B {big}\n{moved}")


def shape(geometry: str) -> str:
    return f"Shape {{ geometry {geometry} }}\n"


def volume(mesh: Mesh) -> float:
    return float(mesh.to_trimesh().volume)


def move(x: float, children: str) -> str:
    return f"Transform {{ translation {x} 0 0 children [ {children} ] }}\n"


N = vrml_shapes.N_SIDES
POLYGON = N / 2 * math.sin(2 * math.pi / N)  # the area of the polygon that stands for a circle of radius 1


@pytest.mark.parametrize(
    ("geometry", "expected", "bounds"),
    [
        ("Box { }", 8.0, [[-1, -1, -1], [1, 1, 1]]),
        ("Box { size 1 2 3 }", 6.0, [[-0.5, -1, -1.5], [0.5, 1, 1.5]]),
        ("Cylinder { radius 2 height 3 }", POLYGON * 4 * 3, [[-2, -1.5, -2], [2, 1.5, 2]]),
        ("Cone { bottomRadius 2 height 3 }", POLYGON * 4 * 3 / 3, [[-2, -1.5, -2], [2, 1.5, 2]]),
        ("Extrusion { }", 4.0, [[-1, 0, -1], [1, 1, 1]]),
        ("Extrusion { spine [ 0 0 0 3 0 0 ] }", 12.0, [[0, -1, -1], [3, 1, 1]]),
        ("Extrusion { spine [ 0 0 0 0 -2 0 ] scale 2 0.5 }", 8.0, [[-2, -2, -0.5], [2, 0, 0.5]]),
        ("Extrusion { orientation 0 1 0 0.7853981633974483 }", 4.0, [[-(2**0.5), 0, -(2**0.5)], [2**0.5, 1, 2**0.5]]),
        ("Extrusion { scale [ 1 1 0 0 ] }", 4.0 / 3.0, [[-1, 0, -1], [1, 1, 1]]),
    ],
)
def test_primitives_are_solids_the_right_way_out(geometry: str, expected: float, bounds: list[list[float]]) -> None:
    mesh = v2(shape(geometry))
    assert mesh.to_trimesh().is_watertight
    assert volume(mesh) == pytest.approx(expected)
    assert mesh.bounds == pytest.approx(np.array(bounds), abs=1e-12)


def test_a_sphere_is_that_of_trimesh() -> None:
    mesh = v2(shape("Sphere { radius 3 }"))
    assert np.linalg.norm(mesh.positions, axis=1) == pytest.approx(np.full(mesh.n_points, 3.0))
    assert mesh.to_trimesh().is_watertight
    assert volume(mesh) == pytest.approx(36 * math.pi, rel=0.02)
    assert mesh.bounds == pytest.approx(np.array([[-3] * 3, [3] * 3]), abs=1e-12)


def test_parts_of_primitives_can_be_left_out() -> None:
    assert v2(shape("Cone { side FALSE }")).n_faces == 1
    assert v2(shape("Cone { bottom FALSE }")).n_faces == N
    assert v2(shape("Cylinder { top FALSE bottom FALSE }")).n_faces == N
    assert v2(shape("Extrusion { beginCap FALSE endCap FALSE }")).n_faces == 4
    assert v1("Cylinder { parts (SIDES | TOP) }").n_faces == N + 1
    assert v1("Cylinder { parts BOTTOM }").n_faces == 1
    assert v1("Cone { parts ALL }").n_faces == N + 1
    with pytest.raises(MeshError, match="no shapes"):
        v2(shape("Cone { side FALSE bottom FALSE }"))


def test_primitives_of_vrml_1() -> None:
    mesh = v1("Translation { translation 5 0 0 } Cube { width 2 height 4 depth 6 }")
    assert mesh.bounds.tolist() == [[4, -2, -3], [6, 2, 3]]
    assert volume(mesh) == pytest.approx(48)
    assert v1("Sphere { radius 2 }").bounds == pytest.approx(np.array([[-2] * 3, [2] * 3]), abs=1e-12)


def test_an_extrusion_along_a_ring_is_a_torus() -> None:
    angles = 2 * np.pi * np.arange(65) / 64
    ring = np.stack([3 * np.cos(angles), 0 * angles, 3 * np.sin(angles)], axis=1)
    ring[-1] = ring[0]
    spine = " ".join(map(repr, ring.ravel().tolist()))
    mesh = v2(shape(f"Extrusion {{ spine [ {spine} ] crossSection [ .5 .5 .5 -.5 -.5 -.5 -.5 .5 .5 .5 ] }}"))
    assert mesh.n_points == 64 * 4
    assert mesh.to_trimesh().is_watertight
    assert volume(mesh) == pytest.approx(2 * math.pi * 3, rel=0.01)  # Pappus
    assert mesh.bounds[:, 1] == pytest.approx([-0.5, 0.5])


def test_an_extrusion_around_a_corner_keeps_its_side_out() -> None:
    # The section turns with the spine, which bends to the right and then back to the left.
    mesh = v2(shape("Extrusion { spine [ 0 0 0, 0 4 0, 4 8 0, 4 12 0 ] crossSection [ 1 1 1 -1 -1 -1 -1 1 1 1 ] }"))
    assert mesh.to_trimesh().is_watertight
    assert volume(mesh) > 0
    assert mesh.bounds[:, 2] == pytest.approx([-1, 1])


def test_an_elevation_grid_looks_up() -> None:
    mesh = v2(shape("ElevationGrid { xDimension 3 zDimension 2 xSpacing 2 zSpacing 5 height [ 0 1 2 3 4 5 ] }"))
    assert mesh.positions.tolist() == [[0, 0, 0], [2, 1, 0], [4, 2, 0], [0, 3, 5], [2, 4, 5], [4, 5, 5]]
    first, second, third = np.moveaxis(mesh.positions[mesh.indices].reshape(-1, 4, 3), 1, 0)[:3]
    normals = np.cross(second - first, third - first)
    assert mesh.n_faces == 2
    assert (normals[:, 1] > 0).all()
    with pytest.raises(MeshError, match="line 2: ElevationGrid of 3 x 2 points has 5 heights"):
        v2(shape("ElevationGrid { xDimension 3 zDimension 2 height [ 0 1 2 3 4 ] }"))


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (shape("Box { }"), 8.0),
        ("Transform { scale -1 1 1 children " + shape("Box { }") + " }", 8.0),
        ("Transform { scale -1 -1 1 children " + shape("Box { }") + " }", 8.0),
        (shape("Extrusion { ccw FALSE }"), -4.0),
        ("Transform { scale 1 1 -1 children " + shape("Extrusion { ccw FALSE solid TRUE convex FALSE }") + " }", -4.0),
    ],
)
def test_mirrors_and_clockwise_faces(body: str, expected: float) -> None:
    assert volume(v2(body)) == pytest.approx(expected)


def test_clockwise_faces_are_reversed() -> None:
    assert faces(v2(shape(f"IndexedFaceSet {{ {POINT_97} ccw FALSE coordIndex [ 0 1 2 ] }}"))) == [[0, 2, 1]]
    hints = "ShapeHints { vertexOrdering CLOCKWISE shapeType SOLID }"
    assert faces(v1(f"<points> Separator {{ {hints} <faces> }} <faces>")) == [[0, 2, 1], [0, 1, 2]]
    with pytest.raises(MeshError, match="line 2: ccw of IndexedFaceSet must be TRUE or FALSE, got 'MAYBE'"):
        v2(shape(f"IndexedFaceSet {{ {POINT_97} ccw MAYBE coordIndex [ 0 1 2 ] }}"))


def test_lines_of_one_point_are_left_out() -> None:
    mesh = v2(shape(f"IndexedLineSet {{ {POINT_97} coordIndex [ 0 -1 0 1 -1 2 -1 1 2 0 ] }}"))
    assert faces(mesh) == [[0, 1], [1, 2], [2, 0]]


def test_point_sets_are_points() -> None:
    mesh = v2(move(2, shape(f"PointSet {{ {POINT_97} }}")))
    assert mesh == Mesh([(2, 0, 0), (3, 0, 0), (2, 1, 0)])
    assert v1("<points> PointSet { }") == Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)])


def test_children_without_the_name_of_their_field() -> None:
    mesh = v2("Transform { translation 1 0 0 <shape> children <shape> <shape> children [ <shape> ] } Group { <shape> }")
    assert mesh.n_faces == 5
    assert mesh.positions[:, 0].tolist() == [1, 2, 1] * 4 + [0, 1, 0]


def test_a_name_defined_among_children_is_known_in_the_order_of_the_file() -> None:
    assert v2("Group { DEF A <shape> children [ USE A ] USE A }").n_faces == 3


PAIR = "PROTO Pair [ field MFNode parts [] field SFVec3f gap 1 0 0 ] { Group { children ["
PAIR += " Group { children IS parts } Transform { translation IS gap children IS parts } ] } }\n"


def test_prototypes_are_expanded() -> None:
    mesh = v2(
        PAIR + "Pair { parts <shape> } Pair { gap 0 5 0 parts [ <shape> Pair { gap 7 0 0 parts <shape> } ] } Pair { }"
    )
    assert mesh.n_faces == 2 + 2 + 4
    assert sorted(mesh.positions[mesh.indices[::3]].tolist()) == sorted(
        [[0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 5, 0], [0, 0, 0], [7, 0, 0], [0, 5, 0], [7, 5, 0]]
    )


def test_prototypes_within_prototypes() -> None:
    inner = "PROTO Inner [ field SFVec3f s 2 2 2 ] { Shape { geometry Box { size IS s } } }"
    group = "Group { children [ Inner { s IS size } Inner { } ] }"
    outer = f"PROTO Outer [ field SFVec3f size 4 4 4 ] {{ {inner} {group} }}"
    mesh = v2(f"{outer} Outer {{ }} Outer {{ size 6 6 6 }}")
    assert [volume(Mesh(mesh.positions, mesh.faces[i : i + 6])) for i in range(0, 24, 6)] == pytest.approx(
        [64, 8, 216, 8]
    )
    # The inner prototype is not known outside.
    with pytest.warns(MeshWarning, match="^not shown: 1 Inner$"):
        v2(f"{outer} Outer {{ }} Inner {{ }}")


def test_prototypes_of_geometry_and_of_coordinates() -> None:
    mesh = v2(
        "PROTO Points [ field MFVec3f at [ 0 0 0 ] ] { Coordinate { point IS at } }"
        "PROTO Tri [ field MFInt32 order [ 0 1 2 ] field SFBool front TRUE ]"
        " { IndexedFaceSet { ccw IS front coordIndex IS order coord Points { at [ 0 0 0 1 0 0 0 1 0 ] } } }"
        "Shape { geometry Tri { } } Shape { geometry Tri { order [ 1 2 0 ] front FALSE } }"
        "Shape { geometry IndexedLineSet { coordIndex [ 0 1 ] coord Points { at [ 5 5 5 6 6 6 ] } } }"
    )
    assert [mesh.positions[face].tolist() for face in mesh.faces] == [
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        [[1, 0, 0], [0, 0, 0], [0, 1, 0]],
        [[5, 5, 5], [6, 6, 6]],
    ]


def test_nodes_of_vrml_1_in_a_file_of_vrml_97() -> None:
    mesh = v2(
        "Separator { Transform { translation 9 0 0 } Group { Translation { translation 0 1 0 } }"
        f" {POINT_1} {FACE_1} <shape> }} <shape>"
    )
    assert mesh.positions[mesh.indices[::3]].tolist() == [[9, 1, 0], [9, 1, 0], [0, 0, 0]]


@pytest.mark.parametrize(
    ("body", "n_faces", "warning"),
    [
        ('<shape> Shape { geometry Text { string "a" } } Shape { geometry Text { } }', 1, "not shown: 2 Text"),
        (
            '<shape> EXTERNPROTO Far [ field SFInt32 n ] "http://x/y.wrl" Far { n 2 }',
            1,
            "not shown: 1 Far (EXTERNPROTO)",
        ),
        ("HAnimJoint { translation 0 0 1 children <shape> }", 1, "shown as groups, by their children: 1 HAnimJoint"),
        (
            "<shape> NurbsPatch { } Odd { <shape> }",
            2,
            "not shown: 1 NurbsPatch; shown as groups, by their children: 1 Odd",
        ),
        ('<shape> Inline { url "http://x/y.wrl" }', 1, "not shown: 1 Inline (not a file beside it: 'http://x/y.wrl')"),
        ("<shape> Inline { }", 1, "not shown: 1 Inline (not a file beside it: no name)"),
        ("<shape> " + " ".join(f"Kind{i} {{ }}" for i in range(10)), 1, "and 2 more"),
    ],
)
def test_what_cannot_be_shown_is_named_once(body: str, n_faces: int, warning: str) -> None:
    with pytest.warns(MeshWarning) as caught:
        mesh = v2(body)
    assert mesh.n_faces == n_faces
    assert [str(one.message) for one in caught] == [warning] or str(caught[0].message).endswith("and 2 more")


def test_a_prototype_that_contains_itself_says_so() -> None:
    for body in ("A { }", "Group { children A { } }", "PROTO B [ ] { A { } } B { }"):
        with pytest.raises(MeshError, match=r"no shapes: not shown: 1 A \(a part of itself\)$"):
            v2(f"PROTO A [ ] {{ {body} }} A {{ }}")
    with pytest.warns(MeshWarning, match=r"^not shown: 1 A \(a part of itself\)$"):
        assert v2("PROTO A [ ] { Group { children [ <shape> A { } ] } } A { }").n_faces == 1


@pytest.mark.parametrize(
    "body",
    [
        "PROTO Group [ ] { Group { children <shape> } } Group { }",  # the node of the language
        "PROTO A [ ] { <shape> } PROTO A [ ] { A { } } A { }",  # the one before
        "PROTO A [ ] { PROTO A [ ] { <shape> } A { } } A { }",  # the one within
    ],
)
def test_a_prototype_may_contain_another_of_its_name(body: str) -> None:
    assert v2(body).n_faces == 1


def test_what_is_silent_is_no_loss() -> None:
    v2("<shape> Viewpoint { } NavigationInfo { } DirectionalLight { } TimeSensor { }")
    v2("<shape> Script { field SFNode n DEF X Group { } } USE X")
    v1("<points> <faces> Material { } PerspectiveCamera { } Info { } Texture2 { } NormalBinding { }")
    with pytest.raises(MeshError, match=r"^no shapes: not shown: 1 Text$"):
        v2(shape("Text { }"))


def test_text_of_vrml_1_is_named() -> None:
    with pytest.warns(MeshWarning, match="not shown: 1 AsciiText"):
        v1('<points> <faces> AsciiText { string "a" }')


def test_files_beside_are_read(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    whole = tmp_path / "whole.wrl"
    whole.write_text(
        '#VRML V2.0 utf8\nTransform { translation 5 0 0 children Inline { url [ "no.wrl" "parts/a%20b.wrl#View" ] } }\n'
    )
    (tmp_path / "parts" / "a b.wrl").write_text(
        f'#VRML V2.0 utf8\n{SHAPE_97}\nInline {{ url "old.wrl" }} Inline {{ url "old.wrl" }}'
    )
    (tmp_path / "parts" / "old.wrl").write_bytes(gzip.compress(f"#VRML V1.0 ascii\n{POINT_1} {FACE_1}".encode()))
    mesh = load_mesh(whole)
    assert mesh.positions[mesh.indices[::3]].tolist() == [[5, 0, 0]] * 3
    old = tmp_path / "old.wrl"
    old.write_text(f'#VRML V1.0 ascii\nSeparator {{ WWWInline {{ name "parts/old.wrl" }} }} {POINT_1} {FACE_1}')
    assert load_mesh(old).n_faces == 2


def test_no_file_elsewhere_is_read(tmp_path: Path) -> None:
    (tmp_path / "secret.wrl").write_text(f"#VRML V2.0 utf8\n{SHAPE_97}")
    folder = tmp_path / "model"
    folder.mkdir()
    for name in (
        "../secret.wrl",
        str(tmp_path / "secret.wrl"),
        f"file:{tmp_path}/secret.wrl",
        "..",
        "a\0b",
        "x" * 5000,
    ):
        (folder / "a.wrl").write_text(f'#VRML V2.0 utf8\n{SHAPE_97} Inline {{ url "{name}" }}')
        with pytest.warns(MeshWarning, match="a.wrl: not shown: 1 Inline \\(not a file beside it"):
            mesh = load_mesh(folder / "a.wrl")
        assert mesh.n_faces == 1


def test_a_file_that_names_itself_or_a_broken_one(tmp_path: Path) -> None:
    (tmp_path / "a.wrl").write_text(f'#VRML V2.0 utf8\n{SHAPE_97} Inline {{ url "b.wrl" }}')
    (tmp_path / "b.wrl").write_text('#VRML V2.0 utf8\nInline { url "a.wrl" }')
    with pytest.warns(MeshWarning, match="of itself: 'b.wrl'"):
        mesh = load_mesh(tmp_path / "a.wrl")
    assert mesh.n_faces == 2
    (tmp_path / "b.wrl").write_text("#VRML V2.0 utf8\nGroup {")
    with pytest.raises(MeshError, match=r"a\.wrl: b\.wrl: line 2: unexpected end of the file"):
        load_mesh(tmp_path / "a.wrl")


@pytest.mark.slow
def test_prototypes_and_primitives_cannot_multiply_without_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    nest = "".join(f"PROTO P{i} [ ] {{ Group {{ children [ {f'P{i - 1} {{ }} ' * 10} ] }} }}\n" for i in range(1, 40))
    for _ in within_cpu_s(20.0):
        with pytest.raises(MeshError, match=r"expands to more than .* nodes, the limit FileLimits\(nodes=\.\.\.\)"):
            v2(f"PROTO P0 [ ] {{ {SHAPE_97} }}\n{nest} P39 {{ }}")
        monkeypatch.setattr(limits, "FREE_NUMBERS", 1 << 18)
        with pytest.raises(MeshError, match=r"expands to more than .* numbers, the limit FileLimits\(points=\.\.\.\)"):
            v2("DEF S " + shape("Sphere { }") + "Group { children [ " + "USE S " * 5000 + "] }")


def test_blanks_before_what_is_no_word_are_passed_once() -> None:
    """A pattern that could divide them in several ways would never end."""
    with pytest.raises(MeshError, match=r"^line 400: unexpected"):
        v1("\n# a comment\n, \t" * 199 + "\x01")


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("PROTO P [ field!SFFloat x 1 ] { Group { } }", "field!SFFloat"),
        ("PROTO P [ field SFFloat x 1 exposedField`SFFloat y 1 ] { Group { } }", "exposedField`SFFloat"),
        ("ROUTE A.x TO.y", "TO.y"),
    ],
)
def test_a_keyword_is_a_whole_word(text: str, word: str) -> None:
    """ISO 14772-1, A.3: an Id may hold `!`, `$` and the like, so these are names; and none begins with a period."""
    with pytest.raises(MeshError, match=re.escape(f"line 2: unexpected {word!r}")):
        load_mesh(io.BytesIO(f"#VRML V2.0 utf8\n{text} Shape {{ geometry Box {{ }} }}".encode()), file_type="wrl")
