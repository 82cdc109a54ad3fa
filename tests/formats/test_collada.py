"""COLLADA files: positions, faces and colours against trimesh with pycollada, damage, and what it costs."""

import io
import random
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh

from gpu_xform import FileLimits, Mesh, load_mesh
from gpu_xform.errors import MeshError, MeshWarning
from tests.support.cost import within_cpu_s
from tests.support.urdf_files import TRIANGLE_DAE

_INSTANCE = '<instance_geometry url="#g"/>'
_NODE = '<node id="n"><translate>100 0 0</translate>'


def read(text: str, **options: Any) -> Mesh:
    return load_mesh(io.BytesIO(text.encode()), file_type="dae", **options)


def source(name: str, rows: list[list[float]], params: str) -> str:
    numbers = " ".join(repr(value) for row in rows for value in row)
    return (
        f'<source id="{name}"><float_array id="{name}a">{numbers}</float_array><technique_common><accessor>'
        + "".join(f'<param name="{param}" type="float"/>' for param in params)
        + "</accessor></technique_common></source>"
    )


class Maker:
    """Files of all kinds of faces, values and transforms, in nodes within nodes."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)  # noqa: S311

    def rows(self, n_rows: int, n_columns: int) -> list[list[float]]:
        rows = [[round(self.random.uniform(-9, 9), 3) for _ in range(n_columns)] for _ in range(n_rows)]
        return [*rows, list(rows[0])]  # a point twice

    def faces(self, kind: str) -> str:
        inputs = [("VERTEX", "v", 6)] + [
            each for each in (("NORMAL", "n", 3), ("TEXCOORD", "t", 3), ("COLOR", "c", 3)) if self.random.random() < 0.5
        ]
        heads = "".join(
            f'<input semantic="{what}" source="#{of}" offset="{i}"/>' for i, (what, of, _) in enumerate(inputs)
        )
        sizes = [self.random.randint(3, 6) for _ in range(3)]
        if kind == "triangles":
            sizes = [9]
        corners = [
            " ".join(str(self.random.randrange(n_rows)) for _ in range(size) for _, _, n_rows in inputs)
            for size in sizes
        ]
        lists = f"<p>{' '.join(corners)}</p>" if kind == "polylist" else "".join(f"<p>{each}</p>" for each in corners)
        counts = f"<vcount>{' '.join(map(str, sizes))}</vcount>" if kind == "polylist" else ""
        symbol = self.random.choice(["s", "other"])
        return f'<{kind} material="{symbol}">{heads}{counts}{lists}</{kind}>'

    def node(self, depth: int) -> str:
        numbers = " ".join(f"{self.random.uniform(-2, 2):.2f}" for _ in range(12))
        transforms = [
            f"<matrix>{numbers} 0 0 0 1</matrix>",
            "<translate>1 -2.5 3</translate>",
            f"<rotate>0.6 0 -0.8 {self.random.uniform(-180, 180):.1f}</rotate>",
            "<scale>1 -2 3.5</scale>",
        ]
        self.random.shuffle(transforms)
        inner = self.node(depth + 1) + '<instance_node url="#l"/>' if depth < 3 else ""
        bound = TRIANGLE_DAE.partition("<bind_material>")[2].partition("</instance_geometry>")[0]
        shape = f'<instance_geometry url="#g"><bind_material>{bound}</instance_geometry>'
        return f"<node>{''.join(transforms[: self.random.randint(0, 4)])}{inner}{shape}</node>"

    def file(self) -> str:
        geometry = (
            source("p", self.rows(5, 3), "XYZ")
            + source("n", self.rows(2, 3), "XYZ")
            + source("t", self.rows(2, 2), "ST")
            + source("c", [[self.random.random() for _ in range(4)] for _ in range(3)], "RGBA")
            + '<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
            + "".join(map(self.faces, ("triangles", "tristrips", "trifans", "polylist", "polygons", "triangles")))
        )
        head, _, rest = TRIANGLE_DAE.partition("<mesh>")
        text = f"{head}<mesh>{geometry}</mesh>{rest.partition('</mesh>')[2]}"
        library = f'<library_nodes><node id="l"><translate>0 0 7</translate>{_INSTANCE}</node></library_nodes>'
        return text.replace("<library_visual_scenes>", f"{library}<library_visual_scenes>").replace(
            _NODE, f"{self.node(0)}{_NODE}"
        )


@pytest.mark.parametrize("seed", range(6))
def test_it_is_read_as_trimesh_and_pycollada_read_it(seed: int) -> None:
    """pycollada rounds to float32, which our numbers are not."""
    text = Maker(seed).file()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = trimesh.load_scene(io.BytesIO(text.encode()), file_type="dae")
    mesh = read(text)
    positions, colors, n_points = [], [], 0
    for matrix, name in map(scene.graph.get, scene.graph.nodes_geometry):
        shape, turned = scene.geometry[name], np.linalg.det(matrix) < 0
        faces = shape.faces[:, [0, 2, 1]] if turned else shape.faces
        positions.append(0.01 * trimesh.transform_points(shape.vertices, matrix)[faces].reshape(-1, 3))
        material = getattr(shape.visual, "material", None)
        white = np.full((3 * len(faces), 4), 255)
        per_point = (
            shape.visual.vertex_colors[faces].reshape(-1, 4) if material is None and shape.visual.defined else white
        )
        colors.append(per_point if material is None else np.tile(material.main_color, (3 * len(faces), 1)))
        n_points += len(shape.vertices)
    assert mesh.n_points == n_points
    expected = np.concatenate(positions)
    np.testing.assert_allclose(mesh.positions[mesh.indices], expected, rtol=0, atol=4e-7 * np.abs(expected).max())
    found = np.asarray(mesh.attributes.corner["color"]).astype(int)
    assert np.abs(found - np.concatenate(colors)).max() <= 1


def test_numbers_keep_their_digits() -> None:
    """They were rounded to float32."""
    text = TRIANGLE_DAE.replace("0 0 0 10 0 0 0 20 30", "0.1 0 1e-12 16777217 0 0 0 20 30").replace('"0.01"', '"1"')
    np.testing.assert_array_equal(
        read(text.replace("100 0 0", "0 0 0")).positions, [(0.1, 0, 1e-12), (16777217, 0, 0), (0, 20, 30)]
    )


def test_what_is_looked_at_lies_along_minus_z() -> None:
    text = TRIANGLE_DAE.replace("<translate>100 0 0</translate>", "<lookat>100 0 0  100 50 0  0 0 2</lookat>")
    # x to the right of who stands at (100, 0, 0) and looks along y, his y up, and his z behind him.
    np.testing.assert_allclose(read(text).positions, [(1, 0, 0), (1.1, 0, 0), (1, -0.3, 0.2)], atol=1e-15)


def test_a_broken_material_leaves_others_their_colors() -> None:
    """All materials were left out."""
    shape = TRIANGLE_DAE[TRIANGLE_DAE.index("<instance_geometry") : TRIANGLE_DAE.index("</node>")]
    more = TRIANGLE_DAE.replace(_NODE, f"<node>{shape.replace('#m', '#x')}</node>{_NODE}")
    with pytest.warns(MeshWarning, match=r"it is read without material '#x' \(it is not there\)$"):
        colors = np.asarray(read(more).attributes.face["color"])
    assert colors.tolist() == [[255] * 4, [255, 51, 102, 255]]
    more = TRIANGLE_DAE.replace(
        "</library_geometries>", "</library_geometries><library_lights><light/></library_lights>"
    )
    assert np.asarray(read(more).attributes.face["color"]).tolist() == [[255, 51, 102, 255]]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0 1 2</p>", "0 1 3</p>", r"geometry '#g' \(its triangles name an item of source 'p' that it does not have"),
        ("0 1 2</p>", "0 1 -1</p>", r"geometry '#g' \(its triangles name"),
        ("0 1 2</p>", "0 1</p>", r"geometry '#g' \(its triangles end within a corner or a triangle"),
        ("0 1 2</p>", "0 1 2x</p>", r"geometry '#g' \(its triangles: not a number"),
        ("0 20 30", "0 20", r"geometry '#g' \(source 'p' has 8 numbers, for rows of 3"),
        ("0 20 30", "0 20 z", r"geometry '#g' \(source 'p': not a number"),
        ('offset="0"', 'offset="a"', r"geometry '#g' \(an offset must be a natural number, got 'a'"),
        ('offset="0"', 'offset="100000000"', r"geometry '#g' \(its triangles end within"),
        ('"VERTEX"', '"NORMAL"', r"geometry '#g' \(its triangles have no positions"),
        ('url="#g"', 'url="other.dae#g"', r"geometry 'other.dae#g' \(it is not there"),
        ("</translate>", '</translate><instance_node url="#q"/>', "node '#q', which is not there"),
        ("100 0 0", "100 0", "<translate> must be 3 numbers, got '100 0'"),
        ("<translate>100 0 0</translate>", "<rotate>0 0 1 inf</rotate>", "<rotate> must be 4 numbers"),
        ("<translate>100 0 0</translate>", f"<matrix>{'1 ' * 16}</matrix>", "must be affine"),
        ("<translate>100 0 0</translate>", "<scale>1e200 1 1</scale><scale>1e200 1 1</scale>", "finite"),
        ("<translate>100 0 0</translate>", "<lookat>1 1 1 1 1 1 0 0 1</lookat>", "finite"),
        ('url="#s"', 'url="#t"', "there is no scene '#t'"),
    ],
)  # fmt: skip
def test_damage_is_named(old: str, new: str, message: str) -> None:
    assert old in TRIANGLE_DAE
    text = TRIANGLE_DAE.replace(old, new)
    if "instance_node" in new:
        text = text.replace("instance_geometry", "a")
    with pytest.raises(MeshError, match=message):
        read(text)


def many_nodes(n: int) -> str:
    return TRIANGLE_DAE.replace("</node>", "</node>" + f"<node><translate>1 2 3</translate>{_INSTANCE}</node>" * n)


def many_groups(n: int) -> str:
    group = TRIANGLE_DAE[TRIANGLE_DAE.index("<triangles") : TRIANGLE_DAE.index("</mesh>")]
    return TRIANGLE_DAE.replace("</mesh>", group * n + "</mesh>")


def many_lights(n: int) -> str:
    return TRIANGLE_DAE.replace("</node>", f'<instance_light url="#l"/>{"</node>"}', 1).replace(
        "</library_geometries>", "</library_geometries><library_lights>" + "<light/>" * n + "</library_lights>"
    )


def groups_of_a_long_source(n: int) -> str:
    return many_groups(n).replace(' count="9">0 0 0', ">0 0 0").replace("20 30<", f"20 30 {'inf 0 0 ' * 50_000}<")


def groups_of_many_inputs(n: int) -> str:
    inputs = "".join(f'<input semantic="{i}" source="#p"/>' for i in range(10_000))
    return many_groups(n).replace("</vertices>", f"{inputs}</vertices>")


def materials_of_one_effect(n: int) -> str:
    text = TRIANGLE_DAE.replace('<technique sid="common">', "<newparam/>" * 10_000 + '<technique sid="common">')
    text = text.replace("<color>1 0.2 0.4 1</color>", '<param ref="a"/>')
    materials = "".join(f'<material id="m{i}"><instance_effect url="#e"/></material>' for i in range(n))
    bound = "".join(f'<instance_material symbol="{i}" target="#m{i}"/>' for i in range(n))
    text = text.replace("</library_materials>", f"{materials}</library_materials>")
    return text.replace("<instance_material", f"{bound}<instance_material")


def shapes_of_many_groups(n: int) -> str:
    bound = [f"<bind_material><technique_common>{_bind(str(i))}</technique_common></bind_material>" for i in range(n)]
    shapes = "".join(f'<instance_geometry url="#g">{each}</instance_geometry>' for each in bound)
    return many_groups(2000).replace("</node>", f"{shapes}</node>")


def _bind(symbol: str) -> str:
    return f'<instance_material symbol="{symbol}" target="#m"/>'


@pytest.mark.parametrize(
    ("make", "n", "n_faces"),
    [
        (groups_of_a_long_source, 5000, 5001),
        (groups_of_many_inputs, 2500, 2501),
        (materials_of_one_effect, 2000, 1),
        (shapes_of_many_groups, 80, 81 * 2001),
    ],
)
def test_what_groups_and_materials_share_is_read_once(make: Callable[[int], str], n: int, n_faces: int) -> None:
    text = make(n)
    for _ in within_cpu_s(1.2):
        assert read(text).n_faces == n_faces


@pytest.mark.parametrize(
    ("make", "n", "n_faces"), [(many_nodes, 3000, 3001), (many_groups, 2000, 2001), (many_lights, 20_000, 1)]
)
def test_nodes_and_groups_cost_little(make: Callable[[int], str], n: int, n_faces: int) -> None:
    """Before, a mesh of trimesh was made and merged for each, which took ten times as long and more."""
    text = make(n)
    for _ in within_cpu_s(0.5):
        assert read(text).n_faces == n_faces


def test_limits_count_what_instances_show() -> None:
    text = many_nodes(200)
    assert read(text, limits=FileLimits(nodes=500, points=700)).n_faces == 201
    with pytest.raises(MeshError, match="its nodes: expands to more than 10 points of 16 numbers"):
        read(text, limits=FileLimits(points=10))
    with pytest.raises(MeshError, match="its nodes: expands to more than 300 nodes"):
        read(text, limits=FileLimits(nodes=300))


def test_limits_count_how_deep_nodes_are() -> None:
    chain = TRIANGLE_DAE.replace(_NODE, f"<node><node>{_NODE}").replace(
        "</visual_scene>", "</node></node></visual_scene>"
    )
    assert read(chain, limits=FileLimits(depth=3)) == read(TRIANGLE_DAE)
    with pytest.raises(MeshError, match=r"more than 2 deep, the limit FileLimits\(depth=2\)"):
        read(chain, limits=FileLimits(depth=2))
