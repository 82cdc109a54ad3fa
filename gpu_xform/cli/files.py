"""Reading and writing of meshes, arrays, matrices and pictures, from files or through standard streams."""

import contextlib
import csv
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar

import numpy as np
import numpy.typing as npt

from .._core import npy
from .._core.atomic_files import atomic_write
from .._core.error_context import prefix_error, prefix_errors
from .._core.git_lfs import POINTER_WORDS, is_lfs_pointer
from ..errors import ArgumentError
from ..geometry.mesh import Mesh
from .paths import STDIO, file_type
from .stage_times import format_size, report_stage
from .streams import get_binary_stream, name_file_in_errors

if TYPE_CHECKING:
    from PIL.Image import Image

    from ..geometry.scene import Scene

Model = TypeVar("Model")


def read_mesh(
    path: str, declared_type: str | None, tolerance: float | None, pose: Mapping[str, float] | None = None
) -> Mesh:
    """Read the mesh in `path`, the joints of a robot posed."""
    from ..formats import load_mesh

    if pose is not None:
        from ..formats.gltf import merge_scene

        posed = read_scene(path, declared_type, tolerance, pose)
        with name_file_in_errors(path):
            return merge_scene(posed)
    with report_stage(f"read {path}") as details:
        mesh = load_model(load_mesh, path, declared_type, tolerance)
        details.append(f"{mesh.n_points:,} points, {mesh.n_faces:,} faces")
    return mesh


def read_scene(
    path: str, declared_type: str | None, tolerance: float | None = None, pose: Mapping[str, float] | None = None
) -> "Scene":
    """Read the scene in `path`, the joints of a robot posed."""
    from ..formats import load_scene

    with report_stage(f"read {path}") as details:
        scene = load_model(load_scene, path, declared_type, tolerance)
        details.append(f"{len(scene):,} nodes")
    if pose is None:
        return scene
    if not scene.joints:
        raise ArgumentError(f"--pose is for robots, {path} has no joints")
    with prefix_errors("--pose"):
        return scene.posed(pose)


def load_model(
    load: Callable[..., Model], path: str, declared_type: str | None, tolerance: float | None = None
) -> Model:
    """Return what `load_mesh` or `load_scene` makes of `path`; an error about isolation names its option."""
    try:
        return load(open_source(path), file_type=file_type(path, declared_type), tolerance=tolerance)
    except ArgumentError as error:
        raise (prefix_error(error, "--isolated") if error.argument == "isolated" else error) from error.__cause__


def write_mesh(mesh: Mesh, path: str, file_type: str) -> None:
    """Write a mesh to `path`."""
    from ..formats import save_mesh

    with report_stage(f"wrote {path}"), name_file_in_errors(path):
        save_mesh(mesh, open_target(path), file_type=file_type)


def open_source(path: str) -> "str | BinaryIO":
    """Return a path, or standard input."""
    return get_binary_stream("stdin") if path == STDIO else path


def open_target(path: str) -> "str | BinaryIO":
    """Return a path, or standard output."""
    return get_binary_stream("stdout") if path == STDIO else path


def read_matrix_stack(path: str, count: str) -> npt.NDArray[Any]:
    """Read matrices (k, 4, 4) from an .npy file; errors call k `count`."""
    stack = read_array(path)
    if stack.ndim != 3 or stack.shape[1:] != (4, 4):
        raise ArgumentError(f"{path}: expected an array of shape ({count}, 4, 4), got {stack.shape}")
    return stack


def read_array(path: str) -> npt.NDArray[Any]:
    """Read the array in an .npy file."""
    with report_stage(f"read {path}") as details:
        array = _read_npy(path)
        details.append(f"{array.dtype} {array.shape}")
    return array


def _read_npy(path: str) -> npt.NDArray[Any]:
    data = b""
    try:
        data = get_binary_stream("stdin").read() if path == STDIO else Path(path).read_bytes()
        return npy.read_array(data)
    except ValueError as error:
        if is_lfs_pointer(data):
            raise ArgumentError(f"{path}: {POINTER_WORDS}") from None
        raise ArgumentError(f"{path}: not an .npy file of numbers: {error}") from None
    except MemoryError as error:
        raise ArgumentError(f"{path}: not enough memory: {error}") from None


def write_array(array: npt.NDArray[Any], path: str) -> None:
    """Write a C-ordered array to an .npy file."""
    with report_stage(f"wrote {path}"), _open_output(path) as file:
        npy.write_array(array, file)


def read_matrix(path: str) -> npt.NDArray[Any]:
    """Read the (4, 4) entries in an .npy file, or in a text of 16 numbers."""
    if file_type(path) == "npy":
        return read_array(path)
    try:
        words = Path(path).read_text("utf-8").replace(",", " ").split()
        return np.array([float(word) for word in words]).reshape(4, 4)
    except ValueError:
        raise ArgumentError(f"{path}: expected a text of 16 numbers, row by row, or an .npy file") from None


def read_table(path: str) -> npt.NDArray[Any]:
    """Read the rows of numbers in an .npy file, or in a text with a row per line."""
    if file_type(path) == "npy":
        return read_array(path)
    try:
        lines = Path(path).read_text("utf-8").replace(",", " ").splitlines()
        return np.array([[float(word) for word in line.split()] for line in lines if line.strip()])
    except OSError as error:
        raise ArgumentError(f"expected rows of numbers or a file of them, got {path!r} ({error.strerror})") from None
    except ValueError:
        raise ArgumentError(f"{path}: expected a text of rows of as many numbers, or an .npy file") from None


def read_labels(path: str) -> "list[str] | dict[int | tuple[float, float, float], str]":
    """Read the labels of a model: a text per line of a .txt file, or the rows INDEX,TEXT or X,Y,Z,TEXT of a .csv."""
    try:
        text = Path(path).read_text("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ArgumentError(f"{path}: expected text in UTF-8: {error}") from None
    if file_type(path) == "txt":
        return text.splitlines()
    labels: dict[int | tuple[float, float, float], str] = {}
    for number, row in enumerate(csv.reader(text.splitlines()), 1):
        if not row:
            continue
        *key, label = row
        try:
            if len(key) == 1:
                labels[int(key[0])] = label
            else:
                x, y, z = map(float, key)
                labels[x, y, z] = label
        except ValueError:
            expected = "INDEX,TEXT or X,Y,Z,TEXT"
            raise ArgumentError(f"{path}: line {number}: expected {expected}, got {','.join(row)!r}") from None
    return labels


def write_picture(picture: "Image | str | bytes", path: str, *, make_folders: bool) -> None:
    """Write an image as PNG, and a document as it is."""
    with report_stage(f"wrote {path}") as details:
        data = _encode(picture)
        if make_folders:
            Path(path).parent.mkdir(parents=True, exist_ok=True)
        with _open_output(path) as file:
            # Not by Pillow, which reports every failure to write as an encoder error.
            file.write(data)
        details.append(format_size(len(data)))


def _encode(picture: "Image | str | bytes") -> bytes:
    if isinstance(picture, bytes):
        return picture
    if isinstance(picture, str):
        return picture.encode()
    from io import BytesIO

    png = BytesIO()
    picture.save(png, "PNG", **({"dpi": picture.info["dpi"]} if "dpi" in picture.info else {}))
    return png.getvalue()


@contextlib.contextmanager
def _open_output(path: str) -> Iterator[BinaryIO]:
    with name_file_in_errors(path):
        if path == STDIO:
            yield get_binary_stream("stdout")
        else:
            with atomic_write(path) as file:
                yield file
