"""Whatever happens to a valid file, reading it gives a mesh or a MeshError, soon."""

import gzip
import io
import warnings
import zipfile
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gpu_xform import rotate_x, samples
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import load_mesh, save_mesh
from gpu_xform.geometry.mesh import Mesh
from tests.support.cost import within_cpu_s
from tests.support.gltf_files import BINARY, as_text, data_uri, document
from tests.support.threemf_files import container

HOUSE = samples.house()
WITH_SEGMENTS = Mesh(HOUSE.positions, [*HOUSE.faces, (0, 7), (3, 8)])
VRML_1 = b"""#VRML V1.0 ascii
Separator { DEF C Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] } Material { diffuseColor [ 1 0 0 ] }
  Transform { translation 1 2 3 rotation 0 0 1 1.5 scaleFactor 2 2 2 }
  DEF F IndexedFaceSet { coordIndex [ 0, 1, 2, 3, -1 ] }
  Separator { MatrixTransform { matrix 1 0 0 0 0 1 0 0 0 0 1 0 5 5 5 1 } USE F } Switch { whichChild 0 USE F }
  Cone { parts (SIDES | BOTTOM) } IndexedLineSet { coordIndex [ 0, 1, 2 ] } }
"""
VRML_97 = b"""#VRML V2.0 utf8
PROTO P [ field SFFloat x 1 ] { Group { } }
DEF T Transform { translation 0 0 1 center 1 1 1 scale 2 2 2 children [
  DEF S Shape { geometry IndexedFaceSet {
    coord DEF C Coordinate { point [ 0 0 0 1 0 0 1 1 0 0 1 0 ] } coordIndex [ 0 1 2 3 -1 ] } }
  Switch { whichChoice 0 choice USE S } LOD { level [ USE S ] } ] }
Shape { geometry IndexedLineSet { coord USE C coordIndex [ 0 1 2 -1 ] } } # "end"
ROUTE T.a TO S.b
"""

VRML_LOOKS = b"""#VRML V2.0 utf8
PROTO Q [ field SFColor c 0 0 0 exposedField MFInt32 i [ 0 ] ] { PROTO R [ field MFInt32 j [ 0 ] ] {
  Shape { appearance Appearance { material DEF M Material { diffuseColor 1 0 0 transparency 0.5 }
    texture ImageTexture { url "a.png" } } geometry IndexedFaceSet { ccw FALSE
    coord Coordinate { point [ 0 0 0 1 0 0 1 1 0 0 1 0 ] } coordIndex [ 0 1 2 -1 0 2 3 -1 ]
    color Color { color [ 1 0 0, 0 1 0, 0 0 1 ] } colorIndex IS j
    normal Normal { vector [ 0 0 1, 0 0 -1 ] } normalPerVertex FALSE
    texCoord TextureCoordinate { point [ 0 0, 1 1 ] } texCoordIndex [ 0 1 0 -1 1 0 1 -1 ] } } }
  R { j IS i } }
Transform { scale -1 2 3 children [ Q { i [ 0 1 2 -1 2 1 0 -1 ] } Q { i [ 0 0 0 -1 1 1 1 -1 ] }
  Shape { geometry ElevationGrid { xDimension 2 zDimension 2 height [ 0 1 2 3 ] colorPerVertex FALSE
    color Color { color [ 1 1 0 ] } } }
  Shape { geometry PointSet { coord Coordinate { point [ 5 5 5 ] } color Color { color [ 1 0 1 ] } } } ] }
Inline { url "b.wrl" }
"""
VRML_BINDINGS = b"""#VRML V1.0 ascii
Separator { Material { diffuseColor [ 1 0 0, 0 1 0 ] } MaterialBinding { value PER_FACE_INDEXED }
  Normal { vector [ 0 0 1, 0 1 0 ] } NormalBinding { value PER_VERTEX_INDEXED } Texture2 { filename "a.gif" }
  TextureCoordinate2 { point [ 0 0, 1 1 ] } Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] }
  IndexedFaceSet { coordIndex [ 0, 1, 2, -1, 0, 2, 3, -1 ] materialIndex [ 1, 0 ]
    normalIndex [ 0, 0, 1, -1, 1, 1, 0, -1 ] textureCoordIndex [ 0, 1, 0, -1, 1, 0, 1, -1 ] }
  MaterialBinding { value PER_PART } Cube { } Cylinder { } Cone { } Sphere { } }
"""
PLY_STRIPS = b"""ply
format ascii 1.0
comment TextureFile a.png
obj_info x
element vertex 6
property float x
property float y
property float z
property uchar red
property list uchar float weights
element tristrips 1
property list int int vertex_indices
element camera 1
property double f
end_header
0 0 0 255 1 0.5
1 0 0 0 0
0 1 0 1 2 1 2
1 1 0 2 0
0 2 0 3 0
1 2 0 4 0
8 0 1 2 3 4 5 -1 0
1.5
"""
OBJ_FORMS = b"""# forms
mtllib a.mtl
v 0 0 0 1 0 0
v 1 0 0
v 1 1 0 0.5
v 0 1 0
vt 0 0
vn 0 0 1
vp 0 0
o a
g b c
s 1
usemtl d
f 1/1/1 2//1 3
f -4 -3 -2 -1
l 1 2 3 4
p 1 -1
cstype rat bspline
deg 3 3
surf 0 1 0 1 1 2 \
3 4
parm u 0 1
end
"""
THREEMF = """<model unit="inch" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
  xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02"><metadata name="Title">x</metadata><resources>
  <basematerials id="9"><base name="a" displaycolor="#FF0000"/></basematerials>
  <m:colorgroup id="5"><m:color color="#FF0000"/><m:color color="#00FF0080"/></m:colorgroup>
  <m:multiproperties id="6" pids="5 9"><m:multi pindices="1 0"/></m:multiproperties>
  <object id="1" pid="6" pindex="0"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>
  <vertex x="0" y="2" z="0"/><vertex x="0" y="0" z="3"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/>
  <triangle v1="0" v2="1" v3="3" pid="5" p1="0" p2="1" p3="0"/></triangles></mesh></object>
  <object id="2"><components><component objectid="1"/><component objectid="1" transform="0 1 0 -1 0 0 0 0 1 0 0 5"/>
  </components></object></resources><build><item objectid="2" transform="1 0 0 0 -1 0 0 0 1 10 0 0"/></build></model>"""


def saved(mesh: Mesh, kind: str) -> bytes:
    file = io.BytesIO()
    save_mesh(mesh, file, file_type=kind)
    return file.getvalue()


def four_nodes() -> dict[str, Any]:
    content = document()
    content["nodes"] = [
        {"name": "a", "mesh": 0, "children": [1, 2], "translation": [1, 2, 3]},
        {"name": "b", "mesh": 0, "rotation": [0, 0.6, 0, 0.8]},
        {"mesh": 0, "scale": [1, 2, 3], "children": [3]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 5, 5, 1]},
    ]
    return content


def skinned() -> bytes:
    """Return a file with a skin, a morph target, an animation, a sparse accessor, colours and a material."""
    content, data = document(), bytearray(BINARY)

    def add(values: npt.ArrayLike, dtype: str, kind: str, **more: Any) -> int:
        rows = np.asarray(values, dtype)
        content["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": rows.nbytes})
        data.extend(rows.tobytes() + bytes(-rows.nbytes % 4))
        codes = {"u1": 5121, "u2": 5123, "f4": 5126}
        view = {"bufferView": len(content["bufferViews"]) - 1, "componentType": codes[dtype[-2:]]}
        content["accessors"].append({**view, "count": len(rows), "type": kind, **more})
        return len(content["accessors"]) - 1

    primitive = content["meshes"][0]["primitives"][0]
    n = content["accessors"][primitive["attributes"]["POSITION"]]["count"]
    primitive["attributes"] |= {
        "JOINTS_0": add(np.tile([0, 1, 0, 0], (n, 1)), "u1", "VEC4"),
        "WEIGHTS_0": add(np.tile([0.5, 0.5, 0, 0], (n, 1)), "<f4", "VEC4"),
        "COLOR_0": add(np.full((n, 4), 200), "u1", "VEC4", normalized=True),
        "NORMAL": add(np.tile([0, 0, 1], (n, 1)), "<f4", "VEC3"),
    }
    indices, values = add([0, 1], "<u2", "SCALAR"), add(np.ones((2, 3)), "<f4", "VEC3")
    views = content["accessors"][indices]["bufferView"], content["accessors"][values]["bufferView"]
    sparse = {
        "count": 2,
        "indices": {"bufferView": views[0], "componentType": 5123},
        "values": {"bufferView": views[1]},
    }
    content["accessors"].append({"componentType": 5126, "count": n, "type": "VEC3", "sparse": sparse})
    primitive["targets"] = [{"POSITION": len(content["accessors"]) - 1}]
    primitive["material"] = 0
    content["materials"] = [{"name": "a", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]
    content["meshes"][0]["weights"] = [0.5]
    content["nodes"] = [{"mesh": 0, "skin": 0}, {"translation": [1, 0, 0], "children": [2]}, {"scale": [2, 2, 2]}]
    content["nodes"] += [{"mesh": 0}, {"mesh": 0, "weights": [0.25]}, {"mesh": 0, "skin": 0}]
    inverse = add(np.tile(np.eye(4).ravel(), (2, 1)), "<f4", "MAT4")
    content["skins"] = [{"joints": [1, 2], "inverseBindMatrices": inverse}]
    sampler = {"input": add([0, 1], "<f4", "SCALAR"), "output": add(np.eye(2, 3), "<f4", "VEC3")}
    target = {"node": 1, "path": "translation"}
    content["animations"] = [{"name": "go", "samplers": [sampler], "channels": [{"sampler": 0, "target": target}]}]
    content["scenes"] = [{"nodes": [0, 1, 3, 4, 5]}]
    return as_text(data_uri(bytes(data)), content=content)


TRIANGLES = HOUSE.to_trimesh()
ASCII_PLY = TRIANGLES.export(file_type="ply", encoding="ascii")
BINARY_OFF = b"OFF BINARY\n" + np.array([4, 4, 0], ">i4").tobytes() + np.eye(4, 3, dtype=">f4").tobytes()
BINARY_OFF += np.array([[3, *face, 0] for face in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))], ">i4").tobytes()
SEEDS: list[tuple[str, bytes]] = [
    ("obj", saved(WITH_SEGMENTS, "obj")),
    ("obj", saved(HOUSE, "obj").replace(b"f 1 2", b"f 1/1/1 2//2")),
    ("off", saved(WITH_SEGMENTS, "off")),
    ("off", BINARY_OFF),
    ("ply", saved(WITH_SEGMENTS, "ply")),
    ("ply", ASCII_PLY),
    ("stl", saved(HOUSE, "stl")),
    ("stl", trimesh.exchange.stl.export_stl_ascii(TRIANGLES).encode()),
    ("glb", saved(HOUSE, "glb")),
    ("gltf", as_text(data_uri(BINARY), content=four_nodes())),
    ("wrl", VRML_1),
    ("wrl", VRML_97),
    ("wrl", gzip.compress(VRML_1)),
    ("wrl", VRML_LOOKS),
    ("wrl", VRML_BINDINGS),
    ("ply", PLY_STRIPS),
    ("obj", OBJ_FORMS),
    ("3mf", container(THREEMF, compression=zipfile.ZIP_STORED)),
    ("3mf", container(THREEMF)),
    ("gltf", skinned()),
]
SNIPPETS = [b"", b"\0", b"-1", b"0", b"4000000000", b"99999999999999999999", b"nan", b"1e999", b"\xff\xff\xff\xff"]
SNIPPETS += [b"\n", b"{", b"}", b"[", b"]", b'"', b"#", b" USE S ", b" -", b"/", b"\\\n", b"\r", b"\x80"]


@st.composite
def damaged(draw: st.DrawFn) -> tuple[str, bytes]:
    kind, data = draw(st.sampled_from(SEEDS))
    content = bytearray(data)
    for _ in range(draw(st.integers(1, 3))):
        place = draw(st.integers(0, len(content)))
        match draw(st.sampled_from(["cut", "flip", "put", "drop", "again"])):
            case "cut":
                del content[place:]
            case "flip" if place < len(content):
                content[place] ^= 1 << draw(st.integers(0, 7))
            case "put":
                content[place : place + draw(st.integers(0, 4))] = draw(st.sampled_from(SNIPPETS))
            case "drop":
                del content[place : place + draw(st.integers(1, 20))]
            case _:
                content[place:place] = content[place : place + draw(st.integers(1, 60))]
    return kind, bytes(content)


@pytest.mark.parametrize(("kind", "data"), SEEDS)
def test_seeds_are_valid(kind: str, data: bytes) -> None:
    with warnings.catch_warnings(action="ignore", category=MeshWarning):
        assert load_mesh(io.BytesIO(data), file_type=kind).n_faces >= 4


@pytest.mark.slow
@settings(max_examples=1500, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(damaged())
def test_damage_gives_a_mesh_or_a_mesh_error(case: tuple[str, bytes]) -> None:
    kind, data = case
    for _ in within_cpu_s(5.0):
        try:
            with warnings.catch_warnings(action="ignore", category=MeshWarning):
                mesh = load_mesh(io.BytesIO(data), file_type=kind)
        except MeshError:
            pass
        else:
            assert mesh.n_points > 0
            assert np.isfinite(mesh.positions).all()
            assert mesh.indices.max(initial=0) < mesh.n_points


@pytest.mark.parametrize(("kind", "data"), SEEDS)
def test_no_truncated_file_is_accepted(kind: str, data: bytes) -> None:
    with warnings.catch_warnings(action="ignore", category=MeshWarning):
        whole = load_mesh(io.BytesIO(data), file_type=kind)
    for end in range(0, len(data), max(1, len(data) // 60)):
        try:
            part = load_mesh(io.BytesIO(data[:end]), file_type=kind)
        except (MeshError, MeshWarning):
            continue
        # Only what has neither a count nor a last brace can be cut without a trace, between two statements.
        assert kind in ("obj", "wrl") or part == whole


def test_numbers_at_which_numpy_stops_are_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    # Older ones gave what came before, and a warning that a filter may hide.
    def stops_at_x(text: bytes, *args: Any, **options: Any) -> Any:
        return fromstring(text.split(b"x")[0], *args, **options)

    fromstring = np.fromstring
    monkeypatch.setattr(np, "fromstring", stops_at_x)
    with pytest.raises(MeshError, match="expected a number, got '9x'"):
        load_mesh(io.BytesIO(b"v 1 2 3\nv 1 2 3 9x\n"), file_type="obj")


def singles(kind: str, positions: npt.NDArray[Any], normals: npt.NDArray[Any]) -> bytes:
    """Return a file of three points in single precision."""
    if kind == "npy":
        np.save(file := io.BytesIO(), positions.astype("<f4"))
        return file.getvalue()
    if kind == "ply":
        names = ("x", "y", "z", "nx", "ny", "nz")
        header = ["ply", "format binary_little_endian 1.0", "element vertex 3", *(f"property float {n}" for n in names)]
        return "\n".join([*header, "end_header\n"]).encode() + np.hstack([positions, normals]).astype("<f4").tobytes()
    attributes = {} if kind == "stl" else {"point": {"normal": normals}}
    metadata = {"off": {"encoding": "binary", "order": ">"}} if kind == "off" else None
    return saved(Mesh(positions, [(0, 1, 2)], attributes=attributes, metadata=metadata), kind)


@pytest.mark.parametrize(
    ("kind", "place"),
    [*((kind, "positions") for kind in ("glb", "npy", "off", "ply", "stl")), ("glb", ""), ("off", ""), ("ply", "")],
)
def test_signalling_nans_are_nans(kind: str, place: str) -> None:
    """NumPy warns of them when their type changes; any bytes may be one."""
    positions, normals, mark = np.eye(3), np.eye(3, dtype=np.float32), np.float32(0.6712)
    (positions if place == "positions" else normals)[1, 1] = mark
    order = ">" if kind == "off" else "<"
    old, new = (np.array(value, order + dtype).tobytes() for value, dtype in ((mark, "f4"), (0x7F800001, "u4")))
    data = singles(kind, positions, normals).replace(old, new)
    if place == "positions":
        with pytest.raises(MeshError, match=r"must be finite|not finite"):
            load_mesh(io.BytesIO(data), file_type=kind)
        return
    mesh = load_mesh(io.BytesIO(data), file_type=kind).transformed(rotate_x(0.5))
    assert np.isnan(mesh.attributes.point["normal"]).any(axis=1).tolist() == [False, True, False]
    signalling = np.full((3, 3), 0x7F800001, np.uint32).view(np.float32)
    mesh = mesh.with_attributes({"point": dict.fromkeys(("normal", "tangent", "color"), signalling)})
    for other in ("glb", "obj", "off", "ply"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshWarning)
            again = io.BytesIO(saved(mesh.transformed(rotate_x(0.5)), other))
            assert load_mesh(again, file_type=other).n_points == 3
