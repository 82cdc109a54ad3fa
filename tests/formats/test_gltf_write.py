"""Scenes and meshes written as glTF, against what trimesh reads, and read again."""

import io
import json
import math
import warnings
from typing import Any

import numpy as np
import pygltflib
import pytest
import trimesh
from hypothesis import example, given
from hypothesis import strategies as st

from gpu_xform import Mesh, Scene, load_mesh, load_scene, samples, save_mesh, scale, translate
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats.gltf_accessors import Accessors
from gpu_xform.formats.gltf_document import read_glb
from gpu_xform.geometry.attributes import RaggedArray
from gpu_xform.geometry.deformable_mesh import DeformableMesh
from tests.formats.test_gltf_animations import MOVES, TURNS, animated
from tests.formats.test_gltf_meshes import add_skinned_cube, scene_of
from tests.support.gltf_files import Builder

KINDS = ["glb", "gltf"]


def saved(model: Mesh | Scene, kind: str = "glb") -> bytes:
    file = io.BytesIO()
    save_mesh(model, file, file_type=kind)
    return file.getvalue()


def again(scene: Scene, kind: str = "glb") -> Scene:
    return load_scene(io.BytesIO(saved(scene, kind)), file_type=kind)


def assert_same(a: Scene, b: Scene) -> None:
    """Assert that two scenes have the same nodes, and show the same meshes in the same places."""
    assert [(node.name, node.parent, node.visible) for node in a] == [(n.name, n.parent, n.visible) for n in b]
    for node in a:
        assert np.array_equal(node.transform, b[node.name].transform)
        assert np.array_equal(node.weights, b[node.name].weights)  # type: ignore[arg-type]
        assert node.metadata == b[node.name].metadata
    assert a.metadata == b.metadata
    assert list(a.animations) == list(b.animations)
    layers = list(zip(a.layers(), b.layers(), strict=True))
    for first, second in layers:
        assert first.model == second.model
        assert np.array_equal(first.transform, second.transform)


@pytest.mark.parametrize("kind", KINDS)
def test_a_scene_keeps_its_tree(kind: str) -> None:
    assert_same(samples_as_single(), again(samples_as_single(), kind))


def samples_as_single() -> Scene:
    """Return the robot arm with triangles in float32, as glTF holds them."""

    def as_single(mesh: Mesh) -> Mesh:
        solid = mesh.to_trimesh()
        return made.setdefault(id(mesh), Mesh(solid.vertices.astype(np.float32), solid.faces))

    made: dict[int, Mesh] = {}
    plain = Scene()
    for node in samples.robot_arm():
        copy = plain.add(name=node.name, parent=node.parent, transform=node.transform)
        for shown in node.models:
            copy.show(as_single(shown.model))
    return plain


def test_trimesh_reads_the_same_nodes() -> None:
    scene = samples_as_single()
    read: Any = trimesh.load_scene(io.BytesIO(saved(scene)), file_type="glb", process=False)
    assert {node.name for node in scene} <= set(read.graph.nodes)
    for name in [node.name for node in scene if len(node.models) == 1]:
        matrix, geometry = read.graph[name]
        assert np.allclose(matrix, scene.world(name))
        assert np.allclose(read.geometry[geometry].vertices, scene[name].models[0].model.positions)
    assert len(read.geometry) == len({id(shown.model) for node in scene for shown in node.models})


columns = st.sampled_from(
    [
        ("normal", np.float32, 3),
        ("tangent", np.float32, 4),
        ("texcoord", np.float32, 2),
        ("texcoord_1", np.float32, 2),
        ("color", np.uint8, 4),
        ("color", np.uint8, 3),
        ("color", np.float32, 3),
        ("intensity", np.float32, None),
        ("class", np.uint8, None),
        ("flow", np.float32, 2),
        ("echo", np.int16, None),
    ]
)


@given(st.lists(columns, unique_by=lambda column: column[0]), st.randoms(use_true_random=False), st.booleans())
def test_attributes_per_point_come_back_bit_for_bit(given_: list[Any], random: Any, is_cloud: bool) -> None:
    rng = np.random.default_rng(random.getrandbits(32))
    table = {}
    for name, dtype, width in given_:
        shape = (8,) if width is None else (8, width)
        values = rng.integers(0, 200, shape) if np.dtype(dtype).kind in "iu" else rng.random(shape)
        table[name] = values.astype(dtype)
    cube = samples.cube()
    mesh = Mesh(cube.positions, () if is_cloud else cube.to_trimesh().faces, attributes={"point": table})
    for kind in KINDS:
        assert load_mesh(io.BytesIO(saved(mesh, kind)), file_type=kind) == mesh


def test_attributes_per_corner_split_points() -> None:
    square = Mesh(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        [(0, 1, 2), (0, 2, 3)],
        attributes={
            "corner": {"texcoord": np.array([(0, 0), (1, 0), (1, 1), (0.5, 0), (1, 1), (0, 1)], np.float32)},
            "point": {"intensity": np.array([1, 2, 3, 4], np.float32)},
        },
    )
    read = load_mesh(io.BytesIO(saved(square)), file_type="glb")
    assert read.n_points == 5
    assert np.array_equal(read.positions[read.indices], square.positions[square.indices])
    point = read.attributes.point
    assert np.array_equal(point["texcoord"][read.indices], square.attributes.corner["texcoord"])
    assert np.array_equal(point["intensity"][read.indices], np.array([1, 2, 3, 1, 3, 4], np.float32))


def test_segments_and_points_are_written() -> None:
    for mesh in (
        Mesh([(0, 0, 0), (1, 2, 3)]),
        Mesh([(0, 0, 0), (1, 2, 3), (4, 5, 6)], [(0, 1), (1, 2)]),
    ):
        assert load_mesh(io.BytesIO(saved(mesh)), file_type="glb") == mesh
    both = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 3)])
    models = [shown.model for shown in load_scene(io.BytesIO(saved(both)), file_type="glb")["geometry_0"].models]
    assert models == [both]


@pytest.mark.parametrize("kind", KINDS)
def test_skins_targets_and_animations_come_back(kind: str) -> None:
    builder = Builder()
    add_skinned_cube(builder, 3)
    builder.content["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": builder.array(np.ones((8, 3)))}]
    builder.content["nodes"][4]["weights"] = [0.25]
    scene = scene_of(builder)
    assert_same(scene, again(scene, kind))
    posed = {"joint 1": translate(1, 2, 3)}
    assert again(scene, kind).posed(posed).layers()[0].model == scene.posed(posed).layers()[0].model

    moving = scene_of(
        animated(("translation", MOVES, "LINEAR"), ("rotation", TURNS.as_quat(), "STEP"), scale=[1, 2, 3])
    )
    read = again(moving, kind)
    assert_same(moving, read)
    for time in (0.0, 0.7, 3.0):
        first, second = (scene.animations["dance"].at(time).transforms["cube"] for scene in (moving, read))
        assert np.array_equal(first, second)


def furnished() -> Builder:
    """Return a document with a material, a texture, an image, a camera and extras everywhere."""
    builder = animated(("translation", MOVES, "LINEAR"))
    content = builder.content
    image = builder.view(b"\x89PNG not really")
    content["images"] = [{"bufferView": image, "mimeType": "image/png", "name": "wood"}]
    content["samplers"] = [{"wrapS": 33071}]
    content["textures"] = [{"source": 0, "sampler": 0}]
    transform = {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 2]}}
    content["materials"] = [
        {"name": "plain"},
        {"name": "wooden", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": transform}}},
    ]
    content["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]
    content["meshes"][0] |= {"name": "box", "extras": {"part": 7}}
    content["meshes"][0]["primitives"][0]["material"] = 1
    content["nodes"][0]["extras"] = {"mass": 2.5}
    builder.node(name="eye", camera=0, translation=[0, 0, 9])
    content["asset"] |= {"generator": "by hand", "copyright": "nobody"}
    content["extras"] = {"order": 66}
    content["extensionsUsed"] = ["KHR_texture_transform"]
    content["scenes"] = [{"nodes": [0, 1], "name": "all"}]
    return builder


@pytest.mark.parametrize("kind", KINDS)
def test_materials_images_cameras_and_extras_come_back(kind: str) -> None:
    scene = scene_of(furnished())
    mesh = scene["cube"].models[0].model
    assert isinstance(mesh, DeformableMesh)
    attributes = mesh.mesh.attributes
    assert attributes.labels["material"] == ("wooden",)
    assert attributes.material["wooden"]["pbrMetallicRoughness"]["baseColorTexture"]["index"] == 0
    read = again(scene, kind)
    assert_same(scene, read)
    kept = read.metadata["gltf"]
    assert kept["image_bytes"] == [b"\x89PNG not really"]
    assert [material["name"] for material in kept["materials"]] == ["plain", "wooden"]
    assert kept["extras"] == {"order": 66}
    assert read["cube"].metadata["gltf"] == {"extras": {"mass": 2.5}}
    assert read["eye"].metadata["gltf"] == {"camera": 0}
    assert read["cube"].models[0].model.mesh.metadata["gltf"] == {"name": "box", "extras": {"part": 7}}


def test_copies_become_nodes() -> None:
    scene = Scene()
    node = scene.add(samples.cube(), name="tree", transform=scale(2))
    node.instances = np.stack([translate(i, 0, 0) for i in range(3)])
    scene.add(samples.cube(), name="child", parent="tree")
    read = again(scene)
    assert [n.name for n in read] == ["tree", "child", "tree, copy 1", "tree, copy 2", "tree, copy 3"]
    assert len(read["tree, copy 1"].models) == 1
    places = sorted(m[0, 3] for layer in read.layers() for m in layer.transform)
    assert places == sorted(m[0, 3] for layer in scene.layers() for m in layer.transform)


def test_what_is_not_held_is_named() -> None:
    scene = Scene()
    faces = {"group": np.arange(6)}
    mesh = samples.cube().with_attributes({"face": faces, "point": {"time": np.arange(8) / 3}})
    scene.add(mesh, name="cube", color="red")
    with pytest.warns(MeshWarning, match="glTF does not hold all digits of time, group per face, the style color"):
        saved(scene)


@pytest.mark.parametrize("dtype", [np.int32, np.uint32, np.int64, np.uint64])
def test_the_largest_integers_lose_digits_without_a_warning_of_numpy(dtype: type) -> None:
    """Rounded to float32, they are beyond their own type."""
    mesh = samples.cube().with_attributes({"point": {"count": np.full(8, np.iinfo(dtype).max, dtype)}})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        data = saved(mesh)
    assert [(each.category, str(each.message)) for each in caught] == [
        (MeshWarning, "<file>: glTF does not hold all digits of count")
    ]
    count = load_mesh(io.BytesIO(data), file_type="glb").attributes.point["count"]
    assert count.tolist() == [float(np.iinfo(dtype).max + 1)] * mesh.n_points


def test_what_a_mesh_holds_beside_tables_of_numbers_is_named_in_one_line() -> None:
    lists = RaggedArray([1, 2, 3, 4], [0, 2, 3, 3, 4, 4, 4, 4, 4])
    mesh = samples.cube().with_attributes(
        {"point": {"tags": lists}, "material": {"mtllib": ["a.mtl"]}},
        metadata={"obj": {"holds": ["1 comment"], "left_out": ["2 surfaces"]}},
    )
    for kind in KINDS:
        scene = Scene()
        scene.add(mesh)
        for model in (mesh, scene):
            with pytest.warns(MeshWarning) as caught:
                saved(model, kind)
            assert [str(warning.message) for warning in caught] == [
                "<file>: glTF does not hold material (mtllib), tags per point, 1 comment; left out: 2 surfaces"
            ]


@pytest.mark.parametrize("kind", KINDS)
def test_a_scene_names_what_it_does_not_keep_of_its_file(kind: str) -> None:
    builder = Builder()
    add_skinned_cube(builder, 3)
    content = builder.content
    primitive = content["meshes"][0]["primitives"][0]
    primitive |= {"extras": {"shade": 3}, "extensions": {"VENDOR_variants": {"of": [1, 2]}}}
    up = builder.array(np.ones((8, 3)))
    primitive["targets"] = [{"POSITION": up, "NORMAL": up}]
    content["scenes"] = [{"nodes": [3], "name": "first"}, {"nodes": [3, 4], "name": "second", "extras": {"of": 2}}]
    content["scene"] = 1
    content["skins"][0]["name"] = "bones"
    scene = scene_of(builder)
    with pytest.warns(MeshWarning, match="left out: 1 other scene, 1 name of skins, NORMAL of morph targets$"):
        data = saved(scene, kind)
    after = pygltflib.GLTF2.gltf_from_json(data.decode()) if kind == "gltf" else pygltflib.GLTF2.load_from_bytes(data)
    assert [(found.name, found.extras) for found in after.scenes] == [("second", {"of": 2})]
    (written,) = after.meshes[0].primitives
    assert (written.extras, written.extensions) == ({"shade": 3}, {"VENDOR_variants": {"of": [1, 2]}})


def test_a_scene_in_another_format_is_one_mesh() -> None:
    scene = samples.robot_arm()
    for kind in ("obj", "stl", "ply", "off"):
        with pytest.warns(MeshWarning, match=rf"{kind.upper()} does not hold \d+ nodes"):
            data = saved(scene, kind)
        mesh = load_mesh(io.BytesIO(data), file_type=kind)
        (low, high) = mesh.bounds
        points = np.concatenate(
            [shown.model.transformed(scene.world(node)).positions for node in scene for shown in node.models]
        )
        assert np.allclose([low, high], [points.min(axis=0), points.max(axis=0)], atol=1e-5)


def test_paths_and_arrays_in_a_scene_are_written_as_meshes(tmp_path: Any) -> None:
    save_mesh(samples.cube(), tmp_path / "cube.obj")
    scene = Scene()
    scene.add(tmp_path / "cube.obj", name="file")
    scene.add(np.array([(0, 0, 0), (1, 1, 1)], np.float32), name="points")
    read = again(scene)
    assert read["file"].models[0].model.n_faces == 12
    assert read["points"].models[0].model == Mesh([(0, 0, 0), (1, 1, 1)])


def test_coordinates_beyond_float32_are_refused() -> None:
    with pytest.raises(MeshError, match=r"<file>: glTF holds float32, the mesh of node 'geometry_0' has .* of 1e\+39"):
        saved(Mesh([(0, 0, 1e39)]))


def test_a_mesh_of_a_document_names_what_only_its_scene_holds() -> None:
    mesh = load_mesh(io.BytesIO(furnished().pack()), file_type="glb")
    with pytest.warns(
        MeshWarning, match="OBJ does not hold textures of material 'wooden', .*2 nodes, 1 animation, 1 camera, 1 image"
    ):
        saved(mesh, "obj")
    with pytest.warns(MeshWarning) as caught:
        data = saved(mesh)
    said = " ".join(str(warning.message) for warning in caught)
    assert "one mesh does not hold 2 nodes, 1 animation, 1 camera, 1 image" in said
    assert "textures of material 'wooden'" in said
    again = load_mesh(io.BytesIO(data), file_type="glb")
    assert again.with_attributes(mesh.attributes) == mesh
    assert again.attributes.point.keys() == mesh.attributes.point.keys()
    content = read_glb(data).content
    assert "textures" not in content
    assert "Texture" not in json.dumps(content["materials"])


def test_points_that_no_face_uses_are_named_where_corners_differ() -> None:
    text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 5 5\nv 6 6 6\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n"
    with pytest.warns(MeshWarning, match="glTF does not hold 2 points that no face uses"):
        saved(load_mesh(io.BytesIO(text), file_type="obj"))


def test_corners_without_texture_coordinates_are_written_without_them() -> None:
    points = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n"
    mesh = load_mesh(io.BytesIO(points + b"f 1/1/1 2/2/1 3/3/1\nf 1//1 3//1 4//1\nf 1/1 2 4\nl 1 4\n"), file_type="obj")
    with pytest.warns(MeshWarning, match="does not hold texcoord of 1 faces, which some of their corners lack"):
        data = saved(mesh)
    scene = trimesh.load_scene(io.BytesIO(data), file_type="glb")
    kinds = {len(part.vertices): part for part in scene.geometry.values() if isinstance(part, trimesh.Trimesh)}
    assert all(np.isfinite(part.vertex_normals).all() for part in kinds.values())
    again_read = load_mesh(io.BytesIO(data), file_type="glb")
    assert sorted(np.diff(again_read.offsets).tolist()) == [2, 3, 3, 3]
    of_face = np.isfinite(again_read.attributes.point["texcoord"]).all(axis=1)[again_read.indices]
    assert of_face.sum() == 3
    for row in _float_accessors(data):
        assert np.isfinite(row).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load_mesh(io.BytesIO(saved(again_read)), file_type="glb") == again_read


def _float_accessors(data: bytes) -> list[Any]:
    """Return the rows of all accessors of a GLB file that hold floats."""
    document = read_glb(data)
    accessors = Accessors(document.content, document.buffers)
    return [
        accessors.components(i) for i, held in enumerate(document.content["accessors"]) if held["componentType"] == 5126
    ]


def test_numbers_that_some_points_of_a_cloud_lack_are_named() -> None:
    cloud = Mesh(np.eye(3), attributes={"point": {"time": [1.0, np.nan, 2.0], "gain": [1.0, 2.0, 3.0]}})
    with pytest.warns(MeshWarning, match="time per point, which 1 of 3 rows lack"):
        read = load_mesh(io.BytesIO(saved(cloud)), file_type="glb")
    assert list(read.attributes.point) == ["gain"]


def test_points_do_not_multiply_on_the_way() -> None:
    torus = samples.torus(20, 20)
    names = [f"m{i}" for i in range(5)]
    mesh = torus.with_attributes(
        {
            "face": {"material": np.arange(torus.n_faces) % 5},
            "labels": {"material": names},
            "material": {name: {"name": name} for name in names},
        }
    )
    for _ in range(3):
        mesh = load_mesh(io.BytesIO(saved(mesh)), file_type="glb")
        assert mesh.n_points == torus.n_points
        assert mesh.n_faces == 2 * torus.n_faces
        assert sorted(mesh.attributes.labels["material"]) == names
    assert np.bincount(mesh.attributes.face["material"]).tolist() == [2 * torus.n_faces // 5] * 5


# Section 3.7.2.1 of the glTF 2.0 specification: the types, the component types, and those that must be normalized.
FLOAT, UBYTE, USHORT = 5126, 5121, 5123
BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
DEFINED = {
    "POSITION": ({"VEC3"}, {FLOAT}, set()),
    "NORMAL": ({"VEC3"}, {FLOAT}, set()),
    "TANGENT": ({"VEC4"}, {FLOAT}, set()),
    "TEXCOORD": ({"VEC2"}, {FLOAT, UBYTE, USHORT}, {UBYTE, USHORT}),
    "COLOR": ({"VEC3", "VEC4"}, {FLOAT, UBYTE, USHORT}, {UBYTE, USHORT}),
    "JOINTS": ({"VEC4"}, {UBYTE, USHORT}, set[int]()),
    "WEIGHTS": ({"VEC4"}, {FLOAT, UBYTE, USHORT}, {UBYTE, USHORT}),
}


def assert_attributes_are_valid(document: Any) -> None:
    n_checked = 0
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            for semantic, i in primitive["attributes"].items():
                accessor, (kind, _, number) = document["accessors"][i], semantic.partition("_")
                view = document["bufferViews"][accessor["bufferView"]]
                width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
                component = accessor["componentType"]
                assert view.get("byteStride", width * BYTES[component]) % 4 == 0
                if semantic.startswith("_"):
                    assert component != 5125
                    continue
                types, components, normalized = DEFINED[kind]
                assert semantic in ("POSITION", "NORMAL", "TANGENT") or number.isdecimal()
                assert not number or all(f"{kind}_{k}" in primitive["attributes"] for k in range(int(number)))
                assert accessor["type"] in types
                assert component in components
                assert accessor.get("normalized", False) == (component in normalized)
                assert {"min", "max"} <= accessor.keys() or kind != "POSITION"
                n_checked += 1
            for target in primitive.get("targets", ()):
                for i in target.values():
                    assert (document["accessors"][i]["type"], document["accessors"][i]["componentType"]) == (
                        "VEC3",
                        FLOAT,
                    )
    assert n_checked


SETS = ["color", "color_1", "color_2", "texcoord", "texcoord_1", "color_" + "9" * 5000]
of_any_type = st.dictionaries(
    st.sampled_from(
        [*SETS, "normal", "tangent", "texcoord_01", "position", "POSITION", "joints_0", "COLOR_0", "_", "a b"]
    ),
    st.tuples(st.sampled_from(["f4", "f8", "u1", "u2", "i4", "u4", "i8", "?", "U1"]), st.integers(1, 5)),
)


@given(of_any_type, of_any_type, of_any_type)
@example({"normal": ("f4", 2), "tangent": ("f4", 3)}, {"texcoord": ("f8", 3)}, {"color": ("u1", 3)})
@example({"color_1": ("u1", 3), "texcoord": ("f4", 1)}, {"texcoord_1": ("f4", 2)}, {})
def test_attributes_have_the_types_of_the_specification(point: Any, corner: Any, face: Any) -> None:
    """What has no such type is told."""
    point = {name: column for name, column in point.items() if name not in corner}
    attributes = {
        what: {name: np.ones((n, width) if width > 1 else n, dtype) for name, (dtype, width) in table.items()}
        for what, table, n in (("point", point, 8), ("corner", corner, 24), ("face", face, 6))
    }
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        data = saved(samples.cube().with_attributes(attributes), "gltf")
    assert_attributes_are_valid(json.loads(data))
    text = str(caught[0].message) if caught else ""
    read = load_mesh(io.BytesIO(data), file_type="gltf").attributes.point
    for name, (dtype, width) in {**point, **corner}.items():
        what = "corner" if name in corner else "point"
        if name not in read:
            assert f"{name} per {what}" in text or f"{name} per point" in text
        elif name != "color" or "color" not in face:
            is_cut = name in ("texcoord", "texcoord_1") and width == 3 and dtype != "U1"
            assert read[name].shape[1:] == (() if width == 1 else (2 if is_cut else width,))
            assert (f"the third number of {name} per {what}" in text) == is_cut
    assert read.keys() <= {*point, *corner, "color"}


@given(of_any_type)
@example({"color": ("u1", 4)})
@example(
    {"color": ("u1", 3), "color_1": ("f4", 4), "color_2": ("f4", 2), "texcoord": ("f4", 2), "texcoord_1": ("f8", 3)}
)
def test_what_the_specification_defines_has_its_names(point: Any) -> None:
    """Other programs find colours and texture coordinates under no others."""
    columns = {name: np.ones((8, width) if width > 1 else 8, dtype) for name, (dtype, width) in point.items()}
    with warnings.catch_warnings(action="ignore"):
        document = json.loads(saved(samples.cube().with_attributes({"point": columns}), "gltf"))
    expected = {"POSITION"}
    widths = {"color": (3, 4), "texcoord": (2, 3), "normal": (3,), "tangent": (4,)}
    held = {
        name
        for name, (dtype, width) in point.items()
        if dtype != "U1" and width in widths.get(name.partition("_")[0], ())
    }
    for kind in ("color", "texcoord"):
        for k in range(3):
            if (kind if k == 0 else f"{kind}_{k}") not in held:
                break
            expected.add(f"{kind.upper()}_{k}")
    expected |= {name.upper() for name in ("normal", "tangent") if name in held}
    found = document["meshes"][0]["primitives"][0]["attributes"]
    assert {name for name in found if not name.startswith("_")} == expected


@pytest.mark.parametrize(
    ("column", "labels"),
    [
        ([0, 1], {}),
        *(
            (column, {"material": ["a", "b"]})
            for column in (
                [0.5, 0.25],
                [True, False],
                np.eye(2),
                np.eye(2, dtype=int),
                RaggedArray([1, 2, 1], [0, 1, 3]),
            )
        ),
    ],
)
def test_a_material_that_is_no_number_of_a_name_is_told(column: Any, labels: Any) -> None:
    """A property of PLY may have any values, in a list too."""
    mesh = Mesh(np.eye(4, 3), [(0, 1, 2), (1, 2, 3)], attributes={"face": {"material": column}, "labels": labels})
    with pytest.warns(MeshWarning, match="^<file>: glTF does not hold material per face$"):
        document = json.loads(saved(mesh, "gltf"))
    assert [part.keys() for part in document["meshes"][0]["primitives"]] == [{"attributes", "indices"}]


def test_third_texture_coordinates_of_zero_are_no_loss() -> None:
    """OBJ counts those that a file leaves out, NaN here, as 0; many exporters write them."""
    rows = np.random.default_rng(0).random((24, 3)) * (1, 1, 0)
    rows[3, 2] = math.nan
    read = load_mesh(io.BytesIO(saved(samples.cube().with_attributes({"corner": {"texcoord": rows}}))), file_type="glb")
    written = rows[:, :2].astype(np.float32)
    np.testing.assert_array_equal(np.unique(read.attributes.point["texcoord"], axis=0), np.unique(written, axis=0))


def test_an_attribute_per_point_beside_one_per_corner_is_told() -> None:
    mesh = samples.cube().with_attributes({"point": {"a": np.zeros(8)}, "corner": {"a": np.ones(24)}})
    with pytest.warns(MeshWarning, match=r"glTF does not hold a per point \(beside that per corner\)$"):
        read = load_mesh(io.BytesIO(saved(mesh)), file_type="glb")
    assert read.attributes.point["a"].tolist() == [1] * 8


def test_skins_and_targets_have_the_types_of_the_specification() -> None:
    builder = Builder()
    add_skinned_cube(builder, 1)
    assert_attributes_are_valid(json.loads(saved(scene_of(builder), "gltf")))


def test_normals_and_texture_coordinates_of_another_width_are_named() -> None:
    points = {"normal": np.eye(8, 2), "tangent": np.eye(8, 3), "texcoord": np.ones(8), "texcoord_1": np.eye(8, 3)}
    told = [
        *("normal per point (2 numbers, not 3)", "tangent per point (3 numbers, not 4)"),
        *("texcoord per point (1 number, not 2)", "the third number of texcoord_1 per point"),
    ]
    with pytest.warns(MeshWarning) as caught:
        saved(samples.cube().with_attributes({"point": points}))
    assert [str(each.message) for each in caught] == [f"<file>: glTF does not hold {', '.join(sorted(told))}"]
