"""Materials of OBJ files, in `.mtl` files beside them."""

import contextlib
import io
import sys
import tracemalloc
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from gpu_xform import Mesh, load_mesh, render_array, save_mesh
from gpu_xform.cli import main
from gpu_xform.errors import MeshWarning
from tests.support.cost import within_cpu_s

POINTS = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 2 0\n"
FACES = b"usemtl steel\nf 1 2 3 4\nusemtl paint\nf 4 3 5\n"
MTL = b"""# made by hand
newmtl steel
Ns 96
Kd 0.25 0.5 0.75 # bluish
d 0.5
map_Kd -s 2 2 1 sheet metal.png

newmtl paint
\tKd 1 0 0
Tr 0.25
illum 2
newmtl steel
Kd 0 0 0
newmtl unused
Kd 0 1 0
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "m.obj"
    path.write_bytes(b"mtllib m.mtl\n" + POINTS + FACES)
    (tmp_path / "m.mtl").write_bytes(MTL)
    (tmp_path / "sheet metal.png").write_bytes(b"PNG")
    return path


def run(*words: object) -> int:
    return main(list(map(str, words)))


def test_colours_are_those_of_the_file(model: Path) -> None:
    material = load_mesh(model).attributes.material
    assert list(material) == ["mtllib", "steel", "paint"]
    steel, paint = (material[name]["pbrMetallicRoughness"]["baseColorFactor"] for name in ("steel", "paint"))
    assert steel == (0.25, 0.5, 0.75, 0.5)
    assert paint == (1.0, 0.0, 0.0, 0.75)
    assert material["steel"]["extras"]["mtl"] == {"Ns": "96", "map_Kd": "-s 2 2 1 sheet metal.png"}


def test_pictures_have_the_colours(model: Path) -> None:
    picture = render_array(str(model), size=(64, 64), fill="file", color="black", background="white")
    red = (picture[..., 0] > 200) & (picture[..., 1] < 100)
    blue = (picture[..., 2].astype(int) - picture[..., 0] > 30) & ~red
    assert red.sum() > 100
    assert blue.sum() > 100


def test_colours_reach_glb_and_what_does_not_is_named(model: Path, tmp_path: Path) -> None:
    with pytest.warns(MeshWarning) as caught:
        save_mesh(load_mesh(model), tmp_path / "m.glb")
    assert len(caught) == 1
    assert "glTF does not hold map_Kd of material 'steel'" in str(caught[0].message)
    found = {
        part.visual.material.name: part.visual.material.baseColorFactor
        for part in trimesh.load_scene(tmp_path / "m.glb").geometry.values()
    }
    assert np.allclose(found["steel"], [64, 128, 191, 128], atol=1)
    assert np.allclose(found["paint"], [255, 0, 0, 191], atol=1)
    assert run("transform", model, tmp_path / "n.glb", "--strict") == 2
    assert not (tmp_path / "n.glb").exists()


@pytest.mark.parametrize("name", ["my wood.mtl", "sub/m.mtl", r"sub\m.mtl", "a.mtl m.mtl", "100%25.mtl"])
def test_names_are_meant_letter_for_letter(tmp_path: Path, name: str) -> None:
    (tmp_path / "sub").mkdir()
    for library in ["a.mtl", "m.mtl"] if " m" in name else [name.replace("\\", "/")]:
        (tmp_path / library).write_bytes(b"newmtl x\n" if library == "a.mtl" else MTL.replace(b"map_Kd", b"#"))
    (tmp_path / "m.obj").write_bytes(f"mtllib {name}\n".encode() + POINTS + FACES)
    assert "steel" in load_mesh(tmp_path / "m.obj").attributes.material


def test_a_missing_file_is_a_warning(model: Path) -> None:
    (model.parent / "m.mtl").unlink()
    with pytest.warns(MeshWarning, match=r"m\.obj: the materials of m\.mtl are not there"):
        mesh = load_mesh(model)
    assert mesh.attributes.material == {"mtllib": ("m.mtl",)}


def test_a_pointer_of_git_lfs_is_a_warning(model: Path) -> None:
    model.with_suffix(".mtl").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
    with pytest.warns(MeshWarning, match=r"the materials of m\.mtl are not there: it is a pointer of Git LFS"):
        load_mesh(model)


def test_files_elsewhere_are_not_opened(tmp_path: Path) -> None:
    (tmp_path / "secret.mtl").write_bytes(MTL)
    (tmp_path / "in").mkdir()
    (tmp_path / "in/m.obj").write_bytes(b"mtllib ../secret.mtl\n" + POINTS + FACES)
    with pytest.warns(MeshWarning, match=r"secret\.mtl are not there"):
        load_mesh(tmp_path / "in/m.obj")


def test_the_file_goes_along_into_another_folder(model: Path, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    mesh = load_mesh(model)
    with pytest.warns(MeshWarning, match=r"OBJ does not hold the image sheet metal\.png$"):
        save_mesh(mesh, tmp_path / "sub/s.obj")
    assert (tmp_path / "sub/m.mtl").read_bytes() == MTL
    with pytest.warns(MeshWarning, match=r"s\.obj: the image 'sheet metal\.png' of material 'steel' is not there"):
        assert load_mesh(tmp_path / "sub/s.obj") == mesh


def test_beside_the_file_nothing_is_written_or_lost(model: Path, tmp_path: Path) -> None:
    before = sorted(path.name for path in tmp_path.iterdir())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        save_mesh(load_mesh(model), tmp_path / "n.obj")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*before, "n.obj"])
    assert run("transform", model, tmp_path / "o.obj", "--strict") == 0


def test_another_file_of_the_name_stays(model: Path, tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/m.mtl").write_bytes(b"other")
    with pytest.warns(MeshWarning, match=r"the materials of m\.mtl, for another file of that name is there"):
        save_mesh(load_mesh(model), tmp_path / "sub/s.obj")
    assert (tmp_path / "sub/m.mtl").read_bytes() == b"other"


def test_a_stream_has_no_file_beside_it(model: Path) -> None:
    with pytest.warns(MeshWarning, match=r"OBJ does not hold the file m\.mtl"):
        save_mesh(load_mesh(model), io.BytesIO(), file_type="obj")
    mesh = load_mesh(io.BytesIO(model.read_bytes()), file_type="obj")
    with pytest.warns(MeshWarning, match=r"glTF does not hold material \(mtllib\)"):
        save_mesh(mesh, io.BytesIO(), file_type="glb")


def test_obj_names_what_it_loses_of_a_material() -> None:
    material: dict[str, Any] = {"steel": {"name": "steel", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}}
    mesh = Mesh(
        [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
        [(0, 1, 2)],
        attributes={"face": {"material": [0]}, "labels": {"material": ["steel"]}, "material": material},
    )
    file = io.BytesIO()
    with pytest.warns(MeshWarning, match=r"OBJ does not hold colour of material 'steel'$"):
        save_mesh(mesh, file, file_type="obj")
    assert b"usemtl steel" in file.getvalue()


@pytest.mark.parametrize("data", [b"", b"newmtl", b"Kd 1", b"newmtl steel\nKd x\nd\nTr nan\nmap_Kd\n\xff", b"\0\xff"])
def test_damaged_files_give_no_colours(model: Path, data: bytes) -> None:
    (model.parent / "m.mtl").write_bytes(data)
    with contextlib.suppress(MeshWarning):
        material = load_mesh(model).attributes.material
    assert "pbrMetallicRoughness" not in material.get("steel", {})


@pytest.mark.parametrize(
    ("statement", "image"),
    [
        ("map_Kd wood.png", "wood.png"),
        ("map_Kd oak floor.png", "oak floor.png"),
        ("bump -bm 0.2 oak floor.png", "oak floor.png"),
        ("map_d -o 1 -s 2 2 2 -clamp on -imfchan l sub\\wood.png", "sub/wood.png"),
        ("refl -type cube_top -cc off 1 2.png", "1 2.png"),
        ("disp -s 1 1 1 -t 0 0 0 -mm 0 1 ./wood.png", "wood.png"),
        ("map_Ks -s 1 2 3 4.png", "3 4.png"),
        ('map_Kd "wood.png"', "wood.png"),
        ('map_Kd "oak floor.png"', "oak floor.png"),
        ('map_Kd -s 1 1 1 "sub\\oak  floor.png"', "sub/oak  floor.png"),
        ("map_Kd", None),
        ("map_aat on", None),
    ],
)
def test_images_are_found_behind_options(model: Path, statement: str, image: str | None) -> None:
    (model.parent / "sub").mkdir()
    names = ("wood.png", "oak floor.png", "sub/wood.png", "1 2.png", "3 4.png", "sub/oak  floor.png")
    for name in names:
        (model.parent / name).write_bytes(b"PNG")
    model.with_suffix(".mtl").write_text(f"newmtl steel\n{statement}\n")
    assert load_mesh(model).metadata["obj"]["images"] == (() if image is None else (image,))


@pytest.mark.skipif(sys.platform == "win32", reason="no file has such a name there")
def test_quotation_marks_may_belong_to_a_name(model: Path) -> None:
    for name in ("wood.png", '"wood.png"'):
        (model.parent / name).write_bytes(b"PNG")
    model.with_suffix(".mtl").write_text('newmtl steel\nmap_Kd "wood.png"\n')
    assert load_mesh(model).metadata["obj"]["images"] == ('"wood.png"',)


@pytest.mark.parametrize(
    ("statements", "words"),
    [
        ("newmtl steel\nmap_Kd none.png", "image 'none.png' of material 'steel' is not there: no such file"),
        ("newmtl steel\nmap_Kd a.png\nmap_d -s 1 1 1 a.png", "image 'a.png' of material 'steel' is not there"),
        ('newmtl steel\nbump -bm 0.2 "no floor.png"', "image 'no floor.png' of material 'steel' is not"),
        ("newmtl steel\nrefl -type cube_top -cc on -imfchan l C:\\art\\up.png", "image 'C:/art/up.png' of material"),
        (
            "newmtl steel\nmap_Kd a.png\nmap_Ks b.png\nnewmtl unused\nmap_Kd c.png\nnewmtl paint\nmap_Kd a.png",
            "images 'a.png' of materials 'steel', 'paint', 'b.png' of material 'steel' are not there: no such files",
        ),
        ("newmtl steel\nmap_Kd ../secret.png", r"image '../secret.png' of material 'steel' is not there"),
        (
            "newmtl steel\n" + "\n".join(f"map_Kd a{i}.png" for i in range(1000)),
            "'a7.png' of material 'steel' and 992 more are not there",
        ),
    ],
    ids=["one", "twice", "quotation marks", "options", "several", "elsewhere", "many"],
)
def test_images_that_are_missing_are_one_warning(model: Path, statements: str, words: str) -> None:
    model.write_bytes(b"mtllib m.mtl\n" + POINTS + FACES + b"usemtl steel\nf 1 2 3\n" * 100)
    model.with_suffix(".mtl").write_text(statements)
    with pytest.warns(MeshWarning) as caught:
        mesh = load_mesh(model)
    assert [words in str(each.message) for each in caught] == [True], str(caught[0].message)
    assert str(caught[0].message).startswith(f"{model}: the image")
    assert mesh.metadata["obj"]["images"] == ()


def test_an_image_of_a_material_that_no_face_has_is_not_missed(model: Path) -> None:
    model.with_suffix(".mtl").write_text("newmtl unused\nmap_Kd none.png\nnewmtl steel\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_mesh(model)
        load_mesh(io.BytesIO(model.read_bytes()), file_type="obj")


def test_materials_by_the_thousand_take_time_that_grows_with_their_number(model: Path) -> None:
    """Before, each material was looked for among all names that faces have."""
    names = [f"m{i}" for i in range(40_000)]
    model.write_bytes(b"mtllib m.mtl\n" + POINTS + "".join(f"usemtl {name}\nf 1 2 3\n" for name in names).encode())
    model.with_suffix(".mtl").write_text("".join(f"newmtl {name}\nmap_Kd {name}.png\n" for name in names[::-1]))
    for _ in within_cpu_s(3):
        with pytest.warns(MeshWarning, match=r"'m39999\.png' of material 'm39999', .* and 39992 more are not there"):
            mesh = load_mesh(model)
        assert len(mesh.attributes.material) == 40_001


@pytest.mark.parametrize(
    "body",
    [
        "map_Kd " + "a " * 50_000,
        "map_Kd -s " + "1 " * 50_000,
        "map_Kd -s 1 1 1" + " " * 100_000,
        "map_Kd " + "-s 1 1 1 " * 33_000,
        "map_Kd -s 1 1 1 sheet metal.png\n" * 3_000,
    ],
    ids=["words", "arguments", "blanks", "options", "statements"],
)
def test_long_image_statements_end_soon_and_in_little_memory(model: Path, body: str) -> None:
    """Before, each word of one was looked for with all behind it: 100 kB took up to 138 s and 2.4 GB."""
    load_mesh(model)
    model.with_suffix(".mtl").write_text(f"newmtl steel\n{body}")
    for _ in within_cpu_s(0.5):
        tracemalloc.start()
        try:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                load_mesh(model)
            assert all(len(str(each.message)) < 500 for each in caught)
            assert tracemalloc.get_traced_memory()[1] < 5e6
        finally:
            tracemalloc.stop()


@pytest.mark.parametrize(
    ("statement", "names"),
    [
        ('"all paints.mtl"', ["all paints.mtl"]),
        ('"all paints.mtl" "metals.mtl"', ["all paints.mtl", "metals.mtl"]),
        ('metals.mtl "all paints.mtl"', ["metals.mtl", "all paints.mtl"]),
        ('5".mtl', ['5".mtl']),
        ('5".mtl 6".mtl', ['5".mtl', '6".mtl']),
        ('"6".mtl', ['"6".mtl']),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="no file has such a name there")
def test_libraries_may_stand_in_quotation_marks(statement: str, names: list[str], model: Path) -> None:
    """As some exporters write names with blanks; such a library was said to be missing, as two."""
    for name in names:
        (model.parent / name).write_text(f"newmtl {name}\n")
    model.write_bytes(f"mtllib {statement}\n".encode() + POINTS + FACES)
    mesh = load_mesh(model)
    assert list(mesh.metadata["obj"]["libraries"]) == names
    again = model.parent / "again"
    again.mkdir()
    save_mesh(mesh, again / "m.obj")
    assert load_mesh(again / "m.obj").metadata["obj"]["libraries"] == mesh.metadata["obj"]["libraries"]
    for name in names:
        (again / name).unlink()
    with pytest.warns(MeshWarning, match=f"the materials of {', '.join(names)} are not there"):
        load_mesh(again / "m.obj")


def test_a_library_of_many_names_is_read_once(model: Path) -> None:
    """Before, it was read and parsed once for each."""
    names = "\n".join(f"mtllib {'./' * (i % 100)}m.mtl" for i in range(1000))
    model.write_bytes(f"{names}\n".encode() + POINTS + FACES)
    mesh = load_mesh(model)
    assert list(mesh.metadata["obj"]["libraries"]) == ["m.mtl"]
    assert "steel" in mesh.attributes.material


def test_many_missing_libraries_are_a_short_warning(model: Path) -> None:
    model.write_bytes(b"mtllib " + b" ".join(b"b%d" % i for i in range(1000)) + b"\n" + POINTS + FACES)
    with pytest.warns(MeshWarning, match=r"the materials of b0, b1, b2, b3, b4, b5, b6, b7 and 992 more are not there"):
        load_mesh(model)


@pytest.mark.parametrize(
    ("statement", "named"),
    [
        ("not there.mtl", "'not there.mtl'"),
        ("NOT  THERE.MTL", "'NOT  THERE.MTL'"),
        ("a b c.mtl d.mtl", "a, b, c.mtl, d.mtl"),
        ("a.mtl b", "a.mtl, b"),
        ("m.mtl not.mtl", "not.mtl"),
        ("m.mtl not there.mtl", "not, there.mtl"),
    ],
)
def test_a_missing_library_is_named_once(model: Path, statement: str, named: str) -> None:
    model.write_bytes(f"mtllib {statement}\n".encode() + POINTS + FACES)
    with pytest.warns(MeshWarning, match=f"the materials of {named} are not there: no such file lies beside it$"):
        load_mesh(model)


@pytest.mark.parametrize(
    "name",
    [
        "settings.txt",
        "conftest.py",
        "sub/x",
        ".m.mtl",
        ".git/x.mtl",
        "../in/x.mtl",
        "sub/../x.mtl",
        r"sub\.a\x.mtl",
        "mtl",
    ],
)
def test_files_whose_names_the_model_chooses_are_no_others_than_libraries(tmp_path: Path, name: str) -> None:
    """They were written beside the destination, with any content, and with ".." into other folders."""
    source, target = tmp_path / "a/in", tmp_path / "b/out"
    for folder in (source / "sub", tmp_path / "b/in", target):
        folder.mkdir(parents=True)
    path = source / name.replace("\\", "/")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(MTL.replace(b"map_Kd", b"#"))
    (source / "m.obj").write_bytes(f"mtllib {name}\n".encode() + POINTS + FACES)
    mesh = load_mesh(source / "m.obj")
    assert "steel" in mesh.attributes.material
    with pytest.warns(MeshWarning) as caught:
        save_mesh(mesh, target / "m.obj")
    assert str(caught[0].message).endswith(f"OBJ does not hold the file {name}, whose materials it names")
    assert [path.name for path in (tmp_path / "b").rglob("*") if path.is_file()] == ["m.obj"]
    assert run("transform", source / "m.obj", source / "n.obj", "--strict") == 0  # beside which it is


@pytest.mark.parametrize("name", ["{folder}/x.mtl", r"\x.mtl", "C:x.mtl", r"\\host\share\x.mtl"])
def test_a_library_of_an_absolute_path_is_written_nowhere(tmp_path: Path, name: str) -> None:
    name = name.format(folder=tmp_path)
    (tmp_path / "out").mkdir()
    attributes = {"material": {"mtllib": [name]}}
    mesh = Mesh(np.eye(3), [(0, 1, 2)], attributes=attributes, metadata={"obj": {"libraries": {name: MTL}}})
    with pytest.warns(MeshWarning, match=r"OBJ does not hold the file .*x\.mtl, whose materials it names"):
        save_mesh(mesh, tmp_path / "out/m.obj")
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "m.obj"]


@pytest.mark.skipif(sys.platform == "win32", reason="makes a symbolic link, which asks for a right of its own there")
def test_no_library_is_written_through_a_link_out_of_the_folder(tmp_path: Path) -> None:
    for folder in ("in/sub", "out", "elsewhere"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "out/sub").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "in/sub/x.mtl").write_bytes(MTL.replace(b"map_Kd", b"#"))
    (tmp_path / "in/m.obj").write_bytes(b"mtllib sub/x.mtl\n" + POINTS + FACES)
    with pytest.warns(MeshWarning, match=r"OBJ does not hold the file sub/x\.mtl, whose materials it names$"):
        save_mesh(load_mesh(tmp_path / "in/m.obj"), tmp_path / "out/m.obj")
    assert list((tmp_path / "elsewhere").iterdir()) == []
