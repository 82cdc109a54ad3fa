"""glTF documents moved and written again: all that they hold stays."""

import base64
import io
import json
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pygltflib
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from gpu_xform import FileLimits, MeshError, chain, load_mesh, load_scene, rotate_y, save_mesh, scale, translate
from gpu_xform.cli import main
from gpu_xform.formats.registry import transform_document
from tests.formats.test_gltf_meshes import add_cube, add_skinned_cube, local, meshopt_cube
from tests.formats.test_gltf_write import furnished
from tests.support.gltf_files import BINARY, Builder, as_text, change, data_uri, document

MOVE = ["--translate", "1,2,3", "--rotate-y", "30", "--scale", "2,1,1"]
MATRIX = chain(translate(1, 2, 3), rotate_y(30, degrees=True), scale(2, 1, 1))


def transform(source: Path, target: Path, *options: str) -> None:
    assert main(["transform", str(source), str(target), *options]) == 0


def parse(path: Path) -> tuple[Any, bytes]:
    """Return the JSON and the first buffer of a file."""
    data = path.read_bytes()
    if path.suffix == ".gltf":
        content = json.loads(data)
        uri = content["buffers"][0].pop("uri")
        return content, base64.b64decode(uri.split(",")[1])
    size = int.from_bytes(data[12:16], "little")
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def assembly(tmp_path: Path) -> Path:
    """Return a file of 28 named meshes, as trimesh writes it."""
    scene: Any = trimesh.Scene()
    visual: Any = trimesh.visual
    for i in range(28):
        solid = trimesh.creation.box(extents=(1, 2, i + 1))
        solid.visual = visual.TextureVisuals(material=visual.material.PBRMaterial(name=f"paint {i}"))
        scene.add_geometry(solid, node_name=f"part {i}", geom_name=f"shape {i}", transform=translate(i, 0, 0))
    path = tmp_path / "assembly.glb"
    path.write_bytes(scene.export(file_type="glb"))
    return path


@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_an_assembly_keeps_its_tree_in_another_place(tmp_path: Path, kind: str) -> None:
    source, target = assembly(tmp_path), tmp_path / f"moved.{kind}"
    transform(source, target, *MOVE)
    before, after = (trimesh.load_scene(path, process=False) for path in (source, target))
    assert set(before.graph.nodes_geometry) == set(after.graph.nodes_geometry) == {f"part {i}" for i in range(28)}
    for name in before.graph.nodes_geometry:
        (old, shape), (new, same) = before.graph[name], after.graph[name]
        assert shape == same
        assert np.allclose(new, MATRIX @ old)
        assert np.array_equal(before.geometry[shape].vertices, after.geometry[shape].vertices)
        assert before.geometry[shape].visual.material.name == after.geometry[shape].visual.material.name
    assert np.allclose(load_mesh(target).positions, load_mesh(source).transformed(MATRIX).positions)


@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_what_is_not_moved_is_equal(tmp_path: Path, kind: str) -> None:
    source, same, there, back = (tmp_path / f"{name}" for name in ("a.glb", f"b.{kind}", "c.gltf", "d.glb"))
    source.write_bytes(furnished().pack())
    transform(source, same)
    content, binary = parse(source)
    read, data = parse(same)
    assert read == content
    assert data[: len(binary)] == binary
    transform(source, there)
    transform(there, back)
    assert parse(back)[0] == content
    texts = [pygltflib.GLTF2.load(str(path)).to_json() for path in (source, back)]
    assert texts[0] == texts[1]


texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=5)
extras = st.dictionaries(texts, st.one_of(st.integers(-9, 9), texts, st.lists(st.booleans(), max_size=2)), max_size=2)
numbers = st.floats(-9, 9, width=32)
placements = st.one_of(
    st.just({}),
    st.fixed_dictionaries(
        {
            "translation": st.lists(numbers, min_size=3, max_size=3),
            "rotation": st.sampled_from([[0, 0, 0.6, 0.8], [1, 0, 0, 0], [0.5, 0.5, -0.5, 0.5]]),
            "scale": st.lists(st.sampled_from([1, -2, 0.5]), min_size=3, max_size=3),
        }
    ),
    st.lists(numbers, min_size=12, max_size=12).map(
        lambda rows: {"matrix": np.vstack([np.reshape(rows, (3, 4)), (0, 0, 0, 1)]).T.ravel().tolist()}
    ),
)
tables = st.lists(
    st.sampled_from(
        [
            ("NORMAL", "<f4", 3, {}),
            ("TANGENT", "<f4", 4, {}),
            ("TEXCOORD_0", "<u2", 2, {"normalized": True}),
            ("TEXCOORD_1", "<f4", 2, {}),
            ("COLOR_0", "|u1", 4, {"normalized": True}),
            ("_X", "<f4", None, {}),
            ("_CLASS", "|u1", 4, {}),
        ]
    ),
    unique_by=lambda column: column[0],
)


@st.composite
def documents(draw: st.DrawFn) -> Builder:
    """Return a document of meshes in nodes, with anything else that a document may hold."""
    builder = Builder()
    content = builder.content
    content |= {"extras": draw(extras), "extensionsUsed": ["VENDOR_a"], "extensions": {"VENDOR_a": draw(extras)}}
    content["images"] = [{"bufferView": builder.view(draw(st.binary(min_size=1, max_size=9))), "mimeType": "image/png"}]
    content["textures"] = [{"source": 0, "extras": draw(extras)}]
    color = {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.25}
    content["materials"] = [{"name": draw(texts), "pbrMetallicRoughness": color, "extras": draw(extras)}]
    for _ in range(draw(st.integers(1, 2))):
        attributes = {}
        for name, dtype, width, more in draw(tables):
            values = np.arange(8 * (width or 1)).reshape((8,) if width is None else (8, width))
            attributes[name] = builder.array(values, dtype, **more)
        builder.mesh(add_cube(builder, **attributes) | {"material": 0}, name=draw(texts), extras=draw(extras))
    n_nodes = draw(st.integers(1, 5))
    for i in range(n_nodes):
        above = draw(st.integers(-1, i - 1))
        builder.node(name=draw(texts), extras=draw(extras), mesh=draw(st.integers(0, len(content["meshes"]) - 1)))
        content["nodes"][i] |= draw(placements)
        if above >= 0:
            content["nodes"][above].setdefault("children", []).append(i)
    below = {child for node in content["nodes"] for child in node.get("children", [])}
    content["scenes"] = [{"name": draw(texts), "nodes": [i for i in range(n_nodes) if i not in below]}]
    if draw(st.booleans()):
        joints = [draw(st.integers(0, n_nodes - 1))]
        content["skins"] = [{"joints": joints, "inverseBindMatrices": builder.array([np.eye(4)])}]
    moving: list[int] = [i for i, node in enumerate(content["nodes"]) if "matrix" not in node]
    is_moving: bool = draw(st.booleans())
    if moving and is_moving:
        sampler = {"input": builder.array([0, 1], min=[0], max=[1]), "output": builder.array([(0, 0, 0), (1, 2, 3)])}
        target = {"node": draw(st.sampled_from(moving)), "path": "translation"}
        content["animations"] = [
            {"name": draw(texts), "samplers": [sampler], "channels": [{"sampler": 0, "target": target}]}
        ]
    return builder


def find_worlds(gltf: pygltflib.GLTF2) -> dict[int, Any]:
    """Return the matrix of each node that shows a mesh, in the world, through pygltflib."""
    worlds = {}
    waiting = [(i, np.eye(4)) for i in gltf.scenes[0].nodes]
    while waiting:
        i, above = waiting.pop()
        node = gltf.nodes[i]
        matrix = above @ (local(node) if node.matrix is None else np.reshape(node.matrix, (4, 4)).T)
        if node.mesh is not None:
            worlds[i] = matrix
        waiting += [(child, matrix) for child in node.children or []]
    return worlds


@settings(max_examples=30)
@given(documents(), st.sampled_from(["glb", "gltf"]), st.booleans())
def test_pygltflib_reads_all_that_was_there_before(builder: Builder, kind: str, is_moved: bool) -> None:
    data, file = builder.pack(), io.BytesIO()
    matrix = MATRIX if is_moved else np.eye(4)
    transform_document(io.BytesIO(data), file, matrix, source_type="glb", target_type=kind)
    written = file.getvalue()
    before = pygltflib.GLTF2.load_from_bytes(data)
    if kind == "glb":
        after = pygltflib.GLTF2.load_from_bytes(written)
        blob = after.binary_blob()
    else:
        after = pygltflib.GLTF2.gltf_from_json(written.decode())
        blob = base64.b64decode(after.buffers[0].uri.split(",")[1])
        after.buffers[0].uri = None
    assert blob[: len(builder.binary)] == builder.binary
    if is_moved:
        old, new = find_worlds(before), find_worlds(after)
        assert old.keys() == new.keys()
        assert all(np.allclose(new[i], MATRIX @ old[i], atol=1e-9) for i in old)
        del after.nodes[len(before.nodes) :]  # the parents of what an animation moves
        roots = before.scenes[0].nodes
        after.scenes[0].nodes = roots
        for i in roots:
            for node in (before.nodes[i], after.nodes[i]):
                node.matrix = node.translation = node.rotation = node.scale = None
    assert after.to_json() == before.to_json()


def test_only_the_roots_are_changed(tmp_path: Path) -> None:
    builder = Builder()
    builder.mesh(add_cube(builder), name="cube")
    builder.node(name="a", mesh=0, translation=[1, 0, 0], children=[1], extras={"n": [1, None, "ü"]})
    builder.node(name="b", mesh=0, rotation=[0, 0.6, 0, 0.8])
    builder.node(name="c", mesh=0, matrix=scale(1, 2, 3).T.ravel().tolist())
    builder.content["scenes"] = [{"nodes": [0, 2]}, {"nodes": [2], "name": "other"}]
    source, target = tmp_path / "a.glb", tmp_path / "b.glb"
    source.write_bytes(builder.pack())
    transform(source, target, *MOVE)
    expected = json.loads(json.dumps(builder.content))
    read, data = parse(target)
    for i, placed in ((0, translate(1, 0, 0)), (2, scale(1, 2, 3))):
        assert np.allclose(np.reshape(read["nodes"][i].pop("matrix"), (4, 4)).T, MATRIX @ placed)
        for name in ("translation", "matrix"):
            expected["nodes"][i].pop(name, None)
    assert read == expected
    assert data == builder.binary


def test_a_node_that_an_animation_moves_gets_a_parent(tmp_path: Path) -> None:
    source, target = tmp_path / "a.glb", tmp_path / "b.glb"
    source.write_bytes(furnished().pack())
    transform(source, target, *MOVE)
    before, after = load_scene(source), load_scene(target)
    assert [node.name for node in after] == ["cube, moved", "cube", "eye"]
    for time in (0.0, 0.8, 4.0):
        old, new = (scene.posed(*scene.animations["dance"].at(time)) for scene in (before, after))
        assert np.allclose(new.world("cube"), MATRIX @ old.world("cube"))
    assert np.allclose(after.world("eye"), MATRIX @ before.world("eye"))


def test_a_skin_moves_with_its_joints(tmp_path: Path) -> None:
    builder = Builder()
    add_skinned_cube(builder, 2)
    source, target = tmp_path / "a.glb", tmp_path / "b.glb"
    source.write_bytes(builder.pack())
    transform(source, target, *MOVE)
    assert np.allclose(load_mesh(target).positions, load_mesh(source).transformed(MATRIX).positions, atol=1e-5)


def test_a_mirror_leaves_solids_the_right_way_out(tmp_path: Path) -> None:
    source, target = assembly(tmp_path), tmp_path / "mirrored.glb"
    transform(source, target, "--reflect", "1,0,0")
    volume = load_mesh(source).to_trimesh().volume
    assert load_mesh(target).to_trimesh().volume == pytest.approx(volume)
    assert trimesh.load_mesh(target).volume == pytest.approx(volume)


def test_packed_arrays_stay_packed(tmp_path: Path) -> None:
    source, target = tmp_path / "a.glb", tmp_path / "b.glb"
    source.write_bytes(meshopt_cube().pack())
    transform(source, target, "--translate", "1,2,3")
    assert np.array_equal(load_mesh(target).positions, load_mesh(source).positions + np.array([1, 2, 3]))
    assert parse(target)[0]["extensionsRequired"] == ["EXT_meshopt_compression"]


def test_files_beside_a_document_come_into_it(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "my points.bin").write_bytes(BINARY[:36])
    (tmp_path / "in" / "wood.jpg").write_bytes(b"\xff\xd8 a picture")
    content = document()
    content["images"] = [{"uri": "wood.jpg"}, {"uri": "https://example.org/far.png"}, {"uri": data_uri(b"third")}]
    source = tmp_path / "in" / "a.gltf"
    source.write_bytes(as_text("my%20points.bin", data_uri(BINARY[36:]), content=content))
    for kind in ("glb", "gltf"):
        target = tmp_path / f"out.{kind}"
        transform(source, target, "--translate", "1,0,0")
        assert load_mesh(target) == load_mesh(source).transformed(translate(1, 0, 0))
        images = load_scene(target).metadata["gltf"]["image_bytes"]
        assert images == [b"\xff\xd8 a picture", None, b"third"]
        (picture, far, _) = parse_images(target)
        assert far == {"uri": "https://example.org/far.png"}
        assert "jpeg" in json.dumps(picture)


def test_an_image_that_is_named_often_is_read_and_written_once(tmp_path: Path) -> None:
    """Before, 57 kB that named themselves 3,000 times became 172 MB, in memory and in the file that was written."""
    picture = b"\x89PNG" + bytes(100_000)
    (tmp_path / "a.png").write_bytes(picture)
    content = document()
    content["images"] = [{"uri": f"{'./' * (i % 50)}a.png", "name": str(i)} for i in range(500)]
    content["images"] += [{"uri": data_uri(b"third")}, {"uri": data_uri(b"third")}]
    source = tmp_path / "a.gltf"
    source.write_bytes(as_text(data_uri(BINARY[:36]), data_uri(BINARY[36:]), content=content))
    expected = [picture] * 500 + [b"third"] * 2
    load_mesh(source)
    tracemalloc.start()
    try:
        scene = load_scene(source)
        assert list(scene.metadata["gltf"]["image_bytes"]) == expected
        for kind in ("glb", "gltf"):
            transform(source, tmp_path / f"out.{kind}", "--translate", "1,0,0")
            save_mesh(scene, tmp_path / f"saved.{kind}")
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()
    for target in (tmp_path / f"{name}.{kind}" for name in ("out", "saved") for kind in ("glb", "gltf")):
        assert target.stat().st_size < 300_000
        assert list(load_scene(target).metadata["gltf"]["image_bytes"]) == expected
        images = parse_images(target)
        assert [image.get("name") for image in images] == [*map(str, range(500)), None, None]
        assert {image.get("mimeType") for image in images[:500]} == {"image/png"}
    with pytest.raises(MeshError, match=r"'a\.png': .*FileLimits\(unpacked_bytes=100003\)"):
        load_scene(source, limits=FileLimits(unpacked_bytes=100_003))
    assert load_scene(source, limits=FileLimits(unpacked_bytes=100_004)).metadata == scene.metadata


@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_buffers_that_name_one_file_are_read_and_written_once(tmp_path: Path, kind: str) -> None:
    """By 1,000 names, too: a file of 450 kB beside 60 kB of JSON was written 1,000 times."""
    (tmp_path / "a.bin").write_bytes(BINARY + bytes(100_000))
    content = document()
    content["buffers"] = [{"uri": f"{'./' * i}a.bin", "byteLength": 36 + i, "name": str(i)} for i in range(300)]
    content["buffers"].append({"uri": data_uri(BINARY[36:]), "byteLength": 6})
    content["bufferViews"][0]["buffer"] = 250
    content["bufferViews"][1].update(buffer=300, byteOffset=0)
    content["bufferViews"].append({"buffer": 17, "byteOffset": 40, "byteLength": 13})
    source, target = tmp_path / "a.gltf", tmp_path / f"b.{kind}"
    source.write_text(json.dumps(content))
    load_mesh(source)
    tracemalloc.start()
    try:
        transform(source, target, "--translate", "1,0,0")
        assert tracemalloc.get_traced_memory()[1] < 3e6
    finally:
        tracemalloc.stop()
    assert target.stat().st_size < 200_000
    assert load_mesh(target) == load_mesh(source).transformed(translate(1, 0, 0))
    if kind == "gltf":
        written, _ = parse(target)
        assert [(buffer["name"], buffer["byteLength"]) for buffer in written["buffers"][:-1]] == [("0", 335)]
        views = [(view["buffer"], view.get("byteOffset", 0)) for view in written["bufferViews"]]
        assert views == [(0, 0), (1, 0), (0, 40)]


@pytest.mark.parametrize("isolated", [False, True])
def test_images_in_one_place_of_a_buffer_are_one_object(tmp_path: Path, isolated: bool) -> None:
    builder = Builder()
    builder.mesh(add_cube(builder))
    builder.node(mesh=0)
    first, second = (builder.view(bytes([i]) * 100_000) for i in range(2))
    builder.content["bufferViews"].append(dict(builder.content["bufferViews"][second]))
    views = [first, second, len(builder.content["bufferViews"]) - 1] * 500
    builder.content["images"] = [{"bufferView": v} for v in views]
    source = tmp_path / "a.glb"
    source.write_bytes(builder.pack())
    load_mesh(source)
    tracemalloc.start()
    try:
        images = load_scene(source, isolated=isolated).metadata["gltf"]["image_bytes"]
        assert tracemalloc.get_traced_memory()[1] < 5e6
    finally:
        tracemalloc.stop()
    assert len(set(map(id, images))) == 2
    assert [image[0] for image in images] == [0, 1, 1] * 500
    assert set(map(len, images)) == {100_000}


def test_images_that_overlap_are_refused_before_they_are_copied() -> None:
    """Each of 3,000 places, a byte apart, would be a copy: 60 kB of JSON for 300 MB."""
    builder = Builder()
    builder.mesh(add_cube(builder))
    builder.node(mesh=0)
    view = builder.content["bufferViews"][builder.view(bytes(100_000))]
    views = [view | {"byteLength": 100_000 - i} for i in range(3000)]
    builder.content["images"] = [{"bufferView": len(builder.content["bufferViews"]) + i} for i in range(3000)]
    builder.content["bufferViews"] += views
    n_bytes = len(builder.binary)
    for isolated in (False, True):
        with pytest.raises(MeshError, match=rf"its images overlap: they have 199999 bytes, its buffers {n_bytes}$"):
            load_scene(io.BytesIO(builder.pack()), file_type="glb", isolated=isolated)
    del builder.content["images"][1:]
    (image,) = load_scene(io.BytesIO(builder.pack()), file_type="glb").metadata["gltf"]["image_bytes"]
    assert image == bytes(100_000)


def parse_images(path: Path) -> Any:
    data = path.read_bytes()
    return (json.loads(data) if path.suffix == ".gltf" else parse(path)[0])["images"]


def test_standard_streams_and_errors(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "a.glb"
    builder = Builder()
    builder.mesh(add_cube(builder))
    builder.node(mesh=0, scale=[1e200, 1, 1])
    source.write_bytes(builder.pack())
    assert main(["transform", str(source), str(tmp_path / "b.glb"), "--scale", "1e200"]) == 2
    assert "a.glb, transformed: node 0: its matrix must be finite" in capsys.readouterr().err
    change("nodes.0.mesh", 5)(builder.content)
    source.write_bytes(builder.pack())
    assert main(["transform", str(source), str(tmp_path / "b.glb")]) == 2
    assert "a.glb: the JSON is not glTF: 'nodes[0].mesh' must be an index of meshes" in capsys.readouterr().err
    assert not (tmp_path / "b.glb").exists()


@pytest.mark.parametrize(
    ("images", "message"),
    [
        (["abc"], r"'images\[0\]' must be an object, got 'abc'"),
        (["ab"], r"'images\[0\]' must be an object, got 'ab'"),
        ([{}, []], r"'images\[1\]' must be an object, got an array"),
        ("a", "'images' must be an array, got 'a'"),
        ({"a": {}}, "'images' must be an array, got an object"),
    ],
)
def test_images_that_are_no_objects_are_refused(tmp_path: Path, images: Any, message: str) -> None:
    source = tmp_path / "a.gltf"
    source.write_bytes(as_text(data_uri(BINARY), content=document() | {"images": images}))
    for read in (load_scene, transform_itself):
        with pytest.raises(MeshError, match=rf"a\.gltf.*: the JSON is not glTF: {message}$"):
            read(source)


@pytest.mark.parametrize("place", ["", "nodes.0.", "meshes.0.", "meshes.0.primitives.0.", "materials.0.", "images.0."])
@pytest.mark.parametrize(("start", "end"), [('{"a":', "}"), ("[", "]")], ids=["objects", "arrays"])
def test_extras_have_a_depth(tmp_path: Path, place: str, start: str, end: str) -> None:
    """Python would end the copying of deep ones by a RecursionError."""
    content = document() | {"materials": [{}], "images": [{}]}
    change("meshes.0.primitives.0.material", 0)(content)
    change(f"{place}extras", "deep")(content)
    deepest = 99 - place.count(".")
    source = tmp_path / "a.gltf"
    for depth in (deepest, deepest + 1, 600, 20_000):
        deep = f"{start * depth}0{end * depth}".encode()
        source.write_bytes(as_text(data_uri(BINARY), content=content).replace(b'"deep"', deep))
        for read in (load_mesh, load_scene, transform_itself):
            if depth == deepest:
                read(source)
                continue
            with pytest.raises(MeshError, match=r"the JSON is (more than 100 objects and arrays deep$|malformed: max)"):
                read(source)


def transform_itself(path: Path) -> None:
    transform_document(path, path.with_name("b.glb"), MATRIX, source_type="gltf", target_type="glb")


def test_projections_become_one_mesh(tmp_path: Path) -> None:
    source, target = assembly(tmp_path), tmp_path / "flat.glb"
    transform(source, target, "--perspective-from-eye", "99", "--project")
    assert np.ptp(load_mesh(target).positions[:, 2]) == 0


def test_a_file_object_gives_the_same() -> None:
    data = furnished().pack()
    assert load_scene(io.BytesIO(data), file_type="glb").metadata["gltf"]["asset"]["generator"] == "by hand"
