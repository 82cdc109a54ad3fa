"""Layers from model files and style options."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array, as_square_matrices
from .._core.types import Float64Array
from ..errors import ArgumentError
from ..geometry.mesh import Mesh
from ..imaging.colors import COLOR_CYCLE
from . import files
from .argument_types.styles import AXES
from .arguments_from_options import collect_style_arguments, compose_transforms
from .path_templates import Template
from .paths import expand_globs
from .reading_options import use_typed_limits
from .streams import name_file_in_errors

if TYPE_CHECKING:
    from ..drawing.layer import Layer, Style

COLORS = ("color", "fill", "scalars", "face_colors", "edge_colors", "vertex_colors")


def read_layers(
    options: Namespace, paths: Sequence[str], world_from_model: Float64Array, size: tuple[int, int] | None = None
) -> list["Layer"]:
    """Read a layer per model file, those of --layer after the others.

    size : of a picture that is one of many, in which models have `legible_style` if none is typed
    """
    layers = _read_styled(options, paths, world_from_model, size)
    for extra in options.extra_layers:
        with use_typed_limits(extra):
            layers += _read_styled(extra, expand_globs(extra.models), compose_transforms(extra))
    has_colors = any(name in each for each in (options, *options.extra_layers) for name in COLORS)
    return layers if has_colors or size or not options.legend or len(layers) < 2 else _color_apart(layers)


def _color_apart(layers: Sequence["Layer"]) -> list["Layer"]:
    """Return layers with lines in a colour each, so that a legend tells them apart."""
    return [replace(layer, color=COLOR_CYCLE[i % len(COLOR_CYCLE)]) for i, layer in enumerate(layers)]


def read_style(options: Namespace, path: str, use: str) -> dict[str, Any]:
    """Return the keywords of `Layer` for all models of the scene in `path`; `use` says in errors what it is for."""
    typed = collect_style_arguments(options)
    for name in ("scalars", "instances"):
        if name in typed:
            raise ArgumentError(f"--{name} is not for {use}")
    return {name: _read_value(name, value, path) for name, value in typed.items()}


def _read_styled(
    options: Namespace, paths: Sequence[str], world_from_model: Float64Array, size: tuple[int, int] | None = None
) -> list["Layer"]:
    """Read a layer per model; the limits of scalars are those of all models together."""
    from ..drawing.layer import Layer, Style
    from ..drawing.legible_style import legible_style

    if options.parts:
        return [layer for path in paths for layer in _read_parts(options, path, world_from_model, size)]
    meshes = [files.read_mesh(path, options.file_type, options.tolerance, options.pose) for path in paths]
    typed = collect_style_arguments(options)
    legible = [legible_style(mesh, size) if size and not typed else Style() for mesh in meshes]
    source, instances = typed.pop("scalars", None), typed.pop("instances", None)
    styles = [
        {**own, **{name: _read_value(name, value, path) for name, value in typed.items()}, "name": Path(path).stem}
        for path, own in zip(paths, legible, strict=True)
    ]
    for style, path in zip(styles, paths, strict=True):
        style["transform"] = (
            world_from_model if instances is None else world_from_model @ _read_instances(instances, path)
        )
    if source is not None:
        scalars = [_read_scalars(source, path, mesh) for path, mesh in zip(paths, meshes, strict=True)]
        limits = _find_finite_limits(np.concatenate([values for values, _ in scalars]))
        styles = [
            {"clim": limits, **style, "scalars": source if is_per_face else values} | _name_color_bar(style, source)
            for style, (values, is_per_face) in zip(styles, scalars, strict=True)
        ]
    return [Layer(mesh, **style) for mesh, style in zip(meshes, styles, strict=True)]


def _read_parts(
    options: Namespace, path: str, world_from_model: Float64Array, size: tuple[int, int] | None
) -> list["Layer"]:
    """Read a layer per part of a model that nodes show."""
    from ..drawing.layer import as_layers
    from ..drawing.legible_style import legible_style
    from ..formats.gltf import merge_scene

    typed = collect_style_arguments(options)
    for name, value in typed.items():
        flag = f"--{name.replace('_', '-')}"
        if name == "scalars" or (name != "instances" and isinstance(value, Template)):
            raise ArgumentError(f"{flag} cannot go with --parts: it is by point or by face of one model")
        if name == "edges" and any(isinstance(part, Template) for part in value):
            raise ArgumentError(f"{flag} FILE cannot go with --parts: it is by point of one model")
    scene = files.read_scene(path, options.file_type, options.tolerance, options.pose)
    instances = typed.pop("instances", None)
    style: dict[str, Any] = {"transform": world_from_model}
    if instances is not None:
        style["transform"] = world_from_model @ _read_instances(instances, path)
    if size is not None and not typed:
        style |= legible_style(merge_scene(scene), size)
    with name_file_in_errors(path):
        return as_layers(scene, cast("Style", style | typed))


def _name_color_bar(style: dict[str, Any], source: str | Template) -> dict[str, Any]:
    """Return the title of a colour bar, if there is one: the name of the scalars, or of their file."""
    if "colorbar" not in style:
        return {}
    return {"colorbar": Path(source.path_for("model")).stem if isinstance(source, Template) else source}


def _read_instances(template: Template, path: str) -> Float64Array:
    """Read the matrices (k, 4, 4), k > 0, from the .npy file for a model file."""
    array_path = template.path_for(path)
    stack = files.read_matrix_stack(array_path, "k")
    if len(stack) == 0:
        raise ArgumentError(f"{array_path}: expected at least one matrix, got none")
    return as_square_matrices(stack, array_path, 4)


def _read_value(name: str, value: Any, path: str) -> Any:
    """Return a style value, with what the files for the model file `path` hold in place of templates."""
    if isinstance(value, Template) and name == "labels":
        return files.read_labels(value.path_for(path))
    if isinstance(value, Template):
        return files.read_array(value.path_for(path))
    return [_read_edge_set(part, path) for part in value] if isinstance(value, list) else value


def _read_edge_set(edges: str | Template, path: str) -> Any:
    """Return the name of an edge set, or the array of an .npy file."""
    if not isinstance(edges, Template):
        return edges
    array_path = edges.path_for(path)
    pairs = files.read_array(array_path)
    if pairs.ndim != 2:
        raise ArgumentError(f"{array_path}: expected an array of shape (m, 2), got {pairs.shape}")
    return pairs


def _read_scalars(source: str | Template, path: str, mesh: Mesh) -> tuple[npt.NDArray[Any], bool]:
    """Return a number per point: a coordinate in the model's frame, an attribute, or the array of an .npy file.

    An attribute may have a number per face instead, which the second value says.
    """
    if not isinstance(source, Template):
        if source in AXES:
            return mesh.positions[:, AXES.index(source)], False
        from ..drawing.attribute_colors import find_scalars, list_scalars

        known = list_scalars(mesh)
        if source not in known:
            attributes = f"{', '.join(known)} of {path}" if known else f"an attribute, of which {path} has none"
            raise ArgumentError(f"--scalars: expected x, y, z, an .npy file, or {attributes}, got {source!r}")
        return find_scalars(mesh, source)
    array_path = source.path_for(path)
    scalars = as_real_array(files.read_array(array_path), array_path, finite=False)
    if scalars.shape != (mesh.n_points,):
        raise ArgumentError(
            f"{array_path}: expected one number for each of the {mesh.n_points} points of {path}, "
            f"got shape {scalars.shape}"
        )
    return scalars, False


def _find_finite_limits(scalars: npt.NDArray[Any]) -> tuple[float, float] | None:
    finite = scalars[np.isfinite(scalars)]
    return (float(finite.min()), float(finite.max())) if len(finite) else None
