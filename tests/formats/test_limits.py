"""Limits of model files: what they expand to is counted before it is allocated, and no honest file is refused."""

import base64
import contextlib
import gzip
import io
import json
import re
import string
import sys
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.cli import main
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError
from gpu_xform.formats.limits import FREE_NUMBERS, NUMBERS_PER_BYTE
from tests.support.cli import error_of
from tests.support.cost import within_cpu_s

POINT_3MF = '<vertex x="0" y="0" z="0"/>'
TRIANGLE_3MF = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>'
    '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'
)
ATTRIBUTES = "".join(f' {name}=""' for name in string.ascii_letters)
NUMBERS_XML = f"<!--{' '.join(map(str, range(40_000)))}-->"  # so that a file is larger
FACE_97 = "Shape{geometry IndexedFaceSet{coord Coordinate{point[0 0 0 1 0 0 0 1 0]} coordIndex[0 1 2]}}"


def threemf(resources: str, item: str, *, level: int | None = None) -> bytes:
    namespace = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    model = f'<model xmlns="{namespace}"><resources>{resources}</resources><build>{item}</build></model>'
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as container:
        container.writestr("3D/3dmodel.model", model)
    return file.getvalue()


def gltf(n_primitives: int = 1, n_points: int = 3, **content: Any) -> bytes:
    data = base64.b64encode(bytes(12 * n_points)).decode()
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": f"data:application/octet-stream;base64,{data}", "byteLength": 12 * n_points}],
        "bufferViews": [{"buffer": 0, "byteLength": 12 * n_points}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": n_points}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * n_primitives}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    return json.dumps(document | content).encode()


def vrml(text: str) -> bytes:
    return b"#VRML V2.0 utf8\n" + text.encode()


def doubled(first: str, step: str, levels: int) -> str:
    return first + "".join(step.format(i, i - 1) for i in range(1, levels))


ZEROS = [{"componentType": 5126, "type": "VEC3", "count": 10**7}] * 20

# Of each, a few kilobytes meant seconds, or hundreds of megabytes.
BOMBS: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "components": (
        "3mf",
        lambda: threemf(
            doubled(
                f'<object id="0">{TRIANGLE_3MF}</object>',
                '<object id="{0}"><components><component objectid="{1}"/><component objectid="{1}"/></components>'
                "</object>",
                25,
            ),
            '<item objectid="24"/>',
        ),
        "nodes",
    ),
    "an archive": ("3mf", lambda: threemf(" " * 10_000_000, ""), "unpacked_bytes"),
    "components of a few items": (
        "3mf",
        lambda: threemf(
            f'<object id="0">{TRIANGLE_3MF}</object><object id="1"><components>'
            + 6000 * '<component objectid="0"/>'
            + "</components></object>",
            8 * '<item objectid="1"/>',
        ),
        "nodes",
    ),
    "items": (
        "3mf",
        lambda: threemf(f'<object id="0">{TRIANGLE_3MF}</object>', 20_000 * '<item objectid="0"/>'),
        "nodes",
    ),
    "items of a large object": (
        "3mf",
        lambda: threemf(
            f'<object id="0"><mesh><vertices>{30_000 * POINT_3MF}</vertices></mesh></object>',
            60 * '<item objectid="0"/>',
        ),
        "points",
    ),
    "objects": ("3mf", lambda: threemf(15_000 * "<object/>", ""), "nodes"),
    "empty elements": ("3mf", lambda: threemf(200_000 * "<a/>", ""), "nodes"),
    "vertices": (
        "3mf",
        lambda: threemf(f"<object><mesh><vertices>{70_000 * '<vertex/>'}</vertices></mesh></object>", ""),
        "nodes",
    ),
    "attributes": ("3mf", lambda: threemf(18_000 * f"<a{ATTRIBUTES}/>", NUMBERS_XML), "nodes"),
    "USE": (
        "wrl",
        lambda: vrml(
            doubled(
                f"DEF A0 {FACE_97}\n",
                "DEF A{0} Group{{children[Transform{{translation {0} 1 0 children USE A{1}}} USE A{1}]}}\n",
                30,
            )
        ),
        "nodes",
    ),
    "USE of many numbers": (
        "wrl",
        lambda: vrml(
            f"DEF A Shape{{geometry PointSet{{coord Coordinate{{point[{'1 2 3,' * 3000}]}}}}}}\n"
            + "".join(f"Transform{{translation {i} 0 0 children USE A}}\n" for i in range(2000))
        ),
        "points",
    ),
    "an extrusion": (
        "wrl",
        lambda: vrml(f"Shape{{geometry Extrusion{{crossSection[{'1 0,' * 3000}] spine[{'0 1 0,' * 3000}]}}}}"),
        "points",
    ),
    "gzip": ("wrz", lambda: gzip.compress(vrml(" " * 20_000_000)), "unpacked_bytes"),
    "zeros": (
        "gltf",
        lambda: gltf(accessors=ZEROS, meshes=[{"primitives": [{"attributes": {"POSITION": i}} for i in range(20)]}]),
        "points",
    ),
    "primitives": ("gltf", lambda: gltf(20_000, 3000), "points"),
    "morph targets": (
        "gltf",
        lambda: gltf(
            n_points=3000,
            meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}] * 15_000}]}],
        ),
        "points",
    ),
    "nodes": (
        "gltf",
        lambda: gltf(n_points=3000, nodes=[{"mesh": 0}] * 5000, scenes=[{"nodes": list(range(5000))}]),
        "points",
    ),
}


@pytest.mark.parametrize("name", BOMBS)
def test_what_expands_without_bound_is_refused_before_it_does(name: str) -> None:
    kind, make, limit = BOMBS[name]
    data = make()
    assert len(data) < 1_000_000
    gx.load_mesh(io.BytesIO(b"v 0 0 0\n"), file_type="obj")
    for _ in within_cpu_s(10):  # traced, it takes five times as long
        tracemalloc.start()
        try:
            with pytest.raises(MeshError, match=rf"the limit FileLimits\({limit}=\.\.\.\)"):
                gx.load_mesh(io.BytesIO(data), file_type=kind)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert peak < 150e6


def test_repeated_shapes_take_hardly_more_memory_than_their_mesh() -> None:
    """A file of 100 kB may repeat a sphere 5,000 times."""
    red = "appearance Appearance{material Material{diffuseColor 1 0 0}}"
    data = vrml(
        f"DEF A Shape{{geometry Sphere{{}} {red}}}\n"
        + "".join(f"Transform{{translation {i} 0 0 children USE A}}\n" for i in range(300))
    )
    gx.load_mesh(io.BytesIO(vrml("Shape{geometry Sphere{}}")), file_type="wrl")
    tracemalloc.start()
    try:
        mesh = gx.load_mesh(io.BytesIO(data), file_type="wrl")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    held = (mesh.positions, mesh.indices, mesh.offsets, mesh.attributes.face["color"])
    assert mesh.n_points == 301 * 482
    assert peak < 1.5 * sum(array.nbytes for array in held)


LONG_LINE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3" + b" \\\n" * 200_000
MANY_ELEMENTS = b"ply\nformat ascii 1.0\n" + b"".join(b"element e%d 0\nproperty int x\n" % i for i in range(20_000))


@pytest.mark.parametrize(
    ("kind", "data"),
    [("obj", LONG_LINE), ("ply", MANY_ELEMENTS + b"end_header\n")],
    ids=["a line continued often", "many elements"],
)
def test_no_time_grows_with_the_square_of_the_length(kind: str, data: bytes) -> None:
    for _ in within_cpu_s(2):
        with contextlib.suppress(MeshError):
            gx.load_mesh(io.BytesIO(data), file_type=kind)


def test_many_models_of_one_node_take_time_that_grows_with_their_number() -> None:
    cube = gx.samples.cube()
    for _ in within_cpu_s(1):
        node = gx.Scene().add(name="crowd")
        for _ in range(50_000):
            node.show(cube)
        assert len(node.models) == 50_000


def test_buffers_that_name_one_file_share_it(tmp_path: Path) -> None:
    (tmp_path / "big.bin").write_bytes(bytes(300_000))
    content = json.loads(gltf())
    content["buffers"] += [{"uri": "big.bin", "byteLength": 4}] * 2000
    (tmp_path / "many.gltf").write_text(json.dumps(content))
    tracemalloc.start()
    try:
        assert gx.load_mesh(tmp_path / "many.gltf").n_faces == 1
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_what_a_file_holds_itself_is_not_refused() -> None:
    sphere = gx.samples.icosphere(5)
    for kind in ("obj", "ply", "stl", "off", "glb", "gltf"):
        file = io.BytesIO()
        gx.save_mesh(sphere, file, file_type=kind)
        assert gx.load_mesh(io.BytesIO(file.getvalue()), file_type=kind).n_faces == sphere.n_faces
    forest = "".join(f"Transform{{translation {i} 0 0 children USE A}}\n" for i in range(5000))
    assert gx.load_mesh(io.BytesIO(vrml(f"DEF A {FACE_97}\n{forest}")), file_type="wrl").n_faces == 5001


def voxels(n: int) -> bytes:
    """Return a 3MF of n^3 cubes, the most regular mesh, compressed best."""
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    sides = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)]
    sides += [(0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    cells = [(2 * x, 2 * y, 2 * z) for x in range(n) for y in range(n) for z in range(n)]
    vertices = "".join(f'<vertex x="{x + i}" y="{y + j}" z="{z + k}"/>' for x, y, z in cells for i, j, k in corners)
    triangles = "".join(
        f'<triangle v1="{8 * cell + i}" v2="{8 * cell + j}" v3="{8 * cell + k}"/>'
        for cell in range(len(cells))
        for i, j, k in sides
    )
    mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
    return threemf(f'<object id="1">{mesh}</object>', '<item objectid="1"/>', level=9)


def test_the_most_regular_mesh_that_is_compressed_best_is_not_refused() -> None:
    data = voxels(18)
    assert len(data) < 4 * 20 * 18**3
    assert gx.load_mesh(io.BytesIO(data), file_type="3mf").n_faces == 12 * 18**3


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux limits a process's memory")
def test_xml_is_read_without_a_tree() -> None:
    """A tree of it takes 110 MB."""
    limits = gx.FileLimits(memory_bytes=80_000_000)
    mesh = gx.load_mesh(io.BytesIO(voxels(18)), file_type="3mf", isolated=True, limits=limits)
    assert mesh.n_faces == 12 * 18**3


CUBE = b"".join(b"v %d %d %d\n" % (x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)) + b"f 1 2 4 3\nf 5 6 8\n"


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"points": 7}, r"it has 8 points, more than FileLimits\(points=7\) allows"),
        ({"faces": 1}, r"it has 2 faces, more than FileLimits\(faces=1\) allows"),
        ({"face_corners": 3}, r"a face of it has 4 corners, more than FileLimits\(face_corners=3\) allows"),
    ],
)
def test_a_limit_that_is_exceeded_is_named(limits: dict[str, int], message: str) -> None:
    with pytest.raises(MeshError, match=rf"^<file>: {message}$"):
        gx.load_mesh(io.BytesIO(CUBE), file_type="obj", limits=gx.FileLimits(**limits))
    (name, value), *_ = limits.items()
    loose = gx.FileLimits(**{name: value + 1})
    assert gx.load_mesh(io.BytesIO(CUBE), file_type="obj", limits=loose).n_faces == 2


def test_attributes_that_others_lack_are_counted_before_they_are_filled_up() -> None:
    def make(n: int) -> bytes:
        primitives = [{"attributes": {"POSITION": 0, f"_A{i}": 0}} for i in range(n)]
        return gltf(meshes=[{"primitives": primitives}])

    few = gx.load_mesh(io.BytesIO(make(3)), file_type="gltf")
    assert [np.isnan(few.attributes.point[f"A{i}"]).all(axis=1).sum() for i in range(3)] == [6, 6, 6]
    for _ in within_cpu_s(1):
        with pytest.raises(MeshError, match="attributes that not all of its parts have: expands to more than"):
            gx.load_mesh(io.BytesIO(make(2000)), file_type="gltf")  # 144 MB


def test_messages_are_in_the_unit_of_the_limit_that_they_name() -> None:
    many = gltf(n_points=3000, nodes=[{"mesh": 0}] * 5000, scenes=[{"nodes": list(range(5000))}])
    for limit in (1, 2000):
        words = rf"(mesh 0|its nodes): expands to more than {limit:,} points of 16 numbers, the limit "
        words += rf"FileLimits\(points={limit}\)$"
        with pytest.raises(MeshError, match=words):
            gx.load_mesh(io.BytesIO(many), file_type="gltf", limits=gx.FileLimits(points=limit))
    most = (FREE_NUMBERS + NUMBERS_PER_BYTE * len(many)) // 16
    words = rf"its nodes: expands to more than {most:,} points of 16 numbers, the limit FileLimits\(points=\.\.\.\)$"
    with pytest.raises(MeshError, match=words):
        gx.load_mesh(io.BytesIO(many), file_type="gltf")


def test_words_and_nodes_of_a_dense_text_are_in_the_unit_of_the_limit() -> None:
    dense, text = DENSE["words"], b"#VRML V2.0 utf8\n" + b"A{}" * 200_000
    for data, what, count in ((dense, "words", 300_000), (text, "nodes", 200_000)):
        for limit in (1, None):  # which is less than what any file may have
            with pytest.raises(
                MeshError, match=rf"of 3?[\d,]+ {what}, more than [\d,]+, .*FileLimits\(nodes=\.\.\.\)$"
            ):
                gx.load_mesh(io.BytesIO(data), file_type="wrl", limits=gx.FileLimits(nodes=limit))
        limit = count // 16 - 4
        words = rf"{what}, more than 16 for each of the nodes that FileLimits\(nodes={limit}\) allows$"
        with pytest.raises(MeshError, match=words):
            gx.load_mesh(io.BytesIO(data), file_type="wrl", limits=gx.FileLimits(nodes=limit))


def test_a_limit_of_the_caller_takes_the_place_of_the_default() -> None:
    data = gltf(n_points=3000, nodes=[{"mesh": 0}] * 600, scenes=[{"nodes": list(range(600))}])
    with pytest.raises(MeshError, match="expands to more than"):
        gx.load_mesh(io.BytesIO(data), file_type="gltf")
    mesh = gx.load_mesh(io.BytesIO(data), file_type="gltf", limits=gx.FileLimits(points=1_800_000))
    assert mesh.n_faces == 600_000
    for limits, words in ((gx.FileLimits(nodes=3), "more than 3 nodes"), (gx.FileLimits(depth=1), "more than 1 deep")):
        nested = vrml(f"Group{{children Group{{children Group{{children {FACE_97}}}}}}}")
        with pytest.raises(MeshError, match=words):
            gx.load_mesh(io.BytesIO(nested), file_type="wrl", limits=limits)
    chain = gltf(n_points=30, nodes=[{"mesh": 0, "children": [1]}, {"mesh": 0}], scenes=[{"nodes": [0]}])
    for limits, words in ((gx.FileLimits(nodes=1), "more than 1 nodes"), (gx.FileLimits(depth=1), "more than 1 deep")):
        with pytest.raises(MeshError, match=words):
            gx.load_scene(io.BytesIO(chain), file_type="gltf", limits=limits)
    assert len(gx.load_scene(io.BytesIO(chain), file_type="gltf", limits=gx.FileLimits(nodes=2, depth=2))) == 2


def write_with_files_beside(folder: Path, kind: str) -> tuple[Path, int]:
    """Write a model that names two files beside it, one of them twice; return its path and what both hold, in bytes."""
    if kind == "obj":
        contents = {"a.mtl": b"newmtl red\nKd 1 0 0\n", "b.mtl": b"newmtl blue\n"}
        data = b"mtllib a.mtl\nmtllib b.mtl ./a.mtl\n" + CUBE
    elif kind == "gltf":
        contents = {"a.bin": bytes(36), "b.bin": bytes(72)}
        document = json.loads(gltf())
        document["buffers"] = [{"uri": name, "byteLength": 36} for name in ("a.bin", "b.bin", "a.bin")]
        data = json.dumps(document).encode()
    elif kind == "wrl":
        contents = {
            f"{name}.wrl": f"#VRML V2.0 utf8\nShape {{ geometry {name} {{ }} }}".encode() for name in ("Box", "Cone")
        }
        data = b'#VRML V2.0 utf8\nInline { url "Box.wrl" } Inline { url "Cone.wrl" } Inline { url "./Box.wrl" }'
    else:
        contents = {"a.obj": CUBE, "b.obj": CUBE + b"# another\n"}
        shown = "".join(f'<visual><geometry><mesh filename="{name}.obj"/></geometry></visual>' for name in "aba")
        data = f'<robot name="r"><link name="l">{shown}</link></robot>'.encode()
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    path = folder / f"model.{kind}"
    path.write_bytes(data)
    return path, sum(map(len, contents.values()))


@pytest.mark.parametrize("kind", ["gltf", "obj", "urdf", "wrl"])
def test_files_beside_a_file_are_counted_once_each_before_they_are_read(kind: str, tmp_path: Path) -> None:
    path, n_bytes = write_with_files_beside(tmp_path, kind)
    whole = gx.load_mesh(path)
    assert gx.load_mesh(path, limits=gx.FileLimits(unpacked_bytes=n_bytes)) == whole
    limit = rf"FileLimits\(unpacked_bytes={n_bytes - 1}\)"
    words = rf"model\.{kind}: .*'(b|Cone)\.\w+': .*more than the {n_bytes - 1} bytes .*{limit}"
    with pytest.raises(MeshError, match=words):
        gx.load_mesh(path, limits=gx.FileLimits(unpacked_bytes=n_bytes - 1))


def test_a_file_beside_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "m.obj"
    path.write_bytes(b"mtllib big.mtl\n" + CUBE)
    with (tmp_path / "big.mtl").open("wb") as file:
        file.truncate(1 << 40)  # of no blocks
    with pytest.raises(MeshError, match=r"FileLimits\(unpacked_bytes=1000000\)"):
        gx.load_mesh(path, limits=gx.FileLimits(unpacked_bytes=1_000_000))


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ({"points": 0}, ArgumentError),
        ({"faces": -1}, ArgumentError),
        ({"points": 1.5}, ArgumentTypeError),
        ({"nodes": "many"}, ArgumentTypeError),
        ({"cpu_s": float("nan")}, ArgumentError),
        ({"depth": True}, ArgumentError),
    ],
)
def test_what_is_no_limit_is_refused(given: dict[str, Any], error: type[Exception]) -> None:
    ((name, value),) = given.items()
    kind = "number" if name == "cpu_s" else "whole number"
    with pytest.raises(error, match=re.escape(f"{name} must be a positive {kind}, got {value!r}")):
        gx.FileLimits(**given)
    with pytest.raises(ArgumentTypeError, match="limits must be FileLimits"):
        gx.load_mesh(io.BytesIO(CUBE), file_type="obj", limits=given)  # type: ignore[arg-type]


def test_the_command_takes_limits(working_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (working_folder / "cube.obj").write_bytes(CUBE)
    for command in (
        "info {}",
        "transform {} x.ply",
        "render {} -o x.png",
        "animate {} -o x.gif",
        "simulate {} -o x.gif",
    ):
        message = error_of([*command.format("cube.obj").split(), "--file-limits", "points=7,faces=3"], capsys)
        assert message == "gpu-xform: error: cube.obj: it has 8 points, more than FileLimits(points=7) allows\n"
    assert np.all(not (working_folder / "x.ply").exists())


def test_a_layer_of_the_command_has_limits_of_its_own(working_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (working_folder / "cube.obj").write_bytes(CUBE)
    (working_folder / "small.obj").write_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    refused = "cube.obj: it has 8 points, more than FileLimits(points=7) allows"
    command = ["render", "-o", "x.png", "--resolution", "9,9"]
    assert refused in error_of([*command, "small.obj", "--layer", "cube.obj --file-limits points=7"], capsys)
    assert main([*command, "cube.obj", "--layer", "small.obj --file-limits points=7"]) == 0
    assert main([*command, "small.obj", "--layer", "cube.obj --file-limits points=8", "--file-limits", "points=3"]) == 0
    assert refused in error_of([*command, "small.obj", "--layer", "cube.obj", "--file-limits", "points=7"], capsys)


NAMES = "points=N, faces=N, face_corners=N, nodes=N, depth=N, unpacked_bytes=N, cpu_s=N, memory_bytes=N"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("bogus=1", f"expected {NAMES}, separated by commas, got 'bogus'"),
        ("points=7,bogus=1,faces=3", f"expected {NAMES}, separated by commas, got 'bogus'"),
        ("point=7", f"expected {NAMES}, separated by commas, got 'point'; did you mean 'points'?"),
        ("points=7,", f"expected {NAMES}, separated by commas, got 'points=7,'"),
        ("7", f"expected {NAMES}, separated by commas, got '7'"),
        ("points=7,faces", "expected a whole number for faces, got ''"),
        ("points=7,faces=many", "expected a whole number for faces, got 'many'"),
        ("faces=3,points=1.5", "expected a whole number for points, got '1.5'"),
        ("points=inf", "expected a whole number for points, got 'inf'"),
        ("cpu_s=x", "expected a number for cpu_s, got 'x'"),
        ("faces=3,points=7,faces=3", "expected faces once, got 'faces=3,points=7,faces=3'"),
        ("points=-7", "points must be a positive whole number, got -7"),
    ],
)
def test_the_command_names_what_is_wrong_with_a_limit(
    text: str, words: str, working_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (working_folder / "cube.obj").write_bytes(CUBE)
    message = error_of(["info", "cube.obj", "--file-limits", text], capsys)
    assert message.rstrip("\n").endswith(f"--file-limits: {words}")


def test_whole_numbers_may_be_written_with_an_exponent(working_folder: Path) -> None:
    (working_folder / "cube.obj").write_bytes(CUBE)
    assert main(["info", "cube.obj", "--file-limits", "points=1e6,faces=2.0"]) == 0


DENSE = {
    "nodes": b"#VRML V2.0 utf8\n" + b"A{}" * 200_000,
    "words": b"#VRML V2.0 utf8\nA{a[" + b'"" ' * 300_000 + b"]}",
    "prototypes": b"#VRML V2.0 utf8\n" + b"PROTO A[]{Group{}}" * 40_000,
    "quotes": b"#VRML V2.0 utf8\n" + b'\\"' * 300_000,
}


@pytest.mark.parametrize("name", DENSE)
def test_dense_text_is_refused_before_it_is_parsed(name: str) -> None:
    for _ in within_cpu_s(2):
        with pytest.raises(MeshError):
            gx.load_mesh(io.BytesIO(DENSE[name]), file_type="wrl")


_TRIANGLE_1 = b"Coordinate3{point[0 0 0,1 0 0,0 1 0]}"
_TRIANGLE_97 = b"coord Coordinate{point[0 0 0 1 0 0 0 1 0]}coordIndex[0 1 2]"
# A list that thousands of shapes share, and thousands of names; before, each took 2 s to a minute.
SHARED = {
    "normals": b"#VRML V1.0 ascii\nNormal{vector[%b]}%b%b"
    % (b"0 0 1," * 40_000, _TRIANGLE_1, b"IndexedFaceSet{coordIndex[0,1,2]}" * 2_000),
    "material": b"#VRML V1.0 ascii\nMaterial{transparency[%b]}MaterialBinding{value PER_PART}%b"
    % (b"1 " * 100_000, b"Separator{Cube{}}" * 3_000),
    "index": b"#VRML V2.0 utf8\nShape{geometry DEF F IndexedFaceSet{%b color Color{color[1 0 0]}colorIndex[%b]}}%b"
    % (_TRIANGLE_97, b"0 " * 100_000, b"Shape{geometry USE F}" * 2_000),
    "points": b"#VRML V1.0 ascii\nMaterial{emissiveColor 1 0 0}Coordinate3{point[%b]}%b"
    % (b"1 0 0 " * 40_000, b"PointSet{numPoints 3}" * 2_000),
    "textures": b"#VRML V1.0 ascii\n" + b"".join(b'Texture2{filename "%d.png"}Cube{}' % i for i in range(5_000)),
}


@pytest.mark.parametrize("name", SHARED)
def test_what_many_shapes_share_is_read_once(name: str) -> None:
    for _ in within_cpu_s(1):
        with contextlib.suppress(MeshError):
            gx.load_mesh(io.BytesIO(SHARED[name]), file_type="wrl")


def test_text_that_holds_data_is_not_dense() -> None:
    """The smallest shapes that show anything, 5,000 of them, and an image of single digits."""
    shapes = b"#VRML V1.0 ascii\n" + b"Separator{Translation{translation 1 0 0}Cube{}}" * 5_000
    assert gx.load_mesh(io.BytesIO(shapes), file_type="wrl").n_faces == 30_000
    image = b"Texture2{image 600 500 1 " + b"0 " * 300_000 + b"}"
    assert gx.load_mesh(io.BytesIO(b"#VRML V1.0 ascii\n" + image + b"Cube{}"), file_type="wrl").n_faces == 6
    limits = gx.FileLimits(nodes=20_000)
    nodes = b"#VRML V1.0 ascii\n" + b"Cube{}" * 15_000
    assert gx.load_mesh(io.BytesIO(nodes), file_type="wrl", limits=limits).n_faces == 90_000


def test_curves_of_one_kind_are_cut_once() -> None:
    points = b"".join(b"v %d 0 %d\n" % (i, i % 3) for i in range(40))
    data = points + b"cstype bezier\ndeg 3\n" + b"curv 0 1 1 2 3 5\nparm u 0 1\nend\n" * 9_000
    for _ in within_cpu_s(2):
        assert gx.load_mesh(io.BytesIO(data), file_type="obj").n_faces >= 9_000
