"""From a file's name to its reader or writer."""

import os
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import BinaryIO, TypeAlias, TypeVar

from .._core.atomic_files import atomic_write
from .._core.error_context import prefix_errors
from .._core.public import public
from .._core.types import StrPath
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from . import glb, gltf, npy, obj, off, ply, stl, vrml
from . import threemf as zipped

Model = TypeVar("Model", Mesh, Scene)

Reader: TypeAlias = Callable[[bytes], Mesh]
Writer: TypeAlias = Callable[[Mesh, BinaryIO], None]
PathOrFile: TypeAlias = StrPath | BinaryIO

_NAMELESS = "<file>"

READERS: dict[str, Reader] = {
    "3mf": zipped.read,
    "glb": glb.read,
    "gltf": gltf.read,
    "npy": npy.read,
    "obj": obj.read,
    "off": off.read,
    "ply": ply.read,
    "stl": stl.read,
    "vrml": vrml.read,
    "wrl": vrml.read,
    "wrz": vrml.read,
}
WRITERS: dict[str, Writer] = {
    "glb": glb.write,
    "npy": npy.write,
    "obj": obj.write,
    "off": off.write,
    "ply": ply.write,
    "stl": stl.write,
}


@public
def load_mesh(source: PathOrFile, *, file_type: str | None = None) -> Mesh:
    """Return the mesh in a model file, its polygons unsplit.

    source : a path, or a binary file object
    file_type : "obj", ".OBJ", ...; from the file's name where not given

    Raises MeshError, which names the file and what is wrong with it, for an unknown type or malformed content;
    ArgumentError for a nameless file object without `file_type`; OSError from the operating system unchanged.
    """
    name, kind = _identify(source, file_type, READERS)
    mesh = _read(source, name, partial(gltf.read, folder=_folder(source)) if kind == "gltf" else READERS[kind])
    if mesh.n_points == 0:
        raise MeshError(f"{name}: the file holds no points")
    return mesh


@public
def load_scene(source: PathOrFile, *, file_type: str | None = None) -> Scene:
    """Return the scene in a model file.

    source : a path, or a binary file object
    file_type : "glb", ".GLTF", ...; from the file's name where not given

    GLB and glTF keep their nodes, and a mesh that several nodes show is one. A node of a name that one before it has
    gets a number, such as "wheel 2", and node 7 without a name is "node 7". Any other file becomes one node.
    Raises as `load_mesh` does.
    """
    name, kind = _identify(source, file_type, READERS)
    if kind == "glb":
        return _read(source, name, glb.read_scene)
    if kind == "gltf":
        return _read(source, name, partial(gltf.read_scene, folder=_folder(source)))
    scene = Scene()
    scene.add(load_mesh(source, file_type=kind), name=None if name == _NAMELESS else Path(name).stem)
    return scene


@public
def save_mesh(mesh: Mesh, target: PathOrFile, *, file_type: str | None = None) -> None:
    """Write a mesh to a model file; a path gets the whole file or is left untouched.

    target : a path, or a binary file object
    file_type : "obj", ".OBJ", ...; from the file's name where not given

    OBJ, OFF and PLY keep polygons and every bit of the coordinates; STL and GLB hold triangles and float32; NPY
    holds an array of points, and no faces.
    Raises MeshError for an unknown type and for a mesh that the format cannot hold; ArgumentError for a nameless file
    object without `file_type`; OSError from the operating system unchanged.
    """
    name, kind = _identify(target, file_type, WRITERS)
    with prefix_errors(name):
        if mesh.n_points == 0:
            raise MeshError("a mesh without points cannot be saved")
        if isinstance(target, str | os.PathLike):
            with atomic_write(target) as file:
                WRITERS[kind](mesh, file)
        else:
            WRITERS[kind](mesh, target)


def _read(source: PathOrFile, name: str, reader: Callable[[bytes], Model]) -> Model:
    """Return what `reader` makes of a file; errors in the file name it."""
    data = Path(source).read_bytes() if isinstance(source, str | os.PathLike) else source.read()
    if not isinstance(data, bytes | bytearray | memoryview):
        message = f"source must be a binary file, its read() gave {type(data).__name__}"
        raise ArgumentTypeError(message, argument="source", expected="be a binary file")
    with prefix_errors(name):
        if len(data) == 0:
            raise MeshError("the file is empty")
        return reader(bytes(data))


def _folder(source: PathOrFile) -> Path | None:
    """Return where other files of the model may lie."""
    return Path(source).parent if isinstance(source, str | os.PathLike) else None


def _identify(source: PathOrFile, file_type: str | None, known: Collection[str]) -> tuple[str, str]:
    """Return a name for messages and a member of `known`."""
    path = source if isinstance(source, str | os.PathLike) else getattr(source, "name", None)
    name = os.fspath(path) if isinstance(path, str | os.PathLike) else None
    if name is None and not hasattr(source, "read") and not hasattr(source, "write"):
        raise ArgumentTypeError(
            f"expected a path or a binary file, got {type(source).__name__}",
            argument="source",
            expected="be a path or a binary file",
        )
    if name is None and file_type is None:
        raise ArgumentError.expecting("file_type", "be given for a file that has no name")
    kind = (Path(name or "").suffix if file_type is None else file_type).lower().lstrip(".")
    if kind not in known:
        got = repr(kind) if kind else "no suffix"
        raise MeshError(f"{name or _NAMELESS}: the type must be one of {', '.join(sorted(known))}, got {got}")
    return name or _NAMELESS, kind
