"""Colours, materials and texture coordinates of 3MF."""

import io
import re
import tracemalloc
import warnings
import zipfile

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Mesh, load_mesh, load_scene
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import save_mesh
from tests.support.cost import within_cpu_s
from tests.support.threemf_files import container

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIAL = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
BEAMS = "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"
TRIANGLES = '<triangle v1="0" v2="2" v3="1" {}/><triangle v1="0" v2="1" v3="3" {}/>'
COLORS = """<m:colorgroup id="5"><m:color color="#FF0000"/><m:color color="#00FF0080"/><m:color color="#0000FF"/>
</m:colorgroup>"""
BASE = """<basematerials id="6"><base name="steel" displaycolor="#102030"/><base name="wood" displaycolor="#405060FF"/>
</basematerials>"""
R, G, B = [255, 0, 0, 255], [0, 255, 0, 128], [0, 0, 255, 255]


def package(resources: str, first: str = "", second: str = "", of_object: str = "", more: str = "") -> bytes:
    return container(f"""<model unit="millimeter" xmlns="{CORE}" xmlns:m="{MATERIAL}" xmlns:b="{BEAMS}">
      <metadata name="Title">two</metadata><resources>{resources}<object id="1" {of_object}><mesh><vertices>
      <vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="2" z="0"/><vertex x="0" y="0" z="3"/>
      </vertices><triangles>{TRIANGLES.format(first, second)}</triangles>{more}</mesh></object></resources>
      <build><item objectid="1"/></build></model>""")


def read(data: bytes) -> Mesh:
    return load_mesh(io.BytesIO(data), file_type="3mf")


def test_colors_of_corners() -> None:
    mesh = read(package(COLORS, 'pid="5" p1="0" p2="1" p3="2"', 'pid="5" p1="2"'))
    assert mesh.attributes.corner["color"].tolist() == [R, G, B, B, B, B]
    assert mesh.attributes.corner["color"].dtype == np.uint8


def test_colors_of_faces_and_of_the_object() -> None:
    mesh = read(package(COLORS, 'pid="5" p1="0"', "", 'pid="5" pindex="2"'))
    assert mesh.attributes.face["color"].tolist() == [R[:3], B[:3]]
    mesh = read(package(COLORS, 'p1="1"', "", 'pid="5" pindex="2"'))
    assert mesh.attributes.face["color"].tolist() == [G, B]
    assert not read(package(COLORS)).attributes


def test_base_materials_have_names_and_colors() -> None:
    mesh = read(package(BASE, 'pid="6" p1="1"', "", 'pid="6" pindex="0"'))
    names = mesh.attributes.labels["material"]
    assert [names[i] for i in mesh.attributes.face["material"]] == ["wood", "steel"]
    assert mesh.attributes.face["color"].tolist() == [[0x40, 0x50, 0x60], [0x10, 0x20, 0x30]]
    # An object has the names that it uses: all of a large group for each of many objects are gigabytes.
    attributes = read(package(BASE, 'pid="6" p1="1"')).attributes
    assert attributes.labels["material"] == ("wood",)
    assert attributes.face["material"].tolist() == [0, -1]


def test_composites_and_several_properties() -> None:
    composite = """<m:compositematerials id="7" matid="6" matindices="0 1"><m:composite values="0.25 0.75"/>
    </m:compositematerials>"""
    mesh = read(package(BASE + composite, 'pid="7" p1="0"'))
    assert mesh.attributes.face["color"][0].tolist() == [0x34, 0x44, 0x54]
    texture = """<m:texture2d id="8" path="/a.png" contenttype="image/png"/><m:texture2dgroup id="9" texid="8">
    <m:tex2coord u="0.25" v="0.5"/><m:tex2coord u="1" v="0"/></m:texture2dgroup>
    <m:multiproperties id="10" pids="5 9"><m:multi pindices="2 1"/><m:multi pindices="0"/></m:multiproperties>"""
    mesh = read(package(COLORS + texture, 'pid="10" p1="0" p2="1" p3="0"'))
    assert mesh.attributes.corner["texcoord"][:3].tolist() == [[1, 0], [0.25, 0.5], [1, 0]]
    assert mesh.attributes.corner["color"][:3].tolist() == [B[:3], R[:3], B[:3]]
    assert mesh.metadata["3mf"]["holds"] == ("1 metadata entry", "1 texture")
    assert mesh.metadata["3mf"]["metadata"] == {"Title": "two"}


@pytest.mark.parametrize("members", ['pid="5" p1="7"', 'pid="99" p1="0"', 'pid="5" p1="-3"', 'pid="5"'])
def test_members_that_do_not_exist_have_no_color(members: str) -> None:
    mesh = read(package(COLORS, members, 'pid="5" p1="2"'))
    assert mesh.attributes.face["color"].tolist() == [[255, 255, 255], B[:3]]


def test_beams_are_segments() -> None:
    beams = '<b:beamlattice><b:beams><b:beam v1="1" v2="3"/><b:beam v1="2" v2="3"/></b:beams></b:beamlattice>'
    mesh = read(package(COLORS, 'pid="5" p1="0"', more=beams))
    assert [face.tolist() for face in mesh.faces] == [[0, 2, 1], [0, 1, 3], [1, 3], [2, 3]]
    assert mesh.attributes.face["color"].tolist() == [R[:3]] + [[255] * 3] * 3


def test_unknown_required_extensions_are_refused_by_name() -> None:
    data = package(COLORS)
    with zipfile.ZipFile(io.BytesIO(data)) as parts:
        text = parts.read("3D/3dmodel.model").decode()
    read(container(text.replace("<model", '<model requiredextensions="m b"')))
    with pytest.raises(MeshError, match="requires the extension 'urn:odd', which cannot be read"):
        read(container(text.replace("<model", '<model requiredextensions="m odd" xmlns:odd="urn:odd"')))


def test_undefined_prefixes_are_forgiven_and_other_errors_are_not() -> None:
    # As in "multiprop-metallic.3mf" of the 3MF consortium's samples.
    assert read(package(COLORS + '<ms:pbmetallic name="x"/>')).n_faces == 2
    with pytest.raises(MeshError, match="is not XML: Opening and ending tag mismatch"):
        read(package(COLORS + "<a></b>"))


def test_pictures_and_other_formats_have_the_colors() -> None:
    mesh = read(package(COLORS, 'pid="5" p1="0"', 'pid="5" p1="2"'))
    plain = Mesh(mesh.positions, mesh.faces)
    expected = gx.render_array(plain, face_colors=["red", "blue"], size=(60, 50))
    assert np.array_equal(gx.render_array(mesh, color="file", size=(60, 50)), expected)
    file = io.BytesIO()
    with pytest.warns(MeshWarning, match="PLY does not hold 1 metadata entry$"):
        save_mesh(mesh, file, file_type="ply")
    again = load_mesh(io.BytesIO(file.getvalue()), file_type="ply")
    assert np.array_equal(again.attributes.face["color"], mesh.attributes.face["color"])
    file = io.BytesIO()
    with warnings.catch_warnings(action="ignore", category=MeshWarning):
        save_mesh(mesh, file, file_type="glb")
    found = load_mesh(io.BytesIO(file.getvalue()), file_type="glb")
    assert found.attributes.point["color"][found.indices][::3].tolist() == [R[:3], B[:3]]


def test_items_with_colors_of_corners_and_of_faces_are_drawn_in_both() -> None:
    data = package(COLORS, 'pid="5" p1="0" p2="1" p3="2"', 'pid="5" p1="2"')
    with zipfile.ZipFile(io.BytesIO(data)) as parts:
        text = parts.read("3D/3dmodel.model").decode()
    (one,) = re.findall("<object.*</object>", text, re.DOTALL)
    two = one.replace('id="1"', 'id="2"').replace('p1="0" p2="1" p3="2"', 'p1="1"')
    text = text.replace(one, one + two).replace("<build>", '<build><item objectid="2"/>')
    assert len(load_scene(io.BytesIO(container(text)), file_type="3mf")) == 2
    mesh = read(container(text))
    assert mesh.attributes.corner["color"].tolist() == [G] * 3 + [B] * 3 + [R, G, B] + [B] * 3
    assert "color" not in mesh.attributes.face


def test_a_long_name_of_a_group_takes_its_own_memory_alone() -> None:
    name = 50_000 * "a"
    model = package(
        COLORS,
        'pid="5" p1="0"',
        f'pid="{name}"',
        more="<triangles>{}</triangles>".format(1000 * '<triangle v1="0" v2="1" v3="2" pid="5" p1="1"/>'),
    )
    tracemalloc.start()
    try:
        mesh = read(model)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
    assert mesh.attributes.face["color"][:3].tolist() == [R, [255] * 4, G]


def test_composites_are_weighted_means_of_their_materials() -> None:
    generator = np.random.default_rng(3)
    palette = generator.integers(0, 256, (9, 4))
    chosen = generator.integers(0, 9, 6)
    rows = [generator.random(n).round(3) * (n != 4) for n in (1, 2, 3, 4, 6, 8, 0)]
    bases = "".join(f'<base name="x" displaycolor="#{bytes(color.tolist()).hex()}"/>' for color in palette)
    composites = "".join(f'<m:composite values="{" ".join(map(str, row.tolist()))}"/>' for row in rows)
    group = f"""<basematerials id="6">{bases}</basematerials><m:compositematerials id="7" matid="6"
        matindices="{" ".join(map(str, chosen.tolist()))}">{composites}</m:compositematerials>"""
    triangles = "".join(f'<triangle v1="0" v2="1" v3="2" pid="7" p1="{i}"/>' for i in range(len(rows)))
    mesh = read(package(group, more=f"<triangles>{triangles}</triangles>"))
    weights = np.zeros((len(rows), 6))
    for weight, row in zip(weights, rows, strict=True):
        weight[: len(row)] = row[:6]
    weights[weights.sum(axis=1) == 0] = 1
    means = weights @ palette[chosen] / weights.sum(axis=1, keepdims=True)
    assert mesh.attributes.face["color"][2:].tolist() == np.rint(means).astype(int).tolist()


COMPOSITES, COMPOSITE = '<m:compositematerials id="7" matid="6" matindices="{}">', '<m:composite values="1"/>'
MULTIPLE, MULTI = '<m:multiproperties id="7" pids="{}">', '<m:multi pindices="0"/>'


@pytest.mark.parametrize(
    "resources",
    [
        f"{BASE}{COMPOSITES.format(40_000 * '0 ')}{1000 * COMPOSITE}</m:compositematerials>",
        f"{MULTIPLE.format(10_000 * '5 ')}{10_000 * MULTI}</m:multiproperties>",
    ],
    ids=["composites", "multiproperties"],
)
def test_members_that_share_a_long_list_are_not_filled_up_to_it(resources: str) -> None:
    model = package(COLORS + resources)
    for _ in within_cpu_s(2):
        tracemalloc.start()
        try:
            assert read(model).n_faces == 2
            assert tracemalloc.get_traced_memory()[1] < 20e6
        finally:
            tracemalloc.stop()


def test_many_namespaces_are_looked_up_once_for_all_required_extensions() -> None:
    with zipfile.ZipFile(io.BytesIO(package(COLORS))) as parts:
        text = parts.read("3D/3dmodel.model").decode()
    namespaces = "".join(f' xmlns:a{i}="{MATERIAL}"' for i in range(4000))
    model = container(text.replace("<model", f'<model{namespaces} requiredextensions="{10_000 * "a1 "}"'))
    for _ in within_cpu_s(1):
        assert read(model).n_faces == 2


@pytest.mark.parametrize(
    "resources",
    [
        f'<m:multiproperties id="7" pids="{540_000 * "5 "}"><m:multi pindices="0"/></m:multiproperties>',
        f'<m:multiproperties id="7" pids="5"><m:multi pindices="{540_000 * "0 "}"/></m:multiproperties>',
    ],
    ids=["groups", "members"],
)
def test_lists_of_half_a_million_words_are_refused_before_they_are_split(resources: str) -> None:
    with pytest.raises(
        MeshError, match=r"it is made of more than 66,\d+ elements of 8 attributes, the limit FileLimits"
    ):
        read(package(COLORS + resources))
