"""The labels of a layer: texts, and the points of the world that they name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentError
from ..geometry.mesh import Mesh
from ..imaging.colors import Rgba, to_rgba
from .boxes import box_corners
from .enums import Hidden
from .label_options import INDICES, NAMES, InstanceNames
from .layer import Layer, dot_diameter, is_auto
from .layer_colors import colors_by_face, has_several_colors
from .layer_placement import hidden_mode
from .lengths import to_pixels
from .point_array import PointArray


@dataclass(frozen=True, eq=False)
class LayerLabels:
    """The texts of one layer, and where they belong.

    points : (k, 3) in the world
    centers : (k, 3), of the model that each point is of
    hidden : what becomes of the labels of hidden points
    are_centred : the texts lie over their points, where there is room
    extents : (k,) of the models that names of nodes belong to, of which the largest has the name; empty for others
    color : of the lines, if that is one
    radius_px : of what is drawn at the points
    """

    texts: Sequence[str]
    points: Float64Array
    centers: Float64Array
    hidden: Hidden
    are_centred: bool
    extents: Float64Array
    color: Rgba | None
    radius_px: float


def layer_labels(layer: Layer) -> LayerLabels | None:
    """Return the labels of a layer whose model is in memory; None if there are none.

    Raises `ArgumentError` for labels that do not suit the points: "labels must have one text for each of the 8 points,
    got 7".
    """
    if layer.labels is None:
        return None
    positions = _positions(layer)
    finite = positions[np.isfinite(positions).all(axis=1)]
    if len(finite) == 0:
        return None
    center = (finite.min(axis=0) + finite.max(axis=0)) / 2.0
    worlds = layer.world_from_model
    is_named = layer.labels == NAMES or isinstance(layer.labels, InstanceNames)
    if is_named:
        texts = list(layer.labels) if isinstance(layer.labels, InstanceNames) else [layer.name or ""] * len(worlds)
        points, instances = np.tile(center, (len(worlds), 1)), np.arange(len(worlds))
    else:
        own_texts, own_points = _texts_at_points(layer.labels, positions)
        texts, points = own_texts * len(worlds), np.tile(own_points, (len(worlds), 1))
        instances = np.repeat(np.arange(len(worlds)), len(own_texts))
    in_world, is_before = _to_world(points, worlds[instances])
    centers, _ = _to_world(np.tile(center, (len(points), 1)), worlds[instances])
    kept = [i for i in np.flatnonzero(is_before).tolist() if texts[i].strip()]
    if not kept:
        return None
    has_one_color = not (has_several_colors(layer) or colors_by_face(layer))
    return LayerLabels(
        texts=[texts[i] for i in kept],
        points=in_world[kept],
        centers=centers[kept],
        hidden=Hidden.SHOW if is_named else hidden_mode(layer),
        are_centred=is_named,
        extents=_extents(finite, worlds[instances[kept]]) if isinstance(layer.labels, InstanceNames) else np.empty(0),
        color=to_rgba(layer.color, "color") if has_one_color else None,
        radius_px=_radius(layer),
    )


def _to_world(points: Float64Array, worlds: Float64Array) -> tuple[Float64Array, BoolArray]:
    """Return points (k, 3) moved each by its matrix (k, 4, 4) and divided by w, and whether w is positive."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        homogeneous = np.einsum("kij,kj->ki", worlds, np.column_stack([points, np.ones(len(points))]))
        moved: Float64Array = homogeneous[:, :3] / homogeneous[:, 3:]
    return moved, (homogeneous[:, 3] > 0.0) & np.isfinite(moved).all(axis=1)


def _extents(points: Float64Array, worlds: Float64Array) -> Float64Array:
    """Return the diagonal (k,) of the box of points (n, 3) in the world, where each matrix (k, 4, 4) puts them."""
    corners = box_corners(np.stack([points.min(axis=0), points.max(axis=0)]))
    moved = [_to_world(corners, np.tile(world, (len(corners), 1, 1)))[0] for world in worlds]
    return np.array([np.linalg.norm(np.ptp(each, axis=0)) for each in moved])


def _texts_at_points(labels: Any, positions: npt.NDArray[Any]) -> tuple[list[str], Float64Array]:
    """Return the texts that are not empty, and the points (k, 3) that they name, in the model's frame."""
    if isinstance(labels, Mapping):
        found = [(text, _point_of(key, positions)) for key, text in labels.items() if text.strip()]
    else:
        n_points = len(positions)
        if labels == INDICES:
            labels = [str(i) for i in range(n_points)]
        if len(labels) != n_points:
            expected = f"have one text for each of the {n_points} points"
            raise ArgumentError.expecting("labels", expected, len(labels))
        found = [(text, positions[i]) for i, text in enumerate(labels) if text and text.strip()]
    points = np.array([point for _, point in found], np.float64).reshape(-1, 3)
    kept = np.flatnonzero(np.isfinite(points).all(axis=1)).tolist()
    return [found[i][0] for i in kept], points[kept]


def _point_of(key: Any, positions: npt.NDArray[Any]) -> Any:
    if isinstance(key, tuple):
        return key
    if not -len(positions) <= key < len(positions):
        raise ArgumentError.expecting("labels", f"name points below {len(positions)}", key)
    return positions[key]


def _positions(layer: Layer) -> npt.NDArray[Any]:
    """Return the points (n, 3) of a layer's model."""
    model: Any = layer.model
    if isinstance(model, PointBuffer):
        return model.numpy().astype(np.float64)
    return model.array if isinstance(model, PointArray) else _mesh_positions(model)


def _mesh_positions(model: Mesh) -> Float64Array:
    return model.positions


def _radius(layer: Layer) -> float:
    width = 0.0 if is_auto(layer.line_width) else to_pixels(layer.line_width, "line_width")
    return 0.5 * max(dot_diameter(layer) or 0.0, width)
