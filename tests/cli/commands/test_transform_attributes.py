"""`gpu-xform transform`: what files hold beside points and faces."""

import io
from pathlib import Path

import numpy as np
import plyfile
import pytest
import trimesh

from gpu_xform import Mesh, load_mesh, samples, save_mesh
from gpu_xform.cli import main
from tests.support.cli import error_of

SCAN = b"""ply
format ascii 1.0
comment scanned on a Tuesday
obj_info num_cols 512
element vertex 3
property float x
property float y
property float z
property float nx
property float ny
property float nz
property float intensity
property uchar red
property uchar green
property uchar blue
element face 1
property list uchar int vertex_indices
end_header
1 2 3 0 0 1 0.25 255 0 7
2 2 3 0 0 1 0.5 254 1 6
1 3 3 0 0.6 0.8 0.75 253 2 5
3 0 1 2
"""
HOUSE = b"""mtllib house.mtl
o house
v 0 0 0
v 1 0 0
v 1 1 0
vt 0 0
vt 1 0
vt 1 1
vn 0 0 1
g wall
usemtl white
f 1/1/1 2/2/1 3/3/1
"""


def scan(path: str) -> plyfile.PlyData:
    return plyfile.PlyData.read(io.BytesIO(Path(path).read_bytes()))


@pytest.fixture(autouse=True)
def _files() -> None:
    Path("scan.ply").write_bytes(SCAN)
    Path("house.obj").write_bytes(HOUSE)
    Path("house.mtl").write_bytes(b"newmtl white\nKd 1 1 1\n")


def test_a_scan_keeps_all_that_it_holds(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["transform", "scan.ply", "moved.ply", "--rotate-x", "90", "--translate", "1,0,0", "--strict"]) == 0
    assert capsys.readouterr().err == ""
    before, after = scan("scan.ply"), scan("moved.ply")
    assert (after.text, after.comments, after.obj_info) == (True, before.comments, before.obj_info)
    assert str(after["vertex"]) == str(before["vertex"])
    for name in ("intensity", "red", "green", "blue"):
        assert np.array_equal(after["vertex"][name], before["vertex"][name])
    assert np.allclose(after["vertex"]["x"], before["vertex"]["x"] + 1)
    assert np.allclose(after["vertex"]["y"], -before["vertex"]["z"])
    assert np.allclose(after["vertex"]["ny"], -before["vertex"]["nz"])


def test_an_obj_file_keeps_its_texture_and_its_materials(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["transform", "house.obj", "moved.obj", "--scale", "2", "--strict"]) == 0
    assert capsys.readouterr().err == ""
    lines = Path("moved.obj").read_bytes().splitlines()
    assert {line for line in HOUSE.splitlines() if line[:2] != b"v "} >= {
        line for line in lines if line[:1] not in b"v"
    }
    assert b"f 1/1/1 2/2/1 3/3/1" in lines
    assert load_mesh("moved.obj").attributes == load_mesh("house.obj").attributes


def test_what_the_target_cannot_hold_is_named_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["transform", "scan.ply", "moved.obj"]) == 0
    message = "gpu-xform: warning: moved.obj: OBJ does not hold intensity per point, 2 comments\n"
    assert capsys.readouterr().err == message
    assert np.allclose(
        load_mesh("moved.obj").attributes.corner["normal"], load_mesh("scan.ply").attributes.point["normal"]
    )
    assert main(["transform", "house.obj", "moved.ply"]) == 0
    err = capsys.readouterr().err
    assert err.startswith("gpu-xform: warning: moved.ply: PLY does not hold ")
    assert err.count("\n") == 1
    for lost in ("labels of material", "labels of group", "labels of object", "material (mtllib)"):
        assert lost in err


def test_strict_makes_an_error_of_a_loss_and_writes_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    message = error_of(["transform", "scan.ply", "moved.stl", "--strict"], capsys)
    assert "moved.stl: STL does not hold " in message
    assert "intensity per point" in message
    assert not Path("moved.stl").exists()


def test_what_loses_nothing_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    save_mesh(samples.cube(), "cube.obj")
    for name in ("cube.ply", "cube.off"):
        assert main(["transform", "cube.obj", name, "--strict"]) == 0
    save_mesh(samples.icosphere(1), "ball.obj")
    for name in ("ball.ply", "ball.off", "ball.stl", "ball.glb", "ball.gltf"):
        assert main(["transform", "ball.obj", name, "--strict"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", ["house.stl", "house.glb", "house.gltf"])
def test_polygons_that_become_triangles_are_named(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    save_mesh(samples.house(), "house.obj")
    n_polygons = int((np.diff(samples.house().offsets) > 3).sum())
    words = f"does not hold {n_polygons} polygons of more than three corners, which become triangles"
    assert words in error_of(["transform", "house.obj", name, "--strict"], capsys)
    assert not Path(name).exists()
    assert main(["transform", "house.obj", name]) == 0
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert words in said


@pytest.mark.parametrize("mirror", [["--reflect", "1,0,0"], ["--scale", "-1,1,1"], ["--scale", "1,-2,1"]])
@pytest.mark.parametrize("suffix", ["obj", "ply", "off", "stl", "glb"])
def test_a_mirrored_solid_keeps_its_positive_volume(mirror: list[str], suffix: str) -> None:
    save_mesh(samples.cube(), f"cube.{suffix}")
    assert main(["transform", f"cube.{suffix}", f"moved.{suffix}", *mirror]) == 0
    solid = trimesh.load_mesh(f"moved.{suffix}", process=True)
    assert solid.volume > 0
    assert load_mesh(f"moved.{suffix}").to_trimesh().volume > 0


def test_a_projection_drops_normals_with_a_word(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["transform", "scan.ply", "flat.ply", "--perspective-from-eye", "9", "--project"]
    assert main(arguments) == 0
    assert capsys.readouterr().err == "gpu-xform: warning: a projection does not keep normal per point\n"
    assert "nx" not in scan("flat.ply")["vertex"].data.dtype.names
    assert np.array_equal(scan("flat.ply")["vertex"]["intensity"], [0.25, 0.5, 0.75])
    assert "normal per point" in error_of([*arguments, "--strict"], capsys)


def test_parts_of_a_scene_keep_their_colors_in_one_mesh(capsys: pytest.CaptureFixture[str]) -> None:
    from gpu_xform import Scene

    scene = Scene()
    red = np.tile(np.array([255, 0, 0, 255], np.uint8), (8, 1))
    cube = samples.cube()
    scene.add(Mesh(cube.positions, cube.faces, attributes={"point": {"color": red}}), name="red")
    scene.add(cube, name="plain", transform=np.diag([2.0, 2, 2, 1]))
    save_mesh(scene, "two.glb")
    assert main(["transform", "two.glb", "one.ply"]) == 0
    assert "PLY does not hold 2 nodes" in capsys.readouterr().err
    mesh = load_mesh("one.ply")
    assert np.array_equal(mesh.attributes.point["color"], np.concatenate([red, np.full((8, 4), 255)]))
