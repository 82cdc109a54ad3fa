"""Skins, morph targets and packed arrays of glTF, against sums written out in NumPy, and against the encoders."""

import io
import json
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import DracoPy
import meshopt
import numpy as np
import pygltflib
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.spatial.transform import Rotation

from gpu_xform import Mesh, Scene, load_mesh, load_scene, rotate_z, samples, scale, translate
from gpu_xform.errors import MeshError, MissingExtraError
from gpu_xform.formats import gltf_meshes
from gpu_xform.formats.gltf import merge_scene
from gpu_xform.geometry.attributes import freeze_value
from gpu_xform.geometry.deformable_mesh import DeformableMesh
from tests.support.cost import within_cpu_s
from tests.support.gltf_files import Builder, document, pack

CUBE = samples.cube().to_trimesh()
POINTS = np.asarray(CUBE.vertices, np.float32)


def mesh_of(builder: Builder) -> Mesh:
    return load_mesh(io.BytesIO(builder.pack()), file_type="glb")


def scene_of(builder: Builder) -> Scene:
    return load_scene(io.BytesIO(builder.pack()), file_type="glb")


def add_cube(builder: Builder, **more: Any) -> dict[str, Any]:
    return {
        "attributes": {"POSITION": builder.array(POINTS), **more},
        "indices": builder.array(CUBE.faces.ravel(), "<u2"),
    }


def local(node: pygltflib.Node) -> Any:
    """Return the matrix of a node that pygltflib read, by SciPy."""
    turn = Rotation.from_quat(node.rotation or (0, 0, 0, 1)).as_matrix()
    matrix = np.eye(4)
    matrix[:3, :3] = turn * (node.scale or (1, 1, 1))
    matrix[:3, 3] = node.translation or (0, 0, 0)
    return matrix


def read_array(gltf: pygltflib.GLTF2, i: int) -> Any:
    """Return the rows of an accessor that pygltflib read, as floats."""
    accessor = gltf.accessors[i]
    view = gltf.bufferViews[accessor.bufferView]
    data = gltf.binary_blob()[view.byteOffset :]
    kind = {5121: "u1", 5123: "<u2", 5126: "<f4"}[accessor.componentType]
    columns = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[accessor.type]
    rows = np.frombuffer(data, kind, accessor.count * columns).reshape(-1, columns).astype(float)
    return rows / np.iinfo(kind).max if accessor.normalized else rows


def skinned_points(data: bytes) -> Any:
    """Return the points of the first mesh, which the first skin carries (glTF 2.0, 3.7.3.3), through pygltflib."""
    gltf = pygltflib.GLTF2.load_from_bytes(data)
    parents = {child: i for i, node in enumerate(gltf.nodes) for child in node.children or ()}

    def world(i: int) -> Any:
        matrix = local(gltf.nodes[i])
        return world(parents[i]) @ matrix if i in parents else matrix

    skin = gltf.skins[0]
    bind = read_array(gltf, skin.inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1)
    matrices = np.array([world(joint) @ b for joint, b in zip(skin.joints, bind, strict=True)])
    attributes = gltf.meshes[0].primitives[0].attributes
    points, joints, weights = (
        read_array(gltf, getattr(attributes, name)) for name in ("POSITION", "JOINTS_0", "WEIGHTS_0")
    )
    blended = np.einsum("nb,nbij->nij", weights, matrices[joints.astype(int)])
    return np.einsum("nij,nj->ni", blended, np.c_[points, np.ones(len(points))])[:, :3]


def add_skinned_cube(builder: Builder, seed: int, weight_type: str = "<f4", n_joints: int = 3) -> None:
    """Add a cube that joints in a chain carry, beside a mesh node that stands elsewhere."""
    rng = np.random.default_rng(seed)
    weights = rng.random((8, 4))
    weights /= weights.sum(axis=1, keepdims=True)
    if weight_type != "<f4":
        weights = np.round(weights * np.iinfo(weight_type).max)
    cube = add_cube(
        builder,
        JOINTS_0=builder.array(rng.integers(0, n_joints, (8, 4)), "|u1"),
        WEIGHTS_0=builder.array(weights, weight_type, normalized=weight_type != "<f4"),
    )
    bind = np.tile(np.eye(4), (n_joints, 1, 1))
    bind[:, :3] = rng.normal(size=(n_joints, 3, 4))
    builder.mesh(cube)
    joints = [
        builder.node(
            name=f"joint {i}",
            translation=rng.normal(size=3).tolist(),
            rotation=Rotation.random(rng=rng).as_quat().tolist(),
            scale=(rng.random(3) + 0.5).tolist(),
            children=[i + 1] if i + 1 < n_joints else [],
        )
        for i in range(n_joints)
    ]
    armature = builder.node(name="armature", translation=[10, 0, 0], scale=[2, 2, 2], children=[0])
    body = builder.node(name="body", mesh=0, skin=0, translation=[5, 6, 7], scale=[3, 1, 1])
    builder.content["skins"] = [{"joints": joints, "inverseBindMatrices": builder.array(bind)}]
    builder.content["scenes"] = [{"nodes": [armature, body]}]


@pytest.mark.parametrize("weight_type", ["<f4", "|u1", "<u2"])
def test_a_skin_puts_points_where_the_sum_of_its_joints_does(weight_type: str) -> None:
    for seed in range(10):
        builder = Builder()
        add_skinned_cube(builder, seed, weight_type)
        expected = skinned_points(builder.pack())
        assert np.allclose(mesh_of(builder).positions, expected, rtol=1e-6, atol=1e-6)
        for mesh, matrices in ((layer.model, layer.transform) for layer in scene_of(builder).layers()):
            assert np.allclose(mesh.positions, expected, rtol=1e-6, atol=1e-6)
            assert np.array_equal(matrices, [np.eye(4)])


def test_a_skin_follows_its_joints_when_they_are_posed() -> None:
    builder = Builder()
    add_skinned_cube(builder, 1)
    scene = scene_of(builder)
    posed = scene.posed({"joint 1": np.eye(4), "body": translate(9, 9, 9)})
    builder.content["nodes"][1] = {"name": "joint 1", "children": [2]}
    (layer,) = posed.layers()
    assert np.allclose(layer.model.positions, skinned_points(builder.pack()), rtol=1e-6, atol=1e-6)
    moved = scene.posed({"armature": translate(1, 2, 3) @ scene["armature"].transform}).layers()[0].model
    assert np.allclose(moved.positions, scene.layers()[0].model.positions + np.array([1, 2, 3]))


def test_all_sets_of_joints_count() -> None:
    builder = Builder()
    cube = add_cube(builder)
    weights = np.zeros((8, 8), np.float32)
    weights[:, [0, 5]] = 0.25, 0.75
    for name, columns in (("0", slice(0, 4)), ("1", slice(4, 8))):
        cube["attributes"][f"JOINTS_{name}"] = builder.array([[0, 0, 0, 0] if name == "0" else [0, 1, 0, 0]] * 8, "|u1")
        cube["attributes"][f"WEIGHTS_{name}"] = builder.array(weights[:, columns])
    builder.mesh(cube)
    joints = [builder.node(), builder.node(translation=[4, 0, 0])]
    builder.node(mesh=0, skin=0)
    builder.content["skins"] = [{"joints": joints}]
    assert np.allclose(mesh_of(builder).positions, POINTS + np.array([3, 0, 0]))


def test_joints_that_mirror_reverse_the_faces_of_a_skin() -> None:
    for matrix, sign in (([-1, 1, 1], 1), ([1, 1, 1], 1)):
        builder = Builder()
        cube = add_cube(
            builder,
            JOINTS_0=builder.array(np.zeros((8, 4)), "|u1"),
            WEIGHTS_0=builder.array(np.tile([1, 0, 0, 0], (8, 1))),
        )
        builder.mesh(cube)
        builder.content["skins"] = [{"joints": [builder.node(scale=matrix)]}]
        builder.node(mesh=0, skin=0)
        assert np.sign(mesh_of(builder).to_trimesh().volume) == sign


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("skins.0.joints", [0, 1], "a point follows joint 2 of a skin with 2 joints"),
        ("skins.0.joints", [], "skin 0 must list its joints"),
        ("skins.0.joints", [-1, 0, 1], "skin 0 must list its joints"),
        ("skins.0.joints", [0, 1, 2, 3], "skin 0 has 3 matrices for 4 joints"),
        ("scenes.0.nodes", [4], "skin must have its joints in the scene, got 'joint 0'"),
        ("accessors.0.componentType", 5120, "JOINTS_0 must be unsigned integers, got int8"),
        ("accessors.0.count", 7, "JOINTS_0 and WEIGHTS_0 have 7 and 8 rows for 8 points"),
        ("nodes.4.weights", [1.0], "weights must have shape"),
    ],
)
def test_a_skin_that_contradicts_its_mesh_is_refused(path: str, value: Any, message: str) -> None:
    from tests.support.gltf_files import change

    builder = Builder()
    add_skinned_cube(builder, 0)
    change(path, value)(builder.content)
    with pytest.raises(MeshError, match=message):
        mesh_of(builder)


@given(
    arrays.arrays(np.float32, (2, 8, 3), elements=st.floats(-4, 4, width=32)),
    st.lists(st.floats(-2, 2), min_size=2, max_size=2),
)
def test_morph_weights_add_targets(targets: Any, weights: list[float]) -> None:
    expected = POINTS + np.einsum("t,tnj->nj", weights, targets.astype(float))
    for of_mesh, of_node in ((weights, None), ([9, 9], weights), (None, weights), (None, None)):
        builder = Builder()
        cube = add_cube(builder) | {"targets": [{"POSITION": builder.array(target)} for target in targets]}
        builder.mesh(cube, **({} if of_mesh is None else {"weights": of_mesh}))
        builder.node(mesh=0, translation=[1, 2, 3], **({} if of_node is None else {"weights": of_node}))
        is_plain = of_mesh is None and of_node is None
        assert np.allclose(
            mesh_of(builder).positions, (POINTS if is_plain else expected) + np.array([1, 2, 3]), atol=1e-6
        )
    model = scene_of(builder)["node 0"].models[0].model
    assert isinstance(model, DeformableMesh)
    assert model.mesh == Mesh(POINTS, CUBE.faces)
    (layer,) = scene_of(builder).posed({}, {"node 0": weights}).layers()
    assert np.allclose(layer.model.positions, expected)


def test_targets_are_moved_before_the_skin_moves_the_points() -> None:
    builder = Builder()
    add_skinned_cube(builder, 4)
    builder.content["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": builder.array(np.ones((8, 3)))}]
    builder.content["meshes"][0]["weights"] = [0.5]
    got = mesh_of(builder).positions
    builder.content["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = builder.array(POINTS + 0.5)
    assert np.allclose(got, skinned_points(builder.pack()), atol=1e-6)


def test_targets_of_another_length_are_refused() -> None:
    builder = Builder()
    builder.mesh(add_cube(builder) | {"targets": [{"POSITION": builder.array(POINTS[:5])}]})
    builder.node(mesh=0)
    with pytest.raises(MeshError, match="mesh 0: morph target 0 moves 5 points, the mesh has 8"):
        mesh_of(builder)


def test_targets_that_move_no_point_share_their_zeros() -> None:
    """A megabyte can spell 320,000 of them: as arrays of their own they took 3.5 s in isolation."""
    builder = Builder()
    builder.mesh(add_cube(builder) | {"targets": [{}, {"POSITION": builder.array(POINTS)}, {}]}, weights=[5, 2, 7])
    builder.node(mesh=0)
    model = scene_of(builder)["node 0"].models[0].model
    assert isinstance(model, DeformableMesh)
    first, moving, last = model.targets
    assert first is last
    assert first.shape == (8, 3)
    assert not first.any()
    assert np.array_equal(moving, POINTS)
    assert np.array_equal(mesh_of(builder).positions, 3.0 * POINTS)


def test_instances_stand_where_their_properties_say() -> None:
    rng = np.random.default_rng(0)
    moves, turns, sizes = rng.normal(size=(5, 3)), Rotation.random(5, rng=rng).as_quat(), rng.random((5, 3)) + 0.5
    for names in (("TRANSLATION", "ROTATION", "SCALE"), ("TRANSLATION",), ("SCALE", "ROTATION")):
        builder = Builder()
        builder.mesh(add_cube(builder))
        given_ = {"TRANSLATION": moves, "ROTATION": turns, "SCALE": sizes}
        attributes = {name: builder.array(given_[name]) for name in names}
        builder.node(
            mesh=0, scale=[2, 2, 2], children=[1], extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}}
        )
        builder.node(mesh=0, translation=[9, 9, 9])
        builder.content["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
        builder.content["scenes"] = [{"nodes": [0]}]
        expected = []
        for move, turn, size in zip(moves, turns, sizes, strict=True):
            points = POINTS * (size if "SCALE" in names else 1)
            points = Rotation.from_quat(turn).apply(points) if "ROTATION" in names else points
            expected.append(2 * (points + (move if "TRANSLATION" in names else 0)))
        expected.append(2 * (POINTS + np.array([9, 9, 9])))
        assert np.allclose(mesh_of(builder).positions, np.concatenate(expected), atol=1e-5)
        (layer,) = scene_of(builder).layers()
        assert layer.transform.shape == (6, 4, 4)


def instanced(accessor: int) -> dict[str, Any]:
    return {"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": accessor}}}}


@pytest.mark.parametrize("isolated", [False, True])
def test_nodes_share_the_copies_of_the_same_accessors(isolated: bool) -> None:
    builder = Builder()
    builder.mesh(add_cube(builder))
    moves = [builder.array(np.full((3, 3), k)) for k in range(2)]
    for k in (0, 0, 1, 0):
        builder.node(mesh=0, **instanced(moves[k]))
    scene = load_scene(io.BytesIO(builder.pack()), file_type="glb", isolated=isolated)
    first, *others = [node.instances for node in scene]
    assert [each is first for each in others] == [True, False, True]
    assert first is not None
    assert not first.flags.writeable
    (layer,) = scene.layers()
    assert layer.transform[:, 0, 3].tolist() == [0.0] * 6 + [1.0] * 3 + [0.0] * 3
    assert layer.nodes == tuple(f"node {k}" for k in range(4) for _ in range(3))


def test_copies_that_nothing_shows_are_counted_before_they_are_made() -> None:
    builder = Builder()
    builder.mesh(add_cube(builder))
    builder.node(mesh=0)
    moves = builder.array(np.ones((50_000, 3)), "|i1", normalized=True)
    accessors = builder.content["accessors"]
    for _ in range(100):
        accessors.append(accessors[moves])
        builder.node(**instanced(len(accessors) - 1))

    def read() -> None:
        with pytest.raises(MeshError, match=r"EXT_mesh_gpu_instancing: expands to more than [\d,]+ numbers beside"):
            mesh_of(builder)

    assert peak_memory(read) < 100e6  # of 640


def test_copies_that_share_their_matrices_are_counted_before_they_are_placed() -> None:
    builder = Builder()
    builder.mesh({"attributes": {"POSITION": builder.array([(1, 2, 3)])}, "mode": 0})
    moves = builder.array(np.ones((50_000, 3)), "|i1", normalized=True)
    for _ in range(24):
        builder.node(mesh=0, **instanced(moves))
    with pytest.raises(MeshError, match=r"node 'node \d+': expands to more than [\d,]+ numbers beside its points"):
        mesh_of(builder)


def test_a_file_that_holds_many_copies_is_read_soon() -> None:
    builder = Builder()
    builder.mesh({"attributes": {"POSITION": builder.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)])}})
    turns = np.random.default_rng(0).integers(1, 127, (200_000, 4))
    attributes = {"ROTATION": builder.array(turns, "|i1", normalized=True)}
    builder.node(mesh=0, extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})
    for _ in within_cpu_s(2):  # 6 s copy by copy
        points = mesh_of(builder).positions.reshape(-1, 3, 3)
    expected = Rotation.from_quat(turns).as_matrix()
    np.testing.assert_allclose(points[:, 1:].transpose(0, 2, 1), expected[:, :, :2], atol=1e-12)


def test_a_file_that_several_buffers_name_counts_once(tmp_path: Path) -> None:
    (tmp_path / "many.bin").write_bytes(bytes(36))
    content = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "many.bin", "byteLength": 36}] * 100,
        "accessors": [{"componentType": 5120, "type": "VEC3", "count": 37}],
        "nodes": [instanced(0)],
    }
    (tmp_path / "many.gltf").write_text(json.dumps(content))
    with pytest.raises(MeshError, match="places 37 copies, its buffers have 36 bytes"):
        load_scene(tmp_path / "many.gltf")


def test_nodes_that_are_not_visible_show_nothing() -> None:
    builder = Builder()
    builder.mesh(add_cube(builder))
    hidden = {"KHR_node_visibility": {"visible": False}}
    builder.node(mesh=0, name="hidden", children=[1], extensions=hidden)
    builder.node(mesh=0, name="in it", extensions={"KHR_node_visibility": {"visible": True}})
    builder.node(mesh=0, name="shown", translation=[9, 0, 0])
    builder.content["extensionsRequired"] = ["KHR_node_visibility"]
    builder.content["scenes"] = [{"nodes": [0, 2]}]
    assert np.array_equal(mesh_of(builder).positions, POINTS + np.array([9, 0, 0]))
    scene = scene_of(builder)
    assert [node.visible for node in scene] == [False, True, True]
    scene["hidden"].visible = True
    (layer,) = scene.layers()
    assert len(layer.transform) == 3


def test_quantized_points_are_read() -> None:
    builder = Builder()
    builder.content["extensionsRequired"] = ["KHR_mesh_quantization"]
    rows = np.zeros((8, 4), "<i2")
    rows[:, :3] = np.round(POINTS * 100)
    view = builder.view(rows.tobytes(), byteStride=8)
    positions = builder.array(np.zeros((8, 3)), "<i2", bufferView=view)
    builder.mesh({"attributes": {"POSITION": positions}, "indices": builder.array(CUBE.faces.ravel(), "<u2")})
    builder.node(mesh=0, scale=[0.01, 0.01, 0.01])
    assert np.allclose(mesh_of(builder).positions, POINTS, atol=0.006)


def add_meshopt(builder: Builder, values: Any, mode: str) -> int:
    """Add an accessor that meshopt packs, whose own buffer is an empty stand-in."""
    data = meshopt.encode_gltf_buffer(values, mode)
    stride = values.itemsize * (1 if values.ndim == 1 else values.shape[1])
    view = builder.view(data)
    packed = builder.content["bufferViews"][view] | {"byteStride": stride, "mode": mode}
    packed["count"] = len(values)
    builder.content["bufferViews"][-1] = {
        "buffer": 1,
        "byteLength": values.nbytes,
        "extensions": {"EXT_meshopt_compression": packed},
    }
    dtype = values.dtype.str
    return builder.array(values, dtype, bufferView=len(builder.content["bufferViews"]) - 1)


def meshopt_cube() -> Builder:
    builder = Builder()
    positions = add_meshopt(builder, POINTS, "ATTRIBUTES")
    corners = CUBE.faces.ravel().astype("<u2")
    indices = add_meshopt(builder, corners.astype("<u4"), "TRIANGLES")
    builder.mesh({"attributes": {"POSITION": positions}, "indices": indices})
    builder.node(mesh=0)
    builder.content["buffers"].append(
        {"byteLength": 4096, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}
    )
    builder.content["extensionsRequired"] = ["EXT_meshopt_compression"]
    return builder


def sorted_triangles(mesh: Mesh) -> list[Any]:
    return sorted(
        np.roll(t, -np.lexsort(t.T)[0], axis=0).ravel().tolist() for t in mesh.positions[np.asarray(mesh.faces)]
    )


def test_arrays_packed_by_meshopt_are_read() -> None:
    mesh = mesh_of(meshopt_cube())
    assert np.array_equal(mesh.positions, POINTS)
    assert sorted_triangles(mesh) == sorted_triangles(Mesh(POINTS, CUBE.faces))


def test_damaged_meshopt_is_refused() -> None:
    builder = meshopt_cube()
    packed = builder.content["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]
    for name, value in (("byteLength", 9), ("count", 2**40), ("byteStride", 11), ("mode", "X"), ("byteOffset", 10**6)):
        before, packed[name] = packed.get(name, 0), value
        with pytest.raises(MeshError):
            mesh_of(builder)
        packed[name] = before


def draco_cube(*, fallback: bool) -> Builder:
    builder = Builder()
    data = DracoPy.encode(POINTS, CUBE.faces.astype(np.uint32), quantization_bits=20, preserve_order=True)
    decoded = DracoPy.decode(data)
    primitive = (
        add_cube(builder)
        if fallback
        else {"attributes": {"POSITION": len(builder.content.setdefault("accessors", []))}, "indices": 1}
    )
    if not fallback:
        builder.content["accessors"] = [
            {"componentType": 5126, "count": len(decoded.points), "type": "VEC3"},
            {"componentType": 5125, "count": decoded.faces.size, "type": "SCALAR"},
        ]
    unique_id = decoded.attributes[0]["unique_id"]
    primitive["extensions"] = {
        "KHR_draco_mesh_compression": {"bufferView": builder.view(data), "attributes": {"POSITION": unique_id}}
    }
    builder.mesh(primitive)
    builder.node(mesh=0, translation=[1, 0, 0])
    builder.content["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    return builder


def test_meshes_packed_by_draco_are_read() -> None:
    for fallback in (False, True):
        mesh = mesh_of(draco_cube(fallback=fallback))
        solid = mesh.to_trimesh()
        assert np.allclose(
            mesh.bounds, [POINTS.min(axis=0) + np.array([1, 0, 0]), POINTS.max(axis=0) + np.array([1, 0, 0])], atol=1e-5
        )
        assert (mesh.n_faces, solid.volume) == (12, pytest.approx(CUBE.volume, rel=1e-5))


def test_damaged_draco_is_refused() -> None:
    for path, value, message in (
        (("accessors", 0, "count"), 9, r"accessor 0 declares 9 rows of 3, its content has shape \(8, 3\)"),
        (("accessors", 0, "count"), 7, "mesh 0: KHR_draco_mesh_compression: accessor 0 declares 7 rows, its content"),
        (("bufferViews", 0, "byteLength"), 30, "mesh 0: KHR_draco_mesh_compression: "),
    ):
        builder = draco_cube(fallback=False)
        section, i, key = path
        builder.content[section][i][key] = value
        with pytest.raises(MeshError, match=message):
            mesh_of(builder)
    packed = builder.content["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
    builder = draco_cube(fallback=False)
    packed = builder.content["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
    packed["attributes"]["POSITION"] = 77
    with pytest.raises(MeshError, match="has no attribute 77 for POSITION"):
        mesh_of(builder)


def test_without_their_libraries_packed_arrays_name_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    monkeypatch.setitem(sys.modules, "meshopt", None)
    for builder, library in ((draco_cube(fallback=False), "DracoPy"), (meshopt_cube(), "meshopt")):
        with pytest.raises(MissingExtraError, match=rf"needs {library}: pip install 'gpu_xform\[gltf\]'"):
            mesh_of(builder)
    assert np.array_equal(mesh_of(draco_cube(fallback=True)).positions, POINTS + np.array([1, 0, 0]))


def test_sparse_accessors_replace_rows() -> None:
    for from_zeros in (True, False):
        builder = Builder()
        base = np.zeros_like(POINTS) if from_zeros else POINTS
        moved = [1, 4, 6]
        sparse: dict[str, Any] = {
            "count": 3,
            "indices": {"bufferView": builder.view(np.array(moved, "<u2").tobytes()), "componentType": 5123},
            "values": {"bufferView": builder.view(np.full((3, 3), 7, "<f4").tobytes())},
        }
        positions = builder.array(base, sparse=sparse)
        if from_zeros:
            del builder.content["accessors"][positions]["bufferView"]
        builder.mesh({"attributes": {"POSITION": positions}, "mode": 0})
        builder.node(mesh=0)
        expected = base.copy()
        expected[moved] = 7
        assert np.array_equal(mesh_of(builder).positions, expected)
        for name, value, message in (
            ("count", 9, "replaces 9 of 8 rows"),
            ("count", 4, "sparse indices with 4 rows ends"),
        ):
            before, sparse[name] = sparse[name], value
            with pytest.raises(MeshError, match=message):
                mesh_of(builder)
            sparse[name] = before
        sparse["indices"]["bufferView"] = builder.view(np.array([1, 6, 4], "<u2").tobytes())
        with pytest.raises(MeshError, match=r"its sparse indices must ascend within 0\.\.7"):
            mesh_of(builder)


def test_zeros_beyond_all_measure_are_refused() -> None:
    builder = Builder()
    builder.content["accessors"] = [{"componentType": 5126, "count": 10**12, "type": "VEC3"}]
    builder.mesh({"attributes": {"POSITION": 0}, "mode": 0})
    builder.node(mesh=0)
    with pytest.raises(
        MeshError, match=r"expands to more than [\d,]+ points of 16 numbers, the limit FileLimits\(points=\.\.\.\)"
    ):
        mesh_of(builder)


def peak_memory(read: Callable[[], Any]) -> int:
    """Return how many bytes a reader holds at most."""
    tracemalloc.start()
    try:
        read()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_of_matrices_only_those_of_joints_are_read() -> None:
    builder = Builder()
    influences = {"JOINTS_0": builder.array(np.zeros((8, 4)), "|u1"), "WEIGHTS_0": builder.array(np.eye(8, 4))}
    cube = add_cube(builder)
    builder.mesh({**cube, "attributes": cube["attributes"] | influences})
    builder.content["accessors"].append({"componentType": 5126, "count": 2_000_000, "type": "MAT4"})
    matrices = len(builder.content["accessors"]) - 1
    builder.content["skins"] = [{"joints": [0], "inverseBindMatrices": matrices}] * 4  # 256 MB each
    for skin in range(4):
        builder.node(mesh=0, skin=skin)
    assert peak_memory(lambda: np.testing.assert_array_equal(mesh_of(builder).positions, np.zeros((32, 3)))) < 10e6
    builder.content["skins"] = [{"joints": [0] * 2_000_001, "inverseBindMatrices": matrices}]
    builder.content["nodes"] = [{"mesh": 0, "skin": 0}]
    with pytest.raises(MeshError, match="skin 0 has 2000000 matrices for 2000001 joints"):
        mesh_of(builder)


def test_joints_of_a_skin_are_gathered_once_and_a_pose_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    builder = Builder()
    add_skinned_cube(builder, 1)
    for _ in range(3):
        builder.content["scenes"][0]["nodes"].append(builder.node(mesh=0, skin=0))
    scene = scene_of(builder)
    given_: list[Any] = []
    made: list[Any] = []
    posed, deformed = DeformableMesh.posed, DeformableMesh._deformed

    def pose(mesh: DeformableMesh, weights: Any, joints: Any) -> Mesh:
        given_.append(joints)
        return posed(mesh, weights, joints)

    def deform(mesh: DeformableMesh, weights: Any, joints: Any) -> Mesh:
        made.append(joints)
        return deformed(mesh, weights, joints)

    monkeypatch.setattr(DeformableMesh, "posed", pose)
    monkeypatch.setattr(DeformableMesh, "_deformed", deform)
    (layer,) = scene.layers()
    assert len(layer.transform) == len(given_) == 4
    assert {id(joints) for joints in given_} == {id(given_[0])}
    assert len(made) == 1
    (again,) = scene.layers()
    assert again.model is layer.model
    (moved,) = scene.posed({"joint 1": np.eye(4)}).layers()
    assert moved.model is not layer.model


@pytest.mark.parametrize("isolated", [False, True])
def test_nodes_share_meshes_and_skins(isolated: bool) -> None:
    builder = Builder()
    add_skinned_cube(builder, 1)
    builder.content["meshes"].append(builder.content["meshes"][0])
    builder.content["skins"].append(builder.content["skins"][0])
    for mesh, skin in ((0, 1), (1, 0), (0, 0)):
        builder.content["scenes"][0]["nodes"].append(builder.node(mesh=mesh, skin=skin))
    scene = load_scene(io.BytesIO(builder.pack()), file_type="glb", isolated=isolated)
    first, other_skin, other_mesh, again = [shown.model for node in scene for shown in node.models]
    assert again is first
    assert other_skin.mesh is first.mesh
    assert other_mesh.skin is first.skin
    assert other_skin.skin is not first.skin


def test_nodes_of_a_scene_that_is_not_read_are_counted_together() -> None:
    scene = Scene()
    mesh = Mesh(np.zeros((1_000_000, 3)))
    for _ in range(4):
        scene.add(mesh)
    with pytest.raises(MeshError, match="its nodes: expands to more than"):
        merge_scene(scene)


@pytest.mark.parametrize("kind", ["skins", "joints", "weights", "targets"])
def test_poses_are_counted_before_they_are_made(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    builder = Builder()
    n_points, n_targets = {"weights": (40_000, 1), "targets": (100, 300)}.get(kind, (3, 0))
    builder.content["accessors"] = [{"componentType": 5126, "type": "VEC3", "count": n_points}]
    attributes = {"POSITION": 0}
    if not n_targets:
        attributes["JOINTS_0"] = builder.array(np.zeros((3, 4)), "|u1")
        attributes["WEIGHTS_0"] = builder.array(np.ones((3, 4)))
    builder.mesh({"attributes": attributes, "targets": [{"POSITION": 0}] * n_targets, "mode": 0})
    if n_targets:
        for i in range(500):
            builder.node(mesh=0, weights=[i + 1] * n_targets)
        name = "its nodes" if kind == "weights" else r"node 'node \d+'"
    else:
        builder.content["skins"] = [{"joints": [0] * 200_000}] if kind == "joints" else [{"joints": [0]}] * 8000
        for i in range(10 if kind == "joints" else 8000):
            builder.node(mesh=0, skin=0 if kind == "joints" else i)
        name = r"node 'node \d+'"
    monkeypatch.setattr(DeformableMesh, "posed", None)
    with pytest.raises(
        MeshError, match=rf"{name}: expands to more than [\d,]+ (numbers beside its points|points of 16 numbers)"
    ):
        mesh_of(builder)


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("name", ["JOINTS_0", "WEIGHTS_0", "POSITION"])
def test_counts_are_compared_before_zeros_are_written_out(name: str, sparse: bool) -> None:
    builder = Builder()
    cube = add_cube(builder)
    influences = {"JOINTS_0": builder.array(np.zeros((8, 4)), "|u1"), "WEIGHTS_0": builder.array(np.eye(8, 4))}
    kind = "VEC3" if name == "POSITION" else "VEC4"
    zeros: dict[str, Any] = {"componentType": 5121, "count": 2**23, "type": kind, "normalized": name != "JOINTS_0"}
    if sparse:
        view = builder.view(bytes(4))
        places = {"bufferView": view, "componentType": 5121}
        zeros["sparse"] = {"count": 0, "indices": places, "values": {"bufferView": view}}
    builder.content["accessors"].append(zeros)
    wrong = {name: len(builder.content["accessors"]) - 1}
    if name == "POSITION":
        builder.mesh({**cube, "targets": [wrong]})
        message = "morph target 0 moves 8388608 points, the mesh has 8"
    else:
        builder.mesh({**cube, "attributes": cube["attributes"] | influences | wrong})
        message = r"JOINTS_0 and WEIGHTS_0 have (8 and 8388608|8388608 and 8) rows for 8 points"
    builder.node(mesh=0)

    def read() -> None:
        with pytest.raises(MeshError, match=message):
            mesh_of(builder)

    assert peak_memory(read) < 1e6


def test_last_rows_within_rounding_are_taken_for_what_they_mean() -> None:
    builder = Builder()
    builder.mesh(add_cube(builder))
    matrix = (translate(1, 2, 3) @ rotate_z(0.3) @ scale(2)).astype(np.float32)
    matrix[3] = 1e-9, -3e-8, 0, 0.9999999
    builder.node(mesh=0, matrix=matrix.T.ravel().tolist())
    scene = scene_of(builder)
    assert scene["node 0"].transform[3].tolist() == [0, 0, 0, 1]
    builder.content["nodes"][0]["matrix"][15] = 0.9999
    with pytest.raises(MeshError, match=r"row \(0, 0, 0, 1\), got \(9\.99.*e-10, -2\.99.*e-08, 0, 0\.9999\)"):
        scene_of(builder)


def test_points_stand_beside_triangles() -> None:
    builder = Builder()
    builder.mesh(add_cube(builder), {"attributes": {"POSITION": builder.array([(9, 9, 9), (8, 8, 8)])}, "mode": 0})
    builder.node(mesh=0)
    assert np.array_equal(mesh_of(builder).positions, [*POINTS, (9, 9, 9), (8, 8, 8)])
    assert [layer.model.n_faces for layer in scene_of(builder).layers()] == [12, 0]


def many_parts(n: int, **said: Any) -> Any:
    """Return a document of a mesh that says something, of so many primitives that say something else each."""
    content = document()
    parts = [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0, "extras": i + 1} for i in range(n)]
    content["meshes"] = [{"name": "all", "primitives": parts, **said}]
    content["materials"] = [{"name": "blue", "extras": [[1] * 50, {"a": [2]}]}]
    return content


@pytest.mark.parametrize("isolated", [False, True])
def test_parts_share_what_their_mesh_and_their_material_say(isolated: bool) -> None:
    data = pack(many_parts(3, extras=[[3] * 50, {"b": [4]}]))
    scene = load_scene(io.BytesIO(data), file_type="glb", isolated=isolated)
    meshes = [shown.model for shown in scene["node 0"].models]
    assert [mesh.metadata["gltf"] for mesh in meshes] == [
        {"name": "all", "extras": ((3,) * 50, {"b": (4,)}), "primitive": {"extras": i + 1}} for i in range(3)
    ]
    assert len({id(mesh.metadata["gltf"]["extras"]) for mesh in meshes}) == 1
    assert len({id(mesh.attributes.material["blue"]) for mesh in meshes}) == 1
    assert meshes[0].attributes.material == {"blue": {"name": "blue", "extras": ((1,) * 50, {"a": (2,)})}}


def test_words_of_a_mesh_are_counted_for_each_of_its_parts() -> None:
    """Of 170 kB, 700 parts would hold 10,000 words each."""
    data = pack(many_parts(700, **{f"{i}": 0 for i in range(10_000)}))
    with pytest.raises(MeshError, match=r"mesh 0: expands to more than .* the limit FileLimits\(points="):
        load_mesh(io.BytesIO(data), file_type="glb")


def test_primitives_without_positions_show_nothing() -> None:
    builder = Builder()
    builder.mesh({"attributes": {}}, add_cube(builder))
    builder.node(mesh=0)
    assert mesh_of(builder).n_points == 8


def test_materials_that_nothing_names_are_not_gone_through(monkeypatch: pytest.MonkeyPatch) -> None:
    """A megabyte may hold 300,000 of them."""
    builder, gone_through = Builder(), list[Any]()

    def freeze(value: Any) -> Any:
        gone_through.append(value)
        return freeze_value(value)

    part = add_cube(builder)
    builder.mesh({**part, "material": 1}, {**part, "material": 1, "extras": 1})
    builder.node(mesh=0)
    builder.content["materials"] = [{"name": name} for name in "abc"]
    monkeypatch.setattr(gltf_meshes, "freeze_value", freeze)
    assert mesh_of(builder).attributes.material == {"b": {"name": "b"}}
    assert [value for value in gone_through if "name" in value] == [{"name": "b"}]
