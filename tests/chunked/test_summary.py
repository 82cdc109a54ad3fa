"""What is said of scans, against laspy, and coordinate systems by their records."""

import json
import struct
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
import zarr

import gpu_xform as gx
from gpu_xform.chunked import summary
from gpu_xform.chunked.las_crs import name_crs
from gpu_xform.chunked.summary import summarize
from tests.chunked.test_las import CRS, OTHER
from tests.support.las_files import make_las


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize("point_format", [3, 10])
def test_las_is_described_as_laspy_reads_it(tmp_path: Path, point_format: int, suffix: str) -> None:
    path = tmp_path / f"in.{suffix}"
    evlrs = [laspy.VLR("someone", 8, "behind", bytes(100))]
    las = make_las(path, 400, point_format, vlrs=[CRS, OTHER], evlrs=evlrs)
    found = summarize(path, suffix)
    header = las.header
    assert (found["points"], found["version"], found["point_format"]) == (400, "1.4", point_format)
    assert found["point_bytes"] == header.point_format.size
    assert found["scale"] == header.scales.tolist()
    assert found["offset"] == header.offsets.tolist()
    assert np.array_equal(found["bounds"], [header.mins, header.maxs])
    assert (found["compression"], found["chunk_points"]) == (("LAZ", 50_000) if suffix == "laz" else (None, None))
    assert list(found["dimensions"]) == list(header.point_format.dimension_names)
    assert found["dimensions"]["intensity"] == "uint16"
    assert found["dimensions"]["edge_of_flight_line"] == "1 bit"
    assert found["dimensions"]["depth"] == "float64"
    counts = header.number_of_points_by_return.tolist()
    assert found["returns"] == counts[: np.max(np.flatnonzero(counts)) + 1]
    assert found["crs"] == "here"
    ours = {"user": "someone", "id": 7, "description": "theirs", "bytes": 77}
    assert ours in found["vlrs"]
    assert found["evlrs"] == [{"user": "someone", "id": 8, "description": "behind", "bytes": 100}]
    assert found["created"] == header.creation_date.isoformat()


def test_bounds_that_no_points_can_have_are_not_told(tmp_path: Path) -> None:
    path = tmp_path / "in.las"
    make_las(path)
    data = bytearray(path.read_bytes())
    struct.pack_into("<6d", data, 179, *([-np.inf, np.inf] * 3))
    path.write_bytes(data)
    assert summarize(path, "las")["bounds"] is None


def test_names_that_are_no_utf8_leave_the_dimensions_of_the_format(tmp_path: Path) -> None:
    path = tmp_path / "in.las"
    make_las(path)
    path.write_bytes(path.read_bytes().replace(b"amplitude", b"h\xf6he-----"))
    with pytest.warns(gx.MeshWarning, match="laspy does not read its header"):
        found = summarize(path, "las")
    assert list(found["dimensions"]) == list(laspy.PointFormat(7).dimension_names)
    with pytest.raises(gx.MeshError, match=r"in\.las: laspy does not read its header"):
        gx.transform_file(path, tmp_path / "out.npy", np.eye(4))
    gx.transform_file(path, tmp_path / "out.las", np.eye(4))


def test_a_zarr_array_is_counted_unless_it_is_large(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    array = zarr.create_array(
        store=str(tmp_path / "a.zarr"), shape=(10, 3), chunks=(2, 3), shards=(4, 3), dtype="f4", attributes={"b": 1}
    )
    array[:] = np.arange(30, dtype="f4").reshape(10, 3)
    found = summarize(tmp_path / "a.zarr", "zarr")
    assert found == {
        "points": 10,
        "bounds": [[0, 1, 2], [27, 28, 29]],
        "columns": 3,
        "dtype": "float32",
        "format": 3,
        "chunks": [2, 3],
        "shards": [4, 3],
        "compressors": ["ZstdCodec"],
        "attributes": ["b"],
    }
    array[1, 1] = np.nan
    with pytest.warns(gx.MeshWarning, match="not finite"):
        assert summarize(tmp_path / "a.zarr", "zarr")["bounds"] == [[0, None, 2], [27, None, 29]]
    monkeypatch.setattr(summary, "MAX_COUNTED_POINTS", 9)
    with pytest.warns(gx.MeshWarning, match="not counted for more than 9 points"):
        assert summarize(tmp_path / "a.zarr", "zarr")["bounds"] is None


def geo_keys(*keys: tuple[int, int, int, int]) -> bytes:
    return struct.pack("<4H", 1, 1, 0, len(keys)) + b"".join(struct.pack("<4H", *key) for key in keys)


UTM = b'PROJCS["WGS 84 / UTM zone 33N",GEOGCS["WGS 84",AUTHORITY["EPSG","4326"]],AUTHORITY["EPSG","32633"]]\0'
WKT2 = b'PROJCRS["a, ""b",BASEGEOGCRS["c",ID["EPSG",4326]],ID["EPSG",32633]]'


@pytest.mark.parametrize(
    ("records", "expected"),
    [
        ({2112: UTM}, "WGS 84 / UTM zone 33N (EPSG:32633)"),
        ({2112: b'PROJCS["mine",GEOGCS["WGS 84",AUTHORITY["EPSG","4326"]]]'}, "mine"),
        ({2112: WKT2}, "a,  (EPSG:32633)"),
        ({34735: geo_keys((3072, 0, 1, 32633))}, "EPSG:32633"),
        ({34735: geo_keys((2048, 0, 1, 4326), (3072, 0, 1, 32633), (4096, 0, 1, 5703))}, "EPSG:32633 + EPSG:5703"),
        ({34735: geo_keys((3072, 0, 1, 32767), (3073, 34737, 6, 4)), 34737: b"xyz|here||"}, "here"),
        ({34735: geo_keys((3073, 34737, 5, 0)), 34737: b"there|"}, "there"),
        ({34735: b"\1\0"}, None),
        ({2112: b""}, None),
        ({}, None),
    ],
)
def test_a_coordinate_system_is_named(records: dict[int, bytes], expected: Any) -> None:
    assert name_crs(records) == expected


def test_attributes_that_are_no_table_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    zarr.create_array(store=str(path), data=np.ones((5, 3), "f4"))
    content = json.loads((path / "zarr.json").read_text())
    (path / "zarr.json").write_text(json.dumps(content | {"attributes": 7}))
    try:
        assert summarize(path, "zarr")["attributes"] == []
    except gx.ArgumentError as error:
        assert "be a Zarr array" in str(error)  # noqa: PT017 - zarr-python 3.4 refuses them itself
        return
    gx.transform_file(path, tmp_path / "out.zarr", np.eye(4))
    assert np.array_equal(zarr.open_array(tmp_path / "out.zarr", mode="r")[:], np.ones((5, 3)))
