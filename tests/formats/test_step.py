"""STEP through cascadio: what comes back of files whose content is known, whatever their unit."""

import io
import itertools
import json
import re
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import FileLimits, Mesh, Scene, load_mesh, load_scene
from gpu_xform._core import limited_process
from gpu_xform.cli import main
from gpu_xform.errors import ArgumentError, MeshError, MeshWarning, MissingExtraError
from gpu_xform.formats import isolation, step, step_process
from gpu_xform.geometry.edges import find_edge_faces, resolve_edges
from tests.support import step_files
from tests.support.python_run import linux_only


def read(data: bytes, tolerance: float | None = None, limits: FileLimits | None = None) -> Mesh:
    return load_mesh(io.BytesIO(data), file_type="step", tolerance=tolerance, limits=limits)


@pytest.fixture(scope="module")
def assembly_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("step") / "assembly.stp"
    path.write_bytes(step_files.write_assembly())
    return path


@pytest.fixture(scope="module")
def assembly(assembly_file: Path) -> Scene:
    return load_scene(assembly_file)


@pytest.fixture(scope="module")
def cylinder() -> Mesh:
    return read(step_files.write_cylinder(2, 5))


@pytest.mark.parametrize("unit", [step_files.INCH, step_files.METRE])
def test_coordinates_are_those_of_the_file_whatever_its_unit(unit: tuple[str, ...]) -> None:
    mesh = read(step_files.write_box(1.1, 2.7, 3.5, unit=unit))
    corners = np.array(list(itertools.product((0, 1.1), (0, 2.7), (0, 3.5))))
    np.testing.assert_array_equal(np.unique(mesh.positions, axis=0), corners)
    assert mesh.n_faces == 12


def test_a_solid_is_closed_and_wound_outwards(cylinder: Mesh) -> None:
    found = find_edge_faces(cylinder)
    assert (found.n_faces == 2).all()
    assert not found.inconsistent_winding.any()
    a, b, c = cylinder.positions[np.asarray(cylinder.faces).T]
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert 0.97 < volume / (np.pi * 2**2 * 5) < 1.0


def test_feature_edges_are_those_of_the_faces_of_the_solid(cylinder: Mesh) -> None:
    edges = resolve_edges(cylinder, "feature", 179.0)
    # Two circles, and no seam.
    assert len(edges) == np.isin(cylinder.positions[:, 2], (0, 5)).sum()
    np.testing.assert_allclose(np.hypot(*cylinder.positions[np.unique(edges), :2].T), 2.0, rtol=1e-6)
    assert {*np.unique(cylinder.positions[edges, 2])} == {0.0, 5.0}
    box = read(step_files.write_box(1, 2, 3))
    assert len(resolve_edges(box, "feature")) == 12
    assert len(box.edges) == 18


def test_tolerance_is_kept_in_the_unit_of_the_file() -> None:
    """A ball of ten metres, in metres, to which the library gives 100,520 triangles at a tolerance of 1."""
    counts = []
    for tolerance in (1.0, 0.1):
        file = step_files.StepFile(step_files.METRE)
        file.product("ball", file.ball(10))
        mesh = read(file.text, tolerance)
        corners = mesh.positions[np.asarray(mesh.faces)]
        weights = np.array([(a, b, 1 - a - b) for a in np.linspace(0, 1, 7) for b in np.linspace(0, 1 - a, 7)])
        assert np.abs(np.linalg.norm(weights @ corners, axis=-1) - 10).max() < tolerance
        counts.append(mesh.n_faces)
    assert counts[0] < 1000 < counts[1] < 5000


def test_too_fine_a_tolerance_is_refused() -> None:
    with pytest.raises(ArgumentError, match=r"tolerance must be at least 2\.\d+e-06, a millionth of the size"):
        read(step_files.write_box(1, 1, 2), 1e-9)


def test_parts_stand_where_the_assembly_puts_them(assembly: Scene) -> None:
    names = {node.name: node.parent for node in assembly}
    assert names == {
        "assembly": None,
        "base": "assembly",
        "near": "assembly",
        "left": "near",
        "right": "near",
        "far": "assembly",
        "left 2": "far",
        "right 2": "far",
    }
    turned = np.array([(0, -1, 0, 30), (1, 0, 0, 20), (0, 0, 1, 5), (0, 0, 0, 1)])
    np.testing.assert_allclose(assembly.world("right 2"), turned, atol=1e-9)
    # Four bolts are one mesh.
    bolts = {id(shown.model) for name in ("left", "right", "left 2", "right 2") for shown in assembly[name].models}
    assert len(bolts) == 1
    assert assembly["left"].models[0].model.metadata["step"]["product"] == "bolt"
    assert assembly.metadata["step"] == {"unit": "millimetre", "metres": 0.001}


def test_colors_are_those_of_the_file(assembly: Scene) -> None:
    bolt = assembly["left"].models[0].model
    assert isinstance(bolt, Mesh)
    expected = np.round(255 * np.array((*step_files.RED, 1.0)))
    np.testing.assert_array_equal(np.asarray(bolt.attributes.face["color"]), np.tile(expected, (bolt.n_faces, 1)))
    # A part without a colour is white, so that `fill="file"` draws all.
    base = assembly["base"].models[0].model
    assert isinstance(base, Mesh)
    assert (np.asarray(base.attributes.face["color"]) == 255).all()


def test_a_part_without_a_name_of_its_own_has_that_of_its_product() -> None:
    data = step_files.write_assembly().replace(b"('left','left'", b"('NAUO7','NAUO7'")
    names = [node.name for node in load_scene(io.BytesIO(data), file_type="step")]
    assert names == ["assembly", "base", "near", "bolt", "right", "far", "bolt 2", "right 2"]


def test_a_picture_shows_the_edges_of_the_solid_and_its_outline() -> None:
    file = step_files.StepFile()
    file.product("ball", file.ball(1))
    mesh = read(file.text)
    lit = (gx.render_array(mesh, size=(64, 64), camera={"direction": (0.3, -1, -0.2)})[..., 0] < 128).sum()
    # An outline, of a ball that has no edge.
    assert 60 < lit < 400
    assert (gx.render_array(mesh, size=(64, 64), edges="all")[..., 0] < 128).sum() > 1000


def test_the_command_tells_moves_and_draws(
    assembly_file: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(["info", str(assembly_file)]) == 0
    told, warned = capfd.readouterr()
    assert re.search(r"nodes +8: assembly, base, near, left, right, far, left 2, right 2\n", told)
    assert re.search(r"units +millimetre\n", told)
    assert warned == ""
    moved = tmp_path / "moved.glb"
    assert main(["transform", str(assembly_file), str(moved), "--scale", "2"]) == 0
    np.testing.assert_allclose(load_mesh(moved).bounds[1], (80, 60, 34))
    picture = tmp_path / "picture.svg"
    assert main(["render", str(assembly_file), "-o", str(picture), "--fill", "file", "--hidden", "remove"]) == 0
    assert picture.read_text("utf-8").count("<path") > 4


def test_limits_hold_before_the_library_expands_an_assembly() -> None:
    file = step_files.StepFile()
    part = file.product("part", file.box(1, 1, 1))
    for level in range(12):
        above = file.product(f"level {level}")
        for i in range(10):
            file.place(part, above, str(i), (i * 10.0**level, 0, 0))
        part = above
    with pytest.raises(MeshError, match="its assembly: expands to more than 9,160 nodes"):
        read(file.text)
    for limits, message in (
        (FileLimits(nodes=5), r"expands to more than 5 nodes, the limit FileLimits\(nodes=5\)"),
        (FileLimits(depth=1), "its nodes are more than 1 deep"),
    ):
        with pytest.raises(MeshError, match=message):
            read(step_files.write_assembly(), limits=limits)
    with pytest.raises(MeshError, match=r"it has 12 faces, more than FileLimits\(faces=11\) allows"):
        read(step_files.write_box(1, 1, 1), limits=FileLimits(faces=11))


def test_an_assembly_within_itself_is_refused() -> None:
    file = step_files.StepFile()
    one, other = file.product("one", file.box(1, 1, 1)), file.product("other")
    file.place(one, other, "a", (0, 0, 0))
    file.place(other, one, "b", (0, 0, 0))
    with pytest.raises(MeshError, match="is a part of itself"):
        read(file.text)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits a process's memory")
def test_an_isolated_scene_is_the_same(assembly: Scene, assembly_file: Path) -> None:
    isolated = load_scene(assembly_file, isolated=True)
    assert [node.name for node in isolated] == [node.name for node in assembly]
    assert isolated["left"].models[0].model == assembly["left"].models[0].model
    assert isolated.metadata == assembly.metadata


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"solid cube", "it is not STEP"),
        (b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n", "Open CASCADE cannot read it"),
        (step_files.write_box(1, 1, 1)[:-2000], "Open CASCADE cannot read it"),
    ],
    ids=["another", "empty", "cut off"],
)
def test_damaged_files_are_errors_and_nothing_is_printed(
    data: bytes, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(MeshError, match=message):
        read(data)
    assert capfd.readouterr() == ("", "")


ENDS = {
    "a loop": (
        "while True: pass",
        FileLimits(cpu_s=0.1),
        "reading it takes more than 0.1 s of a processor, the limit {cpu}",
    ),
    "memory": (
        "bytearray(1 << 32)",
        FileLimits(memory_bytes=10**8),
        "reading it takes more than 100,000,000 bytes, the limit {memory}",
    ),
    "its own words": (
        "raise RuntimeError('Standard_MMgrRaw::Allocate(): malloc failed')",
        FileLimits(memory_bytes=10**8, cpu_s=9),
        "reading it takes more than 100,000,000 bytes, the limit {memory}",
    ),
    "a crash": ("os.abort()", FileLimits(cpu_s=9, memory_bytes=10**8), "Open CASCADE crashed (SIGABRT)"),
    "a crash for want of memory": (
        "x = bytearray(9 * 10**7), time.sleep(0.3), os.abort()",
        FileLimits(memory_bytes=10**8),
        "Open CASCADE crashed (SIGABRT) when it had taken ",  # about 90 MB: the program that is loaded may move it
    ),
    "killed": (
        "os.kill(os.getpid(), 9)",
        FileLimits(cpu_s=9),
        "Open CASCADE was killed, as a system does that lacks memory",
    ),
    "waiting": ("time.sleep(60)", FileLimits(cpu_s=0.1), "Open CASCADE did not end within 0.7 s"),
    "an error": ("raise RuntimeError", FileLimits(cpu_s=9, memory_bytes=10**8), "Open CASCADE cannot read it"),
    "nothing for want of memory": (
        "return b''",
        FileLimits(memory_bytes=10**7),
        "Open CASCADE cannot read it, maybe for want of memory: {memory} allows 10,000,000 bytes",
    ),
}


@linux_only
@pytest.mark.parametrize("name", ENDS)
def test_an_end_of_the_process_names_a_limit_only_if_it_was_hit(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    code, limits, message = ENDS[name]
    program, call = step_process._PROGRAM, "        return cascadio.load("
    assert program.count(call) == 1
    monkeypatch.setattr(step_process, "_PROGRAM", program.replace(call, f"        import time\n        {code}\n{call}"))
    monkeypatch.setattr(limited_process, "_WAIT_S", 0.5 if name == "waiting" else 60.0)
    with pytest.raises(MeshError) as raised:
        read(step_files.write_box(1, 1, 1), limits=limits)
    memory, cpu = "FileLimits(memory_bytes=...)", "FileLimits(cpu_s=...)"
    said, expected = str(raised.value), f"<file>: {message.format(memory=memory, cpu=cpu)}"
    assert said.startswith(expected)
    assert (said == expected) == (name != "a crash for want of memory")


@linux_only
def test_little_memory_does_not_make_it_wait_for_ever() -> None:
    """Below 350 MB, of which Open CASCADE took 200 before it began, it waited for a thread that never came."""
    box = step_files.write_box(1, 2, 3)
    assert read(box, limits=FileLimits(memory_bytes=60_000_000)) == read(box)


@linux_only
@pytest.mark.parametrize("memory_bytes", [7_000_000, 9_000_000, 9_500_000])
@pytest.mark.parametrize("isolated", [False, True])
def test_it_does_not_wait_for_threads_that_memory_is_too_small_for(memory_bytes: int, isolated: bool) -> None:
    """Below 10 MB, Open CASCADE waited for a thread that could not be begun, until its time was over."""
    box, begin = step_files.write_box(1, 2, 3), time.monotonic()
    limits = FileLimits(memory_bytes=memory_bytes, cpu_s=5)
    assert load_mesh(io.BytesIO(box), file_type="step", isolated=isolated, limits=limits) == read(box)
    assert time.monotonic() - begin < 20


@linux_only
@pytest.mark.parametrize("memory_bytes", [1, 500_000, 1_000_000])
@pytest.mark.parametrize("isolated", [False, True])
def test_too_little_memory_is_named(memory_bytes: int, isolated: bool) -> None:
    box, limits = step_files.write_box(1, 2, 3), FileLimits(memory_bytes=memory_bytes, cpu_s=5)
    with pytest.raises(MeshError, match=rf"\b{memory_bytes:,} bytes") as raised:
        load_mesh(io.BytesIO(box), file_type="step", isolated=isolated, limits=limits)
    assert "FileLimits(memory_bytes=...)" in str(raised.value)


@linux_only
def test_isolation_limits_the_process_of_open_cascade_too(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[FileLimits] = []

    def run(_: str, parts: list[bytes], *__: object, **___: object) -> limited_process.Ended:
        given.append(FileLimits(**json.loads(parts[0])["limits"]))
        return limited_process.Ended(3, b"", False, 0)

    monkeypatch.setattr(isolation, "run_limited", run)
    with pytest.raises(MeshError, match="ended with 3"):
        load_mesh(io.BytesIO(b"ISO-10303-21;"), file_type="step", isolated=True)
    assert given == [FileLimits(cpu_s=isolation.DEFAULT_CPU_S, memory_bytes=isolation.DEFAULT_MEMORY_BYTES)]


def test_without_the_extra_the_error_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gpu_xform.formats.step_process.find_spec", lambda _: None)
    with pytest.raises(MissingExtraError, match=r"pip install 'gpu_xform\[cad\]'"):
        read(step_files.write_box(1, 1, 1))


def test_parts_in_other_units_are_converted_with_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(step, "make_glb", lambda *_: (_ for _ in ()).throw(MeshError("enough")))
    data = step_files.write_box(1, 1, 1)
    other = (
        b"#900 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.) );\n#901 = ( GLOBAL_UNIT_ASSIGNED_CONTEXT((#900)) );"
    )
    with (
        pytest.warns(MeshWarning, match="parts in metre are converted to millimetre"),
        pytest.raises(MeshError, match="enough"),
    ):
        read(data.replace(b"ENDSEC;\nEND-", other + b"\nENDSEC;\nEND-"))
