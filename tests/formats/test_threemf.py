import io
import re
import sys
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from gpu_xform import Scene, load_mesh, load_scene
from gpu_xform.cli import main
from gpu_xform.errors import MeshError, MissingExtraError
from tests.support.threemf_files import container

# A tetrahedron, a pair of them of which the second is turned and moved, and the pair ten to the right.
MODEL = """<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
  <resources>
    <object id="1" type="model">
      <mesh>
        <vertices>
          <vertex x="0" y="0" z="0"/>
          <vertex x="1" y="0" z="0"/>
          <vertex x="0" y="2" z="0"/>
          <vertex x="0" y="0" z="3.5"/>
        </vertices>
        <triangles>
          <triangle v1="0" v2="2" v3="1"/>
          <triangle v1="0" v2="1" v3="3"/>
          <triangle v1="1" v2="2" v3="3"/>
          <triangle v1="2" v2="0" v3="3"/>
        </triangles>
      </mesh>
    </object>
    <object id="2" type="model">
      <components>
        <component objectid="1"/>
        <component objectid="1" transform="0 1 0 -1 0 0 0 0 1 0 0 5"/>
      </components>
    </object>
  </resources>
  <build>
    <item objectid="2" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>
  </build>
</model>
"""
TETRAHEDRON = np.array([(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3.5)])
TURNED = np.array([(0, 0, 5), (0, 1, 5), (-2, 0, 5), (0, 0, 8.5)])


@pytest.fixture
def pair(tmp_path: Path) -> Path:
    path = tmp_path / "pair.3mf"
    path.write_bytes(container(MODEL))
    return path


def test_every_item_stands_where_its_transforms_put_it(pair: Path) -> None:
    mesh = load_mesh(pair)
    assert mesh.n_faces == 8
    corners = mesh.positions[mesh.indices].reshape(8, 3, 3)
    triangles = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    expected = np.concatenate([points[triangles] + (10, 0, 0) for points in (TETRAHEDRON, TURNED)])
    assert sorted(corners.tolist()) == sorted(expected.tolist())


def test_without_its_libraries_the_error_says_what_to_install(
    pair: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "lxml", None)
    with pytest.raises(MissingExtraError, match=r"^3MF needs lxml: pip install 'gpu_xform\[3mf\]'$"):
        load_mesh(pair)
    assert main(["transform", str(pair), str(pair.with_name("pair.obj"))]) == 2
    assert "pip install 'gpu_xform[3mf]'" in capsys.readouterr().err


def package(model: str, **parts: str) -> io.BytesIO:
    """Return a container with a model part, and others by their names."""
    return io.BytesIO(container(model, parts))


def load(model: str, **parts: str) -> Scene:
    return load_scene(package(model, **parts), file_type="3mf")


MESH = MODEL[MODEL.index("<mesh>") : MODEL.index("</mesh>") + 7]


@pytest.mark.parametrize(
    ("unit", "millimetres"),
    [("micron", 0.001), ("millimeter", 1), ("centimeter", 10), ("inch", 25.4), ("foot", 304.8), ("meter", 1000)],
)
def test_units_become_millimetres(unit: str, millimetres: float, pair: Path) -> None:
    model = MODEL.replace('unit="millimeter"', f'unit="{unit}"')
    mesh = load_mesh(package(model), file_type="3mf")
    assert np.allclose(mesh.positions, load_mesh(pair).positions * millimetres)
    assert mesh.metadata["3mf"]["unit"] == unit
    assert load(model).metadata["3mf"]["unit"] == unit
    assert load_mesh(package(model.replace(f'unit="{unit}" ', "")), file_type="3mf") == load_mesh(pair)


def test_unknown_units_are_refused() -> None:
    with pytest.raises(MeshError, match=r"the unit must be one of micron, .*, meter, got 'cubit'"):
        load(MODEL.replace("millimeter", "cubit"))


def test_items_and_components_are_nodes(pair: Path) -> None:
    named = MODEL.replace('id="1" type', 'id="1" name="tooth" type')
    scene = load(named.replace('objectid="2"', 'objectid="2" partnumber="A-7"'))
    assert [(node.name, node.parent, len(node.models)) for node in scene] == [
        *(("A-7", None, 0), ("tooth", "A-7", 1), ("tooth 2", "A-7", 1)),
    ]
    assert scene["tooth"].models[0].model is scene["tooth 2"].models[0].model
    solids: Any = trimesh.load_scene(pair)
    expected = [
        solids.geometry[geometry].vertices @ matrix[:3, :3].T + matrix[:3, 3]
        for matrix, geometry in (solids.graph[name] for name in solids.graph.nodes_geometry)
    ]
    got = [
        points
        for layer in scene.layers()
        for matrix in layer.transform
        for points in [layer.model.transformed(matrix).positions]
    ]
    assert sorted(np.concatenate(got).tolist()) == sorted(np.concatenate(expected).tolist())


def test_items_that_mirror_keep_solids_the_right_way_out() -> None:
    plain = load_mesh(package(MODEL), file_type="3mf").to_trimesh().volume
    for matrix in ("-1 0 0 0 1 0 0 0 1 10 0 0", "0 1 0 1 0 0 0 0 1 0 0 0", "-1 0 0 0 -1 0 0 0 -1 0 0 0"):
        mesh = load_mesh(package(MODEL.replace("1 0 0 0 1 0 0 0 1 10 0 0", matrix)), file_type="3mf")
        assert mesh.to_trimesh().volume == pytest.approx(plain) == pytest.approx(7 / 3)


def test_components_may_be_in_other_parts() -> None:
    head = MODEL[: MODEL.index("<resources>")].replace("<model ", '<model xmlns:p="urn:production" ')
    other = "".join(
        f'<object id="{i}" name="part {i}">{MESH.replace("3.5", height)}</object>' for i, height in ((1, "3"), (2, "6"))
    )
    components = "".join(
        f'<component p:path="/3D/Objects/{name}.model" objectid="{i}"/>' for name, i in (("a", 1), ("a", 2), ("b", 1))
    )
    scene = load(
        f'{head}<resources><object id="9"><components>{components}</components></object></resources>'
        '<build><item objectid="9"/></build></model>',
        a=f"{head}<resources>{other}</resources></model>",
        b=f"{head}<resources>{other.replace('part 1', 'twin')}</resources></model>",
    )
    assert [node.name for node in scene] == ["item 0", "part 1", "part 2", "twin"]
    assert [layer.model.to_trimesh().volume for layer in scene.layers()] == pytest.approx([1, 2, 1])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('objectid="2"', 'objectid="7"', "there is no object '7' in part '3d/3dmodel.model'"),
        ('<component objectid="1"/>', '<component objectid="2"/>', "object '2' is a component of itself"),
        ('v3="1"', 'v3="4"', "object '1': face 0 names point 4"),
        ('v3="1"', 'v3="one"', "object '1': its coordinates and indices must be numbers"),
        ('x="1"', "", "object '1': positions must be finite, got nan"),
        ("0 1 0 -1 0 0", "0 1 0 -1 0", "a transform must be 12 numbers, got '0 1 0 -1 0 0 0 1 0 0 5'"),
        ("0 1 0 -1 0 0", "0 1 0 -1 0 nan", "a transform must be finite"),
        ("</model>", "", "part '3D/3dmodel.model' is not XML"),
        ('<item objectid="2" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>', "", "it shows no triangles"),
    ],
)
def test_what_contradicts_itself_is_refused(old: str, new: str, message: str) -> None:
    with pytest.raises(MeshError) as caught:
        load_mesh(package(MODEL.replace(old, new, 1)), file_type="3mf")
    assert message in str(caught.value)


def test_components_that_meet_again_above_are_refused() -> None:
    among = '<object id="3"><components><component objectid="1"/><component objectid="{}"/></components></object>'
    model = MODEL.replace('<component objectid="1"/>', '<component objectid="3"/>')
    with pytest.raises(MeshError, match="object '2' is a component of itself"):
        load(model.replace("</resources>", f"{among.format(2)}</resources>"))
    assert len(load(model.replace("</resources>", f"{among.format(1)}</resources>"))) == 5


def test_components_that_multiply_are_refused() -> None:
    head, tail = MODEL[: MODEL.index('<object id="2"')], MODEL[MODEL.index("</resources>") :]
    doubled = "".join(
        f'<object id="{i}"><components>{2 * f"<component objectid={chr(34)}{i - 1}{chr(34)}/>"}</components></object>'
        for i in range(2, 40)
    )
    with pytest.raises(
        MeshError, match=r"its components: expands to more than .* nodes, the limit FileLimits\(nodes=\.\.\.\)"
    ):
        load(head + doubled + tail.replace('objectid="2"', 'objectid="39"'))
    chain = "".join(
        f'<object id="{i}"><components><component objectid="{i - 1}"/></components></object>' for i in range(2, 400)
    )
    with pytest.raises(MeshError, match="its nodes are more than 256 deep"):
        load(head + chain + tail.replace('objectid="2"', 'objectid="399"'))


def test_no_document_type_is_taken(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("5")
    for declared in (f'<!ENTITY e SYSTEM "{(tmp_path / "secret").as_uri()}">', '<!ENTITY e "5">'):
        bomb = MODEL.replace("<model ", f"<!DOCTYPE model [{declared}]><model ", 1).replace('x="1"', 'x="&e;"')
        with pytest.raises(MeshError, match=r"part '3D/3dmodel\.model' (declares a document type|is not XML)"):
            load(bomb)


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_parts_are_stored_or_deflated(method: int) -> None:
    # Other methods, which OPC does not allow, raise errors of their own, or take gigabytes by a damaged size.
    with pytest.raises(MeshError, match=rf"part '_rels/\.rels' is compressed by method {method}, not by DEFLATE"):
        load_scene(io.BytesIO(container(MODEL, compression=method)), file_type="3mf")
    assert len(load_scene(io.BytesIO(container(MODEL, compression=zipfile.ZIP_STORED)), file_type="3mf")) == 3


def test_no_more_is_unpacked_than_a_container_declares() -> None:
    data = bytearray(container(MODEL + " " * 50_000_000))
    entry = data.rindex(b"PK\1\2")  # of the model, the last part
    data[entry + 24 : entry + 28] = (100).to_bytes(4, "little")
    tracemalloc.start()
    try:
        with pytest.raises(MeshError, match=r"not a ZIP container: Bad CRC-32 for file '3D/3dmodel\.model'"):
            load_scene(io.BytesIO(data), file_type="3mf")
        assert tracemalloc.get_traced_memory()[1] < 5e6
    finally:
        tracemalloc.stop()


def test_a_part_is_read_once_however_its_path_is_spelled(monkeypatch: pytest.MonkeyPatch) -> None:
    head = MODEL[: MODEL.index("<resources>")].replace("<model ", '<model xmlns:p="urn:production" ')
    spelled = ("/3D/Objects/a.model", "3d/objects/a.model", "/3D/OBJECTS/A.model", "/3D/Objects/a.MODEL/")
    items = "".join(f'<item p:path="{path}" objectid="1"/>' for path in spelled)
    opened: list[str] = []
    read = zipfile.ZipFile.open

    def count(container: zipfile.ZipFile, entry: zipfile.ZipInfo, *rest: Any, **named: Any) -> Any:
        opened.append(entry.filename)
        return read(container, entry, *rest, **named)

    made = package(
        f"{head}<build>{items}</build></model>",
        a=f'{head}<resources><object id="1">{MESH}</object></resources></model>',
    )
    monkeypatch.setattr(zipfile.ZipFile, "open", count)
    scene = load_scene(made, file_type="3mf")
    assert opened == ["_rels/.rels", "3D/3dmodel.model", "3D/Objects/a.model"]
    assert len({id(node.models[0].model) for node in scene}) == 1
    assert len(scene) == 4


def test_a_part_in_ebcdic_is_read_or_refused_in_one_line() -> None:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("3D/3dmodel.model", MODEL.replace("UTF-8", "IBM037").encode("cp037"))
    message = ""
    try:
        assert len(load_scene(io.BytesIO(file.getvalue()), file_type="3mf")) == 3
    except MeshError as error:  # as libxml2 was built
        message = str(error)
    assert re.fullmatch(r"(<file>: part '3D/3dmodel\.model' is not XML: .*, line 1)?", message)
