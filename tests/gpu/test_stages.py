import re
from pathlib import Path

import pytest

import gpu_xform
from gpu_xform.errors import ShaderError
from gpu_xform.gpu.stages import read_stages
from tests.support.wgsl import FOLDER, STAGES, VARIANTS, source

PACKAGE = Path(gpu_xform.__file__).parent
OVERRIDE = re.compile(r"^override (\w+): (\w+)", re.MULTILINE)


def test_the_table_has_a_row_for_every_file_that_is_not_shared() -> None:
    files = {file.relative_to(FOLDER).as_posix() for file in FOLDER.rglob("*.wgsl") if file.parent.name != "shared"}
    assert {stage.file for stage in STAGES.values()} == files
    assert len(STAGES) == len(files)


@pytest.mark.parametrize("name", STAGES)
def test_a_stage_is_called_as_its_file_is(name: str) -> None:
    assert Path(STAGES[name].file).stem == name


@pytest.mark.parametrize("name", STAGES)
def test_the_table_has_the_constants_of_the_files(name: str) -> None:
    in_files = {(constant, kind) for constant, kind in OVERRIDE.findall(source(name).code)}
    assert {(constant, kind) for kind, names in STAGES[name].overrides.items() for constant in names} == in_files
    assert set(STAGES[name].values) <= set(STAGES[name].overrides.get("u32", ()))


@pytest.mark.parametrize("name", STAGES)
def test_the_table_has_number_types_for_the_stages_that_import_one(name: str) -> None:
    shared = {file: (FOLDER / "shared" / file).read_text("utf-8") for file in ("real_f32.wgsl", "real_f64.wgsl")}
    imports_real = any(f"alias Real = {kind};" in source(name).code for kind in ("f32", "f64"))
    assert bool(STAGES[name].number_types) == imports_real
    assert {f"real_{number_type}.wgsl" for number_type in STAGES[name].number_types} <= set(shared)


@pytest.mark.parametrize(("name", "number_type"), VARIANTS)
def test_the_table_has_the_entry_points_of_the_files(name: str, number_type: str | None) -> None:
    found = re.findall(r"^@(compute|vertex|fragment)\b.*\s*fn (\w+)\(", source(name, number_type).code, re.MULTILINE)
    assert dict(found) == dict(STAGES[name].entry_points)


@pytest.mark.parametrize("name", STAGES)
def test_every_stage_is_used(name: str) -> None:
    code = "".join(file.read_text("utf-8") for file in PACKAGE.rglob("*.py"))
    assert f'"{name}"' in code


def test_a_stage_can_have_a_vertex_and_a_fragment_entry_point(tmp_path: Path) -> None:
    (tmp_path / "stages.toml").write_text(
        '[wide]\nfile = "wide.wgsl"\nentry_points = { vertex = "expand", fragment = "shade" }\noverrides.bool = ["a"]\n'
    )
    stage = read_stages(tmp_path)["wide"]
    assert stage.entry_points == {"vertex": "expand", "fragment": "shade"}
    assert stage.overrides == {"bool": ("a",)}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("[stage]\nfiel = 'a.wgsl'\n", "unexpected keyword argument 'fiel'"),
        ("[stage]\n", "missing 1 required positional argument: 'file'"),
        ("[stage\n", "at line 1"),
        ("file = 'a.wgsl'\n", "'str' object has no attribute 'get'"),
    ],
)
def test_a_malformed_table_is_a_shader_error(table: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "stages.toml").write_text(table)
    with pytest.raises(ShaderError, match=rf"stages\.toml: .*{re.escape(message)}"):
        read_stages(tmp_path)


def test_a_folder_without_a_table_is_a_shader_error(tmp_path: Path) -> None:
    with pytest.raises(ShaderError, match=r"^no stages\.toml in "):
        read_stages(tmp_path)
