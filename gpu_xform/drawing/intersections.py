"""Intersection lines of layers: where bodies penetrate one another, as layers of their own."""

import os
import weakref
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from ..compute.mesh_buffer import MeshBuffer
from ..errors import ArgumentError, MeshError
from ..geometry.edges import list_edge_parts
from ..geometry.intersections import Segments, intersect_bodies, number_bodies
from ..geometry.mesh import Mesh
from ..geometry.triangulation import triangulate
from .layer import Layer

INTERSECTION = "intersection"  # the edge set
_NOT_OF_LINES = (
    *("transform", "edges", "fill", "point_size", "max_points"),
    *("face_colors", "edge_colors", "vertex_colors", "scalars", "labels"),
)


class _Placed(NamedTuple):
    """A mesh with faces where an instance of it stands; `layer` is the number of its layer."""

    layer: int
    mesh: Mesh
    world_from_model: Float64Array


class _Kept(NamedTuple):
    """The meshes of the last picture with intersections, the matrices, and what was found."""

    meshes: "list[weakref.ref[Mesh]]"
    matrices: list[bytes]
    found: dict[int, Mesh | None]


_kept: list[_Kept] = []


class IntersectionLayer(Layer):
    """A layer that nobody gave: the lines of intersection of another one, or what a section adds to it."""


class MeetingLines(IntersectionLayer):
    """Lines of intersection alone: beside the outline of a body, as they often lie, they are as hard to hide as it."""


def add_intersections(layers: Sequence[Layer]) -> list[Layer]:
    """Return layers in which each that asks for the edge set "intersection" is followed by one of those lines.

    Bodies are instances of meshes, and in them the faces that edges connect. Each line belongs to the last layer that
    asks for it and has a body there. Raises `MeshError` for a layer that draws nothing else if no body penetrates one
    of its own, `ArgumentError` if there are too many faces to compare.
    """
    asks = [_asks(layer) for layer in layers]
    if not any(asks):
        return list(layers)
    loaded = [with_mesh(layer) for layer in layers]
    found = _find_lines(loaded, np.array(asks))
    result: list[Layer] = []
    for number, (layer, is_asking) in enumerate(zip(loaded, asks, strict=True)):
        if not is_asking:
            result.append(layer)
            continue
        rest = [part for part in _edge_parts(layer) if not _is_intersection(part)]
        lines = found.get(number)
        if number not in found and not rest and layer.fill is None and layer.point_size is None:
            prefix = f"{layer.name}: " if layer.name else ""
            reason = f"{INTERSECTION!r} chooses none: no two bodies penetrate one another"
            raise MeshError(f"{prefix}edges must choose at least one edge, {reason}")
        result.append(_without_intersections(layer, rest))
        if lines is not None:
            result.append(_line_layer(layer, lines))
    return result


def with_mesh(layer: Layer) -> Layer:
    """Return a layer whose model is a mesh in memory if it is a path, or a mesh on a device."""
    model = layer.model
    if isinstance(model, MeshBuffer):
        return replace(layer, model=model.mesh)
    if not isinstance(model, str | os.PathLike):
        return layer
    from ..formats import load_mesh

    return replace(layer, model=load_mesh(model), name=Path(model).stem if layer.name is None else layer.name)


def _asks(layer: Layer) -> bool:
    return any(_is_intersection(part) for part in _edge_parts(layer))


def _edge_parts(layer: Layer) -> list[Any]:
    return [] if layer.edges is None else list_edge_parts(layer.edges)


def _is_intersection(part: object) -> bool:
    return isinstance(part, str) and part == INTERSECTION


def _without_intersections(layer: Layer, rest: list[Any]) -> Layer:
    """Return a layer that draws the other edges, or, without any, only hides what is behind it."""
    if rest:
        return replace(layer, edges=rest[0] if len(rest) == 1 else rest)
    if layer.fill is not None or layer.point_size is not None:
        return replace(layer, edges=np.empty((0, 2), np.int64))
    return replace(layer, edges=None, alpha=0.0)


def _line_layer(layer: Layer, lines: Mesh) -> MeetingLines:
    """Return a layer of lines in the world, in the style of the lines of `layer`."""
    own = {each.name: getattr(layer, each.name) for each in fields(layer)}
    changes: dict[str, Any] = own | dict.fromkeys(_NOT_OF_LINES) | {"labels": None, "colorbar": False}
    changes |= {
        "model": lines,
        "name": f"{layer.name or ''} {INTERSECTION}".strip(),
        "hidden": layer.hidden or ("remove" if layer.fill is not None and layer.hidden_style is None else None),
        "color": "black" if isinstance(layer.color, str) and layer.color == "face" else layer.color,
        "shading": "none",
    }
    return MeetingLines(**changes)


def _find_lines(layers: Sequence[Layer], asks: BoolArray) -> dict[int, Mesh | None]:
    """Return the lines of each layer that others meet, by its number; None if later layers have them."""
    placed = [
        _Placed(number, layer.model, matrix)
        for number, layer in enumerate(layers)
        if isinstance(layer.model, Mesh) and layer.model.n_faces > 0
        for matrix in layer.world_from_model
    ]
    matrices = [b"%d %b %d" % (each.layer, each.world_from_model.tobytes(), asks[each.layer]) for each in placed]
    for kept in _kept:
        if kept.matrices == matrices and all(ref() is each.mesh for ref, each in zip(kept.meshes, placed, strict=True)):
            return kept.found
    try:
        found = _intersect(placed, asks)
    except OverflowError as error:
        raise ArgumentError.expecting(
            "edges", f"leave {INTERSECTION!r} out of a picture of so many faces", reason=error
        ) from None
    _kept[:] = [_Kept([weakref.ref(each.mesh) for each in placed], matrices, found)]
    return found


def _intersect(placed: Sequence[_Placed], asks: BoolArray) -> dict[int, Mesh | None]:
    points, triangles, bodies, owners = [], [], [], []
    n_points = n_bodies = 0
    for each in placed:
        corners, faces = triangulate(each.mesh.positions, each.mesh.offsets, each.mesh.indices)
        homogeneous = each.mesh.positions @ each.world_from_model[:, :3].T + each.world_from_model[:, 3]
        is_before_eye = (homogeneous[:, 3] > 0.0)[corners].all(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            world = homogeneous[:, :3] / homogeneous[:, 3:]
        points.append(np.where(homogeneous[:, 3:] > 0.0, world, 0.0))
        triangles.append(corners[is_before_eye] + n_points)
        numbers = number_bodies(each.mesh)
        bodies.append(numbers[faces[is_before_eye]] + n_bodies)
        owners.append(np.full(int(is_before_eye.sum()), each.layer))
        n_points += len(world)
        n_bodies += int(numbers.max(initial=-1)) + 1
    if not placed:
        return {}
    segments = intersect_bodies(np.concatenate(points), np.concatenate(triangles), np.concatenate(bodies))
    return _share_out(segments, np.concatenate(owners), asks)


def _share_out(segments: Segments, owners: IndexArray, asks: BoolArray) -> dict[int, Mesh | None]:
    """Return the lines of each layer, as `_find_lines`: owners (t,) are the layers of triangles."""
    both = owners[segments.triangles]
    owner = np.where(asks[both], both, -1).max(axis=1, initial=-1)
    found: dict[int, Mesh | None] = dict.fromkeys(np.unique(both).tolist())
    for number in np.unique(owner[owner >= 0]).tolist():
        used, edges = np.unique(segments.edges[owner == number], return_inverse=True)
        found[number] = Mesh(segments.points[used], edges.reshape(-1, 2))
    return found
