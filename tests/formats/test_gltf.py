"""Scenes from files: the nodes of glTF, its meshes, and its two forms."""

import contextlib
import io
import json
import math
import struct
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gpu_xform import Mesh, Scene, chain, homogeneous, load_mesh, load_scene, samples, save_mesh, scale, translate
from gpu_xform.errors import ArgumentError, MeshError
from gpu_xform.geometry.attributes import sign_of_determinant
from tests.support.cost import within_cpu_s
from tests.support.gltf_files import BINARY, POINTS, TRIANGLE, as_text, change, data_uri, document, pack


def scene_of(content: Any, binary: bytes = BINARY) -> Scene:
    return load_scene(io.BytesIO(pack(content, binary)), file_type="glb")


def with_nodes(*nodes: dict[str, Any], roots: list[int] | None = None) -> Any:
    content = document()
    content["nodes"] = list(nodes)
    content["scenes"] = [{"nodes": [0] if roots is None else roots}]
    return content


def tree(scene: Scene) -> list[tuple[str, str | None, int]]:
    """Return name, parent and number of models of each node."""
    return [(node.name, node.parent, len(node.models)) for node in scene]


def test_nodes_keep_their_names_their_order_and_their_meshes() -> None:
    scene = scene_of(
        with_nodes(
            {"name": "car", "children": [3, 1]},
            {"name": "wheel", "mesh": 0, "translation": [1, 2, 3]},
            {"name": "elsewhere", "mesh": 0},
            {"name": "body", "children": [4], "scale": [1, 2, 4]},
            {"name": "mirror", "mesh": 0, "translation": [1, 1, 1]},
        )
    )
    assert tree(scene) == [("car", None, 0), ("body", "car", 0), ("mirror", "body", 1), ("wheel", "car", 1)]
    assert np.array_equal(scene.world("mirror"), scale(1, 2, 4) @ translate(1, 1, 1))
    assert scene["wheel"].models[0].model is scene["mirror"].models[0].model
    assert scene["wheel"].models[0].model == TRIANGLE
    (layer,) = scene.layers()
    assert np.array_equal(layer.transform, [scene.world("mirror"), scene.world("wheel")])


def test_a_tree_that_trimesh_wrote() -> None:
    graph: Any = trimesh.Scene()
    box, ball = trimesh.creation.box(), trimesh.creation.icosphere(subdivisions=1)
    matrices = {
        name: chain(scale(1, 2, 3), translate(*offset)) for name, offset in (("a", (1, 2, 3)), ("b", (4, 5, 6)))
    }
    graph.add_geometry(box, node_name="a", geom_name="box", transform=matrices["a"])
    graph.add_geometry(ball, node_name="b", geom_name="ball", parent_node_name="a", transform=matrices["b"])
    graph.graph.update("c", frame_from="b", geometry="box", matrix=matrices["a"])
    data = graph.export(file_type="glb")
    scene = load_scene(io.BytesIO(data), file_type="glb")
    assert tree(scene) == [("a", None, 1), ("b", "a", 1), ("c", "b", 1)]
    for name in ("a", "b", "c"):
        assert np.array_equal(scene.world(name), graph.graph[name][0])
    assert scene["a"].models[0].model is scene["c"].models[0].model
    for name, part in (("a", box), ("b", ball)):
        assert scene[name].models[0].model == Mesh(part.vertices.astype(np.float32), part.faces)


numbers = st.floats(-100, 100)
triples = st.tuples(numbers, numbers, numbers)
quaternions = st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: math.hypot(*q) > 1e-3)


@st.composite
def forests(draw: st.DrawFn) -> list[tuple[int, dict[str, Any]]]:
    """Return for each node its parent, an earlier one or -1, and what the file says of its place."""
    nodes: list[tuple[int, dict[str, Any]]] = []
    for i in range(draw(st.integers(1, 8))):
        if draw(st.booleans()):
            place: dict[str, Any] = {
                "matrix": np.vstack(
                    [np.reshape(draw(st.lists(numbers, min_size=12, max_size=12)), (3, 4)), [0, 0, 0, 1]]
                )
                .T.ravel()
                .tolist()
            }
        else:
            place = draw(
                st.fixed_dictionaries({}, optional={"translation": triples, "rotation": quaternions, "scale": triples})
            )
        nodes.append((draw(st.integers(-1, i - 1)), place))
    return nodes


def local(place: dict[str, Any]) -> Any:
    """Return the matrix of a node, by SciPy."""
    if "matrix" in place:
        return np.array(place["matrix"]).reshape(4, 4).T
    turn = Rotation.from_quat(place.get("rotation", (0, 0, 0, 1))).as_matrix()
    return translate(*place.get("translation", (0, 0, 0))) @ homogeneous(turn) @ scale(*place.get("scale", (1, 1, 1)))


@given(forests())
def test_every_node_is_where_the_product_of_its_matrices_puts_it(forest: list[tuple[int, dict[str, Any]]]) -> None:
    nodes = [{"name": str(i), "mesh": 0, **place} for i, (_, place) in enumerate(forest)]
    for i, (parent, _) in enumerate(forest):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(i)
    content = with_nodes(*nodes, roots=[i for i, (parent, _) in enumerate(forest) if parent < 0])
    scene = scene_of(content)
    worlds: list[Any] = []
    for parent, place in forest:
        worlds.append(local(place) if parent < 0 else worlds[parent] @ local(place))
    points: list[Any] = []
    corners: list[int] = []
    for node in scene:
        i = int(node.name)
        size = np.abs(worlds[i]).max()
        assert np.allclose(node.transform, local(forest[i][1]), rtol=1e-12, atol=1e-12)
        assert np.allclose(scene.world(node), worlds[i], rtol=1e-9, atol=1e-9 * size)
        order = (0, 2, 1) if sign_of_determinant(scene.world(node)) < 0 else (0, 1, 2)
        corners.extend(len(points) + corner for corner in order)
        points.extend(TRIANGLE.positions @ scene.world(node)[:3, :3].T + scene.world(node)[:3, 3])
    assert len(scene) == len(forest)
    mesh = load_mesh(io.BytesIO(pack(content)), file_type="glb")
    assert np.array_equal(mesh.positions, points)
    assert np.array_equal(mesh.indices, corners)


def test_names_are_made_unique() -> None:
    for given_, expected in (
        (
            ["wheel", None, "wheel", "wheel 2", "", "wheel"],
            ["wheel", "node 1", "wheel 3", "wheel 2", "node 4", "wheel 4"],
        ),
        (["node 1", None, "wheel 2", "wheel 2"], ["node 1", "node 1 2", "wheel 2", "wheel 2 2"]),
        (["node", "node", None, None], ["node", "node 2", "node 2 2", "node 3"]),
        ([None, "node", "node 0"], ["node 0 2", "node", "node 0"]),
    ):
        nodes = [{} if name is None else {"name": name} for name in given_]
        scene = scene_of(with_nodes(*nodes, roots=list(range(len(nodes)))))
        assert [node.name for node in scene] == expected


def test_the_scene_that_the_file_chooses_is_read() -> None:
    content = with_nodes({"name": "a"}, {"name": "b", "children": [2]}, {"name": "c"})
    content["scenes"] = [{"nodes": [0]}, {"nodes": [1]}]
    content["scene"] = 1
    assert [node.name for node in scene_of(content)] == ["b", "c"]
    del content["scene"]
    assert [node.name for node in scene_of(content)] == ["a"]
    del content["scenes"]
    assert [node.name for node in scene_of(content)] == ["a", "b", "c"]


def test_children_of_a_camera_are_kept() -> None:
    content = with_nodes({"camera": 0, "translation": [0, 0, 9], "children": [1]}, {"mesh": 0})
    content["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    assert load_mesh(io.BytesIO(pack(content)), file_type="glb").bounds.tolist() == [[0, 0, 9], [1, 1, 9]]


def primitive(mode: int | None, corners: list[int] | None, kind: str = "H") -> tuple[Any, bytes]:
    """Return a file of six points, drawn in one mode."""
    points = np.arange(18).reshape(6, 3).astype("<f4").tobytes()
    content = document()
    content["accessors"][0]["count"] = 6
    content["bufferViews"][0]["byteLength"] = 72
    binary = points
    if corners is None:
        del content["meshes"][0]["primitives"][0]["indices"], content["accessors"][1]
    else:
        indices = struct.pack(f"<{len(corners)}{kind}", *corners)
        content["accessors"][1].update(count=len(corners), componentType={"B": 5121, "H": 5123, "I": 5125}[kind])
        content["bufferViews"][1].update(byteOffset=72, byteLength=len(indices))
        binary += indices
    content["buffers"] = [{"byteLength": len(binary)}]
    if mode is not None:
        content["meshes"][0]["primitives"][0]["mode"] = mode
    return content, binary


@pytest.mark.parametrize("kind", ["B", "H", "I"])
@pytest.mark.parametrize(
    ("mode", "corners", "faces"),
    [
        (1, [5, 4, 0, 3], [(5, 4), (0, 3)]),
        (2, [5, 4, 0], [(5, 4), (4, 0), (0, 5)]),
        (3, [5, 4, 0, 3], [(5, 4), (4, 0), (0, 3)]),
        (None, [5, 4, 0, 3, 1, 2], [(5, 4, 0), (3, 1, 2)]),
        (4, [5, 4, 0, 3, 1, 2], [(5, 4, 0), (3, 1, 2)]),
        (5, [5, 4, 0, 3, 1], [(5, 4, 0), (4, 3, 0), (0, 3, 1)]),
        (5, [5, 4, 0, 0, 2, 2, 3, 1], [(5, 4, 0), (2, 1, 3)]),
        (6, [5, 4, 0, 3, 1], [(4, 0, 5), (0, 3, 5), (3, 1, 5)]),
    ],
)
def test_modes_of_drawing(mode: int | None, corners: list[int], faces: list[tuple[int, ...]], kind: str) -> None:
    content, binary = primitive(mode, corners, kind)
    mesh = scene_of(content, binary)["node 0"].models[0].model
    assert mesh == Mesh(np.arange(18).reshape(6, 3), faces)
    assert load_mesh(io.BytesIO(pack(content, binary)), file_type="glb") == mesh


@pytest.mark.parametrize(("mode", "corners"), [(1, []), (2, []), (3, [2]), (4, []), (5, [1, 2]), (6, [0]), (6, [])])
def test_a_primitive_without_a_face_shows_nothing(mode: int, corners: list[int]) -> None:
    assert tree(scene_of(*primitive(mode, corners))) == [("node 0", None, 0)]


def test_points_without_indices_are_taken_in_their_order() -> None:
    mesh = scene_of(*primitive(None, None))["node 0"].models[0].model
    assert mesh == Mesh(np.arange(18).reshape(6, 3), [(0, 1, 2), (3, 4, 5)])


def test_a_mesh_of_several_primitives_shows_each() -> None:
    content, binary = primitive(None, [5, 4, 0])
    content["meshes"][0]["primitives"] += [{"attributes": {"POSITION": 0}, "mode": mode} for mode in (0, 2)]
    models = [shown.model for shown in scene_of(content, binary)["node 0"].models]
    points = np.arange(18).reshape(6, 3)
    assert models == [Mesh(points, [(5, 4, 0), *((i, (i + 1) % 6) for i in range(6))]), Mesh(points)]
    mesh = load_mesh(io.BytesIO(pack(content, binary)), file_type="glb")
    assert np.array_equal(mesh.positions, np.concatenate([points, points]))
    assert [face.tolist() for face in mesh.faces][:2] == [[5, 4, 0], [0, 1]]


def test_points_are_those_that_indices_name() -> None:
    mesh = scene_of(*primitive(0, [5, 0, 0]))["node 0"].models[0].model
    assert mesh == Mesh([(15, 16, 17), (0, 1, 2), (0, 1, 2)])
    with pytest.raises(MeshError, match=r"mesh 0 names point 6, outside 0\.\.5"):
        scene_of(*primitive(0, [5, 6]))


@pytest.mark.parametrize(
    ("kind", "component", "most"), [("b", 5120, 127), ("B", 5121, 255), ("h", 5122, 32767), ("H", 5123, 65535)]
)
def test_integers_may_stand_for_fractions(kind: str, component: int, most: int) -> None:
    least = -most - 1 if kind.islower() else 0
    stride = 4 * struct.calcsize(kind)
    rows = [(0, most, 1), (least, 0, 0), (1, 2, 3)]
    data = b"\xee" * 4 + b"".join(struct.pack(f"<3{kind}", *row).ljust(stride, b"\xee") for row in rows)
    content = document()
    content["accessors"][0].update(componentType=component, byteOffset=4)
    content["bufferViews"][0].update(byteLength=len(data), byteStride=stride)
    content["bufferViews"][1].update(byteOffset=len(data))
    content["buffers"] = [{"byteLength": len(data) + 6}]
    for normalized, expected in ((False, rows), (True, np.maximum(np.array(rows) / most, -1))):
        content["accessors"][0]["normalized"] = normalized
        model = scene_of(content, data + BINARY[36:])["node 0"].models[0].model
        assert model == Mesh(expected, [(0, 1, 2)])


HALF = math.sqrt(0.5)


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ({"translation": [1, 2]}, r"translation must have shape \(3,\), got \(2,\)"),
        ({"translation": [1, 2, math.nan]}, "translation must be finite, got nan at index 2"),
        ({"scale": [1, 2, "3"]}, "scale must hold real numbers"),
        ({"scale": {"x": 1}}, "scale must hold real numbers"),
        ({"rotation": [0, 0, 0, 0]}, "rotation must not be the zero vector"),
        ({"rotation": [0, 0, HALF]}, r"rotation must have shape \(4,\), got \(3,\)"),
        ({"matrix": [1, 2, 3]}, r"matrix must have shape \(16,\), got \(3,\)"),
        ({"matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}, r"matrix must be affine, .* got \(1, 0, 0, 1\)"),
        (
            {"matrix": np.eye(4).ravel().tolist(), "scale": [1, 1, 1]},
            "it has both a matrix and a translation, rotation",
        ),
        ({"name": 5}, "name must be a text, got '5'"),
    ],
)
def test_nodes_that_are_nowhere_are_named_with_their_file(tmp_path: Path, node: Any, message: str) -> None:
    path = tmp_path / "bad.glb"
    path.write_bytes(pack(with_nodes({"children": [1]}, {"mesh": 0, **node})))
    for load in (load_scene, load_mesh):
        with pytest.raises(MeshError, match=rf"bad\.glb: node 1: {message}"):
            load(path)


@pytest.mark.parametrize(
    ("nodes", "roots", "message"),
    [
        ([{"children": [0]}], [0], "1 nodes are descendants of themselves"),
        ([{}, {"children": [2]}, {"children": [1]}], [0], "2 nodes are descendants of themselves"),
        (
            [{"children": [2]}, {"children": [2]}, {}],
            [0],
            "node 1 has the child 2, which is no node or has a parent already",
        ),
        ([{"children": [1, 1]}, {}], [0], "node 0 has the child 1, which is no node or has a parent already"),
        ([{"children": [1]}, {}], [0, 1], "the scene lists node 1, which is in node 0"),
        ([{"children": [-1]}, {}], [0], "node 0 has the child -1"),
    ],
)
def test_nodes_that_are_no_tree_are_refused(tmp_path: Path, nodes: Any, roots: list[int], message: str) -> None:
    path = tmp_path / "knot.glb"
    path.write_bytes(pack(with_nodes(*nodes, roots=roots)))
    for load in (load_scene, load_mesh):
        with pytest.raises(MeshError) as caught:
            load(path)
        assert str(caught.value).startswith(f"{path}: {message}")


def test_a_world_that_overflows_is_an_error_of_the_file() -> None:
    huge = {"scale": [1e200, 1e200, 1e200]}
    content = with_nodes({**huge, "children": [1]}, {**huge, "mesh": 0})
    with pytest.raises(MeshError, match="<file>: the world matrix of 'node 1' must stay within float64's range"):
        load_mesh(io.BytesIO(pack(content)), file_type="glb")


@pytest.mark.slow
def test_what_is_large_in_nodes_alone_is_read_soon() -> None:
    for _ in within_cpu_s(10.0):
        n = 20_000
        crowd = scene_of(with_nodes(*[{"mesh": 0, "name": "tree"}] * n, roots=list(range(n))))
        assert len(crowd) == n
        assert f"tree {n}" in crowd
        (layer,) = crowd.layers()
        assert layer.transform.shape == (n, 4, 4)
        chain = [{"children": [i + 1], "translation": [1, 0, 0]} for i in range(n - 1)]
        deep = scene_of(with_nodes(*chain, {"mesh": 0}))
        assert np.array_equal(deep.world(f"node {n - 1}"), translate(n - 1, 0, 0))


def test_meshes_that_use_one_array_too_often_are_refused() -> None:
    count = 99_999
    content = document()
    for accessor in content["accessors"]:
        accessor["count"] = count
    content["bufferViews"] = [{"buffer": 0, "byteLength": 12 * count}, {"buffer": 0, "byteLength": 2 * count}]
    content["buffers"] = [{"byteLength": 12 * count}]
    content["meshes"] = [{"primitives": content["meshes"][0]["primitives"] * 1000}]
    with pytest.raises(
        MeshError, match=r"mesh 0: expands to more than .* numbers, the limit FileLimits\(points=\.\.\.\)"
    ):
        scene_of(content, b"\0" * 12 * count)


def test_any_other_file_is_one_node(tmp_path: Path) -> None:
    path = tmp_path / "my house.obj"
    save_mesh(samples.house(), path)
    for source, kind, name in ((path, None, "my house"), (io.BytesIO(path.read_bytes()), "obj", "node 1")):
        scene = load_scene(source, file_type=kind)
        assert tree(scene) == [(name, None, 1)]
        assert scene[name].models[0].model == samples.house()
        assert np.array_equal(scene.world(name), np.eye(4))
    with pytest.raises(MeshError, match="the type must be one of 3mf, dae, glb, gltf, "):
        load_scene(io.BytesIO(b""), file_type="txt")
    with pytest.raises(ArgumentError, match="file_type must be given"):
        load_scene(io.BytesIO(b""))
    with pytest.raises(MeshError, match="<file>: the file is empty"):
        load_scene(io.BytesIO(b""), file_type="glb")


def test_gltf_holds_its_buffers_or_names_files_beside_it(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "the corners.bin").write_bytes(BINARY[36:])
    (tmp_path / "all.bin").write_bytes(BINARY)
    for uris in (
        [data_uri(BINARY)],
        ["all.bin"],
        ["./parts/../all.bin"],
        [data_uri(POINTS), quote("parts/the corners.bin")],
        [data_uri(POINTS), "parts/the corners.bin"],
    ):
        path = tmp_path / "model.gltf"
        path.write_bytes(as_text(*uris))
        assert load_scene(path)["node 0"].models[0].model == TRIANGLE
        assert load_mesh(str(path)) == TRIANGLE
    assert load_mesh(io.BytesIO(as_text(data_uri(BINARY))), file_type="gltf") == TRIANGLE


def test_gltf_opens_no_other_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "model"
    folder.mkdir()
    (tmp_path / "secret.bin").write_bytes(BINARY)
    (folder / "link.bin").symlink_to(tmp_path / "secret.bin")
    (folder / "folder.bin").mkdir()
    path = folder / "model.gltf"
    monkeypatch.chdir(folder)
    refused = ["../secret.bin", "%2e%2e/secret.bin", str(tmp_path / "secret.bin"), "link.bin", "../none.bin"]
    refused += ["file:///etc/passwd", "https://example.org/a.bin", "a\0.bin", "n" * 5000]
    missing = ["none.bin", "no/ne.bin", "folder.bin", "", "n" * 300, "n" * 20 + "%20"]
    for uri in (*refused, *missing):
        path.write_bytes(as_text(uri))
        shown = repr(uri if len(uri) <= 40 else uri[:37] + "...")
        text = f"its buffer must be a file beside it, got {shown}" + ", which was not found" * (uri in missing)
        for name in (path, "model.gltf"):
            with pytest.raises(MeshError) as caught:
                load_mesh(name)
            assert str(caught.value) == f"{name}: {text}"
        with pytest.raises(MeshError, match=r"<file>: its buffer is another file, .*, which is not opened"):
            load_scene(io.BytesIO(path.read_bytes()), file_type="gltf")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (as_text(None), "buffer 0 has no content"),
        (as_text(data_uri(BINARY), None), "buffer 1 has no content"),
        (as_text(data_uri(BINARY[:-1])), "buffer 0 declares 42 bytes, it has 41"),
        (as_text("data:,abc"), "a data URI must be base64, got 'data:,abc'"),
        (as_text("data:;base64,a!aa"), "a data URI must be base64, got 'data:;base64,a!aa'"),
        (as_text("data:;base64,\xe9"), "a data URI must be base64"),
        (b"\xff", "the JSON is malformed"),
        *[
            (text.encode(), f"the JSON is not glTF: it must be an object, got {got}")
            for text, got in (("[]", "an array"), ("null", "null"), ("1", "'1'"), ('"a"', "'a'"), ("true", "true"))
        ],
        (
            json.dumps({"buffers": [{"byteLength": 1, "uri": 5}]}).encode(),
            "the JSON is not glTF: 'buffers[0].uri' must be a text, got '5'",
        ),
        (json.dumps({"buffers": 5}).encode(), "the JSON is not glTF: 'buffers' must be an array, got '5'"),
    ],
)
def test_broken_gltf_is_refused(data: bytes, message: str) -> None:
    for load in (load_scene, load_mesh):
        with pytest.raises(MeshError) as caught:
            load(io.BytesIO(data), file_type="gltf")
        assert str(caught.value).startswith(f"<file>: {message}")


@pytest.mark.parametrize(
    "part", [{"skins": 0}, {"scenes": 0}, {"scenes": [{"nodes": [0]}, 0]}, {"extensionsUsed": 5}, {"cameras": 1.5}]
)
def test_parts_that_no_mesh_holds_must_be_gltf_too(part: dict[str, Any]) -> None:
    data = json.dumps(document() | {"buffers": [{"byteLength": len(BINARY), "uri": data_uri(BINARY)}]} | part)
    with pytest.raises(
        MeshError, match=r"<file>: the JSON is not glTF: '[a-zA-Z01\[\]]+' must be an (array|object), got '[0-9.]+'$"
    ):
        load_mesh(io.BytesIO(data.encode()), file_type="gltf")


def test_binary_gltf_may_hold_text_buffers_too() -> None:
    content = document()
    content["buffers"] = [{"byteLength": 36}, {"byteLength": 6, "uri": data_uri(BINARY[36:])}]
    content["bufferViews"][1].update(buffer=1, byteOffset=0)
    assert scene_of(content, POINTS)["node 0"].models[0].model == TRIANGLE


paths = st.sampled_from(
    [
        *("nodes", "nodes.0", "nodes.0.mesh", "nodes.0.children", "nodes.0.name", "nodes.0.matrix", "scene", "scenes"),
        *("scenes.0", "scenes.0.nodes", "meshes", "meshes.0", "meshes.0.primitives", "meshes.0.primitives.0"),
        *("meshes.0.primitives.0.attributes", "meshes.0.primitives.0.mode", "accessors", "accessors.0.count"),
        *("accessors.0.bufferView", "accessors.1.componentType", "accessors.1.type", "bufferViews.0.byteStride"),
        *("bufferViews", "bufferViews.0.byteLength", "buffers", "buffers.0", "buffers.0.byteLength", "buffers.0.uri"),
    ]
)
values = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 3) | st.floats() | st.text(max_size=3) | st.just(10**400),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["0", "nodes", "mesh"]), inner),
)


@pytest.mark.slow
@given(path=paths, value=values)
def test_whatever_stands_in_a_document_gives_a_scene_or_a_mesh_error(path: str, value: Any) -> None:
    content = document()
    content["nodes"][0].update(children=[], matrix=np.eye(4).ravel().tolist(), name="a")
    if value is not None:
        change(path, value)(content)
    with contextlib.suppress(MeshError):
        assert isinstance(scene_of(content), Scene)
