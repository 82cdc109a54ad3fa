"""A shape that is shown often is read twice at most, and is what it would be if it were written out each time."""

import io
import warnings
from itertools import product
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import vrml, vrml_builder, vrml_values
from gpu_xform.geometry.mesh import Mesh
from tests.support.cost import within_cpu_s
from tests.support.types import Array

POINTS = "coord Coordinate { point [0 0 0, 1 0 0, 1 1 0, 0 1 0.5] }"
LOOKS = "color Color { color [1 0 0, 0 1 0, 0 0 1, 1 1 0] } normal Normal { vector [0 0 1, 0 1 0, 1 0 0, 0.6 0 0.8] }"
TEXCOORD = "texCoord TextureCoordinate { point [0 0, 1 0, 1 1, 0 1] }"
RED = "appearance Appearance { material Material { diffuseColor 1 0 0 transparency 0.5 } }"
PROTOTYPE = f"""
PROTO P [ field MFInt32 index [0 1 2] field MFVec3f points [0 0 0, 1 0 0, 0 1 0] field SFColor tint 0 0 1 ] {{
  Shape {{ appearance Appearance {{ material Material {{ diffuseColor IS tint }} }}
    geometry IndexedFaceSet {{ coord Coordinate {{ point IS points }} coordIndex IS index }} }} }}
PROTO Q [ field MFInt32 list [2 1 0] ] {{ Group {{ children [
  P {{ index IS list }} Shape {{ {RED} geometry Box {{ }} }} P {{ }} ] }} }}
"""
SHAPES_97 = {
    "faces": f"Shape {{ geometry IndexedFaceSet {{ {POINTS} coordIndex [0 1 2 -1 0 2 3] }} }}",
    "coloured corners": f"Shape {{ geometry IndexedFaceSet {{ {POINTS} {LOOKS} {TEXCOORD} coordIndex [0 1 2 3] }} }}",
    "coloured faces": f"Shape {{ geometry IndexedFaceSet {{ {POINTS} {LOOKS} colorPerVertex FALSE "
    "normalPerVertex FALSE coordIndex [0 1 2 -1 0 2 3 -1] colorIndex [2 1] } }",
    "misfits": f"Shape {{ {RED} geometry IndexedFaceSet {{ {POINTS} coordIndex [0 1 2] "
    "normal Normal { vector [0 0 1] } } }",
    "lines": f"Shape {{ geometry IndexedLineSet {{ {POINTS} coordIndex [0 1 2 -1 3 0] "
    "color Color { color [1 0 0, 0 1 0] } colorPerVertex FALSE } }",
    "a grid": f"Shape {{ {RED} geometry ElevationGrid {{ {LOOKS} "
    "xDimension 2 zDimension 2 height [0 1 2 4] xSpacing 3 } }",
    "an extrusion": f"Shape {{ {RED} geometry Extrusion {{ }} }}",
    "a cone": f"Shape {{ {RED} geometry Cone {{ side FALSE }} }}",
    "an instance": "P { tint 0 1 0 }",
    "a plain instance": "P { }",
    "an instance of instances": "Q { list [1 0 2] }",
}
PLACES_97 = {
    "as it is": "{}",
    "moved": "Transform {{ translation 1 2 3 children [ {} ] }}",
    "turned": "Transform {{ rotation 0 1 1 2 children [ {} ] }}",
    "mirrored": "Transform {{ scale 1 -2 1 children [ {} ] }}",
}
SHAPES_1 = {
    "faces": "IndexedFaceSet { coordIndex [0, 1, 2, -1, 0, 2, 3, -1] }",
    "indexed faces": "IndexedFaceSet { coordIndex [0, 1, 2] materialIndex [1, 0, 1] normalIndex [2, 1, 0] }",
    "lines": "IndexedLineSet { coordIndex [0, 1, 2, -1] }",
    "a cube": "Cube { width 3 }",
    "a cylinder": "Cylinder { parts (SIDES | TOP) }",
}
STATES_1 = {
    "as it is": "",
    "other points": "Coordinate3 { point [9 0 0, 8 0 0, 7 7 0, 6 0 6] }",
    "a material": "Material { diffuseColor [0 1 0, 0 0 1, 1 0 1] emissiveColor [1 1 0] } "
    "MaterialBinding { value PER_PART }",
    "bound to corners": "Material { diffuseColor [0 1 0, 0 0 1] } MaterialBinding { value PER_VERTEX_INDEXED }",
    "normals": "Normal { vector [0 0 1, 0 1 0, 1 0 0, 1 1 1] }",
    "normals of faces": "Normal { vector [0 0 1, 0 1 0] } NormalBinding { value PER_FACE }",
    "clockwise": "ShapeHints { vertexOrdering CLOCKWISE }",
    "mirrored": "Scale { scaleFactor 1 1 -1 }",
}


def read(text: str) -> Mesh:
    with warnings.catch_warnings(action="ignore"):  # one shape has an attribute that does not fit
        return vrml.read(text.encode())


def at_corners(mesh: Mesh) -> dict[str, Array]:
    """Return points and attributes at each corner, for shapes that USE one list share points."""
    found = {"point": mesh.positions[mesh.indices], "size": np.diff(mesh.offsets)}
    found |= {name: table[mesh.indices] for name, table in mesh.attributes.point.items()}
    found |= mesh.attributes.corner
    found |= {f"{name} of faces": table for name, table in mesh.attributes.face.items()}
    return found


def assert_same(one: Mesh, other: Mesh) -> None:
    found, expected = at_corners(one), at_corners(other)
    assert found.keys() == expected.keys()
    for name, table in found.items():
        assert np.array_equal(table, expected[name], equal_nan=True), name


@pytest.mark.parametrize("name", SHAPES_97)
def test_shapes_of_vrml_97_that_are_used_again_are_what_they_are_written_out(name: str) -> None:
    shape = SHAPES_97[name]
    for places in product(PLACES_97.values(), repeat=3):
        layout = (
            "#VRML V2.0 utf8\n"
            + PROTOTYPE
            + "{first}\n"
            + "\n".join(place.format(" ".join(["{again}"] * 3)).replace("{{", "{{{{") for place in places)
        )
        text = layout.replace("{first}", f"DEF S {shape}").replace("{again}", "USE S")
        written = layout.replace("{first}", shape).replace("{again}", shape)
        assert_same(read(text), read(written))


@pytest.mark.parametrize("name", SHAPES_1)
def test_shapes_of_vrml_1_that_are_used_again_have_the_looks_of_their_place(name: str) -> None:
    shape = SHAPES_1[name]
    for states in product(STATES_1.values(), repeat=2):
        head = "#VRML V1.0 ascii\nCoordinate3 { point [0 0 0, 1 0 0, 1 1 0, 0 1 0.5] } "
        bodies = [
            head
            + first
            + " ".join(
                f" {again} {again} Separator {{ {state} {again} {again} }} {again} {again} {state}" for state in states
            )
            + f" {again} {again}"
            for first, again in ((f"DEF S {shape}", "USE S"), (shape, shape))
        ]
        assert_same(*map(read, bodies))


def count_calls(monkeypatch: pytest.MonkeyPatch, owner: Any, name: str) -> list[None]:
    calls: list[None] = []
    known = getattr(owner, name)

    def call(*arguments: Any) -> Any:
        calls.append(None)
        return known(*arguments)

    monkeypatch.setattr(owner, name, call)
    return calls


def test_a_shape_is_read_twice_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    faces = f"Shape {{ {RED} geometry IndexedFaceSet {{ {POINTS} {LOOKS} coordIndex [0 1 2 3] }} }}"
    moved = "".join(f"Transform {{ translation {i} 0 0 rotation 1 0 0 1 children USE S }}\n" for i in range(500))
    reads = count_calls(monkeypatch, vrml_builder, "read_indexed")
    assert read(f"#VRML V2.0 utf8\nDEF S {faces}\n{moved}").n_faces == 501
    assert len(reads) == 2
    reads.clear()
    instances = "".join(f"Transform {{ translation {i} 0 0 children P {{ }} }}\n" for i in range(500))
    assert read(f"#VRML V2.0 utf8\n{PROTOTYPE}{instances}").n_faces == 500
    assert len(reads) == 2


def test_a_list_that_is_malformed_for_one_shape_is_so_for_all(monkeypatch: pytest.MonkeyPatch) -> None:
    reads = count_calls(monkeypatch, vrml_values.Numbers, "_read_finite")
    bad = f"DEF C Coordinate {{ point [0 0 0 1 1 1] }} DEF K Color {{ color [1e999 0 0 {'0 0 0 ' * 100}] }}"
    shapes = "Shape { geometry IndexedFaceSet { coord USE C color USE K coordIndex [0 1] } }\n" * 300
    with pytest.warns(MeshWarning, match="colours of 300 shapes$"):
        assert vrml.read(f"#VRML V2.0 utf8\n{bad}{shapes}".encode()).n_faces == 300
    assert len(reads) == 1


def find_least_limit(name: str, text: str) -> int:
    """Return the least limit of a kind that a file passes."""
    for limit in range(1, 200):
        try:
            gx.load_mesh(io.BytesIO(text.encode()), file_type="wrl", limits=gx.FileLimits(**{name: limit}))
        except MeshError:
            continue
        return limit
    raise AssertionError(f"no {name} are enough")


@pytest.mark.parametrize("name", ["nodes", "points"])
def test_what_is_not_read_again_counts_as_often_as_it_is_shown(name: str) -> None:
    indices = " ".join(["0 1 0"] * 40)
    shape = (
        "Shape { geometry IndexedFaceSet { coord USE C coordIndex [0 1 0] color Color { color [1 0 0, 0 1 0] } "
        f"colorIndex [{indices}] normal Normal {{ vector [0 0 1, 0 1 0] }} }} }}\n"
    )
    head = "#VRML V2.0 utf8\nDEF C Coordinate { point [0 0 0, 1 1 1] }\n"
    used = find_least_limit(name, head + "DEF S " + shape + "USE S " * 4)
    assert used == find_least_limit(name, head + shape * 5)


def test_each_instance_of_a_prototype_counts_all_of_its_nodes() -> None:
    for instances in ("P { } " * 5, "P { tint 1 0 0 } " * 5, "DEF I P { tint 1 0 0 } " + "USE I " * 4):
        # an instance, a Shape, its Appearance and Material, its IndexedFaceSet and Coordinate
        assert find_least_limit("nodes", "#VRML V2.0 utf8\n" + PROTOTYPE + instances) == 5 * 6


def test_points_that_a_shape_has_elsewhere_must_be_enough_there_too() -> None:
    text = (
        "#VRML V1.0 ascii\nCoordinate3 { point [0 0 0, 1 0 0, 1 1 0] } DEF S IndexedFaceSet { coordIndex [0, 1, 2] } "
    )
    text += "USE S USE S Coordinate3 { point [0 0 0, 1 0 0] } USE S"
    with pytest.raises(MeshError, match=r"index 2 is out of range, there are 2 points$"):
        read(text)


def test_instances_of_one_prototype_have_their_own_values() -> None:
    prototype = (
        "PROTO I [ field MFInt32 list [] ] { Shape { geometry IndexedFaceSet { coord USE C coordIndex IS list } } }"
    )
    both = "I { list [0 1 2] } I { list [2 1 3 0] }"
    text = f"#VRML V2.0 utf8\nDEF C Coordinate {{ point [0 0 0, 1 0 0, 1 1 0, 0 1 0] }}\n{prototype}\n"
    text += f"PROTO J [] {{ Group {{ children [ {both} ] }} }}\nDEF D J {{ }} USE D J {{ }} {both}"
    assert [face.tolist() for face in read(text).faces] == [[0, 1, 2], [2, 1, 3, 0]] * 4


BOX_OF = "Shape { geometry Box { %s } }"


@pytest.mark.parametrize(
    ("fields", "size"),
    [
        ("size 5 5 5 size IS s", 3),
        ("size IS other size IS s", 3),
        ("size IS s size 5 5 5", 5),
        ("size IS missing", 2),
        ("size IS missing size IS s", 3),
        ("size IS unset", 2),
    ],
)
def test_the_last_value_of_a_field_counts_whether_it_is_a_name_or_not(fields: str, size: float) -> None:
    """What has no value, as a name that the prototype lacks, or one for which it has no value itself, is as left out.

    A prototype's default that is a name of another prototype has none either.
    """
    interface = "field SFVec3f s 3 3 3 field SFVec3f other 4 4 4 field SFVec3f unset IS s"
    text = f"#VRML V2.0 utf8\nPROTO P [ {interface} ] {{ {BOX_OF % fields} }} P {{ }}"
    assert np.ptp(read(text).positions, axis=0).tolist() == [size] * 3


@pytest.mark.parametrize(
    ("group", "n_faces"),
    [
        ("children IS c children [ ]", 6),
        ("children [ ] children IS c", 6),
        (f"children IS c children [ {BOX_OF % ''} {BOX_OF % ''} ]", 12),
        (f"children [ {BOX_OF % ''} {BOX_OF % ''} ] children IS c", 12),
    ],
)
def test_children_that_are_written_out_count_before_those_of_a_name(group: str, n_faces: int) -> None:
    text = f"#VRML V2.0 utf8\nPROTO P [ field MFNode c [ {BOX_OF % ''} ] ] {{ Group {{ {group} }} }} P {{ }}"
    assert read(text).n_faces == n_faces


def test_a_flag_that_names_what_has_no_value_is_as_left_out() -> None:
    text = (
        "#VRML V2.0 utf8\nPROTO P [ ] { Shape { geometry Cone { bottom IS b side IS s } } } Cone { bottom IS b } P { }"
    )
    assert read(text).n_faces == 2 * 33


WIDE = "A{}" * 15_000
BOX = "Shape { geometry Box { } }"
# Of each, thousands of nodes that are one, or of one prototype, each of which took time for all that it has.
REPEATED = {
    "fields of a prototype": "PROTO P [ "
    + "".join(f"field MFInt32 f{i} [] " for i in range(3_000))
    + "field SFVec3f s 1 1 1 ] { Shape { geometry Box { size IS s } } }\n"
    + "P { s 1 2 3 }" * 5_000,
    "a body of prototypes": "PROTO P [] {" + "PROTO X [] { }" * 12_000 + BOX + "}\n" + "P{}" * 10_000,
    "a wide switch": BOX + "DEF S Switch { whichChoice 0 choice [" + WIDE + "] }\n" + "USE S " * 10_000,
    "levels of detail": BOX + "DEF S LOD { level [" + WIDE + "] }\n" + "USE S " * 10_000,
    "what shows nothing": BOX + "DEF S WorldInfo {" + WIDE + "}\n" + "USE S " * 10_000,
    "names of a file": BOX + "DEF S Inline { url [" + '"a" ' * 30_000 + "] }\n" + "USE S " * 4_000,
    "names of a texture": "DEF S Shape { appearance Appearance { texture ImageTexture { url ["
    + '"a" ' * 30_000
    + "] } } geometry Box { } }\n"
    + "USE S " * 4_000,
}


@pytest.mark.parametrize("name", REPEATED)
def test_no_node_takes_time_for_what_others_have_too(name: str) -> None:
    for _ in within_cpu_s(1.5):
        read("#VRML V2.0 utf8\n" + REPEATED[name] + "\n#" + "-" * 300_000)
