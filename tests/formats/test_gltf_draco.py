"""Streams of Draco in glTF, counted by their headers, against what DracoPy encodes and decodes."""

import contextlib
import io
from typing import Any

import DracoPy
import numpy as np
import pytest

from gpu_xform import MeshError, load_mesh
from gpu_xform.formats.gltf_draco import count_draco, decode_draco
from tests.support.gltf_files import Builder

GRID = np.stack(np.meshgrid(np.arange(30.0), np.arange(30.0), [0.0]), -1).reshape(-1, 3)
FACES = np.array([(i, i + 1, i + 31) for i in range(869) if i % 30 < 29], np.uint32)


def encode(seed: int) -> bytes:
    """Return a stream of a mesh whose faces meet anyhow, with some attributes, packed in some way."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 40))
    faces = np.concatenate([[[0, 1, 2]], rng.integers(0, n, (rng.integers(1, 120), 3))]).astype(np.uint32)
    more: dict[str, Any] = {}
    if seed % 2:
        more |= {"normals": rng.normal(size=(n, 3)), "tex_coord": rng.random((n, 2))}
    if seed % 3 == 0:
        more["generic_attributes"] = {"weight": rng.random((n, 2)).astype(np.float32)}
    more["create_metadata"] = seed % 5 == 0
    return bytes(
        DracoPy.encode(
            rng.normal(size=(n, 3)), faces, compression_level=seed % 11, preserve_order=seed % 4 == 0, **more
        )
    )


@pytest.mark.parametrize("seed", range(60))
def test_headers_declare_what_streams_hold(seed: int) -> None:
    data = encode(seed)
    counts = count_draco(data)
    mesh = decode_draco(data, lambda _: None)
    lengths = {len(column) for column in mesh.columns.values()}
    assert len(mesh.corners) == 3 * counts.n_faces
    assert {counts.n_points} == lengths if seed % 4 == 0 else counts.n_points <= min(lengths)
    assert counts.n_seams <= len(mesh.columns)


@pytest.mark.parametrize("seed", range(12))
def test_no_part_of_a_header_ends_in_another_error(seed: int) -> None:
    data = encode(seed)
    for n_bytes in range(len(data)):
        try:
            count_draco(data[:n_bytes])
        except MeshError:
            continue
        assert n_bytes > 11
    for place in range(min(len(data), 60)):
        for byte in (0, 127, 255):
            with contextlib.suppress(MeshError):
                count_draco(data[:place] + bytes([byte]) + data[place + 1 :])


def test_streams_of_another_kind_are_refused() -> None:
    cloud = bytes(DracoPy.encode(GRID))
    with pytest.raises(MeshError, match=r"^expected a mesh of bitstream 2\.2, got type 0 and method \d of bitstream 2"):
        count_draco(cloud)
    with pytest.raises(MeshError, match=r"got type 1 and method 1 of bitstream 2\.1$"):
        count_draco(encode(1)[:6] + b"\1" + encode(1)[7:])
    with pytest.raises(MeshError, match=r"^expected a stream that begins with 'DRACO'$"):
        count_draco(b"DRAC")
    with pytest.raises(MeshError, match=r"^its 13 bytes end within their header$"):
        count_draco(encode(1)[:13])


def packed(n_parts: int, n_points: int = 900, n_corners: int = 3 * len(FACES)) -> bytes:
    """Return a GLB whose primitives name one stream, of a grid of 30 by 30 points, and declare so much of it."""
    data = DracoPy.encode(GRID, FACES, preserve_order=True)
    (attribute,) = DracoPy.decode(data).attributes
    builder = Builder()
    builder.content["accessors"] = [
        {"componentType": 5126, "count": n_points, "type": "VEC3"},
        {"componentType": 5125, "count": n_corners, "type": "SCALAR"},
    ]
    draco = {"bufferView": builder.view(bytes(data)), "attributes": {"POSITION": attribute["unique_id"]}}
    part = {"attributes": {"POSITION": 0}, "indices": 1, "extensions": {"KHR_draco_mesh_compression": draco}}
    builder.mesh(*([part] * n_parts))
    builder.node(mesh=0)
    return builder.pack()


def test_a_stream_that_many_primitives_name_is_decoded_once(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[int] = []
    decode, data = DracoPy.decode, packed(50)

    def count(stream: bytes) -> Any:
        calls.append(len(stream))
        return decode(stream)

    monkeypatch.setattr(DracoPy, "decode", count)
    mesh = load_mesh(io.BytesIO(data), file_type="glb")
    assert len(calls) == 1
    assert (mesh.n_points, mesh.n_faces) == (900, 50 * len(FACES))
    assert np.allclose(mesh.positions, GRID, atol=0.02)


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        ((899, 3 * len(FACES)), "accessor 0 declares 899 rows, its content has 900"),
        ((900, 3 * len(FACES) - 1), f"accessor 1 declares {3 * len(FACES) - 1} rows, its content has {3 * len(FACES)}"),
        ((10**8, 3 * len(FACES)), r"expands to more than .* the limit FileLimits\(points="),
        ((900, 10**8), r"expands to more than .* the limit FileLimits\(points="),
    ],
)
def test_streams_of_more_than_is_declared_and_counted_are_not_decoded(
    declared: tuple[int, int], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = packed(1, *declared)
    monkeypatch.delattr(DracoPy, "decode")
    with pytest.raises(MeshError, match=f"mesh 0: (KHR_draco_mesh_compression: )?{message}"):
        load_mesh(io.BytesIO(data), file_type="glb")
