"""From model files and the options of the style to layers."""

import contextlib
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.arguments import real_array, square_matrices
from .._core.error_context import prefixed
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh
from . import files
from . import options as option_groups
from .argument_types import AXES
from .commands.transform import composed
from .path_templates import Template

if TYPE_CHECKING:
    from ..drawing.layer import Layer


def require_scalars(options: Namespace) -> None:
    """Raise `ArgumentError` for options that mean nothing without --scalars."""
    for one in (options, *options.further):
        for name in ("cmap", "clim"):
            if name in one and "scalars" not in one:
                raise ArgumentError(f"--{name} must come with --scalars")


def read_layers(options: Namespace, paths: Sequence[str], world_from_model: Float64Array) -> list["Layer"]:
    """Return a layer for each model file, --layer's after the others."""
    layers = _layers(options, paths, world_from_model)
    for further in options.further:
        layers += _layers(further, files.matching(further.models), composed(further))
    return layers


# The options that give the library's arguments, where the library alone knows what is allowed.
OPTIONS = {
    "background": "--no-background",
    "edge_colors": "--edge-colors",
    "edges": "--edges",
    "face_colors": "--face-colors",
    "fill": "--fill",
    "fps": "--fps",
    "path": "-o",
    "scalars": "--scalars",
    "size": "--resolution",
    "vertex_colors": "--vertex-colors",
}


@contextlib.contextmanager
def naming(options: Namespace, paths: Sequence[str]) -> Iterator[None]:
    """Put the names of model files before what is wrong with what they show, and options before what they give.

    Where there is --layer, what is wrong names its model already.
    """
    try:
        yield
    except MeshError as error:
        if options.further:
            raise
        raise prefixed(error, files.called(paths)) from error.__cause__
    except (ArgumentError, ArgumentTypeError) as error:
        if error.argument not in OPTIONS:
            raise
        raise prefixed(error, OPTIONS[error.argument]) from error.__cause__


def _layers(options: Namespace, paths: Sequence[str], world_from_model: Float64Array) -> list["Layer"]:
    """Return a layer for each model; where `scalars` colour them, one colour means one number in all of them."""
    from ..drawing.layer import Layer

    meshes = [files.read_mesh(path, options.file_type) for path in paths]
    typed = option_groups.style(options)
    source, instances = typed.pop("scalars", None), typed.pop("instances", None)
    styles = [
        {name: _with_arrays(value, path) for name, value in typed.items()} | {"name": Path(path).stem} for path in paths
    ]
    for style, path in zip(styles, paths, strict=True):
        style["transform"] = world_from_model if instances is None else world_from_model @ _instances(instances, path)
    if source is not None:
        scalars = [_scalars(source, path, mesh) for path, mesh in zip(paths, meshes, strict=True)]
        limits = _limits(np.concatenate(scalars))
        styles = [{"clim": limits, **style, "scalars": numbers} for style, numbers in zip(styles, scalars, strict=True)]
    return [Layer(mesh, **style) for mesh, style in zip(meshes, styles, strict=True)]


def _instances(source: Template, path: str) -> Float64Array:
    """Return the matrices (k, 4, 4), k > 0, in the .npy file that belongs to a model file."""
    array_path = source.path(path)
    stack = files.read_stack(array_path, "k")
    if len(stack) == 0:
        raise ArgumentError(f"{array_path}: expected at least one matrix, got none")
    return square_matrices(stack, array_path, 4)


def _with_arrays(value: Any, path: str) -> Any:
    """Return a value of the style, arrays in place of the .npy files that belong to the model file `path`."""
    if isinstance(value, Template):
        return files.read_array(value.path(path))
    return [_pairs(part, path) for part in value] if isinstance(value, list) else value


def _pairs(edges: str | Template, path: str) -> Any:
    """Return a name of edges, or what is in an .npy file."""
    if not isinstance(edges, Template):
        return edges
    array_path = edges.path(path)
    pairs = files.read_array(array_path)
    if pairs.ndim != 2:
        raise ArgumentError(f"{array_path}: expected an array of shape (m, 2), got {pairs.shape}")
    return pairs


def _scalars(source: str | Template, path: str, mesh: Mesh) -> Float64Array:
    """Return a number for each point: a coordinate, as the file has it, or what is in an .npy file."""
    if not isinstance(source, Template):
        return mesh.positions[:, AXES.index(source)]
    array_path = source.path(path)
    scalars = real_array(files.read_array(array_path), array_path, finite=False)
    if scalars.shape != (mesh.n_points,):
        raise ArgumentError(
            f"{array_path}: expected one number for each of the {mesh.n_points} points of {path}, "
            f"got shape {scalars.shape}"
        )
    return scalars


def _limits(scalars: Float64Array) -> tuple[float, float] | None:
    finite = scalars[np.isfinite(scalars)]
    return (float(finite.min()), float(finite.max())) if len(finite) else None
