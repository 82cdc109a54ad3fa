"""From model files and the options of the style to layers."""

import contextlib
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .._arguments import Float64Array, real_array
from ..errors import ArgumentError, MeshError
from ..mesh import Mesh
from . import files, option_groups
from .templates import Template
from .values import AXES

if TYPE_CHECKING:
    from ..pictures.layers import Layer


def require_scalars(options: Namespace) -> None:
    """Raise `ArgumentError` for options that mean nothing without --scalars."""
    for name in ("cmap", "clim"):
        if name in options and "scalars" not in options:
            raise ArgumentError(f"--{name} must come with --scalars")


def read_layers(
    options: Namespace, paths: Sequence[str], world_from_model: Float64Array
) -> tuple[list["Layer"], Float64Array]:
    """Return a layer for each model file, and the points of all of them (n, 3) in the world."""
    from ..pictures.subjects import world_positions

    meshes = [files.read_mesh(path, options.file_type) for path in paths]
    points = np.concatenate([world_positions(mesh.positions, world_from_model) for mesh in meshes])
    return _layers(options, paths, meshes, world_from_model), points


# The options that give the library's arguments, where the library alone knows what is allowed.
OPTIONS = {
    "background": "--no-background",
    "fps": "--fps",
    "path": "-o",
    "scalars": "--scalars",
    "size": "--resolution",
}


@contextlib.contextmanager
def naming(paths: Sequence[str]) -> Iterator[None]:
    """Put the names of model files before what is wrong with what they show, and options before what they give."""
    try:
        yield
    except MeshError as error:
        raise MeshError(f"{files.called(paths)}: {error}") from None
    except ArgumentError as error:
        argument = str(error).partition(" ")[0]
        if argument not in OPTIONS:
            raise
        raise ArgumentError(f"{OPTIONS[argument]}: {error}") from None


def _layers(
    options: Namespace, paths: Sequence[str], meshes: Sequence[Mesh], world_from_model: Float64Array
) -> list["Layer"]:
    """Return a layer for each model; where `scalars` colour them, one colour means one number in all of them."""
    from ..pictures.layers import Layer

    style = option_groups.style(options) | {"transform": world_from_model}
    source = style.pop("scalars", None)
    if source is None:
        return [Layer(mesh, name=Path(path).stem, **style) for path, mesh in zip(paths, meshes, strict=True)]
    scalars = [_scalars(source, path, mesh) for path, mesh in zip(paths, meshes, strict=True)]
    style.setdefault("clim", _limits(np.concatenate(scalars)))
    return [
        Layer(mesh, name=Path(path).stem, scalars=numbers, **style)
        for path, mesh, numbers in zip(paths, meshes, scalars, strict=True)
    ]


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
