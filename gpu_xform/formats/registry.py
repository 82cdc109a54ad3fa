"""The registry of file formats: the reader or writer for a file's suffix."""

import os
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import BinaryIO, TypeAlias, TypeVar

from .._core.atomic_files import atomic_write
from .._core.error_context import prefix_error, prefix_errors
from .._core.public import public
from .._core.types import StrPath
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from . import glb, gltf, npy, obj, off, ply, stl, threemf, vrml

Model = TypeVar("Model", Mesh, Scene)

Reader: TypeAlias = Callable[[bytes], Mesh]
Writer: TypeAlias = Callable[[Mesh, BinaryIO], None]
PathOrFile: TypeAlias = StrPath | BinaryIO

_UNNAMED = "<file>"

READERS: dict[str, Reader] = {
    "3mf": threemf.read,
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
    """Read a mesh from a model file; polygons are not split into triangles.

    Parameters
    ----------
    source : path or binary file object
        OBJ, OFF, PLY, STL, VRML (also compressed), GLB, glTF, 3MF (with the extra `3mf`), or an array of points (NPY).
    file_type : str, optional
        "obj", ".OBJ", ...; by default, the suffix of the file's name.

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
        For a nameless file object without `file_type`.
    ArgumentTypeError
        If `source` is neither a path nor a binary file object.
    OSError
        If the file cannot be read.
    """
    name, kind = _identify(source, file_type, READERS)
    mesh = _read(source, name, partial(gltf.read, folder=_get_folder(source)) if kind == "gltf" else READERS[kind])
    if mesh.n_points == 0:
        raise prefix_error(MeshError("the file holds no points"), name)
    return mesh


@public
def load_scene(source: PathOrFile, *, file_type: str | None = None) -> Scene:
    """Read a scene from a model file.

    GLB and glTF keep their nodes, and a mesh that several nodes show is one object. If an earlier node has the same
    name, a node gets a number, such as "wheel 2"; node 7, if it has no name, becomes "node 7". A file of any other
    format becomes one node.

    Parameters
    ----------
    source : path or binary file object
        Of any format that `load_mesh` reads.
    file_type : str, optional
        "glb", ".GLTF", ...; by default, the suffix of the file's name.

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
        For a nameless file object without `file_type`.
    ArgumentTypeError
        If `source` is neither a path nor a binary file object.
    OSError
        If the file cannot be read.
    """
    name, kind = _identify(source, file_type, READERS)
    if kind == "glb":
        return _read(source, name, glb.read_scene)
    if kind == "gltf":
        return _read(source, name, partial(gltf.read_scene, folder=_get_folder(source)))
    scene = Scene()
    scene.add(load_mesh(source, file_type=kind), name=None if name == _UNNAMED else Path(name).stem)
    return scene


@public
def save_mesh(mesh: Mesh, target: PathOrFile, *, file_type: str | None = None) -> None:
    """Write a mesh to a model file; a path gets the whole file or is left untouched.

    OBJ, OFF and PLY keep polygons and every bit of the coordinates. STL and GLB hold triangles and float32. NPY holds
    an array of points, and no faces.

    Parameters
    ----------
    mesh : Mesh
        At least one point.
    target : path or binary file object
        Where to write.
    file_type : str, optional
        "glb", "npy", "obj", "off", "ply" or "stl"; by default, the suffix of the file's name.

    Raises
    ------
    MeshError
        For an unknown type, and for a mesh that the format cannot hold.
    ArgumentError
        For a nameless file object without `file_type`.
    ArgumentTypeError
        If `target` is neither a path nor a binary file object.
    OSError
        If the file cannot be written.
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
    """Return what `reader` makes of a file; the messages of errors begin with its name."""
    data = Path(source).read_bytes() if isinstance(source, str | os.PathLike) else source.read()
    if not isinstance(data, bytes | bytearray | memoryview):
        message = f"source must be a binary file, its read() gave {type(data).__name__}"
        raise ArgumentTypeError(message, argument="source", expected="be a binary file")
    with prefix_errors(name):
        if len(data) == 0:
            raise MeshError("the file is empty")
        return reader(bytes(data))


def _get_folder(source: PathOrFile) -> Path | None:
    """Return the folder in which further files of the model may lie."""
    return Path(source).parent if isinstance(source, str | os.PathLike) else None


def _identify(source: PathOrFile, file_type: str | None, known: Collection[str]) -> tuple[str, str]:
    """Return the file's name for messages, and its type, a member of `known`."""
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
        error = MeshError(f"the type must be one of {', '.join(sorted(known))}, got {got}")
        raise prefix_error(error, name or _UNNAMED)
    return name or _UNNAMED, kind
