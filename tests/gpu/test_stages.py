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


def test_a_stage_is_called_as_its_file_is() -> None:
    for name in STAGES:
        assert Path(STAGES[name].file).stem == name, name


def test_the_table_has_the_constants_of_the_files() -> None:
    for name in STAGES:
        in_file = {(constant, kind) for constant, kind in OVERRIDE.findall(source(name).code)}
        in_table = {(constant, kind) for kind, names in STAGES[name].overrides.items() for constant in names}
        assert in_table == in_file, name
        assert set(STAGES[name].values) <= set(STAGES[name].overrides.get("u32", ())), name


def test_the_table_has_number_types_for_the_stages_that_import_one() -> None:
    for name in STAGES:
        imports_real = any(f"alias Real = {kind};" in source(name).code for kind in ("f32", "f64"))
        assert bool(STAGES[name].number_types) == imports_real, name
        assert {f"real_{number_type}" for number_type in STAGES[name].number_types} <= {"real_f32", "real_f64"}, name


def test_the_table_has_the_entry_points_of_the_files() -> None:
    for name, number_type in VARIANTS:
        found = re.findall(
            r"^@(compute|vertex|fragment)\b.*\s*fn (\w+)\(", source(name, number_type).code, re.MULTILINE
        )
        assert dict(found) == dict(STAGES[name].entry_points), name


def test_every_stage_is_used() -> None:
    code = "".join(file.read_text("utf-8") for file in PACKAGE.rglob("*.py"))
    for name in STAGES:
        assert f'"{name}"' in code, name


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
