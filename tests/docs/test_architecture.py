"""ARCHITECTURE.md names files that exist; tests/test_package.py holds its table of folders."""

import re
import tomllib
from pathlib import Path

import gpu_xform

PACKAGE = Path(gpu_xform.__file__).parent
ROOT = PACKAGE.parent
PAGE = (ROOT / "ARCHITECTURE.md").read_text("utf-8")
PATHS = sorted({word for word in re.findall(r"`([\w./]+)`", PAGE) if "/" in word or word.endswith((".py", ".toml"))})


def find(path: str) -> Path | None:
    """Return what a path of the page leads to, from the top of the repository or from the package."""
    return next((folder / path for folder in (ROOT, PACKAGE) if (folder / path).exists()), None)


def test_a_path_on_the_page_exists() -> None:
    for path in PATHS:
        assert find(path) is not None, path


def test_the_page_names_most_modules_of_the_walks() -> None:
    assert len(PATHS) > 50
    for folder in ("compute", "drawing", "gpu", "raster", "vector", "rendering"):
        assert any(path.startswith(f"{folder}/") for path in PATHS), folder


def test_every_task_has_a_file_to_start_at() -> None:
    section = PAGE.split("\n## Where to look\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (?!task|-)(.+?) +\| (.+?) +\|$", section, re.MULTILINE)
    assert len(rows) >= 10
    for task, files in rows:
        paths = [path for path in re.findall(r"`([\w./]+)`", files) if "/" in path]
        assert paths, task
        assert all(path in PATHS for path in paths)


def test_the_page_says_why_packages_that_are_imported_late_are_required() -> None:
    section = PAGE.split("\n## Dependencies\n")[1].split("\n## ")[0]
    required = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["dependencies"]
    names = {re.split("[<>=]", requirement)[0] for requirement in required}
    assert set(re.findall(r"`(\w+)` (?:parses|has|triangulates|shows)", section)) == names - {
        *("numpy", "pillow", "trimesh", "wgpu")
    }


def test_the_page_is_one_page() -> None:
    assert PAGE.count("\n") <= 145
