"""Tables of matrices, as registration tools write them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import gpu_xform as gx
from gpu_xform.cli.matrix_table import MatrixTable
from tests.support.reference_transform import AFFINE

TURN = Rotation.from_euler("xyz", [20, -50, 70], degrees=True)
POSE = gx.translate(3, -4, 50) @ gx.homogeneous(TURN.as_matrix())
SECOND = gx.translate(1, 2, 3)
X, Y, Z, W = TURN.as_quat()
ROWS = "\n".join(" ".join(map(repr, row)) for row in AFFINE.tolist())
ROWS_OF_SECOND = "\n".join(" ".join(map(repr, row)) for row in SECOND.tolist())
NUMBERS = ", ".join(map(repr, AFFINE.ravel().tolist()))


def table(name: str, content: Any) -> MatrixTable:
    Path(name).write_text(content if isinstance(content, str) else json.dumps(content))
    return MatrixTable(name)


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("t.json", {"a.laz": AFFINE.tolist(), "b": SECOND.ravel().tolist()}, (AFFINE, SECOND)),
        ("t.json", [AFFINE.tolist(), SECOND.tolist()], (AFFINE, SECOND)),
        (
            "t.json",
            [{"file": "b.laz", "matrix": SECOND.tolist()}, {"name": "a", "transformation": AFFINE[:3].tolist()}],
            (AFFINE, SECOND),
        ),
        ("t.csv", f"a.laz, {NUMBERS}\nb, 1,0,0,1, 0,1,0,2, 0,0,1,3\n", (AFFINE, SECOND)),
        ("t.csv", f"file,{','.join(f'm{i}x' for i in range(16))}\na,{NUMBERS}\nb,1,1,0,0,0,1,2,3\n", (AFFINE, SECOND)),
        ("t.csv", f"{NUMBERS}\n1 0 0 1 0 1 0 2 0 0 1 3\n", (AFFINE, SECOND)),
        ("t.csv", f"a,2.5,{W},{X},{Y},{Z},3,-4,50\nb,1,1,0,0,0,1,2,3", (POSE @ gx.scale(2.5), SECOND)),
        ("t.csv", "a, matrices/a.txt\nb, matrices/b.txt", (AFFINE, SECOND)),
        (
            "images.txt",
            "# Image list with two lines of data per image:\n# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA, NAME\n"
            f"7 {W} {X} {Y} {Z} 3 -4 50 1 a.laz\n1.5 2.5 -1\n2 1 0 0 0 1 2 3 1 folder/b.laz\n\n",
            (np.linalg.inv(POSE), np.linalg.inv(SECOND)),
        ),
        (
            "t.json",
            {"class_name": "PoseGraph", "nodes": [{"pose": m.T.ravel().tolist()} for m in (AFFINE, SECOND)]},
            (AFFINE, SECOND),
        ),
        (
            "t.json",
            {
                "class_name": "PinholeCameraTrajectory",
                "parameters": [{"extrinsic": m.T.ravel().tolist()} for m in (POSE, SECOND)],
            },
            (np.linalg.inv(POSE), np.linalg.inv(SECOND)),
        ),
        ("t.txt", f"{ROWS}\n\n{ROWS_OF_SECOND}\n", (AFFINE, SECOND)),
        ("t.log", f"0 0 1\n{ROWS}\n1 1 2\n{ROWS_OF_SECOND}\n", (AFFINE, SECOND)),
        ("t.csv", f"a;{NUMBERS.replace(',', ';')}\nb;1;0;0;1;0;1;0;2;0;0;1;3\n", (AFFINE, SECOND)),
        ("t.csv", f"a\t{NUMBERS.replace(', ', chr(9))}\nb\t1\t1\t0\t0\t0\t1\t2\t3\n", (AFFINE, SECOND)),
        (
            "t.csv",
            f"tx,ty,tz,qx,qy,qz,qw,rmse,file\n3,-4,50,{X},{Y},{Z},{W},0.1,a.laz\n1,2,3,0,0,0,1,0,b.laz\n",
            (POSE, SECOND),
        ),
        (
            "t.csv",
            f"name;qw;qx;qy;qz;x;y;z;s\na;{W};{X};{Y};{Z};3;-4;50;2\nb;1;0;0;0;1;2;3;1",
            (POSE @ gx.scale(2), SECOND),
        ),
        ("t.json", {"a": {"matrix": AFFINE.tolist()}, "elsewhere/b.ply": {"pose": SECOND.tolist()}}, (AFFINE, SECOND)),
        ("t.json", {"C:\\scans\\a.laz": AFFINE.tolist(), "b.copc.laz": SECOND.tolist()}, (AFFINE, SECOND)),
        (
            "images.txt",
            f"7 {W} {X} {Y} {Z} 3 -4 50 1 photos/a.jpg\n1 2 -1 3 4 -1 5 6 -1 7 8 -1\n2 1 0 0 0 1 2 3 1 b.png\n",
            (np.linalg.inv(POSE), np.linalg.inv(SECOND)),
        ),
    ],
)
def test_a_table_has_a_matrix_per_file(name: str, content: Any, expected: Any) -> None:
    Path("matrices").mkdir()
    np.savetxt("matrices/a.txt", AFFINE, fmt="%.17g")
    np.savetxt("matrices/b.txt", SECOND)
    found = table(name, content)
    assert np.allclose(found.find("tiles/a.laz", 0, 2), expected[0], rtol=1e-15, atol=1e-14)
    second = "folder/b.laz" if name == "images.txt" else "tiles/b.laz"
    assert np.allclose(found.find(second, 1, 2), expected[1], rtol=1e-15, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("t.json", "{", r"t\.json: expected JSON, CSV or"),
        ("t.json", "3", "expected matrices by name, or a list"),
        ("t.json", {"a": [1, 2]}, r"t\.json: 'a': expected 16 numbers or 12"),
        ("t.json", {"a": [[np.nan] * 4] * 4}, "'a': expected a finite matrix"),
        ("t.json", [{"file": "a"}], "entry 0: expected 16 numbers"),
        ("t.json", [{"file": "a", "matrix": AFFINE.tolist()}, AFFINE.tolist()], "with a name and without one"),
        ("t.csv", f"a,{NUMBERS}\na,{NUMBERS}", r"t\.csv: line 2: a second matrix for a"),
        ("t.csv", "a,1,2,three", "line 1: expected 16 numbers"),
        ("t.json", "[" * 100_000, r"t\.json: expected JSON"),
        ("t.json", {"class_name": "PoseGraph"}, "PoseGraph without a list of nodes"),
        ("t.json", {"class_name": "PoseGraph", "nodes": [{"pose": [1, 2]}]}, "node 0: expected 16 numbers as pose"),
        ("t.json", {"class_name": "PoseGraph", "nodes": [7]}, "node 0: expected 16 numbers as pose"),
        (
            "t.json",
            {"class_name": "PinholeCameraTrajectory", "parameters": [{"extrinsic": [0] * 16}]},
            "view 0: the pose of a camera must have an inverse",
        ),
        ("images.txt", "1 0 0 0 0 1 2 3 1 a.jpg\n\n", r"a\.jpg: expected a positive scale, a quaternion"),
        ("t.txt", "1305031102.17 1.3 0.6 1.6 0.6 0.6 -0.3 -0.4\n", "line 1: expected a positive scale, a quaternion"),
        ("t.csv", "a,0,1,0,0,0,1,2,3\n", "line 1: expected a positive scale"),
        ("t.csv", f"name;m\na;0,5;{'0;' * 14}1", r"t\.csv: line 2: expected decimal points, got commas: 'a;0,5;0"),
        ("t.csv", "a,none.txt", r"t\.csv: line 1: expected 16 numbers, or the name of a file of them, got 'none\.txt'"),
    ],
)
def test_what_is_no_table_is_an_error_that_says_where(name: str, content: Any, message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=message):
        table(name, content)


def test_a_file_that_a_table_does_not_name_is_an_error() -> None:
    with pytest.raises(gx.ArgumentError, match=r"t\.json: no matrix for tiles/c\.laz"):
        table("t.json", {"a": AFFINE.tolist()}).find("tiles/c.laz", 0, 1)
    with pytest.raises(gx.ArgumentError, match=r"no matrix for scan03\.laz; did you mean 'scan3\.laz'\?"):
        table("t.json", {"scan3.laz": AFFINE.tolist(), "other": AFFINE.tolist()}).find("scan03.laz", 0, 1)
    with pytest.raises(gx.ArgumentError, match=r"no matrix for tile_3\.laz$"):  # its neighbour is no misspelling
        table("t.json", {"tile_2.laz": AFFINE.tolist(), "tile_4.laz": AFFINE.tolist()}).find("tile_3.laz", 0, 1)
    with pytest.raises(gx.ArgumentError, match=r"2 matrices may be that of c\.laz: a/c\.laz, b/c\.laz"):
        table("t.json", {"a/c.laz": AFFINE.tolist(), "b/c.laz": AFFINE.tolist()}).find("c.laz", 0, 1)
    with pytest.raises(gx.ArgumentError, match=r"t\.json: 1 matrices without names for 2 files"):
        table("t.json", [AFFINE.tolist()]).find("a", 0, 2)
