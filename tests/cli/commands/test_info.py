"""`gpu-xform info`: what model files hold."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gpu_xform import Mesh, Scene, samples, save_mesh, transform_file, translate
from gpu_xform.cli import main
from tests.cli.commands.test_transform_attributes import HOUSE, SCAN
from tests.support.cli import error_of
from tests.support.las_files import make_las


def info_of(capsys: pytest.CaptureFixture[str], *paths: str) -> list[dict[str, Any]]:
    assert main(["info", *paths, "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    found: list[dict[str, Any]] = json.loads(out)
    return found


def test_a_folder_is_told_from_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    Path("models").mkdir()
    assert "models: a folder; models/* stands for the files in it" in error_of(["info", "models"], capsys)


def test_a_scan(capsys: pytest.CaptureFixture[str]) -> None:
    Path("scan.ply").write_bytes(SCAN)
    (found,) = info_of(capsys, "scan.ply")
    assert found == {
        "file": "scan.ply",
        "type": "ply",
        "points": 3,
        "faces": {"3": 1},
        "edges": 3,
        "bounds": [[1, 2, 3], [2, 3, 3]],
        "attributes": {
            "point": {"normal": "3 x float32", "color": "3 x uint8", "intensity": "float32"},
            "corner": {},
            "face": {},
        },
        "labels": {},
        "materials": [],
        "colors": {},
        "libraries": [],
        "nodes": [{"name": "scan", "parent": None, "models": 1}],
        "animations": [],
        "joints": [],
        "units": None,
        "encoding": "ascii",
        "comments": ["scanned on a Tuesday", "obj_info num_cols 512"],
        "warnings": [],
    } | {"attributes": found["attributes"]}
    assert found["attributes"]["point"] == {"intensity": "float32", "normal": "3 x float32", "color": "3 x uint8"}


def test_faces_by_size_and_edges(capsys: pytest.CaptureFixture[str]) -> None:
    save_mesh(samples.house(), "house.obj")
    save_mesh(Mesh(samples.cube().positions), "cloud.ply")
    house, cloud = info_of(capsys, "house.obj", "cloud.ply")
    mesh = samples.house()
    assert house["faces"] == {str(size): int((np.diff(mesh.offsets) == size).sum()) for size in np.diff(mesh.offsets)}
    assert house["edges"] == len(mesh.edges)
    assert (cloud["points"], cloud["faces"], cloud["edges"]) == (8, {}, 0)


def test_nodes_and_units_of_a_scene(capsys: pytest.CaptureFixture[str]) -> None:
    scene = Scene()
    scene.add(samples.cube(), name="base")
    scene.add(samples.cube(), name="arm", parent="base", transform=translate(4, 0, 0))
    save_mesh(scene, "arm.glb")
    (found,) = info_of(capsys, "arm.glb")
    assert [(node["name"], node["parent"]) for node in found["nodes"]] == [("base", None), ("arm", "base")]
    assert found["units"] == "metre"
    assert found["points"] == 16
    assert found["bounds"] == [[-1, -1, -1], [5, 1, 1]]


def test_a_page_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    Path("house.obj").write_bytes(HOUSE)
    assert main(["info", "house.obj"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "house.obj"
    rows = dict(line.split(None, 1) for line in lines[1:] if not line.startswith("  per"))
    assert rows["points"] == "3"
    assert rows["faces"] == "1 (1 of 3 corners)"
    assert rows["bounds"] == "(0, 0, 0) to (1, 1, 0)"
    assert rows["material"] == "white"
    assert "  per corner  texcoord (2 x float64), normal (3 x float64)" in lines


def test_what_cannot_be_read_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    Path("bad.obj").write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/7 3/1\n")
    (found,) = info_of(capsys, "bad.obj")
    assert found["warnings"] == ["bad.obj: 1 corners name texture coordinates that the file does not hold"]
    assert "no.obj" in error_of(["info", "no.obj"], capsys)


def test_the_tolerance_of_surfaces_can_be_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points = "".join(f"v {x} {y} {x * x + y}\n" for y in range(2) for x in range(3))
    surface = "cstype bezier\ndeg 2 1\nsurf 0 1 0 1 1 2 3 4 5 6\nparm u 0 1\nparm v 0 1\nend\n"
    path = tmp_path / "bent.obj"
    path.write_text(points + surface)
    n_faces = []
    for tolerance in ("1", "0.01"):
        assert main(["info", str(path), "--json", "--tolerance", tolerance]) == 0
        n_faces.append(json.loads(capsys.readouterr().out)[0]["faces"]["4"])
    assert n_faces == [1, 64]  # control points z = 0, 1, 4 differ by 1, 3: a distance of 2 x 2 / (8 n^2) at most
    assert main(["info", str(path), "--tolerance", "0"]) == 2
    assert "--tolerance: expected a number greater than 0, got '0'" in capsys.readouterr().err


def test_files_that_can_be_read_are_told_beside_one_that_cannot(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("a.ply", "c.ply"):
        save_mesh(samples.cube(), name)
    Path("b.ply").write_bytes(b"ply\nbad")
    assert main(["info", "a.ply", "b.ply", "none.ply", "c.ply", "--json"]) == 2
    out, err = capsys.readouterr()
    assert [found["file"] for found in json.loads(out)] == ["a.ply", "c.ply"]
    assert [line.split()[2] for line in err.splitlines()] == ["b.ply:", "none.ply:"]


def test_bounds_far_from_the_origin_keep_their_digits(capsys: pytest.CaptureFixture[str]) -> None:
    save_mesh(Mesh([(389000.25, 5400000.5, 10.125), (389010.25, 5400002.5, 11.0)]), "utm.ply")
    assert main(["info", "utm.ply"]) == 0
    assert "(389000.25, 5400000.5, 10.125) to (389010.25, 5400002.5, 11)" in capsys.readouterr().out


def test_materials_have_their_colours(capsys: pytest.CaptureFixture[str]) -> None:
    Path("house.obj").write_bytes(HOUSE)
    Path("house.mtl").write_bytes(b"newmtl white\nKd 1 1 0.5\nd 0.25\n")
    (found,) = info_of(capsys, "house.obj")
    assert found["colors"] == {"white": [1, 1, 0.5, 0.25]}
    assert found["libraries"] == ["house.mtl"]
    assert main(["info", "house.obj"]) == 0
    out = capsys.readouterr().out
    assert "white (1, 1, 0.5, 0.25)" in out
    assert "mtllib      house.mtl" in out


def test_scans_by_their_headers(capsys: pytest.CaptureFixture[str]) -> None:
    las = make_las(Path("tile.laz"), 40)
    save = np.arange(6, dtype="f4").reshape(2, 3)
    np.save("a.npy", save)
    transform_file("a.npy", "a.zarr", np.eye(4))
    tile, array = info_of(capsys, "tile.laz", "a.zarr/")
    assert (tile["type"], tile["points"], tile["point_format"], tile["warnings"]) == ("laz", 40, 7, [])
    assert np.array_equal(tile["bounds"], [las.header.mins, las.header.maxs])
    assert (array["type"], array["points"], array["bounds"]) == ("zarr", 2, [[0, 1, 2], [3, 4, 5]])
    assert main(["info", "tile.laz", "a.zarr"]) == 0
    lines = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    assert ["type", "LAZ, chunks of 50,000 points; LAS 1.4, point format 7, 58 bytes per point"] in lines
    assert ["scale", "0.001, 0.002, 0.005"] in lines
    assert ["crs", "none named"] in lines
    assert ["type", "zarr, format 3, 3 x float32"] in lines


def test_a_scan_that_is_none_is_named_once(capsys: pytest.CaptureFixture[str]) -> None:
    Path("no.las").write_bytes(b"no")
    assert main(["info", "no.las"]) != 0
    assert capsys.readouterr().err.count("no.las") == 1
    assert main(["info", "-", "--file-type", "las"]) != 0
    assert "not through a pipe" in capsys.readouterr().err


@pytest.mark.parametrize("path", ["tile.laz", "a.zarr"])
@pytest.mark.parametrize("option", ["--file-limits points=10", "--isolated", "--tolerance 1"])
def test_options_of_models_are_refused_for_scans(path: str, option: str, capsys: pytest.CaptureFixture[str]) -> None:
    make_las(Path("tile.laz"), 40)
    np.save("a.npy", np.ones((40, 3)))
    transform_file("a.npy", "a.zarr", np.eye(4))
    flag = option.split()[0]
    assert f"error: {path}: {flag} is for models, which are read whole\n" in error_of(
        ["info", path, *option.split()], capsys
    )
    assert main(["info", path]) == 0
