"""The registry of file formats: the reader or writer for a file's suffix."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from contextlib import suppress
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from .._core.arguments import require_flag, require_text
from .._core.atomic_files import atomic_write
from .._core.error_context import prefix_error, prefix_errors
from .._core.git_lfs import MAX_POINTER_BYTES, POINTER_WORDS, is_lfs_pointer
from .._core.public import public
from .._core.suggestions import MIN_FILE_TYPE_SIMILARITY, did_you_mean
from .._core.targets import require_path
from .._core.types import Float64Array, StrPath
from .._core.whole_writes import as_whole_writer
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from ..surfaces.resolution import as_tolerance
from ._losses import ListLosses, list_attributes, warn_of
from ._warn import name_file
from .limits import NO_LIMITS, FileLimits, as_limits, is_isolated, spend

if TYPE_CHECKING:
    from .gltf_document import Document

Model = TypeVar("Model", Mesh, Scene, "Document")

Reader: TypeAlias = Callable[[bytes], Mesh]
Writer: TypeAlias = Callable[[Mesh, BinaryIO], None]
PathOrFile: TypeAlias = StrPath | BinaryIO
ModelToSave: TypeAlias = Mesh | Scene | StrPath | npt.NDArray[Any]

_UNNAMED = "<file>"


def _call(module: str, function: str, /, *arguments: Any, **options: Any) -> Any:
    return getattr(import_module(f".{module}", __package__), function)(*arguments, **options)


def _from(module: str, function: str) -> partial[Any]:
    """Return a function of another module of this folder, which is imported when the function is first called.

    All formats together take as long to import as NumPy, and three megabytes.
    """
    return partial(_call, module, function)


READERS: dict[str, partial[Mesh]] = {
    "3mf": _from("threemf", "read"),
    "dae": _from("collada", "read"),
    "glb": _from("glb", "read"),
    "gltf": _from("gltf", "read"),
    "las": _from("las", "read"),
    "laz": _from("las", "read"),
    "npy": _from("npy", "read"),
    "obj": _from("obj", "read"),
    "off": _from("off", "read"),
    "ply": _from("ply", "read"),
    "step": _from("step", "read"),
    "stl": _from("stl", "read"),
    "stp": _from("step", "read"),
    "urdf": _from("urdf", "read"),
    "vrml": _from("vrml", "read"),
    "wrl": _from("vrml", "read"),
    "wrz": _from("vrml", "read"),
}
# What else the readers import, when they first need it.
_IMPORTS = {
    "3mf": ("encodings.cp437", "lxml.etree", "numpy.ma"),
    "dae": ("lxml.etree", "numpy.ma"),
    "las": ("laspy",),
    "laz": ("laspy",),
    "obj": (".obj_free_forms",),
    "urdf": ("heapq", "lxml.etree", ".collada", ".glb", ".obj", ".stl"),
}
# These may name files beside their own, and take the folder of it.
_BESIDE = ("gltf", "obj", "urdf", "vrml", "wrl", "wrz")
_SCENE_READERS: dict[str, Callable[..., Scene]] = {
    "3mf": _from("threemf", "read_scene"),
    "glb": _from("glb", "read_scene"),
    "gltf": _from("gltf", "read_scene"),
    "step": _from("step", "read_scene"),
    "stp": _from("step", "read_scene"),
    "urdf": _from("urdf", "read_scene"),
}
_IN_PROCESSES = ("step", "stp")  # in any case
_OF_SURFACES = ("obj", "step", "stp")  # which take a tolerance
# Files whose nodes can be moved in the file, so that whatever else it holds stays.
DOCUMENT_TYPES = ("glb", "gltf")
TRIANGLE_TYPES = (*DOCUMENT_TYPES, "stl")  # whose faces have three corners
WRITERS: dict[str, Writer] = {
    "glb": _from("glb", "write"),
    "gltf": _from("gltf", "write"),
    "npy": _from("npy", "write"),
    "obj": _from("obj", "write"),
    "off": _from("off", "write"),
    "ply": _from("ply", "write"),
    "stl": _from("stl", "write"),
}

_merge_scene: Callable[[Scene], Mesh] = _from("gltf", "merge_scene")
_list_library_losses = _from("obj_materials", "list_library_losses")
_write_libraries = _from("obj_materials", "write_libraries")

# What each format cannot hold of a mesh; the writer of glTF tells itself.
_LOSSES: dict[str, ListLosses] = {
    "npy": list_attributes,
    "obj": _from("obj", "list_losses"),
    "off": _from("off", "list_losses"),
    "ply": _from("ply", "list_losses"),
    "stl": _from("stl", "list_losses"),
}


@public
def load_mesh(
    source: PathOrFile,
    *,
    file_type: str | None = None,
    tolerance: float | None = None,
    limits: FileLimits | None = None,
    isolated: bool | None = None,
) -> Mesh:
    """Read a mesh from a model file; polygons are not split into triangles.

    Parameters
    ----------
    source : path or binary file object
        OBJ, OFF, PLY, STL, VRML (also compressed), GLB, glTF, 3MF (with the extra `3mf`), STEP (with the extra `cad`),
        URDF and COLLADA (with the extra `robots`), a scan (LAS, LAZ; with the extra `las`), or an array of points
        (NPY).
    file_type : str, optional
        "obj", ".OBJ", ...; by default, the suffix of the file's name.
    tolerance : float, optional
        The largest distance between polygons and the surfaces that they stand for, in the file's unit: of the Bézier
        and B-spline surfaces and curves of an OBJ file, by default a thousandth of the diagonal of its points; of the
        faces of a STEP file, kept by all shapes that were measured, by default a five-hundredth of its size, and at
        least a millionth. Other files have none.
    limits : FileLimits, optional
        What the file may hold. By default it may hold what its bytes spell out, and expand to some multiple of it.
        Its seconds and bytes of memory need `isolated`, but for STEP.
    isolated : bool, optional
        Read the file in a process of its own, whose memory and time the system limits (Linux only): whatever the file
        does to a reader, a mesh comes back or a `MeshError`. False by default.

    Returns
    -------
    Mesh

    Raises
    ------
    MeshError
        For an unknown type or malformed content; the message names the file, the line or byte, and what is wrong.
    MissingExtraError
        If the extra that the format needs is not installed.
    ArgumentError
        For a nameless file object without `file_type`, a tolerance that is not positive or needs more than 2^24 faces,
        `isolated` where the system has no such limits, and limits of `cpu_s` or `memory_bytes` without it.
    ArgumentTypeError
        If `source` is neither a path nor a binary file object.
    OSError
        If the file cannot be read.

    Warns
    -----
    MeshWarning
        Of what the file holds and the result does not; the message names the file.
    """
    name, kind = _identify(source, file_type, READERS)
    if tolerance is not None:
        tolerance = as_tolerance(tolerance)
    folder, limits = _get_folder(source), as_limits(limits)
    if require_flag(isolated, "isolated", default=is_isolated()):
        from .isolation import read_isolated_mesh

        reader: Reader = partial(read_isolated_mesh, kind=kind, folder=folder, tolerance=tolerance, limits=limits)
    else:
        _require_no_process_limits(limits, kind)
        reader = _find_reader(kind, folder, tolerance)
    mesh = _read(source, name, reader, limits)
    if mesh.n_points == 0:
        raise prefix_error(MeshError("the file holds no points"), name)
    return mesh


def _require_no_process_limits(limits: FileLimits, kind: str) -> None:
    """Raise ArgumentError for limits that only a process of its own can keep, where a file of a type is read here."""
    if (limits.cpu_s is not None or limits.memory_bytes is not None) and kind not in _IN_PROCESSES:
        raise ArgumentError.expecting("isolated", "be set for limits of cpu_s and memory_bytes")


def read_bytes(
    data: bytes, kind: str, folder: Path | None, tolerance: float | None, limits: FileLimits, is_scene: bool
) -> Mesh | Scene:
    """Return the mesh of a file of a known type, which has no name, or its scene."""
    with spend(len(data), limits):
        find = _find_scene_reader if is_scene else _find_reader
        return find(kind, folder, tolerance)(data)


def prepare(kind: str) -> None:
    """Import what reads files of a type; start its threads, and let linear algebra take the memory it works in."""
    with suppress(ImportError):  # the reader says which extra brings it
        for name in (f".{READERS[kind].args[0]}", *_IMPORTS.get(kind, ())):
            import_module(name, __package__)
        if kind in ("las", "laz"):
            _from("laz", "start_threads")()
    np.linalg.inv(np.eye(4) @ np.eye(4))


def _find_reader(kind: str, folder: Path | None, tolerance: float | None) -> Reader:
    return partial(READERS[kind], **_list_options(kind, folder, tolerance))


def _find_scene_reader(kind: str, folder: Path | None, tolerance: float | None) -> Callable[[bytes], Scene]:
    return partial(_SCENE_READERS[kind], **_list_options(kind, folder, tolerance))


def _list_options(kind: str, folder: Path | None, tolerance: float | None) -> dict[str, Any]:
    """Return the keywords that the reader of a type takes beside the file."""
    options: dict[str, Any] = {"folder": folder} if kind in _BESIDE else {}
    if kind in _OF_SURFACES:
        options["tolerance"] = tolerance
    if kind == "urdf":
        options["read_model"] = _read_named_model
    return options


def _read_named_model(data: bytes, kind: str, folder: Path) -> Mesh | None:
    """Return the mesh of a file that another file names, None for a type that is not known or may name the first."""
    return None if kind not in READERS or kind == "urdf" else _find_reader(kind, folder, None)(data)


@public
def load_scene(
    source: PathOrFile,
    *,
    file_type: str | None = None,
    tolerance: float | None = None,
    limits: FileLimits | None = None,
    isolated: bool | None = None,
) -> Scene:
    """Read a scene from a model file.

    GLB and glTF keep their nodes, 3MF its items and components, in millimetres, STEP its assemblies and parts, in its
    own unit, which `metadata` names, URDF its links, and the `joints` between them; a mesh that several nodes show is
    one object. If an earlier node has the same name, a node gets a number, such as "wheel 2"; node 7, if it has no
    name, becomes "node 7". A file of any other format becomes one node.

    Parameters
    ----------
    source : path or binary file object
        Of any format that `load_mesh` reads.
    file_type : str, optional
        "glb", ".GLTF", ...; by default, the suffix of the file's name.
    tolerance : float, optional
        As `load_mesh` takes it.
    limits : FileLimits, optional
        As `load_mesh` takes it.
    isolated : bool, optional
        As `load_mesh` takes it: whatever the file does to a reader, a scene comes back or a `MeshError`.

    Returns
    -------
    Scene

    Raises
    ------
    MeshError
        For an unknown type or malformed content; the message names the file, the line or byte, and what is wrong.
    MissingExtraError
        If the extra that the format needs is not installed.
    ArgumentError
        For a nameless file object without `file_type`, `isolated` where the system has no such limits, and limits of
        `cpu_s` or `memory_bytes` without it.
    ArgumentTypeError
        If `source` is neither a path nor a binary file object.
    OSError
        If the file cannot be read.

    Warns
    -----
    MeshWarning
        Of what the file holds and the result does not; the message names the file.
    """
    name, kind = _identify(source, file_type, READERS)
    if kind in _SCENE_READERS:
        if tolerance is not None:
            tolerance = as_tolerance(tolerance)
        folder, limits = _get_folder(source), as_limits(limits)
        reader = _find_scene_reader(kind, folder, tolerance)
        if require_flag(isolated, "isolated", default=is_isolated()):
            from .isolation import read_isolated_scene

            reader = partial(read_isolated_scene, kind=kind, folder=folder, tolerance=tolerance, limits=limits)
        else:
            _require_no_process_limits(limits, kind)
        return _read(source, name, reader, limits)
    scene = Scene()
    scene.add(
        load_mesh(source, file_type=kind, tolerance=tolerance, limits=limits, isolated=isolated),
        name=None if name == _UNNAMED else Path(name).stem,
    )
    return scene


def transform_document(
    source: PathOrFile, target: PathOrFile, matrix: Float64Array, *, source_type: str, target_type: str
) -> None:
    """Write a model file of DOCUMENT_TYPES again, its nodes moved by a matrix; all else it holds is kept.

    matrix : (4, 4), with the last row (0, 0, 0, 1)
    source_type, target_type : the types of the files
    """
    from . import gltf_document

    name, kind = _identify(source, source_type, DOCUMENT_TYPES)
    folder = _get_folder(source)
    document = _read(source, name, partial(_read_document, kind=kind, folder=folder))
    with prefix_errors(f"{name}, transformed"):
        moved = document if np.array_equal(matrix, np.eye(4)) else gltf_document.move(document, matrix)
    with prefix_errors(_identify(target, target_type, DOCUMENT_TYPES)[0]):
        _write(target, partial(gltf_document.WRITERS[target_type], moved))


def _read_document(data: bytes, kind: str, folder: Path | None) -> Document:
    """Return a document that can also be read as a mesh, whatever it shows."""
    from . import gltf, gltf_document

    document = gltf_document.read_glb(data, folder) if kind == "glb" else gltf_document.read_document(data, folder)
    gltf.make_scene(document)
    return document


@public
def save_mesh(mesh: ModelToSave, target: PathOrFile, *, file_type: str | None = None) -> None:
    """Write a mesh or a scene to a model file; a path gets the whole file or is left untouched.

    OBJ, OFF and PLY keep polygons and every bit of the coordinates. STL holds triangles, GLB and glTF hold triangles,
    segments and points, all three as float32. NPY holds an array of points, and no faces. The `.mtl` files that a mesh
    was read with are written beside an OBJ file, unless they are there. GLB and glTF keep the nodes
    of a scene, their names, what they share, and its animations; in any other format a scene becomes one mesh.

    Parameters
    ----------
    mesh : Mesh, Scene, path of a model file, or (n, 3) array of points
        At least one point.
    target : path or binary file object
        Where to write.
    file_type : str, optional
        "glb", "gltf", "npy", "obj", "off", "ply" or "stl"; by default, the suffix of the file's name.

    Raises
    ------
    MeshError
        For an unknown type, and for a mesh that the format cannot hold.
    ArgumentError
        For a nameless file object without `file_type`.
    ArgumentTypeError
        If `mesh` is none of these, or `target` neither a path nor a binary file object.
    OSError
        If the file cannot be written.

    Warns
    -----
    MeshWarning
        Of attributes and all else that the format cannot hold.
    """
    name, kind = _identify(target, file_type, WRITERS)
    with prefix_errors(name), name_file(name):
        model = mesh.with_models(_load_model) if isinstance(mesh, Scene) else _load_model(mesh)
        if not isinstance(model, Mesh | Scene):
            expected = "be a Mesh, a Scene, a path or an array of points"
            raise ArgumentTypeError.expecting("mesh", expected, type(mesh).__name__)
        if isinstance(model, Mesh) and model.n_points == 0:
            raise MeshError("a mesh without points cannot be saved")
        if kind in DOCUMENT_TYPES:
            from . import gltf_document, gltf_write

            _write(target, partial(gltf_document.WRITERS[kind], gltf_write.make_document(model)))
        else:
            _write_mesh(_merge_scene(model) if isinstance(model, Scene) else model, target, kind)


def _write_mesh(mesh: Mesh, target: PathOrFile, kind: str) -> None:
    """Write a mesh in a format without nodes, and warn of what it cannot hold."""
    folder = _get_folder(target)
    lost = _LOSSES[kind](mesh)
    if kind == "obj":
        lost += _list_library_losses(mesh, folder)
    warn_of(lost, [mesh.metadata], kind)
    if kind == "obj" and folder is not None:
        _write_libraries(mesh, folder)
    _write(target, partial(WRITERS[kind], mesh))


def _load_model(model: Any) -> Any:
    """Return the mesh of a path or of an array of points in a scene; any other model as it is."""
    if isinstance(model, str | os.PathLike):
        return load_mesh(model)
    return Mesh(model) if isinstance(model, np.ndarray) else model


def _write(target: PathOrFile, write: Callable[[BinaryIO], None]) -> None:
    """Write a whole file, or to a file object."""
    if isinstance(target, str | os.PathLike):
        with atomic_write(target) as file:
            write(file)
    else:
        write(as_whole_writer(target))


def _read(source: PathOrFile, name: str, reader: Callable[[bytes], Model], given: FileLimits | None = None) -> Model:
    """Return what `reader` makes of a file; the messages of errors begin with its name."""
    data = Path(source).read_bytes() if isinstance(source, str | os.PathLike) else source.read()
    if not isinstance(data, bytes | bytearray | memoryview):
        message = f"source must be a binary file, its read() gave {type(data).__name__}"
        raise ArgumentTypeError(message, argument="source", expected="be a binary file")
    limits = as_limits(given)
    with prefix_errors(name), name_file(name), spend(len(data), limits) as budget:
        if len(data) == 0:
            raise MeshError("the file is empty")
        if is_lfs_pointer(bytes(data[:MAX_POINTER_BYTES])):
            raise MeshError(POINTER_WORDS)
        model = reader(bytes(data))
        if limits is not NO_LIMITS:
            if isinstance(model, Mesh):
                budget.require_mesh([model])
            elif isinstance(model, Scene):
                shown = [layer.model for layer in model.layers()]
                budget.require_mesh([each for each in shown if isinstance(each, Mesh)])
        return model


def _get_folder(source: PathOrFile) -> Path | None:
    """Return the folder in which further files of the model may lie."""
    return Path(source).parent if isinstance(source, str | os.PathLike) else None


def _identify(source: PathOrFile, file_type: str | None, known: Collection[str]) -> tuple[str, str]:
    """Return the file's name for messages, and its type, a member of `known`."""
    require_text(file_type, "file_type")
    is_path = isinstance(source, str | os.PathLike)
    path: Any = source if is_path else getattr(source, "name", None)
    name = os.fspath(path) if isinstance(path, str | os.PathLike) else None
    if is_path:
        require_path(path, "the path of a model file")
    if name is None and not hasattr(source, "read") and not hasattr(source, "write"):
        argument = "target" if known is WRITERS else "source"
        raise ArgumentTypeError.expecting(argument, "be a path or a binary file", type(source).__name__)
    if name is None and file_type is None:
        raise ArgumentError.expecting("file_type", "be given for a file that has no name")
    kind = (Path(name or "").suffix if file_type is None else file_type).lower().lstrip(".")
    if known is READERS and is_path and Path(path).is_dir():
        raise prefix_error(MeshError("it is a folder, not a model file"), name or _UNNAMED)
    if kind not in known:
        if known is READERS and is_path:
            Path(path).stat()  # a file that is missing is the graver mistake
        if known is READERS and kind == "xacro":
            raise prefix_error(
                MeshError("it is xacro, from which URDF is made: xacro FILE -o robot.urdf"), name or _UNNAMED
            )
        got = (
            f"{kind!r}{did_you_mean(kind, sorted(known), MIN_FILE_TYPE_SIMILARITY)}"
            if kind
            else "no suffix and no file type"
        )
        error = MeshError(f"the type must be one of {', '.join(sorted(known))}, got {got}")
        raise prefix_error(error, name or _UNNAMED)
    return name or _UNNAMED, kind
