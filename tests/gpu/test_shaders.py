import re
from pathlib import Path

import pytest

import gpu_xform
from gpu_xform.errors import DeviceError, ShaderError
from gpu_xform.gpu import shaders
from gpu_xform.gpu.device import Device

FOLDER = Path(str(shaders.shader_folder()))
STAGES = sorted(file.stem for file in FOLDER.glob("*.wgsl"))
SHARED = sorted(file.stem for file in (FOLDER / "shared").glob("*.wgsl"))
PACKAGE = Path(gpu_xform.__file__).parent


def test_the_shaders_are_where_the_package_looks() -> None:
    assert "transform_points_f32" in STAGES
    assert "ink_lines" in STAGES
    assert "homogeneous" in SHARED
    assert not [file for file in FOLDER.rglob("*") if file.is_file() and file.suffix != ".wgsl"]


def test_the_checkouts_shaders_are_found_where_the_package_holds_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.resources.files", lambda _: tmp_path / "gpu_xform")
    module = tmp_path / "gpu_xform" / "gpu" / "shaders.py"
    monkeypatch.setattr(shaders, "__file__", str(module))
    with pytest.raises(ShaderError, match="the installation is incomplete"):
        shaders.shader_folder()
    (tmp_path / "wgsl").mkdir()
    assert shaders.shader_folder() == tmp_path / "wgsl"
    (tmp_path / "gpu_xform" / "wgsl").mkdir(parents=True)
    assert shaders.shader_folder() == tmp_path / "gpu_xform" / "wgsl"


def entry_points(stage: str) -> list[str]:
    return re.findall(r"^@compute .*\nfn (\w+)\(", shaders.source(stage), re.MULTILINE)


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_compiles(stage: str, device: Device) -> None:
    chosen = dict.fromkeys(re.findall(r"^override (\w+)", shaders.source(stage), re.MULTILINE), 1.0)
    assert entry_points(stage) == ["main"]
    if "f64" in stage and not device.has_float64:
        with pytest.raises(ShaderError):
            device.pipelines.module(stage)
        return
    assert device.pipelines.compute(stage, **chosen)


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_is_used(stage: str) -> None:
    code = "".join(file.read_text("utf-8") for file in PACKAGE.rglob("*.py"))
    pattern = stage.removesuffix("_f32").removesuffix("_f64").removesuffix("_2d")
    assert re.search(rf'"{pattern}', code)


@pytest.mark.parametrize("name", SHARED)
def test_every_shared_file_is_imported(name: str) -> None:
    importers = [file for file in FOLDER.rglob("*.wgsl") if f"#import {name}\n" in file.read_text("utf-8")]
    assert importers


@pytest.mark.parametrize("stage", STAGES)
def test_every_line_reaches_the_device_as_it_stands_in_its_file(stage: str) -> None:
    resolved = shaders.source(stage).splitlines()
    lines = (FOLDER / f"{stage}.wgsl").read_text("utf-8").splitlines()
    own = [line for line in lines if not line.startswith("#import")]
    at = 0
    for line in own:
        at = resolved.index(line, at) + 1
    shared = [line for name in SHARED for line in (FOLDER / "shared" / f"{name}.wgsl").read_text("utf-8").splitlines()]
    assert set(resolved) <= {*own, *shared}
    assert not [line for line in resolved if line.startswith("#")]


@pytest.mark.parametrize("stage", STAGES)
def test_only_buffers_are_written_at_an_index(stage: str) -> None:
    """The compiler that Direct3D 12 has by default knows no other l-value with an index, such as a vector."""
    code = shaders.source(stage)
    buffers = set(re.findall(r"var<storage, read_write> (\w+):", code))
    assert set(re.findall(r"(\w+)\[[^\]]*\](?:\+\+|--| [-+*/]?= )", code)) <= buffers


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared" / "leaf.wgsl").write_text("const LEAF = 1;\n", "utf-8")
    (tmp_path / "shared" / "left.wgsl").write_text("#import leaf\nconst LEFT = LEAF;\n", "utf-8")
    (tmp_path / "shared" / "right.wgsl").write_text("#import leaf\nconst RIGHT = LEAF; // {not_a_template}\n", "utf-8")
    return tmp_path


def test_an_import_stands_in_its_place_and_only_once(folder: Path) -> None:
    (folder / "stage.wgsl").write_text(
        "const FIRST = 0;\n#import left\n#import right // why\nconst LAST = 2;\n", "utf-8"
    )
    assert shaders.resolve(folder, "stage").splitlines() == [
        "const FIRST = 0;",
        "const LEAF = 1;",
        "const LEFT = LEAF;",
        "const RIGHT = LEAF; // {not_a_template}",
        "const LAST = 2;",
    ]


def test_files_that_import_each_other_end(folder: Path) -> None:
    (folder / "shared" / "ping.wgsl").write_text("#import pong\nconst PING = 1;\n", "utf-8")
    (folder / "shared" / "pong.wgsl").write_text("#import ping\nconst PONG = 1;\n", "utf-8")
    (folder / "stage.wgsl").write_text("#import ping\n", "utf-8")
    assert shaders.resolve(folder, "stage").splitlines() == ["const PONG = 1;", "const PING = 1;"]


def test_an_unknown_import_names_the_file_and_the_line(folder: Path) -> None:
    (folder / "stage.wgsl").write_text("const FIRST = 0;\n\n#import trunk\n", "utf-8")
    with pytest.raises(ShaderError, match=r"^stage\.wgsl:3: no shared/trunk\.wgsl to import$"):
        shaders.resolve(folder, "stage")
    (folder / "shared" / "leaf.wgsl").write_text("// a leaf\n#import trunk\n", "utf-8")
    (folder / "stage.wgsl").write_text("#import left\n", "utf-8")
    with pytest.raises(ShaderError, match=r"^leaf\.wgsl:2: no shared/trunk\.wgsl to import$"):
        shaders.resolve(folder, "stage")


@pytest.mark.parametrize(
    "line", ["#include leaf", "#import", "#import ../stage", "#import leaf left", "#import leaf.wgsl"]
)
def test_another_directive_names_the_file_and_the_line(line: str, folder: Path) -> None:
    (folder / "stage.wgsl").write_text(f"\n{line}\n", "utf-8")
    with pytest.raises(ShaderError, match=rf"^stage\.wgsl:2: expected '#import name', got {re.escape(repr(line))}$"):
        shaders.resolve(folder, "stage")


def test_a_stage_without_a_file_is_a_shader_error(folder: Path) -> None:
    with pytest.raises(ShaderError, match=r"no absent\.wgsl in "):
        shaders.resolve(folder, "absent")
    with pytest.raises(ShaderError, match=r"no absent\.wgsl in "):
        shaders.source("absent")


def test_a_shader_that_does_not_compile_is_a_shader_error(monkeypatch: pytest.MonkeyPatch) -> None:
    with Device() as other:
        monkeypatch.setattr(shaders, "source", lambda _: "fn main() { let x: u32 = 1.5; }")
        with pytest.raises(ShaderError, match=r"^broken\.wgsl does not compile on Device\("):
            other.pipelines.module("broken")
        monkeypatch.setattr(shaders, "source", lambda _: "@compute @workgroup_size(1) fn main() {}")
        with pytest.raises(ShaderError, match=r"^plain\.wgsl with \{'missing': 1\.0\} is refused"):
            other.pipelines.compute("plain", missing=1.0)


def test_a_pipeline_is_compiled_once_for_each_choice_of_its_constants(device: Device) -> None:
    compute = device.pipelines.compute
    first = compute("transform_in_place_f32", workgroup_size=64, finish=1)
    assert compute("transform_in_place_f32", finish=1, workgroup_size=64) is first
    assert compute("transform_in_place_f32", workgroup_size=64, finish=0) is not first
    assert compute("transform_in_place_f32", workgroup_size=32, finish=1) is not first


def test_a_closed_device_compiles_nothing() -> None:
    with Device() as other:
        pass
    with pytest.raises(DeviceError, match="closed"):
        other.pipelines.compute("transform_in_place_f32", workgroup_size=64, finish=1)
