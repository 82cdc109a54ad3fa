"""Colours, normals and texture coordinates of VRML, against what ISO 14772-1 and the VRML 1.0 specification say."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gpu_xform.errors import MeshWarning
from gpu_xform.formats import vrml
from gpu_xform.geometry.mesh import Mesh

QUAD = "point [0 0 0, 1 0 0, 1 1 0, 0 1 0]"
R, G, B, K = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]
COLORS = "color [1 0 0, 0 1 0, 0 0 1, 0 0 0]"


def v1(body: str) -> Mesh:
    return vrml.read(f"#VRML V1.0 ascii\nSeparator {{ {body} }}".encode())


def v2(body: str) -> Mesh:
    return vrml.read(f"#VRML V2.0 utf8\n{body}".encode())


def face_set(more: str, index: str = "0 1 2 -1 0 2 3 -1", appearance: str = "") -> str:
    geometry = f"IndexedFaceSet {{ coord Coordinate {{ {QUAD} }} coordIndex [{index}] {more} }}"
    return f"Shape {{ {appearance} geometry {geometry} }}"


def test_colors_without_an_index_are_those_of_points() -> None:
    mesh = v2(face_set(f"color Color {{ {COLORS} }}"))
    assert mesh.attributes.point["color"].tolist() == [R, G, B, K]
    assert not mesh.attributes.corner
    assert not mesh.attributes.face


def test_an_index_of_colors_gives_one_to_each_corner() -> None:
    mesh = v2(face_set(f"color Color {{ {COLORS} }} colorIndex [3 2 1 -1 0 0 0 -1]"))
    assert mesh.attributes.corner["color"].tolist() == [K, B, G, R, R, R]
    # Corners that agree at every point are those of points; the last -1 may be missing.
    mesh = v2(face_set(f"color Color {{ {COLORS} }} colorIndex [3 2 1 -1 3 1 0]"))
    assert mesh.attributes.point["color"].tolist() == [K, B, G, R]


@pytest.mark.parametrize(("index", "expected"), [("", [R, G]), ("colorIndex [2 1]", [B, G])])
def test_colors_of_faces(index: str, expected: list[list[float]]) -> None:
    mesh = v2(face_set(f"color Color {{ {COLORS} }} colorPerVertex FALSE {index}"))
    assert mesh.attributes.face["color"].tolist() == expected


def test_reversed_faces_take_their_corners_along() -> None:
    text = face_set(f"ccw FALSE color Color {{ {COLORS} }} colorIndex [3 2 1 -1 0 1 2 -1]")
    mesh = v2(text)
    assert [face.tolist() for face in mesh.faces] == [[0, 2, 1], [0, 3, 2]]
    assert mesh.attributes.corner["color"].tolist() == [K, G, B, R, B, G]
    mirrored = v2(f"Transform {{ scale -1 1 1 children {text} }}")
    assert mirrored.attributes.corner["color"].tolist() == [K, B, G, R, G, B]


def test_the_color_of_a_material_is_that_of_its_faces() -> None:
    red = "appearance Appearance { material Material { diffuseColor 1 0 0 } }"
    clear = "appearance Appearance { material Material { diffuseColor 0 1 0 transparency 0.25 } }"
    mesh = v2(face_set("", appearance=red) + face_set("", "0 1 2") + face_set("", "0 1 2", appearance=clear))
    assert mesh.attributes.face["color"].tolist() == [[*R, 1], [*R, 1], [1, 1, 1, 1], [*G, 0.75]]
    assert not v2(face_set("")).attributes


def test_colors_of_faces_and_of_corners_in_one_file_are_those_of_corners() -> None:
    red = "appearance Appearance { material Material { diffuseColor 1 0 0 } }"
    of_corners = face_set(f"color Color {{ {COLORS} }} colorIndex [0 1 2 -1 3 3 3 -1]")
    mesh = v2(of_corners + face_set("", "0 1 2", appearance=red))
    assert mesh.attributes.corner["color"].tolist() == [R, G, B, K, K, K, R, R, R]
    assert "color" not in mesh.attributes.face


def test_prototypes_give_appearances() -> None:
    mesh = v2(
        "PROTO Paint [ field SFColor tint 0 0 0 ] { Appearance { material Material { diffuseColor IS tint } } }\n"
        + face_set("", appearance="appearance Paint { tint 0 0 1 }")
    )
    assert mesh.attributes.face["color"].tolist() == [B, B]


def test_lines_and_points_have_colors() -> None:
    lines = f"IndexedLineSet {{ coord Coordinate {{ {QUAD} }} coordIndex [0 1 2 -1 3 -1 2 3] "
    lines += f"color Color {{ {COLORS} }}"
    mesh = v2(f"Shape {{ geometry {lines} colorPerVertex FALSE colorIndex [2 0 1] }} }}")
    assert mesh.attributes.face["color"].tolist() == [B, B, G]
    assert v2(f"Shape {{ geometry {lines} }} }}").attributes.point["color"].tolist() == [R, G, B, K]
    points = f"Shape {{ geometry PointSet {{ coord Coordinate {{ {QUAD} }} color Color {{ {COLORS} }} }} }}"
    assert v2(points).attributes.point["color"].tolist() == [R, G, B, K]
    shining = "appearance Appearance { material Material { emissiveColor 0 1 0 } }"
    points = f"Shape {{ {shining} geometry PointSet {{ coord Coordinate {{ {QUAD} }} }} }}"
    assert v2(points).attributes.point["color"].tolist() == [G] * 4


def test_colors_of_a_grid() -> None:
    grid = "ElevationGrid {{ xDimension 3 zDimension 2 height [0 0 0 0 0 0] color Color {{ {} }} {} }}"
    mesh = v2("Shape { geometry " + grid.format(COLORS, "colorPerVertex FALSE") + " }")
    assert mesh.attributes.face["color"].tolist() == [R, G]
    mesh = v2("Shape { geometry " + grid.format("color [1 0 0 0 1 0 0 0 1 0 0 0 0 1 0 1 0 0]", "") + " }")
    assert mesh.attributes.point["color"].tolist() == [R, G, B, K, G, R]


def test_normals_are_turned_with_their_shape() -> None:
    normals = "normal Normal { vector [1 0 0, 0 0.6 0.8] } normalPerVertex FALSE"
    mesh = v2(f"Transform {{ scale 1 2 -1 children {face_set(normals)} }}")
    expected = np.linalg.inv(np.diag([1.0, 2.0, -1.0])).T @ [0.0, 0.6, 0.8]
    assert mesh.attributes.face["normal"][0].tolist() == [1, 0, 0]
    assert np.allclose(mesh.attributes.face["normal"][1], expected / np.linalg.norm(expected))
    per_point = "normal Normal { vector [1 0 0, 0 1 0, 0 0 1, -1 0 0] }"
    assert v2(face_set(per_point)).attributes.point["normal"].tolist() == [R, G, B, [-1, 0, 0]]


def test_texture_coordinates_and_the_name_of_a_texture() -> None:
    texture = 'appearance Appearance { texture ImageTexture { url "brick.png" } }'
    text = "texCoord TextureCoordinate { point [0 0, 1 0, 1 1, 0 1] } texCoordIndex [1 2 3 -1 0 0 0 -1]"
    mesh = v2(face_set(text, appearance=texture))
    assert mesh.attributes.corner["texcoord"].tolist() == [[1, 0], [1, 1], [0, 1], [0, 0], [0, 0], [0, 0]]
    assert dict(mesh.attributes.material) == {"texture": "brick.png"}
    two = face_set("", appearance=texture) + face_set("", appearance=texture.replace("brick", "wood"))
    assert v2(two).metadata["vrml"]["holds"] == ("2 textures",)


def test_what_a_material_says_beside_its_color_is_named() -> None:
    glossy = "appearance Appearance { material Material { shininess 0.5 specularColor 1 1 1 } }"
    assert v2(face_set("", appearance=glossy)).metadata["vrml"]["holds"] == ("shininess, specularColor of materials",)


MATERIAL_1 = "Material { diffuseColor [1 0 0, 0 1 0, 0 0 1, 0 0 0] } Coordinate3 { " + QUAD + " } "
FACES_1 = "IndexedFaceSet {{ coordIndex [0 1 2 -1 0 2 3 -1] {} }}"


@pytest.mark.parametrize(
    ("binding", "index", "place", "expected"),
    [
        ("DEFAULT", "", "face", [R, R]),
        ("OVERALL", "", "face", [R, R]),
        ("PER_FACE", "", "face", [R, G]),
        ("PER_PART", "", "face", [R, G]),
        ("PER_FACE_INDEXED", "materialIndex [2 3]", "face", [B, K]),
        ("PER_VERTEX", "", "corner", [R, G, B, K, R, G]),
        ("PER_VERTEX_INDEXED", "", "point", [R, G, B, K]),
        ("PER_VERTEX_INDEXED", "materialIndex [0 0 0 -1 1 2 3 -1]", "corner", [R, R, R, G, B, K]),
    ],
)
def test_bindings_of_vrml_1(binding: str, index: str, place: str, expected: list[list[float]]) -> None:
    mesh = v1(f"{MATERIAL_1} MaterialBinding {{ value {binding} }} {FACES_1.format(index)}")
    assert getattr(mesh.attributes, place)["color"].tolist() == expected


def test_a_separator_of_vrml_1_ends_what_its_materials_are_for() -> None:
    blue = "Separator { Material { diffuseColor 0 0 1 } " + FACES_1.format("") + " }"
    mesh = v1(f"Material {{ diffuseColor 1 0 0 }} Coordinate3 {{ {QUAD} }} {blue} {FACES_1.format('')}")
    assert mesh.attributes.face["color"].tolist() == [B, B, R, R]


def test_parts_of_primitives_of_vrml_1() -> None:
    materials = "Material { diffuseColor [0.1 0 0, 0.2 0 0, 0.3 0 0, 0.4 0 0, 0.5 0 0, 0.6 0 0] } "
    materials += "MaterialBinding { value PER_PART } "
    cube = v1(materials + "Cube { }")
    centers = np.array([cube.positions[face].mean(axis=0) for face in cube.faces])
    order = [
        (0, 0, 1),
        (0, 0, -1),
        (-1, 0, 0),
        (1, 0, 0),
        (0, 1, 0),
        (0, -1, 0),
    ]  # front, back, left, right, top, bottom
    reds = {
        tuple(center): red for center, red in zip(centers.tolist(), cube.attributes.face["color"][:, 0], strict=True)
    }
    assert [reds[center] for center in order] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    cylinder = v1(materials + "Cylinder { }")
    heights = np.array([cylinder.positions[face][:, 1].mean() for face in cylinder.faces])
    reds_of_faces = cylinder.attributes.face["color"][:, 0]
    assert np.array_equal(reds_of_faces, np.where(heights > 0.5, 0.2, np.where(heights < -0.5, 0.3, 0.1)))
    for parts, expected in (("(SIDES | TOP)", 0.2), ("(SIDES | BOTTOM)", 0.3)):
        capped = v1(materials + f"Cylinder {{ parts {parts} }}")
        assert capped.attributes.face["color"][:, 0].tolist() == [0.1] * 32 + [expected]
    assert v1(materials + "Cone { }").attributes.face["color"][:, 0].tolist() == [0.1] * 32 + [0.2]


def test_normals_of_vrml_1() -> None:
    normals = "Normal { vector [1 0 0, 0 1 0, 0 0 1, 0 0 -1] } "
    mesh = v1(normals + f"Coordinate3 {{ {QUAD} }} " + FACES_1.format("normalIndex [3 3 3 -1 0 1 2 -1]"))
    assert mesh.attributes.corner["normal"].tolist() == [[0, 0, -1]] * 3 + [R, G, B]
    mesh = v1(normals + f"NormalBinding {{ value PER_FACE }} Coordinate3 {{ {QUAD} }} " + FACES_1.format(""))
    assert mesh.attributes.face["normal"].tolist() == [R, G]


def test_attributes_that_do_not_fit_are_left_out_and_named_once() -> None:
    text = face_set("color Color { color [1 0 0] } normal Normal { vector [0 0 1, 0 0] }")
    with pytest.warns(MeshWarning, match="left out, for they do not fit: colours of 2 shapes, normals of 2 shapes$"):
        mesh = v2(text + text)
    assert not mesh.attributes
    assert mesh.n_faces == 4


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_corner_colors_against_a_reading_of_the_standard_one_corner_at_a_time(data: st.DataObject) -> None:
    n_points, n_colors = data.draw(st.integers(3, 6)), data.draw(st.integers(1, 4))
    corner = st.tuples(st.integers(0, n_points - 1), st.integers(0, n_colors - 1))
    faces = data.draw(st.lists(st.lists(corner, min_size=3, max_size=5), min_size=1, max_size=4))
    ccw = data.draw(st.booleans())
    colors = data.draw(
        st.lists(st.tuples(*[st.sampled_from([0.0, 0.25, 1.0])] * 3), min_size=n_colors, max_size=n_colors)
    )
    numbers = [" ".join(str(pair[i]) for pair in face) for i in (0, 1) for face in faces]
    points, chosen = " -1 ".join(numbers[: len(faces)]), " -1 ".join(numbers[len(faces) :])
    text = f"""Shape {{ geometry IndexedFaceSet {{ ccw {str(ccw).upper()}
      coord Coordinate {{ point [{" ".join(f"{i} 0 {i * i}" for i in range(n_points))}] }} coordIndex [{points}]
      color Color {{ color [{" ".join(" ".join(map(repr, row)) for row in colors)}] }} colorIndex [{chosen}] }} }}"""
    with warnings.catch_warnings(action="error"):
        mesh = v2(text)
    turned = faces if ccw else [[face[0], *face[:0:-1]] for face in faces]
    expected = [list(colors[color]) for face in turned for _, color in face]
    assert [face.tolist() for face in mesh.faces] == [[point for point, _ in face] for face in turned]
    table = mesh.attributes.corner.get("color")
    found = mesh.attributes.point["color"][mesh.indices] if table is None else table
    assert found.tolist() == expected
