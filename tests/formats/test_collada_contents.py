"""What COLLADA files hold, value by value: points that are one, colours, materials, units, and what is left out."""

import io
from typing import Any

import numpy as np
import pytest

from gpu_xform import Mesh, load_mesh
from gpu_xform.errors import MeshError, MeshWarning
from tests.support.urdf_files import TRIANGLE_DAE

_DIFFUSE = "<diffuse><color>1 0.2 0.4 1</color></diffuse>"
PLAIN = TRIANGLE_DAE.replace('meter="0.01"', 'meter="1"').replace("<translate>100 0 0</translate>", "")
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def read(text: str) -> Mesh:
    return load_mesh(io.BytesIO(text.encode()), file_type="dae")


def source(name: str, rows: list[list[Any]]) -> str:
    numbers = " ".join(str(value) for row in rows for value in row)
    params = '<param type="float"/>' * len(rows[0])
    return (
        f'<source id="{name}"><float_array>{numbers}</float_array>'
        f"<technique_common><accessor>{params}</accessor></technique_common></source>"
    )


def faces(kind: str, content: str, *inputs: tuple[str, str]) -> str:
    heads = "".join(f'<input semantic="{what}" source="#{of}" offset="{i}"/>' for i, (what, of) in enumerate(inputs))
    return f'<{kind} material="s">{heads}{content}</{kind}>'


def with_mesh(content: str, vertices: str = "", *, material: bool = False) -> str:
    head, _, rest = PLAIN.partition("<mesh>")
    vertices = f'<vertices id="v"><input semantic="POSITION" source="#p"/>{vertices}</vertices>'
    text = f"{head}<mesh>{content}{vertices}</mesh>{rest.partition('</mesh>')[2]}"
    return text if material else text.replace('symbol="s"', 'symbol="other"')


def point_colors(mesh: Mesh) -> list[list[int]]:
    colors: list[list[int]] = np.asarray(mesh.attributes.point["color"]).tolist()
    return colors


def face_color(text: str) -> list[int]:
    (color,) = np.asarray(read(text).attributes.face["color"]).tolist()
    assert isinstance(color, list)
    return color


@pytest.mark.parametrize("unit", ['meter="0"', 'meter="a"', ""])
def test_a_unit_that_is_none_is_a_metre(unit: str) -> None:
    text = TRIANGLE_DAE.replace('meter="0.01"', unit).replace("<translate>100 0 0</translate>", "")
    assert read(text).positions.tolist() == [[0, 0, 0], [10, 0, 0], [0, 20, 30]]


def test_four_losses_are_named_of_more() -> None:
    nodes = "".join(f'<instance_node url="#q{i}"/>' for i in range(5))
    names = ", ".join(f"node '#q{i}', which is not there" for i in range(4))
    for n, end in ((4, "$"), (5, r", \.\.\.$")):
        text = PLAIN.replace("<instance_geometry", nodes[: n * len(nodes) // 5] + "<instance_geometry")
        with pytest.warns(MeshWarning, match=f"it is read without {names}{end}"):
            read(text)


@pytest.mark.parametrize(
    ("what", "step", "n_points"),
    [
        ("VERTEX", [1e-9, 0, 0], 4),
        ("VERTEX", [1e-7, 0, 0], 5),
        ("VERTEX", [0, 0, 1e-7], 5),
        ("NORMAL", [0.001, 0, 0], 4),
        ("NORMAL", [0, 0, 0.02], 5),
        ("TEXCOORD", [1e-5, 0], 4),
        ("TEXCOORD", [0, 1e-3], 5),
    ],
)
def test_corners_are_one_point_where_they_are_almost_equal(what: str, step: list[float], n_points: int) -> None:
    """A square of two triangles whose fifth corner is the first but for a step: in its place, normal or texture."""
    tables: dict[str, list[list[Any]]] = {
        "VERTEX": [*SQUARE, [0, 0, 0]],
        "NORMAL": [[0, 0, 1]] * 5,
        "TEXCOORD": [[0, 0]] * 5,
    }
    tables[what] = [*tables[what][:4], [a + b for a, b in zip(tables[what][0], step, strict=True)]]
    content = source("p", tables["VERTEX"]) + source("n", tables["NORMAL"]) + source("t", tables["TEXCOORD"])
    indices = " ".join(f"{i} {i} {i}" for i in (0, 1, 2, 4, 2, 3))
    content += faces("triangles", f"<p>{indices}</p>", ("VERTEX", "v"), ("NORMAL", "n"), ("TEXCOORD", "t"))
    mesh = read(with_mesh(content, material=True))
    assert mesh.n_points == n_points
    assert read(with_mesh(content)).n_points == (4 if what == "TEXCOORD" else n_points)  # no material, no texture


def test_what_is_no_number_is_zero_and_what_is_infinite_leaves_its_triangles_out() -> None:
    triangle = faces("triangles", "<p>0 1 2 2 3 0</p>", ("VERTEX", "v"))
    mesh = read(with_mesh(source("p", [["NaN", 5, 0], *SQUARE[1:]]) + triangle))
    assert mesh.positions.tolist() == [[0, 5, 0], *SQUARE[1:]]
    mesh = read(with_mesh(source("p", [SQUARE[0], ["INF", 0, 0], *SQUARE[2:]]) + triangle))
    assert mesh.positions[mesh.indices].tolist() == [SQUARE[2], SQUARE[3], SQUARE[0]]
    with pytest.raises(MeshError, match="it shows no triangles"):
        read(with_mesh(source("p", [["-INF", 0, 0], *SQUARE[1:]]) + triangle))


COLORS: list[list[Any]] = [[1, 0, 0, 0.5], [0, 2, -1, 1], [0.999, "INF", 0.25, 1], [0, 0, 0, 0]]
BYTES = [[255, 0, 0, 128], [0, 255, 0, 255], [255, 0, 64, 255], [0, 0, 0, 0]]


def test_colors_become_the_nearest_bytes() -> None:
    content = source("p", SQUARE) + source("c", COLORS)
    triangles = faces("triangles", "<p>0 0 1 1 2 2 2 2 3 3 0 0</p>", ("VERTEX", "v"), ("COLOR", "c"))
    assert point_colors(read(with_mesh(content + triangles))) == BYTES


def test_colors_may_stand_among_the_vertices_and_the_first_ones_count() -> None:
    content = source("p", SQUARE) + source("c", [row[:3] for row in COLORS]) + source("d", [[1, 1, 1]] * 4)
    both = '<input semantic="COLOR" source="#c"/><input semantic="COLOR" source="#d"/>'
    text = with_mesh(content + faces("triangles", "<p>0 1 2 2 3 0</p>", ("VERTEX", "v")), both)
    assert point_colors(read(text)) == [[*row[:3], 255] for row in BYTES]
    triangles = faces("triangles", "<p>0 0 0 1 1 1 2 2 2</p>", ("VERTEX", "v"), ("COLOR", "c"), ("COLOR", "d"))
    assert point_colors(read(with_mesh(content + triangles))) == [[*row[:3], 255] for row in BYTES[:3]]


def test_colors_of_two_numbers_are_none() -> None:
    content = source("p", SQUARE) + source("c", [[1, 0]] * 4)
    content += faces("triangles", "<p>0 0 1 1 2 2</p>", ("VERTEX", "v"), ("COLOR", "c"))
    assert not read(with_mesh(content)).attributes


def test_of_triangles_the_first_list_counts_and_of_polygons_all() -> None:
    lists = "<p>0 1 2</p><p>2 3 0</p>"
    for kind, n_faces in (("triangles", 1), ("polygons", 2), ("tristrips", 2), ("trifans", 2)):
        mesh = read(with_mesh(source("p", SQUARE) + faces(kind, lists, ("VERTEX", "v"))))
        assert mesh.n_faces == n_faces
    mesh = read(with_mesh(source("p", SQUARE) + faces("polygons", "<p>0 1</p><p>1</p><p>2 3 0</p>", ("VERTEX", "v"))))
    assert mesh.positions[mesh.indices].tolist() == [SQUARE[2], SQUARE[3], SQUARE[0]]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            faces("triangles", "<p>0 0 1 1 2 2</p>", ("VERTEX", "v"), ("NORMAL", "t")),
            "must have rows of 3 numbers, has 2",
        ),
        (faces("polylist", "<vcount>-1 3</vcount><p>0 1 2</p>", ("VERTEX", "v")), "has fewer corners than it counts"),
        (faces("polylist", "<vcount>4</vcount><p>0 1 2</p>", ("VERTEX", "v")), "has fewer corners than it counts"),
        (
            faces("polylist", f"<vcount>{2**63 - 1} {2**63 - 1} 5</vcount><p>0 1 2</p>", ("VERTEX", "v")),
            "has fewer corners than it counts",
        ),
        (
            faces("polylist", "<vcount>3</vcount><p>0 0 1 1 2 2 2</p>", ("VERTEX", "v"), ("TEXCOORD", "t")),
            "its polylist end within a corner",
        ),
        (faces("triangles", "<p>0 1 2</p>", ("VERTEX", "nothing")), "there is no source 'nothing' of floats"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_group_is_named(content: str, message: str) -> None:
    with pytest.raises(MeshError, match=rf"geometry '#g' \(.*{message}"):
        read(with_mesh(source("p", SQUARE) + source("t", [[0, 0]] * 4) + content))


def test_an_address_without_its_mark_is_none() -> None:
    with pytest.raises(MeshError, match=r"geometry 'xg' \(it is not there\)"):
        read(PLAIN.replace('url="#g"', 'url="xg"'))
    with pytest.warns(MeshWarning, match="node 'xn', which is not there"):
        read(PLAIN.replace("<instance_geometry", '<instance_node url="xn"/><instance_geometry'))


@pytest.mark.parametrize(
    ("shader", "color"),
    [
        (_DIFFUSE, [255, 51, 102, 255]),
        ("<diffuse><color>1 0.2 0.4 0.2</color></diffuse>", [255, 51, 102, 51]),
        ("<diffuse><color>1 0.2 0.4</color></diffuse>", [255, 51, 102, 255]),
        ("<diffuse><color>1</color></diffuse>", [255, 0, 0, 255]),
        ("<emission><color>1 0 0 1</color></emission>", [255] * 4),
        ('<diffuse><texture texture="a.png"/></diffuse>', [255] * 4),
        (_DIFFUSE + "<transparent><color>0 0 0 0.2</color></transparent>", [255, 51, 102, 51]),
        ('<diffuse><param ref="b"/></diffuse>', [0, 0, 255, 255]),
        ('<diffuse><param ref="c"/></diffuse>', [0, 255, 0, 51]),
        ('<diffuse><param ref="d"/></diffuse>', [255] * 4),
    ],
)
@pytest.mark.parametrize("kind", ["phong", "lambert", "blinn", "constant"])
def test_the_color_of_a_material(kind: str, shader: str, color: list[int]) -> None:
    parameters = (
        '<newparam sid="a"><float3>1 1 0</float3></newparam><newparam sid="b"><float3>0 0 1</float3></newparam>'
    )
    text = PLAIN.replace(_DIFFUSE, shader).replace("lambert>", f"{kind}>")
    text = text.replace("<profile_COMMON>", f"<profile_COMMON>{parameters}").replace(
        f"<{kind}>", f'<newparam sid="c"><float4>0 1 0 0.2</float4></newparam><{kind}>'
    )
    assert face_color(text) == color


@pytest.mark.parametrize("text", ["1 2 3 4 5", "", "1 b"])
def test_a_color_that_is_none_is_named(text: str) -> None:
    with pytest.warns(MeshWarning, match=rf"material '#m' \(its diffuse colour must be 3 or 4 numbers, got '{text}'\)"):
        assert not read(PLAIN.replace("1 0.2 0.4 1", text)).attributes


@pytest.mark.parametrize(
    ("axis", "expected"), [("1 0 0", [1, -3, 2]), ("0 1 0", [3, 2, -1]), ("0 0 1", [-2, 1, 3]), ("0 0 -1", [2, -1, 3])]
)
def test_a_quarter_turn_about_each_axis(axis: str, expected: list[float]) -> None:
    text = PLAIN.replace("0 0 0 10 0 0 0 20 30", "1 2 3 10 0 0 0 20 30")
    text = text.replace('<node id="n">', f'<node id="n"><rotate>{axis} 90</rotate>')
    np.testing.assert_allclose(read(text).positions[0], expected, atol=1e-15)


def test_each_group_has_the_material_that_its_symbol_is_bound_to() -> None:
    group = faces("triangles", "<p>0 1 2</p>", ("VERTEX", "v"))
    text = with_mesh(source("p", SQUARE) + group + group.replace('"s"', '"t"'), material=True)
    text = text.replace(
        '<instance_material symbol="s"', '<instance_material symbol="t" target="#w"/><instance_material symbol="s"'
    )
    white = '<material id="w"><instance_effect url="#f"/></material>'
    effect = TRIANGLE_DAE[TRIANGLE_DAE.index("<effect") : TRIANGLE_DAE.index("</library_effects>")]
    text = text.replace("</library_materials>", f"{white}</library_materials>")
    text = text.replace("<effect", effect.replace('"e"', '"f"').replace("1 0.2 0.4 1", "0 0 1 1") + "<effect", 1)
    assert np.asarray(read(text).attributes.face["color"]).tolist() == [[255, 51, 102, 255], [0, 0, 255, 255]]


def test_the_scene_that_is_named_is_shown() -> None:
    other = '<visual_scene id="x"><node><instance_geometry url="#y"/></node></visual_scene><visual_scene'
    assert read(PLAIN.replace("<visual_scene", other, 1)) == read(PLAIN)


def test_a_node_within_itself_and_a_skin_are_named() -> None:
    with pytest.raises(MeshError, match="a node is a part of itself"):
        read(PLAIN.replace("<instance_geometry", '<instance_node url="#n"/><instance_geometry'))
    with pytest.warns(MeshWarning, match="it is read without skins$"):
        read(PLAIN.replace("<instance_geometry", '<instance_controller url="#k"/><instance_geometry'))


def test_materials_share_an_effect_that_is_wrong() -> None:
    text = PLAIN.replace("1 0.2 0.4 1", "1 b").replace(
        "</library_materials>", '<material id="w"><instance_effect url="#e"/></material></library_materials>'
    )
    text = text.replace(
        '<instance_material symbol="s"', '<instance_material symbol="t" target="#w"/><instance_material symbol="s"'
    )
    with pytest.warns(MeshWarning, match=r"material '#w' \(its diffuse.*'1 b'\), material '#m' \(its diffuse.*'1 b'\)"):
        read(text)


def test_instances_have_colors_of_their_own() -> None:
    """Of a geometry with coloured points, shown in its material, without one, and mirrored in another material."""
    bound = PLAIN[PLAIN.index("<bind_material>") : PLAIN.index("</instance_geometry>")]
    other = bound.replace("#m", "#w")
    shown = (
        f'<instance_geometry url="#g">{bound}</instance_geometry><instance_geometry url="#g"/>'
        f'<node><scale>-1 2 1</scale><instance_geometry url="#g">{other}</instance_geometry></node></node>'
    )
    group = faces("triangles", "<p>0 0 1 1 2 2</p>", ("VERTEX", "v"), ("COLOR", "c"))
    colors = source("c", [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    text = with_mesh(source("p", SQUARE) + colors + group, material=True)
    text = text[: text.index("<instance_geometry")] + shown + text[text.index("</visual_scene>") :]
    effect = TRIANGLE_DAE[TRIANGLE_DAE.index("<effect") : TRIANGLE_DAE.index("</library_effects>")]
    text = text.replace("<effect", effect.replace('"e"', '"f"').replace("1 0.2 0.4 1", "0 0 1 1") + "<effect", 1)
    text = text.replace(
        "</library_materials>", '<material id="w"><instance_effect url="#f"/></material></library_materials>'
    )
    mesh = read(text)
    red, white = [255, 0, 0, 255], [255, 51, 102, 255]
    points = [red, [0, 255, 0, 255], [0, 0, 255, 255]]
    assert np.asarray(mesh.attributes.corner["color"]).tolist() == [white] * 3 + points + [[0, 0, 255, 255]] * 3
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    np.testing.assert_array_equal(mesh.positions, [*square, *square, [0, 0, 0], [-1, 0, 0], [-1, 2, 0]])
    np.testing.assert_array_equal(mesh.indices, [0, 1, 2, 3, 4, 5, 6, 8, 7])


def test_coordinates_near_the_largest_numbers_are_points_of_their_own() -> None:
    """They overflow where they are rounded: NumPy warned, and they would have become one point."""
    rows = [["1e308", 0, 0], ["1.5e308", 0, 0], ["-1e308", 0, 0], ["1e300", 0, 0], ["1e308", 0, 0]]
    group = faces("triangles", "<p>0 1 2 0 3 4</p>", ("VERTEX", "v"))
    mesh = read(with_mesh(source("p", rows) + group))
    assert mesh.positions[:, 0].tolist() == [1e308, 1.5e308, -1e308, 1e300]
    assert mesh.indices.tolist() == [0, 1, 2, 0, 3, 0]


@pytest.mark.parametrize("sign", [1, -1])
def test_matrices_near_the_largest_numbers_mirror_by_their_sign(sign: int) -> None:
    """Elimination overflows in them: NumPy warned."""
    rows = ["1 1 -1 0", "-1 1 1 0", f"{sign} {-sign} {sign} 0"]
    matrix = " ".join(rows).replace("1", "1e308") + " 0 0 0 1"
    text = PLAIN.replace("0 0 0 10 0 0 0 20 30", "0 0 0 1 0 0 0 0.5 0.25")
    mesh = read(text.replace('<node id="n">', f'<node id="n"><matrix>{matrix}</matrix>'))
    assert mesh.indices.tolist() == ([0, 1, 2] if sign > 0 else [0, 2, 1])
    expected = np.array([row.split() for row in rows], np.float64)[:, :3] @ [[0, 1, 0], [0, 0, 0.5], [0, 0, 0.25]]
    np.testing.assert_allclose(mesh.positions, 1e308 * expected.T)
