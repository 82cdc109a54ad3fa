"""`gpu-xform transform` of scans: LAS, LAZ, Zarr and streamed PLY, one by one or many."""

import json
import os
from pathlib import Path

import laspy
import numpy as np
import pytest
import zarr

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.compute import streaming
from tests.chunked.test_las import require_moved
from tests.chunked.test_ply import write_cloud
from tests.support.cli import error_of
from tests.support.las_files import NORMALS, make_las, stack
from tests.support.reference_transform import AFFINE, some_points

MATRIX = gx.chain(gx.rotate_z(30, degrees=True), gx.translate(1, 2, 3))
STEPS = ["--rotate-z", "30", "--translate", "1,2,3"]


def test_a_tile_is_moved() -> None:
    before = make_las(Path("in.las"))
    assert main(["transform", "in.las", "out.laz", *STEPS]) == 0
    require_moved(before, laspy.read("out.laz"), MATRIX)
    assert main(["transform", "in.las", "grid.las", *STEPS, "--las-scale", "0.01", "--las-offset", "1,2,3"]) == 0
    header = laspy.read("grid.las").header
    assert (header.scales.tolist(), header.offsets.tolist()) == ([0.01] * 3, [1, 2, 3])


def test_a_zarr_array_may_end_in_a_slash_and_hold_points_of_the_plane() -> None:
    points = some_points(50, "f4", 2)
    zarr.create_array(store="in.zarr", data=points, chunks=(20, 2))
    assert main(["transform", "in.zarr/", "out.zarr/", "--rotate-z", "30", "--translate", "1,2,0"]) == 0
    matrix = gx.chain(gx.rotate_z(30, degrees=True), gx.translate(1, 2, 0))[np.ix_([0, 1, 3], [0, 1, 3])]
    assert np.array_equal(zarr.open_array("out.zarr", mode="r")[:], gx.transform_points(points, matrix))


def test_a_cloud_of_ply_is_streamed(monkeypatch: pytest.MonkeyPatch) -> None:
    write_cloud(Path("in.ply"))
    monkeypatch.setattr("gpu_xform.cli.files.read_mesh", None)
    assert main(["transform", "in.ply", "out.ply", *STEPS]) == 0
    expected = gx.transform_points(gx.load_mesh("in.ply").positions, MATRIX)
    assert np.abs(gx.load_mesh("out.ply").positions - expected).max() < 1e-3


def test_many_tiles_take_a_matrix_each_and_a_bad_one_does_not_stop_the_rest(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("tiles").mkdir()
    tiles = [make_las(Path(f"tiles/t{i}.las"), 100 + i) for i in range(3)]
    Path("tiles/t1.las").write_bytes(b"LASF" + bytes(400))
    matrices = {f"t{i}.las": (AFFINE @ gx.translate(i, 0, 0)).tolist() for i in range(2)}
    Path("poses.json").write_text(json.dumps({**matrices, "t2": MATRIX.tolist(), "t7.las": np.eye(4).tolist()}))
    command = ["transform", "tiles/*.las", "moved/{model}.laz", "--matrix-table", "poses.json", "--translate", "0,0,5"]
    assert main(command) == 2
    printed = capsys.readouterr().err
    assert "gpu-xform: error: tiles/t1.las: LAS version 0.0 is not known" in printed
    assert printed.endswith("gpu-xform: poses.json: no input for t7.las\ngpu-xform: 3 files: 2 done, 1 failed\n")
    require_moved(tiles[0], laspy.read("moved/t0.laz"), gx.translate(0, 0, 5) @ AFFINE)
    require_moved(tiles[2], laspy.read("moved/t2.laz"), gx.translate(0, 0, 5) @ MATRIX)
    assert sorted(path.name for path in Path("moved").iterdir()) == ["t0.laz", "t2.laz"]


def test_no_result_replaces_another_input(capsys: pytest.CaptureFixture[str]) -> None:
    Path("a").mkdir()
    for path in ("a/b.las", "a-b.las"):
        make_las(Path(path), 20)
    before = Path("a-b.las").read_bytes()
    assert main(["transform", "a/b.las", "a-b.las", "{parent}-{model}.las", *STEPS]) == 2
    assert "a-b.las: the result of a/b.las would replace a-b.las, another input" in capsys.readouterr().err
    assert Path("a-b.las").read_bytes() == before
    assert main(["transform", "a/b.las", "a-b.las", "{folder}/{model}.las", *STEPS]) == 0


def test_a_matrix_by_columns_is_told_and_a_singular_one_flattens(
    capsys: pytest.CaptureFixture[str],
) -> None:
    make_las(Path("a.las"), 20)
    make_las(Path("b.las"), 20, normals=False)
    Path("poses.json").write_text(json.dumps({"a": MATRIX.T.tolist(), "b": MATRIX.T.tolist()}))
    command = ["transform", "a.las", "b.las", "out/{model}.las", "--matrix-table", "poses.json"]
    assert main(command) == 2
    assert capsys.readouterr().err.count("it seems to be stored column by column") == 2
    Path("poses.json").write_text(json.dumps([np.diag([1.0, 1, 0, 1]).tolist()] * 2))
    assert main(command) == 0
    flat = laspy.read("out/a.las")
    assert np.ptp(flat.z) == np.ptp(laspy.read("out/b.las").z) == 0
    assert not stack(flat, NORMALS)[:, :2].any()
    assert np.isfinite(stack(flat, NORMALS)).all()


def test_an_interrupted_tile_is_resumed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    make_las(Path("in.las"))
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 5000)
    assert main(["transform", "in.las", "whole.las", *STEPS]) == 0
    run = streaming.transform_file

    def interrupted(*args: object, **options: object) -> None:
        def stop(done: int, _: int) -> None:
            if done > 150:
                raise KeyboardInterrupt

        run(*args, **{**options, "progress": stop})  # type: ignore[arg-type]

    monkeypatch.setattr(streaming, "transform_file", interrupted)
    assert main(["transform", "in.las", "out.las", *STEPS]) == 130
    assert "--resume continues" in capsys.readouterr().err
    monkeypatch.setattr(streaming, "transform_file", run)
    assert main(["transform", "in.las", "out.las", *STEPS, "--resume"]) == 0
    assert Path("out.las").read_bytes() == Path("whole.las").read_bytes()


def test_what_the_target_cannot_hold_is_named_or_refused(capsys: pytest.CaptureFixture[str]) -> None:
    make_las(Path("in.las"))
    assert "NPY does not hold intensity" in error_of(["transform", "in.las", "out.npy", "--strict"], capsys)
    assert not Path("out.npy").exists()
    assert main(["transform", "in.las", "out.npy"]) == 0
    assert capsys.readouterr().err.startswith("gpu-xform: warning: out.npy: NPY does not hold intensity, ")


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("in.las cube.obj out.las", "out.las: 2 files need a path with {model} in it"),
        ("in.las in.las x{model}.las", "xin.las: two results would be written there, of in.las and of in.las"),
        ("in.las out.xyz", "out.xyz: the type must be one of glb, gltf, las, laz, npy, obj, off, ply, stl, zarr,"),
        ("cube.obj out.laz", "cube.obj: the type must be one of las, laz, npy, ply, zarr, got obj"),
        ("in.las -", "in.las: .las, .laz and .zarr go from a file to a file, not through a pipe"),
        ("cube.obj out.obj --workers 2", "--workers is for scans"),
        ("in.las {bogus}.las", "expected {model}, {suffix}, {parent} or {folder}, or doubled braces, got '{bogus}'"),
        ("in.las out.las --file-limits points=10", "in.las: --file-limits is for models, which are read whole"),
        ("in.las out.las --isolated", "in.las: --isolated is for models, which are read whole"),
        ("in.las out.las --tolerance 1", "in.las: --tolerance is for models, which are read whole"),
        ("plane.npy out.laz", "source must have shape (n, 3) for 'out.laz', got (n, 2) of 'plane.npy'"),
        ("fifo.las out.las", "source must be a file for this type, got 'fifo.las'"),
        ("cube.obj out.obj --skip-bad-chunks", "--skip-bad-chunks is for scans"),
        ("in.las out.las --workers 0", "expected a number of processes from 1 to 9999, got '0'"),
        ("in.las out.las --las-scale 0", "expected positive numbers, got '0'"),
        ("in.las out.las --workers 2 --adapter host", "--adapter is for one process"),
        ("in.las out.las --matrix-table none.json", "none.json: No such file"),
        ("none.laz out.laz", "none.laz: No such file"),
        ("none.zarr out.zarr", "none.zarr: No such file"),
    ],
)
def test_wrong_commands_are_refused_in_a_line(command: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    make_las(Path("in.las"), 10)
    gx.save_mesh(gx.samples.cube(), "cube.obj")
    np.save("plane.npy", np.ones((9, 2)))
    os.mkfifo("fifo.las")
    assert message in error_of(["transform", *command.split()], capsys)
    assert sorted(path.name for path in Path().iterdir()) == ["cube.obj", "fifo.las", "in.las", "plane.npy"]
