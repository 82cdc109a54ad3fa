import io
import os
import stat
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform import samples
from gpu_xform._core.atomic_files import atomic_write
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError, MeshWarning
from gpu_xform.formats import load_mesh, load_scene, registry, save_mesh
from gpu_xform.geometry.mesh import Mesh

coordinates = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    points = draw(st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=1, max_size=12))
    corner = st.integers(0, len(points) - 1)
    return Mesh(points, draw(st.lists(st.lists(corner, min_size=2, max_size=9), max_size=9)))


@pytest.mark.parametrize("name", ["models", "models.obj", "models.glb"])
def test_a_folder_is_no_model_file(name: str, tmp_path: Path) -> None:
    folder = tmp_path / name
    folder.mkdir()
    for load in (load_mesh, gx.load_scene):
        with pytest.raises(MeshError) as caught:
            load(folder)
        assert str(caught.value) == f"{folder}: it is a folder, not a model file"


def through(mesh: Mesh, kind: str) -> Mesh:
    file = io.BytesIO()
    save_mesh(mesh, file, file_type=kind)
    return load_mesh(io.BytesIO(file.getvalue()), file_type=kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["obj", "off", "ply"])
@given(mesh=meshes())
def test_polygons_and_every_bit_of_the_coordinates_come_back(kind: str, mesh: Mesh) -> None:
    read = through(mesh, kind)
    assert read.positions.tobytes() == mesh.positions.tobytes()
    faces = [face.tolist() for face in mesh.faces]
    if kind == "ply":  # segments are edges there, which stand behind the faces
        faces.sort(key=lambda face: len(face) == 2)
    assert [face.tolist() for face in read.faces] == faces


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["stl", "glb"])
@given(mesh=meshes())
def test_triangle_formats_keep_the_triangles(kind: str, mesh: Mesh) -> None:
    triangles = Mesh((mesh.positions % 1024).astype(np.float32), [face for face in mesh.faces if len(face) > 2])
    if triangles.n_faces == 0:
        return
    fans = triangles.to_trimesh()
    read = through(triangles, kind)
    assert np.array_equal(read.positions[np.asarray(read.faces)], fans.triangles)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["obj", "off", "ply", "stl", "glb"])
def test_large_meshes_pass_the_seams_between_blocks(kind: str) -> None:
    grid = samples.grid(300)
    mesh = grid if kind in ("obj", "off", "ply") else Mesh.from_trimesh(grid.to_trimesh())
    assert mesh.n_points > 1 << 16
    read = through(Mesh(mesh.positions.astype(np.float32), mesh.faces), kind)
    assert np.array_equal(read.positions[read.indices], mesh.positions.astype(np.float32)[mesh.indices])


@pytest.mark.parametrize("name", ["a.obj", "a.OBJ", "b c.d.Obj", "\xe9\u2028.obj"])
@pytest.mark.parametrize("as_path", [True, False])
def test_paths(tmp_path: Path, name: str, as_path: bool) -> None:
    path: Any = tmp_path / name if as_path else str(tmp_path / name)
    save_mesh(samples.house(), path)
    assert load_mesh(path) == samples.house()
    with open(path, "rb") as file:  # noqa: PTH123
        assert load_mesh(file) == samples.house()


@pytest.mark.parametrize("kind", ["off", ".off", "OFF", ".Off"])
def test_the_file_type_can_be_an_argument(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "solid.txt"
    save_mesh(samples.cube(), path, file_type=kind)
    assert path.read_bytes().startswith(b"OFF")
    assert load_mesh(path, file_type=kind) == samples.cube()
    with path.open("rb") as file:
        assert load_mesh(file, file_type=kind) == samples.cube()


def test_unknown_types_name_the_known_ones(tmp_path: Path) -> None:
    for source, kind, got in (
        ("a.xyz", None, "'xyz'"),
        ("a", None, "no suffix and no file type"),
        ("a.obj", "iges", "'iges'"),
    ):
        (tmp_path / source).touch()
        with pytest.raises(MeshError) as caught:
            load_mesh(tmp_path / source, file_type=kind)
        known = "3mf, dae, glb, gltf, las, laz, npy, obj, off, ply, step, stl, stp, urdf, vrml, wrl, wrz"
        assert str(caught.value) == f"{tmp_path / source}: the type must be one of {known}, got {got}"
    with pytest.raises(MeshError, match="the type must be one of glb, gltf, npy, obj, off, ply, stl, got 'wrl'"):
        save_mesh(samples.cube(), tmp_path / "a.wrl")
    with pytest.raises(ArgumentError, match="file_type must be given for a file that has no name"):
        load_mesh(io.BytesIO(b"x"))
    for value in (3, b"a.obj", None):
        words = f"^source must be a path or a binary file, got {type(value).__name__}$"
        for load in (load_mesh, gx.load_scene):
            with pytest.raises(ArgumentTypeError, match=words) as refused:
                load(value)  # type: ignore[arg-type]
            assert (refused.value.argument, refused.value.expected) == ("source", "be a path or a binary file")
        with pytest.raises(ArgumentTypeError, match=words.replace("source", "target")):
            save_mesh(samples.cube(), value)  # type: ignore[arg-type]
    with pytest.raises(ArgumentTypeError, match=r"source must be a binary file, its read\(\) gave str"):
        load_mesh(io.StringIO("v 0 0 0"), file_type="obj")  # type: ignore[arg-type]


def test_paths_and_points_are_saved_as_meshes(tmp_path: Path) -> None:
    points = np.array([(0, 0, 0), (1, 2, 3)], np.float32)
    save_mesh(points, tmp_path / "a.ply")
    assert load_mesh(tmp_path / "a.ply") == Mesh(points)
    save_mesh(tmp_path / "a.ply", tmp_path / "b.obj")
    assert load_mesh(tmp_path / "b.obj") == Mesh(points)


def test_what_is_no_model_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ArgumentTypeError, match=r"mesh must be a Mesh, a Scene, a path or an array .*, got list"):
        save_mesh([1, 2], tmp_path / "a.ply")  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


def test_a_file_opened_by_number_has_no_name(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    save_mesh(samples.cube(), path)
    with os.fdopen(os.open(path, os.O_RDONLY), "rb") as file:
        with pytest.raises(ArgumentError, match="file_type must be given"):
            load_mesh(file)
        assert load_mesh(file, file_type="obj") == samples.cube()


@pytest.mark.parametrize("kind", sorted(registry.READERS))
def test_bad_files_are_named(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"bad.{kind}"
    for data, message in ((b"", ": the file is empty"), (b"\x00\x01nonsense\xff" * 20, ": ")):
        path.write_bytes(data)
        with pytest.raises(MeshError) as caught:
            load_mesh(path)
        assert str(caught.value).startswith(f"{path}{message}")


def test_lines_are_named_with_the_file(tmp_path: Path) -> None:
    path = tmp_path / "bad.obj"
    path.write_bytes(b"v 0 0 0\nf 1 2 3\n")
    with pytest.raises(MeshError) as caught:
        load_mesh(path)
    assert str(caught.value) == f"{path}: line 2: index 2 is out of range, there are 1 vertices"


def test_files_without_points_are_refused() -> None:
    with pytest.raises(MeshError, match="<file>: the file holds no points"):
        load_mesh(io.BytesIO(b"OFF 0 0 0\n"), file_type="off")
    with pytest.raises(MeshError, match="<file>: a mesh without points cannot be saved"):
        save_mesh(Mesh([]), io.BytesIO(), file_type="obj")


def test_the_system_speaks_for_itself(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        load_mesh(tmp_path / "none.obj")
    with pytest.raises(FileNotFoundError):
        save_mesh(samples.cube(), tmp_path / "none" / "a.obj")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(IsADirectoryError):
        save_mesh(samples.cube(), tmp_path / "folder.obj")


def test_a_failed_save_leaves_all_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.obj"
    path.write_bytes(b"before")

    def write(mesh: Mesh, file: Any) -> None:  # noqa: ARG001
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(registry.WRITERS, "obj", write)
    with pytest.raises(OSError, match="No space left"):
        save_mesh(samples.cube(), path)
    assert path.read_bytes() == b"before"
    assert os.listdir(tmp_path) == ["a.obj"]  # noqa: PTH208


@pytest.fixture
def mask() -> Iterator[int]:
    old = os.umask(0o027)
    yield 0o027
    os.umask(old)


def test_a_new_file_has_the_permissions_of_any(tmp_path: Path, mask: int) -> None:
    path = tmp_path / "a.obj"
    save_mesh(samples.cube(), path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask


@pytest.mark.parametrize("mode", [0o600, 0o664, 0o444])
def test_a_file_that_is_replaced_keeps_its_permissions_and_a_protected_one_stays(tmp_path: Path, mode: int) -> None:
    model, points = tmp_path / "a.obj", tmp_path / "a.npy"
    np.save(points, np.ones((3, 3), np.float32))
    model.touch()
    writers: dict[Path, Callable[[Path], None]] = {model: partial(save_mesh, samples.cube()), points: move_in_place}
    for path, write in writers.items():
        path.chmod(mode)
        before = path.read_bytes()
        if os.access(path, os.W_OK):  # for root, any
            write(path)
            assert path.read_bytes() != before
        else:
            with pytest.raises(PermissionError, match=path.name):
                write(path)
            assert path.read_bytes() == before
        assert stat.S_IMODE(path.stat().st_mode) == mode
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npy", "a.obj"]


def move_in_place(path: Path) -> None:
    gx.transform_file(path, path, gx.translate(1, 2, 3))


def test_a_link_stays_and_its_target_changes(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    target, link = tmp_path / "elsewhere" / "real.obj", tmp_path / "link.obj"
    target.write_bytes(b"before")
    link.symlink_to(target)
    save_mesh(samples.cube(), link)
    assert link.is_symlink()
    assert load_mesh(target) == samples.cube()
    assert [file.name for file in target.parent.iterdir()] == ["real.obj"]


def test_names_of_full_length_can_be_written(tmp_path: Path) -> None:
    path = tmp_path / ("n" * 251 + ".obj")
    save_mesh(samples.cube(), path)
    assert load_mesh(path) == samples.cube()


@pytest.mark.skipif(sys.platform == "win32", reason="no FIFO there")
def test_a_pipe_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with subprocess.Popen(["/bin/cat", pipe], stdout=subprocess.PIPE) as cat:
        save_mesh(samples.cube(), pipe, file_type="obj")
        assert cat.stdout is not None
        assert load_mesh(io.BytesIO(cat.stdout.read()), file_type="obj") == samples.cube()
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_atomic_write_of_bytes(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    with atomic_write(path) as file:
        file.write(b"picture")
        assert not path.exists()
    assert path.read_bytes() == b"picture"

    def interrupted() -> None:
        with atomic_write(path) as file:
            file.write(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_bytes() == b"picture"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("place", ["missing/cube.obj", "file/cube.obj"])
def test_an_error_of_the_system_names_the_path_of_the_caller(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("not a folder")
    with pytest.raises(OSError, match=place) as caught:
        save_mesh(samples.cube(), place)
    assert caught.value.filename == place
    assert isinstance(caught.value, FileNotFoundError | NotADirectoryError)


def test_a_missing_file_is_graver_than_a_wrong_suffix(tmp_path: Path) -> None:
    for read in (load_mesh, load_scene):
        with pytest.raises(FileNotFoundError, match=r"nope\.xyz"):
            read(tmp_path / "nope.xyz")
    (tmp_path / "there.xyz").write_bytes(b"x")
    with pytest.raises(MeshError, match="the type must be one of"):
        load_mesh(tmp_path / "there.xyz")


@pytest.mark.parametrize(("kind", "name"), [("stl", "STL"), ("glb", "glTF")])
def test_coordinates_far_from_the_origin_lose_digits_by_name(tmp_path: Path, kind: str, name: str) -> None:
    far = Mesh(np.eye(3) * 100 + (389000.123, 5400000.25, 0.0), [(0, 1, 2)])
    with pytest.warns(
        MeshWarning, match=rf"{name} does not hold all digits of coordinates, which change by up to 0\.25"
    ):
        save_mesh(far, tmp_path / f"far.{kind}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        save_mesh(Mesh(np.eye(3) * 0.1 + 0.3, [(0, 1, 2)]), tmp_path / f"near.{kind}")


def test_stl_refuses_a_cloud_without_a_list_of_what_else_it_would_lose(tmp_path: Path) -> None:
    cloud = Mesh(np.eye(3), attributes={"point": {"time": [1, 2, 3]}})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(MeshError, match="STL holds triangles only, this mesh has no faces"):
            save_mesh(cloud, tmp_path / "a.stl")
