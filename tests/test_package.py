"""What the package promises as a whole: its names, what it imports and when, and which way its imports run."""

import ast
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import gpu_xform
from gpu_xform import errors

ROOT = Path(gpu_xform.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))

MATRICES = [
    *("identity", "scale", "translate", "rotate", "rotate_x", "rotate_y", "rotate_z", "reflect", "shear"),
    *("project_onto", "homogeneous", "perspective_from_eye", "perspective", "orthographic", "look_at"),
    *("chain", "inverse", "decompose", "explain"),
]
ERRORS = [
    name
    for name, value in vars(errors).items()
    if inspect.isclass(value) and issubclass(value, Exception) and not name.startswith("_")
]
DOCUMENTED = {
    *MATRICES,
    *ERRORS,
    *("matrices", "planar", "samples", "Mesh", "load_mesh", "save_mesh", "Camera", "render", "render_array"),
    *("transform_points", "transform_vectors", "transform_normals", "project_points", "Device", "adapters"),
    *("animate", "turntable", "Animation", "SizeWarning", "MeshWarning", "SimulationWarning"),
    *(
        "MeshBuffer",
        "PointBuffer",
        "bounds",
        "transform_file",
        "PrecisionWarning",
        "Scene",
        "load_scene",
        "compare_images",
    ),
    *(
        "FileLimits",
        "Layer",
        "render_svg",
        "SvgText",
        "render_pdf",
        "view",
        "save_page",
        "default_device",
        "Attributes",
        "RaggedArray",
        "bezier",
        "curve",
    ),
    *("Springs", "Trajectory", "Sphere", "HalfSpace", "Capsule", "Box", "Strands", "ChildStrands"),
    *("parametric", "subdivide", "Subdivision", "bspline_to_bezier"),
    *("dask",),
    *("convolve", "correlate", "gaussian", "box_kernel", "sobel_kernel"),
}


def test_the_public_names_are_the_documented_ones() -> None:
    assert set(gpu_xform.__all__) == DOCUMENTED
    assert gpu_xform.__all__ == sorted(gpu_xform.__all__)
    assert len(gpu_xform.__all__) == len(DOCUMENTED)


def test_every_public_name_is_there_and_documented() -> None:
    for name in sorted(DOCUMENTED):
        value = getattr(gpu_xform, name)
        assert inspect.getdoc(value), name
        assert name in dir(gpu_xform), name
        assert getattr(gpu_xform, name) is value, name
        if not inspect.ismodule(value):
            assert value.__name__ == name, name


def test_the_matrices_and_their_module_are_the_same() -> None:
    for name in MATRICES:
        assert getattr(gpu_xform, name) is getattr(gpu_xform.matrices, name)


def test_another_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match=r"^module 'gpu_xform' has no attribute 'transfrom_points'$"):
        gpu_xform.transfrom_points  # type: ignore[attr-defined]  # noqa: B018


WARNINGS = {
    "ChunkWarning",
    "DeviceWarning",
    "MeshWarning",
    "PrecisionWarning",
    "SimulationWarning",
    "SizeWarning",
    "TextWarning",
}


def test_every_error_is_one_of_ours_and_what_python_users_expect() -> None:
    bases = {
        "ArgumentError": ValueError,
        "ArgumentTypeError": TypeError,
        "SingularMatrixError": errors.ArgumentError,
        "MeshError": ValueError,
        "MissingExtraError": ImportError,
        "DisplayError": RuntimeError,
        "PrecisionError": ValueError,
        "NoAdapterError": RuntimeError,
        "DeviceError": RuntimeError,
        "DeviceMemoryError": MemoryError,
        "ShaderError": RuntimeError,
        "SimulationError": RuntimeError,
    }
    assert {*bases, "GpuXformError", *WARNINGS} == set(ERRORS)
    for name, base in bases.items():
        assert issubclass(getattr(errors, name), base)
        assert issubclass(getattr(errors, name), errors.GpuXformError)


def loaded_after(statement: str) -> set[str]:
    code = f"import sys; before = set(sys.modules); {statement}; print(*sorted(set(sys.modules) - before))"
    result = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert result.stderr == ""
    return set(result.stdout.split())


HEAVY = {
    *("wgpu", "trimesh", "PIL", "plyfile", "scipy", "cffi", "mapbox_earcut", "cmap", "matplotlib", "av"),
    *("pydyf", "rendercanvas", "glfw", "DracoPy", "meshopt", "laspy", "lazrs", "zarr", "dask", "distributed"),
}


def test_importing_the_package_loads_nothing_heavy() -> None:
    loaded = loaded_after("import gpu_xform")
    assert not loaded & {*HEAVY, "numpy"}
    moved = {f"gpu_xform.{name}" for name in gpu_xform._MOVED_MODULES}
    ours = {name for name in loaded if name.startswith("gpu_xform")}
    assert ours == {"gpu_xform", "gpu_xform._core", "gpu_xform._core.moved_module", *moved}


def test_a_public_name_is_imported_when_it_is_first_used() -> None:
    assert "gpu_xform.errors" in loaded_after("import gpu_xform; gpu_xform.errors.MeshError")
    assert "gpu_xform.matrices" in loaded_after("import gpu_xform as gx; gx.matrices.identity()")
    assert not loaded_after("from gpu_xform import Mesh, Scene, planar, samples, rotate_x") & HEAVY


def test_type_checkers_see_the_names_that_are_imported_late() -> None:
    tree = ast.parse((ROOT / "__init__.py").read_text("utf-8"))
    seen = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            for alias in node.names:
                if alias.asname is not None:
                    assert alias.name == alias.asname
                    seen[alias.name] = node.module or alias.name
    assert seen == gpu_xform._MODULES


def test_what_needs_no_device_and_no_file_loads_neither_wgpu_nor_trimesh() -> None:
    use = "import gpu_xform as g; g.Camera.fit(g.samples.cube().transformed(g.rotate_x(1))); g.explain(g.scale(2))"
    assert not loaded_after(use) & HEAVY


@pytest.mark.slow
def test_transforming_points_loads_neither_pillow_nor_trimesh() -> None:
    use = "import gpu_xform as g; g.transform_points([[1, 2, 3]], g.scale(2))"
    loaded = loaded_after(use)
    assert "wgpu" in loaded
    assert not loaded & HEAVY - {"wgpu", "cffi"}


def test_a_colormap_is_found_without_matplotlib_and_without_a_word() -> None:
    use = "from gpu_xform.imaging.colormaps import apply_colormap; apply_colormap([0, 1], 'coolwarm', None, 2)"
    assert loaded_after(use) & HEAVY == {"cmap"}


@cache
def imports(file: Path, *, type_checking: bool) -> tuple[str, ...]:
    """Return the dotted name of every module that a file imports, at its top or later."""
    return tuple(_find_imports(file, type_checking))


def _find_imports(file: Path, type_checking: bool) -> Iterator[str]:
    package = ("gpu_xform", *file.relative_to(ROOT).parent.parts)
    waiting: list[ast.AST] = [ast.parse(file.read_text("utf-8"))]
    while waiting:
        node = waiting.pop()
        if not type_checking and isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        waiting.extend(ast.iter_child_nodes(node))
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            source = ".".join([*base, *(node.module.split(".") if node.module else ())])
            yield from (f"{source}.{alias.name}" for alias in node.names)


def module_name(file: Path) -> str:
    """Return the dotted name of a file; of a folder's `__init__.py`, that of the folder with `.__init__` behind it."""
    return ".".join(("gpu_xform", *file.relative_to(ROOT).with_suffix("").parts))


def members(folder: Path) -> set[str]:
    """Return the modules and the folders of modules that lie directly in a folder, without its `__init__`."""
    files = {path.stem for path in folder.glob("*.py")} - {"__init__"}
    return files | {path.parent.name for path in folder.glob("*/__init__.py")}


def rows_of_the_architecture_page() -> list[list[str]]:
    """Return the (band, folder) pairs of ARCHITECTURE.md's table, from the top."""
    page = (ROOT.parent / "ARCHITECTURE.md").read_text("utf-8")
    table = re.findall(r"^\| ([\w ]*?) *\| `(\w+)` *\|", page, flags=re.MULTILINE)
    return [list(row) for row in table]


def reading_order(folder: Path) -> list[str]:
    """Return the members of a folder in the order in which they are read, each importing from earlier ones only."""
    if folder == ROOT:
        return [name for _, name in rows_of_the_architecture_page()]
    docstring = ast.get_docstring(ast.parse((folder / "__init__.py").read_text("utf-8"))) or ""
    found = re.search(r"^Reading order: ([^.]*)\.", docstring, flags=re.MULTILINE)
    return re.split(r",\s+", found[1]) if found else []


FOLDERS = sorted({path.parent for path in ROOT.rglob("__init__.py")})


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_every_module_has_one_place_in_the_reading_order(folder: Path) -> None:
    order = reading_order(folder)
    assert len(order) == len(set(order))
    expected = members(folder) | ({"__init__"} if folder == ROOT else set())
    if len(expected) > 1:
        assert set(order) == expected


def test_the_architecture_page_has_six_bands() -> None:
    bands = [band for band, _ in rows_of_the_architecture_page() if band]
    assert bands == ["foundation", "data", "device", "numbers", "pictures", "application"]


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_imports_run_one_way(folder: Path) -> None:
    """Of two members of a folder only the later one imports from the earlier; of a folder's `__init__`, nobody in it.

    Imports under `TYPE_CHECKING` and inside functions count as all others do.
    """
    ranks = {name: rank for rank, name in enumerate(reading_order(folder))}
    prefix = module_name(folder / "__init__.py").removesuffix("__init__")
    for member in sorted(members(folder)):
        path = folder / member
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path.with_suffix(".py")]:
            for name in imports(file, type_checking=True):
                if not name.startswith(prefix):
                    continue
                other = name.removeprefix(prefix).split(".")[0]
                if other not in members(folder):  # a name that the folder's __init__ has
                    other = "__init__"
                if other != member:
                    assert other in ranks, f"{module_name(file)} imports {name} from the folder that it lies in"
                    assert ranks[other] < ranks[member], f"{module_name(file)} imports {name}"


def test_no_folder_or_module_is_called_as_a_public_function_is() -> None:
    functions = {name for name in gpu_xform.__all__ if inspect.isfunction(getattr(gpu_xform, name))}
    assert not members(ROOT) & functions


def test_only_these_modules_lie_loose_at_the_top() -> None:
    assert {path.stem for path in ROOT.glob("*.py")} == {
        "__init__",
        "__main__",
        "dask",
        "device",
        "errors",
        "host",
        "planar",
    }


def test_no_models_and_pictures_lie_loose_beside_the_package() -> None:
    """Tests and examples that write into the folder they run in have left some there."""
    suffixes = {path.suffix for path in ROOT.parent.iterdir() if path.is_file()}
    assert suffixes <= {"", ".md", ".toml", ".yaml", ".yml"}


def test_only_the_gpu_folder_imports_wgpu() -> None:
    for file in FILES:
        names = {name.split(".")[0] for name in imports(file, type_checking=True)}
        assert ("wgpu" in names) <= (file.parent == ROOT / "gpu"), file


PURE = ["errors", "_core", "matrices", "planar", "geometry", "surfaces", "samples", "imaging"]
IMPORTED_LATE = {
    "_core": {"tqdm"},
    "geometry": {"trimesh", "mapbox_earcut"},
    "surfaces": {"scipy"},
    "imaging": {"PIL", "cmap"},
}


@pytest.mark.slow
def test_only_the_window_and_the_widget_import_what_shows_them() -> None:
    places = {ROOT / "viewer" / "window.py", ROOT / "viewer" / "notebook.py"}
    for file in FILES:
        names = {name.split(".")[0] for name in imports(file, type_checking=True)}
        assert bool(names & {"rendercanvas", "glfw"}) == (file in places), file


def test_the_pure_modules_need_numpy_alone() -> None:
    for name in PURE:
        path = ROOT / name
        for file in sorted(path.glob("*.py")) if path.is_dir() else [path.with_suffix(".py")]:
            used = {module.split(".")[0] for module in imports(file, type_checking=False)}
            foreign = used - set(sys.stdlib_module_names) - {"numpy", "gpu_xform"}
            assert foreign <= IMPORTED_LATE.get(name, set())
            assert not [module for module in imports(file, type_checking=True) if module.startswith("gpu_xform.gpu")]


def test_only_one_function_submits_work() -> None:
    calls = [file for file in FILES for line in file.read_text("utf-8").splitlines() if "queue.submit(" in line]
    assert calls == [ROOT / "gpu" / "context.py"]


def test_every_public_function_class_and_method_has_a_docstring() -> None:
    missing = []
    for file in FILES:
        tree = ast.parse(file.read_text("utf-8"))
        assert ast.get_docstring(tree) or file.name == "__main__.py", file
        classes = [n for n in tree.body if isinstance(n, ast.ClassDef) and not n.name.startswith("_")]
        for node in [*tree.body, *(node for holder in classes for node in holder.body)]:
            if not isinstance(node, ast.FunctionDef | ast.ClassDef) or node.name.startswith("_"):
                continue
            if "overload" not in map(ast.unparse, node.decorator_list) and ast.get_docstring(node) is None:
                missing.append(f"{file.name}: {node.name}")
    assert not missing


def test_no_docstring_cites_the_lecture_by_a_number() -> None:
    for file in FILES:
        assert not re.search(r"\bL\d\b", file.read_text("utf-8")), file


def test_the_package_is_typed() -> None:
    assert (ROOT / "py.typed").is_file()
