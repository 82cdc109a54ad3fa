"""`gpu-xform info`: what model files hold."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gpu_xform import Mesh, Scene, samples, save_mesh, translate
from gpu_xform.cli import main
from tests.cli.commands.test_transform_attributes import HOUSE, SCAN
from tests.support.cli import error_of


def info_of(capsys: pytest.CaptureFixture[str], *paths: str) -> list[dict[str, Any]]:
    assert main(["info", *paths, "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    found: list[dict[str, Any]] = json.loads(out)
    return found


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
        "nodes": [{"name": "scan", "parent": None, "models": 1}],
        "animations": [],
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
