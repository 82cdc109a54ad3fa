"""Whatever happens to a valid file, reading it gives a mesh or a MeshError, soon."""

import gzip
import io
import time
import warnings
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import load_mesh, save_mesh
from gpu_xform.geometry.mesh import Mesh
from tests.support.gltf_files import BINARY, as_text, data_uri, document

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
    assert load_mesh(io.BytesIO(data), file_type=kind).n_faces >= 4


@pytest.mark.slow
@settings(max_examples=1500, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(damaged())
def test_damage_gives_a_mesh_or_a_mesh_error(case: tuple[str, bytes]) -> None:
    kind, data = case
    start = time.perf_counter()
    try:
        with warnings.catch_warnings(action="ignore", category=MeshWarning):
            mesh = load_mesh(io.BytesIO(data), file_type=kind)
    except MeshError:
        pass
    else:
        assert mesh.n_points > 0
        assert np.isfinite(mesh.positions).all()
        assert mesh.indices.max(initial=0) < mesh.n_points
    assert time.perf_counter() - start < 5.0


@pytest.mark.parametrize(("kind", "data"), SEEDS)
def test_no_truncated_file_is_accepted(kind: str, data: bytes) -> None:
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
