"""Streams of Draco in glTF, counted by their headers, against what DracoPy encodes and decodes."""

import contextlib
import io
from itertools import groupby
from typing import Any

import DracoPy
import numpy as np
import pytest

from gpu_xform import FileLimits, MeshError, load_mesh
from gpu_xform.formats.gltf_draco import decode_draco
from gpu_xform.formats.gltf_draco_counts import count_components, count_draco
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
    mesh = decode_draco(data, lambda _: None, lambda _: None)
    lengths = {len(column) for column in mesh.columns.values()}
    assert len(mesh.corners) == 3 * counts.n_faces
    assert {counts.n_points} == lengths if seed % 4 == 0 else counts.n_points <= min(lengths)
    assert counts.n_seams <= len(mesh.columns)
    assert count_components(data) == sum(column[0].size for column in mesh.columns.values())


@pytest.mark.parametrize("compression_level", [0, 1, 10])
@pytest.mark.parametrize("n", [30, 260])
@pytest.mark.parametrize("is_seamed", [False, True])
def test_components_are_counted_behind_faces_of_every_kind(compression_level: int, n: int, is_seamed: bool) -> None:
    """Corners of one, two and more bytes, in sequence; strips of faces; and their valences, of a thousand faces on."""
    rng, first = np.random.default_rng(n), np.arange(n * (n - 1)).reshape(n - 1, n)[:, :-1].ravel()
    points = np.stack(np.meshgrid(np.arange(n), np.arange(n), [0.0]), -1).reshape(-1, 3)
    faces = np.concatenate([first[:, None] + [0, 1, n], rng.permutation(first)[:, None] + [n, 1, n + 1]])
    more = {"normals": rng.normal(size=points.shape), "tex_coord": rng.random((len(points), 2))} if is_seamed else {}
    data = bytes(DracoPy.encode(points, faces.astype(np.uint32), compression_level=compression_level, **more))
    assert count_components(data) == (8 if is_seamed else 3)
    assert sum(column["data"][0].size for column in DracoPy.decode(data).attributes) == (8 if is_seamed else 3)


def pack_varint(value: int) -> bytes:
    return bytes([value & 127 | 128 * (value > 127)]) + (pack_varint(value >> 7) if value > 127 else b"")


def pack_symbols(symbols: list[int], is_tagged: bool) -> bytes:
    """Return symbols as the format packs them: by how often they come; or their numbers of bits so, and then bits."""
    lengths = [symbol.bit_length() for symbol in symbols]
    coded = lengths if is_tagged else symbols
    precision = 1 << (12 if is_tagged else min(max(3 * max(lengths) // 2, 12), 20))
    counts = np.bincount(coded)
    frequencies = counts * (precision - len(counts)) // len(coded) + (counts > 0)
    frequencies[np.argmax(frequencies)] += precision - frequencies.sum()
    before = np.cumsum(frequencies) - frequencies
    table = b""
    for frequency, same in groupby(frequencies.tolist()):
        n = len(list(same))
        n_more = 0 if frequency < 1 << 6 else 1 if frequency < 1 << 14 else 2
        zeros = bytes([63 << 2 | 3] * (n // 64)) + (bytes([(n % 64 - 1) << 2 | 3]) if n % 64 else b"")
        table += (frequency << 2 | n_more).to_bytes(1 + n_more, "little") * n if frequency else zeros
    state, data = 4 * precision, b""
    for symbol in reversed(coded):
        frequency = int(frequencies[symbol])
        while state >= 4 * 256 * frequency:
            state, data = state >> 8, data + bytes([state & 255])
        state = state // frequency * precision + state % frequency + int(before[symbol])
    rest = state - 4 * precision
    n_bytes = 1 + (rest.bit_length() + 1) // 8
    data += (rest | (n_bytes - 1) << (8 * n_bytes - 2)).to_bytes(n_bytes, "little")
    coder = pack_varint(len(frequencies)) + table + pack_varint(len(data)) + data
    if not is_tagged:
        return b"\1" + bytes([max(lengths)]) + coder
    bits = 0
    for symbol, length in zip(reversed(symbols), reversed(lengths), strict=True):
        bits = bits << length | symbol
    return b"\0" + coder + bits.to_bytes(-(-sum(lengths) // 8), "little")


def encode_packed_corners(seed: int, is_tagged: bool) -> tuple[bytes, Any]:
    """Return a stream whose corners are packed, which DracoPy reads and does not write, and its faces."""
    rng = np.random.default_rng(seed)
    n, n_faces = int(rng.integers(4, 250)), int(rng.integers(1, 300))
    faces = (rng.integers(0, n, (n_faces, 3)) if seed % 3 else np.tile([0, 1, 2], (n_faces, 1))).astype(np.uint32)
    points = rng.normal(size=(n, 3))
    data = bytes(DracoPy.encode(points, faces, compression_level=0, preserve_order=True))
    steps = np.diff(faces.ravel().astype(int), prepend=0).tolist()
    symbols = pack_symbols([abs(step) << 1 | (step < 0) for step in steps], is_tagged)
    method = 11 + len(pack_varint(n_faces)) + len(pack_varint(n))
    return data[:method] + b"\0" + symbols + data[method + 1 + 3 * n_faces :], faces


@pytest.mark.parametrize("is_tagged", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_components_are_counted_behind_corners_that_are_packed(is_tagged: bool, seed: int) -> None:
    data, faces = encode_packed_corners(seed, is_tagged)
    assert np.array_equal(DracoPy.decode(data).faces, faces)
    assert count_components(data) == 3


SEQUENTIAL, EDGEBREAKER = b"DRACO\2\2\1\0\0\0", b"DRACO\2\2\1\1\0\0"


def test_corners_among_millions_of_points_have_four_bytes() -> None:
    decoder = b"\1" + b"\1" + bytes([0, 9, 3, 0, 0]) + b"\2"  # one, of one attribute of three numbers
    assert count_components(SEQUENTIAL + b"\1" + pack_varint(1 << 21) + b"\1" + bytes(12) + decoder) == 3


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (EDGEBREAKER + bytes([1, 3, 1, 0, 1, 0, 0]), "are traversed in a way, 1, that bitstream 2.2 does not know"),
        (EDGEBREAKER + bytes([2, 3, 1, 0, 1, 0, 0, 0, 0]) + pack_varint(9), "it has 9 symbols for 1 faces"),
        (SEQUENTIAL + bytes([1, 3, 0, 0]) + pack_varint(1) + bytes([4, 0]), "its symbols are damaged"),
        (SEQUENTIAL + bytes([1, 3, 0, 0]) + pack_varint(1) + bytes([2, 255, 255, 0]), "its symbols are damaged"),
    ],
)
def test_damage_is_told(data: bytes, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        count_components(data)


def count(data: bytes) -> int:
    """Return the components of a stream of not too many faces."""
    return count_components(data) if count_draco(data).n_faces < 10_000 else -1


@pytest.mark.parametrize("seed", range(14))
def test_no_part_of_a_stream_ends_in_another_error(seed: int) -> None:
    data = encode(seed) if seed < 12 else encode_packed_corners(seed, seed == 12)[0]
    n_components = count(data)
    for n_bytes in range(len(data)):
        try:
            assert count(data[:n_bytes]) == n_components
        except MeshError:
            continue
        assert n_bytes > 30
    for place in range(min(len(data), 200)):
        for byte in (0, 127, 255):
            with contextlib.suppress(MeshError):
                count(data[:place] + bytes([byte]) + data[place + 1 :])


def test_streams_of_another_kind_are_refused() -> None:
    cloud = bytes(DracoPy.encode(GRID))
    with pytest.raises(MeshError, match=r"^expected a mesh of bitstream 2\.2, got type 0 and method \d of bitstream 2"):
        count_draco(cloud)
    with pytest.raises(MeshError, match=r"got type 1 and method 1 of bitstream 2\.1$"):
        count_draco(encode(1)[:6] + b"\1" + encode(1)[7:])
    with pytest.raises(MeshError, match=r"^expected a stream that begins with 'DRACO'$"):
        count_draco(b"DRAC")
    with pytest.raises(MeshError, match=r"^its 13 bytes end too soon$"):
        count_draco(encode(1)[:13])


def packed(n_parts: int, n_points: int = 900, n_corners: int = 3 * len(FACES), **more: Any) -> bytes:
    """Return a GLB whose primitives name one stream, of a grid of 30 by 30 points, and declare so much of it."""
    data = DracoPy.encode(GRID, FACES, preserve_order=True, **more)
    (attribute,) = (each for each in DracoPy.decode(data).attributes if each["attribute_type"] == 0)
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


def test_attributes_that_no_primitive_names_are_counted_before_they_are_decoded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a megabyte, thousands of them took gigabytes."""
    data = packed(1, generic_attributes={f"a{i}": np.zeros((900, 2), np.float32) for i in range(10)})
    assert load_mesh(io.BytesIO(data), file_type="glb", limits=FileLimits(points=2000)).n_points == 900
    monkeypatch.delattr(DracoPy, "decode")
    with pytest.raises(MeshError, match=r"its content: expands to more than 1,400 points .* FileLimits\(points=1400\)"):
        load_mesh(io.BytesIO(data), file_type="glb", limits=FileLimits(points=1400))
