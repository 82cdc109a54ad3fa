"""glTF documents moved and written again: all that they hold stays."""

import base64
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pygltflib
import pytest
import trimesh

from gpu_xform import chain, load_mesh, load_scene, rotate_y, scale, translate
from gpu_xform.cli import main
from tests.formats.test_gltf_meshes import add_cube, add_skinned_cube, meshopt_cube
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
    for i, local in ((0, translate(1, 0, 0)), (2, scale(1, 2, 3))):
        assert np.allclose(np.reshape(read["nodes"][i].pop("matrix"), (4, 4)).T, MATRIX @ local)
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
    assert "a.glb: the JSON is not glTF: IndexError" in capsys.readouterr().err
    assert not (tmp_path / "b.glb").exists()


def test_projections_become_one_mesh(tmp_path: Path) -> None:
    source, target = assembly(tmp_path), tmp_path / "flat.glb"
    transform(source, target, "--perspective-from-eye", "99", "--project")
    assert np.ptp(load_mesh(target).positions[:, 2]) == 0


def test_a_file_object_gives_the_same() -> None:
    data = furnished().pack()
    assert load_scene(io.BytesIO(data), file_type="glb").metadata["gltf"]["asset"]["generator"] == "by hand"
