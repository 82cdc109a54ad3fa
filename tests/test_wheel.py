"""The wheel and the source archive: they hold what they should, and the wheel works without the source tree."""

import json
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parent.parent
SHADERS = {path.relative_to(ROOT / "wgsl").as_posix() for path in (ROOT / "wgsl").rglob("*") if path.is_file()}
SOURCES = [path for folder in ("gpu_xform", "gpu_xform_command") for path in (ROOT / folder).rglob("*.*")]
MODULES = {path.relative_to(ROOT).as_posix() for path in SOURCES if path.suffix in (".py", ".html", ".css", ".js")}

# Nothing of the checkout is on the path: -I leaves out the working folder, -S the .pth file of an editable install.
USE = """
import json, sys
sys.path += sys.argv[1:]
import numpy as np
import gpu_xform as gx
from gpu_xform.gpu import wgsl
points = np.arange(30.0).reshape(10, 3)
moved = gx.transform_points(points, gx.translate(1, 2, 3))
picture = gx.render(gx.samples.cube(), size=(64, 64))
picture.save("cube.png")
print(json.dumps({
    "file": gx.__file__,
    "version": gx.__version__,
    "shaders": str(wgsl.shader_folder()),
    "moved": (moved - points).tolist(),
    "dark": sum(picture.convert("L").point(lambda v: v < 64, "1").histogram()[1:]),
}))
"""


def run(*command: str | Path, cwd: Path) -> str:
    ran = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=300, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


def build_wheel(source: Path, target: Path) -> Path:
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-index", "--no-deps", "--no-build-isolation"]
    run(*pip, "--wheel-dir", target, source, cwd=target)
    [wheel] = target.glob("*.whl")
    return wheel


def names_in(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return {name for name in archive.namelist() if ".dist-info/" not in name}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_wheel(ROOT, tmp_path_factory.mktemp("wheel"))


@pytest.mark.slow
def test_the_wheel_works_without_the_source_tree(wheel: Path, tmp_path: Path) -> None:
    installed, elsewhere = tmp_path / "installed", tmp_path / "elsewhere"
    elsewhere.mkdir()
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps"]
    run(*pip, "--target", installed, wheel, cwd=elsewhere)
    libraries = dict.fromkeys(sysconfig.get_path(name) for name in ("purelib", "platlib"))
    found: dict[str, Any] = json.loads(
        run(sys.executable, "-I", "-S", "-W", "error", "-c", USE, installed, *libraries, cwd=elsewhere)
    )
    assert Path(found["file"]) == installed / "gpu_xform" / "__init__.py"
    assert Path(found["shaders"]) == installed / "gpu_xform" / "wgsl"
    assert found["moved"] == [[1, 2, 3]] * 10
    assert found["dark"] > 100
    assert (elsewhere / "cube.png").read_bytes().startswith(b"\x89PNG")
    assert wheel.name == f"gpu_xform-{found['version']}-py3-none-any.whl"


@pytest.mark.slow
def test_the_wheel_holds_the_package_the_shaders_and_nothing_else(wheel: Path) -> None:
    assert SHADERS
    assert names_in(wheel) == MODULES | {"gpu_xform/py.typed"} | {f"gpu_xform/wgsl/{name}" for name in SHADERS}
    with zipfile.ZipFile(wheel) as archive:
        [licence] = [name for name in archive.namelist() if name.endswith(".dist-info/licenses/LICENSE")]
        assert archive.read(licence) == (ROOT / "LICENSE").read_bytes()
        for name in SHADERS:
            assert archive.read(f"gpu_xform/wgsl/{name}") == (ROOT / "wgsl" / name).read_bytes()


@pytest.mark.slow
def test_the_source_archive_builds_the_same_wheel(wheel: Path, tmp_path: Path) -> None:
    run(sys.executable, "-m", "hatchling", "build", "--target", "sdist", "--directory", tmp_path, cwd=ROOT)
    [archive] = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as files:
        tree = archive.name.removesuffix(".tar.gz")
        held = {name.removeprefix(f"{tree}/wgsl/") for name in files.getnames() if name.startswith(f"{tree}/wgsl/")}
        assert held == SHADERS
        for name in ("README.md", "CHANGELOG.md", "LICENSE", "Makefile", "docs/conventions.md", "examples/demo.py"):
            member = files.extractfile(f"{tree}/{name}")
            assert member is not None
            assert member.read() == (ROOT / name).read_bytes()
    assert names_in(build_wheel(archive, tmp_path)) == names_in(wheel)
