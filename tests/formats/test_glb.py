import io
import math
import struct
import zipfile
from typing import Any

import numpy as np
import pytest
import trimesh

from gpu_xform import samples
from gpu_xform.errors import MeshError
from gpu_xform.formats import glb, save_mesh
from gpu_xform.formats import threemf as zipped
from tests.support.cost import within_cpu_s
from tests.support.gltf_files import BINARY, POINTS, TRIANGLE, change, document, pack


def test_one_triangle() -> None:
    assert glb.read(pack(document())) == TRIANGLE


def test_every_node_puts_its_mesh_where_it_belongs() -> None:
    content = document()
    half = math.sqrt(0.5)
    content["nodes"] = [
        {"mesh": 0, "translation": [0, 0, 5], "children": [1]},
        {"mesh": 0, "rotation": [0, 0, half, half], "scale": [2, 3, 4], "children": [2]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 1, 1, 1]},
    ]
    mesh = glb.read(pack(content))
    expected = [
        *([0, 0, 5], [1, 0, 5], [0, 1, 5]),
        *([0, 0, 5], [0, 2, 5], [-3, 0, 5]),
        *([-3, 2, 9], [-3, 4, 9], [-6, 2, 9]),
    ]
    assert sorted(mesh.positions.round(9).tolist()) == sorted(expected)
    assert mesh.n_faces == 3
    assert np.array_equal(np.asarray(mesh.faces), np.arange(9).reshape(3, 3))


def test_a_scene_of_trimesh() -> None:
    scene: Any = trimesh.Scene()
    moved = np.eye(4)
    moved[0, 3] = 5.0
    scene.add_geometry(trimesh.creation.box(), transform=moved)
    scene.add_geometry(trimesh.creation.icosphere(subdivisions=1))
    mesh = glb.read(scene.export(file_type="glb"))
    assert (mesh.n_points, mesh.n_faces) == (8 + 42, 12 + 80)
    assert mesh.bounds[:, 0].tolist() == pytest.approx([-1, 5.5])


def test_a_polygon_mesh_is_written_as_fans() -> None:
    file = io.BytesIO()
    mesh = samples.snub_dodecahedron()
    save_mesh(mesh, file, file_type="glb")
    read = glb.read(file.getvalue())
    assert np.array_equal(read.positions, mesh.positions.astype(np.float32))
    assert np.array_equal(read.faces, mesh.to_trimesh().faces)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("accessors.0.count", 4, "accessor 0 with 4 rows ends at byte 48 of a view of 36"),
        ("accessors.0.count", 10**18, "mesh 0: expands to more than"),
        ("accessors.0.count", -1, "count must be an integer of at least 0, got '-1'"),
        ("accessors.0.count", 2.5, "count must be an integer"),
        ("accessors.0.byteOffset", 4, "accessor 0 with 3 rows ends at byte 40"),
        ("accessors.1.sparse", {"count": 1}, "the JSON is not glTF: 'accessors[1].sparse' has no indices"),
        ("extensionsRequired", ["KHR_materials_unlit", "X_a"], "it requires the extension 'X_a', which cannot be read"),
        ("extensionsRequired", ["X_a", 5], "it requires the extensions 'X_a', '5', which cannot be read"),
        ("accessors.0.bufferView", 7, "[0].bufferView' must be an index of bufferViews, of which there are 2, got '7'"),
        ("accessors.0.type", "VEC9", "accessor 0 must be of type VEC3, got \"'VEC9'\""),
        ("accessors.0.componentType", 1, "componentType' must be one of 5120, 5121, 5122, 5123, 5125, 5126, got"),
        ("bufferViews.0.byteStride", 4, "accessor 0 has rows of 12 bytes every 4 bytes"),
        ("bufferViews.0.byteStride", 16, "accessor 0 with 3 rows ends at byte 44"),
        ("bufferViews.0.byteLength", 1000, "buffer view 0 ends at byte 1000, the buffer has 44"),
        ("bufferViews.0.byteOffset", -4, "byteOffset must be an integer of at least 0"),
        ("bufferViews.0.buffer", 1, "'bufferViews[0].buffer' must be an index of buffers, of which there are 1"),
        ("buffers.0.byteLength", 1000, "buffer 0 declares 1000 bytes, it has 44"),
        ("buffers.0.uri", "../../etc/passwd", "its buffer is another file, '../../etc/passwd', which is not opened"),
        ("nodes", [{"children": [0]}], "1 nodes are descendants of themselves"),
        (
            "nodes",
            [{"children": [1]}, {"children": [2]}, {"children": [1]}],
            "node 2 has the child 1, which is no node or has",
        ),
        (
            "nodes",
            [{"children": [1]}, {"mesh": 0}, {"children": [1]}],
            "node 2 has the child 1, which is no node or has",
        ),
        ("nodes", [{"children": [9]}], "'nodes[0].children[0]' must be an index of nodes, of which there are 1"),
        ("nodes", [{"mesh": 9}], "'nodes[0].mesh' must be an index of meshes, of which there are 1, got '9'"),
        ("nodes", [{"mesh": "x"}], "mesh must be an integer of at least 0, got \"'x'\""),
        ("nodes", 5, "the JSON is not glTF: 'nodes' must be an array, got '5'"),
        ("nodes", [5], "the JSON is not glTF: 'nodes[0]' must be an object, got '5'"),
        ("meshes.0.primitives.0.mode", 1, "mesh 0 has 3 corners, which must be a multiple of 2"),
        ("meshes.0.primitives.0.mode", 7, "mesh 0 must have a mode of at most 6, got 7"),
        ("meshes.0.primitives.0.indices", 0, "accessor 0 must be of type SCALAR, got \"'VEC3'\""),
        ("accessors.1.componentType", 5122, "accessor 1 holds indices, which must be unsigned integers, got int16"),
        ("nodes.0.mesh", None, "it shows no triangles, no lines and no points"),
        ("meshes.0.primitives.0.indices", 9, "'meshes[0].primitives[0].indices' must be an index of accessors"),
        ("scene", 9, "'scene' must be an index of scenes, of which there are 1, got '9'"),
        ("scenes.0.nodes", [1], "'scenes[0].nodes[0]' must be an index of nodes, of which there are 1, got '1'"),
        ("meshes.0.primitives.0.attributes.JOINTS_0", 0, "mesh 0: JOINTS_0 needs WEIGHTS_0"),
        ("scenes.0.nodes", [0, 0], "the scene must list each node once"),
        ("scenes.0.nodes", [-1], "the scene must list each node once, by a number of at least 0"),
    ],
)
def test_what_disagrees_is_refused(path: str, value: Any, message: str) -> None:
    content = document()
    change(path, value)(content)
    with pytest.raises(MeshError) as caught:
        glb.read(pack(content))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("binary", "message"),
    [
        (POINTS + struct.pack("<3H", 0, 1, 3), "face 0 names point 3, outside 0..2"),
        (POINTS + struct.pack("<3H", 0, 1, 65535), "face 0 names point 65535"),
        (struct.pack("<f", math.nan) + BINARY[4:], "positions must be finite, got nan"),
        (struct.pack("<f", -math.inf) + BINARY[4:], "positions must be finite, got -inf"),
    ],
)
def test_contents_are_checked(binary: bytes, message: str) -> None:
    with pytest.raises(MeshError) as caught:
        glb.read(pack(document(), binary))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"glTF", "byte 0: expected 'glTF' and two headers, got 'glTF'"),
        (b"x" * 40, "byte 0: expected 'glTF'"),
        (b"glTF" + struct.pack("<II", 1, 40) + b"\0" * 28, "byte 4: expected version 2, got 1"),
        (pack(document())[:-1], "byte 8: declares"),
        (b"glTF" + struct.pack("<III", 2, 20, 99) + b"JSON", "byte 12: a chunk declares 99 bytes, 0 are left"),
        (b"glTF" + struct.pack("<III", 2, 20, 0) + b"BIN\0", "byte 12: expected a JSON chunk"),
        (pack(b"{"), "the JSON is malformed"),
        (pack(b"\xff\xfe"), "the JSON is malformed"),
        (pack(b"[" * 100_000), "the JSON is malformed"),
        (pack(b"[]"), "the JSON is not glTF"),
        (pack(b"{}"), "it has no nodes"),
    ],
)
def test_headers_are_checked(data: bytes, message: str) -> None:
    with pytest.raises(MeshError) as caught:
        glb.read(data)
    assert message in str(caught.value)


def test_bytes_behind_the_end_are_none_of_the_file() -> None:
    for rest in (b"\0", b"\n", b"glTF" + b"\xff" * 40):
        assert glb.read(pack(document()) + rest) == TRIANGLE


@pytest.mark.slow
def test_hazards_end_soon() -> None:
    chain = document()
    chain["nodes"] = [{"children": [i + 1]} for i in range(20_000)] + [{"mesh": 0}]
    for _ in within_cpu_s(5.0):
        assert glb.read(pack(chain)) == TRIANGLE
        crowd = document()
        crowd["accessors"][0]["count"] = crowd["accessors"][1]["count"] = 99_999
        crowd["bufferViews"] = [{"buffer": 0, "byteLength": 1_200_000}, {"buffer": 0, "byteLength": 200_000}]
        crowd["buffers"] = [{"byteLength": 1_200_000}]
        crowd["nodes"] = [{"mesh": 0} for _ in range(5000)]
        crowd["scenes"] = [{"nodes": list(range(5000))}]
        with pytest.raises(
            MeshError, match=r"its nodes: expands to more than .* numbers, the limit FileLimits\(points=\.\.\.\)"
        ):
            glb.read(pack(crowd, b"\0" * 1_200_000))


def test_a_chain_that_is_not_too_deep_is_read() -> None:
    chain = document()
    chain["nodes"] = [{"children": [i + 1], "translation": [1, 0, 0]} for i in range(255)] + [{"mesh": 0}]
    assert glb.read(pack(chain)).bounds.tolist() == [[255, 0, 0], [256, 1, 0]]


def test_containers_that_unpack_to_much_are_refused() -> None:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as container:
        container.writestr("3D/3dmodel.model", b" " * 50_000_000)
    assert len(file.getvalue()) < 100_000
    with pytest.raises(
        MeshError, match=r"unpacks to more than .* allowed, the limit FileLimits\(unpacked_bytes=\.\.\.\)"
    ):
        zipped.read(file.getvalue())
    for damaged in (b"PK", file.getvalue()[:-10]):
        with pytest.raises(MeshError, match="not a ZIP container"):
            zipped.read(damaged)


def test_a_container_of_something_else_is_refused() -> None:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as container:
        container.writestr("readme.txt", b"no model")
    with pytest.raises(MeshError, match=r"the container has no part '3D/3dmodel\.model'"):
        zipped.read(file.getvalue())
