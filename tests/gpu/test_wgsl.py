"""The WGSL files themselves, and how their imports are resolved."""

import re
from pathlib import Path

import pytest
import wgpu

from gpu_xform.errors import ShaderError
from gpu_xform.gpu import wgsl
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.wgsl import Origin, Sources
from tests.support.wgsl import FOLDER, STAGES, VARIANTS, source

FEW_ROUNDS = {"reduce_points.wgsl", "find_extremes.wgsl", "list_edges.wgsl"}  # whose invocations take many elements
SHARED = sorted(file.stem for file in (FOLDER / "shared").glob("*.wgsl"))


def test_the_shaders_are_where_the_package_looks() -> None:
    assert "transform_points" in STAGES
    assert "accumulate_lines" in STAGES
    assert "transform" in SHARED
    assert {file.name for file in FOLDER.rglob("*") if file.is_file() and file.suffix != ".wgsl"} == {"stages.toml"}


def test_the_checkouts_shaders_are_found_where_the_package_holds_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.resources.files", lambda _: tmp_path / "gpu_xform")
    module = tmp_path / "gpu_xform" / "gpu" / "wgsl.py"
    monkeypatch.setattr(wgsl, "__file__", str(module))
    with pytest.raises(ShaderError, match="the installation is incomplete"):
        wgsl.shader_folder()
    (tmp_path / "wgsl").mkdir()
    assert wgsl.shader_folder() == tmp_path / "wgsl"
    (tmp_path / "gpu_xform" / "wgsl").mkdir(parents=True)
    assert wgsl.shader_folder() == tmp_path / "gpu_xform" / "wgsl"


def test_every_shared_file_is_imported() -> None:
    code = "".join(file.read_text("utf-8") for file in FOLDER.rglob("*.wgsl"))
    for name in SHARED:
        imported = re.sub("real_f(32|64)", "real", name)
        assert f"#import {imported}\n" in code, name


def test_loops_over_the_work_of_an_invocation_end_with_their_test() -> None:
    for file in (file for file in FOLDER.rglob("*.wgsl") if file.name not in FEW_ROUNDS):
        # With its test at its start, lavapipe runs such a loop twice if there is work for one round.
        assert not re.search(r"for \(var \w+ = [^;]*invocation\.x", file.read_text("utf-8")), file


def entry_names(text: str) -> list[str]:
    """Return the names that a shared file says its entry declares."""
    found = re.search(r"^// Entry declares: (.*?)\.$", text, re.MULTILINE | re.DOTALL)
    return re.findall(r"\w+", found[1]) if found else []


def test_shared_files_bind_nothing_and_have_no_constants_of_the_hosts() -> None:
    for name in SHARED:
        text = (FOLDER / "shared" / f"{name}.wgsl").read_text("utf-8")
        assert not re.search(r"^(@|override|var)", text, re.MULTILINE), name


@pytest.mark.parametrize("name", SHARED)
def test_shared_files_have_no_free_names_but_those_that_they_say_their_entry_declares(
    name: str, device: GpuDevice
) -> None:
    """WGSL passes no storage buffer to a function: what reads one names it, and says so in the file's first lines."""
    file = f"shared/{name}.wgsl"
    names = entry_names((FOLDER / file).read_text("utf-8"))
    number_type = "f64" if name.endswith("f64") else "f32"
    stages = [stage for stage in STAGES if any(origin.file == file for origin in source(stage).origins)]
    entries = [(FOLDER / STAGES[stage].file).read_text("utf-8") for stage in stages]
    declarations = {
        own: re.findall(rf"^(?:@.* var(?:<.*>)? |override ){own}:.*;", entry, re.MULTILINE)
        for entry in entries
        for own in names
    }
    assert all(len(found) == 1 for found in declarations.values())
    for entry in entries:
        assert all(re.search(rf"^(?:@.* var(?:<.*>)? |override ){own}:", entry, re.MULTILINE) for own in names)
    code = wgsl.resolve(FOLDER, file, number_type).code
    own_lines = {own: line for own, [line] in declarations.items()}
    compiles = device.context.handle.create_shader_module
    compiles(code="\n".join([*own_lines.values(), code]))
    for own in names:
        with pytest.raises(wgpu.GPUError, match=own):
            compiles(code="\n".join([line for other, line in own_lines.items() if other != own] + [code]))


def test_lines_are_as_short_as_those_of_python() -> None:
    for file in FOLDER.rglob("*.wgsl"):
        assert max(map(len, file.read_text("utf-8").splitlines())) <= 120, file


def test_every_line_reaches_the_device_as_it_stands_in_its_file() -> None:
    files = {
        path.relative_to(FOLDER).as_posix(): path.read_text("utf-8").splitlines() for path in FOLDER.rglob("*.wgsl")
    }
    for stage, number_type in VARIANTS:
        resolved = source(stage, number_type)
        lines = resolved.code.splitlines()
        assert not [line for line in lines if line.startswith("#")], stage
        own_file = STAGES[stage].file
        own = [line for line, origin in zip(lines, resolved.origins, strict=True) if origin.file == own_file]
        assert own == [line for line in files[own_file] if not line.startswith("#")], stage
        assert lines == [files[file][number - 1] for file, number in resolved.origins], stage


def test_only_buffers_are_written_at_an_index() -> None:
    """The compiler that Direct3D 12 has by default knows no other l-value with an index, such as a vector."""
    for stage, number_type in VARIANTS:
        code = source(stage, number_type).code
        buffers = set(re.findall(r"var<storage, read_write> (\w+):", code))
        assert set(re.findall(r"(?<![\w.])(\w+)(?:\.\w+)*\[.*\](?:\+\+|--| [-+*/]?= )", code)) <= buffers, stage


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared" / "leaf.wgsl").write_text("const LEAF = 1;\n", "utf-8")
    (tmp_path / "shared" / "left.wgsl").write_text("#import leaf\nconst LEFT = LEAF;\n", "utf-8")
    (tmp_path / "shared" / "right.wgsl").write_text("#import leaf\nconst RIGHT = LEAF; // {not_a_template}\n", "utf-8")
    return tmp_path


def resolved_lines(folder: Path, number_type: str | None = None) -> list[str]:
    return wgsl.resolve(folder, "stage.wgsl", number_type).code.splitlines()


def test_an_import_stands_in_its_place_and_only_once(folder: Path) -> None:
    (folder / "stage.wgsl").write_text(
        "const FIRST = 0;\n#import left\n#import right // why\nconst LAST = 2;\n", "utf-8"
    )
    assert resolved_lines(folder) == [
        "const FIRST = 0;",
        "const LEAF = 1;",
        "const LEFT = LEAF;",
        "const RIGHT = LEAF; // {not_a_template}",
        "const LAST = 2;",
    ]


def test_every_line_knows_where_it_stands(folder: Path) -> None:
    (folder / "stage.wgsl").write_text(
        "const FIRST = 0;\n#import left\n#import right // why\nconst LAST = 2;\n", "utf-8"
    )
    assert wgsl.resolve(folder, "stage.wgsl").origins == (
        Origin("stage.wgsl", 1),
        Origin("shared/leaf.wgsl", 1),
        Origin("shared/left.wgsl", 2),
        Origin("shared/right.wgsl", 2),
        Origin("stage.wgsl", 4),
    )


def test_the_number_type_chooses_what_real_stands_for(folder: Path) -> None:
    (folder / "stage.wgsl").write_text("#import real\n#import left\n", "utf-8")
    (folder / "shared" / "left.wgsl").write_text("#import real\nconst LEFT = 1;\n", "utf-8")
    (folder / "shared" / "real_f32.wgsl").write_text("alias Real = f32;\n", "utf-8")
    (folder / "shared" / "real_f64.wgsl").write_text("alias Real = f64;\n", "utf-8")
    assert resolved_lines(folder, "f32") == ["alias Real = f32;", "const LEFT = 1;"]
    assert resolved_lines(folder, "f64") == ["alias Real = f64;", "const LEFT = 1;"]
    with pytest.raises(ShaderError, match=r"^stage\.wgsl:1: no shared/real\.wgsl to import$"):
        resolved_lines(folder)


def test_files_that_import_each_other_end(folder: Path) -> None:
    (folder / "shared" / "ping.wgsl").write_text("#import pong\nconst PING = 1;\n", "utf-8")
    (folder / "shared" / "pong.wgsl").write_text("#import ping\nconst PONG = 1;\n", "utf-8")
    (folder / "stage.wgsl").write_text("#import ping\n", "utf-8")
    assert resolved_lines(folder) == ["const PONG = 1;", "const PING = 1;"]


def test_an_unknown_import_names_the_file_and_the_line(folder: Path) -> None:
    (folder / "stage.wgsl").write_text("const FIRST = 0;\n\n#import trunk\n", "utf-8")
    with pytest.raises(ShaderError, match=r"^stage\.wgsl:3: no shared/trunk\.wgsl to import$"):
        resolved_lines(folder)
    (folder / "shared" / "leaf.wgsl").write_text("// a leaf\n#import trunk\n", "utf-8")
    (folder / "stage.wgsl").write_text("#import left\n", "utf-8")
    with pytest.raises(ShaderError, match=r"^shared/leaf\.wgsl:2: no shared/trunk\.wgsl to import$"):
        resolved_lines(folder)


@pytest.mark.parametrize(
    "line", ["#include leaf", "#import", "#import ../stage", "#import leaf left", "#import leaf.wgsl"]
)
def test_another_directive_names_the_file_and_the_line(line: str, folder: Path) -> None:
    (folder / "stage.wgsl").write_text(f"\n{line}\n", "utf-8")
    with pytest.raises(ShaderError, match=rf"^stage\.wgsl:2: expected '#import name', got {re.escape(repr(line))}$"):
        resolved_lines(folder)


def test_a_stage_without_a_file_or_a_row_is_a_shader_error(folder: Path) -> None:
    (folder / "stages.toml").write_text('[lost]\nfile = "lost.wgsl"\n')
    with pytest.raises(ShaderError, match=r"^no lost\.wgsl in "):
        Sources(folder).source("lost")
    with pytest.raises(ShaderError, match=r"^no stage 'absent' in the table of "):
        Sources(folder).source("absent")


def test_a_number_type_must_be_one_of_the_stages() -> None:
    with pytest.raises(ShaderError, match=r"^number type of stage 'self_test' must be none, got f32$"):
        source("self_test", "f32")
    with pytest.raises(ShaderError, match=r"^number type of stage 'reduce_points' must be f32 or f64, got f16$"):
        source("reduce_points", "f16")


def test_bindings_are_read_by_name(folder: Path) -> None:
    (folder / "stage.wgsl").write_text(
        """#import left
@group(0) @binding(2) var<storage, read> points: array<vec4<f32>>; // packed
@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(7) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(5) var picture: texture_2d<f32>;
// @group(0) @binding(9) var<uniform> nothing: Tile;
var<private> own: u32;
""",
        "utf-8",
    )
    assert wgsl.resolve(folder, "stage.wgsl").bindings == {"points": 2, "tile": 0, "counts": 7, "picture": 5}


def test_every_binding_of_a_stage_has_a_name_and_a_number_of_its_own() -> None:
    for stage, number_type in VARIANTS:
        resolved = source(stage, number_type)
        assert len(resolved.bindings) == resolved.code.count("@binding("), stage
        assert len(set(resolved.bindings.values())) == len(resolved.bindings), stage
