"""Thinning of clouds for a quick look: some of many points, chosen evenly over their order."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import IndexArray
from ..errors import ArgumentError
from ..geometry.edges import list_edge_parts
from ..geometry.mesh import Mesh
from .layer import Layer
from .point_array import PointArray


def thin_layer(layer: Layer) -> Layer:
    """Return a layer with at most `layer.max_points` points if it shows points alone, else the layer.

    Raises `ArgumentError` for points that are on a device, and for edges by index.
    """
    max_points = layer.max_points
    if max_points is None:
        return layer
    if isinstance(layer.model, str | os.PathLike):
        from ..formats import load_mesh

        name = Path(layer.model).stem if layer.name is None else layer.name
        layer = replace(layer, model=load_mesh(layer.model), name=name)
    model = layer.model
    if not isinstance(model, Mesh | PointArray):
        raise ArgumentError.expecting("max_points", "go with points in memory or in a file", type(model).__name__)
    if isinstance(model, Mesh) and model.n_faces:
        return layer
    if layer.edges is not None and any(not isinstance(part, str) for part in list_edge_parts(layer.edges)):
        raise ArgumentError.expecting("edges", "not be given by indices if max_points leaves points out")
    if model.n_points <= max_points:
        return layer
    rows = choose_rows(model.n_points, max_points)
    positions = model.array if isinstance(model, PointArray) else model.positions
    changes: dict[str, Any] = {name: _take(getattr(layer, name), rows) for name in ("scalars", "vertex_colors")}
    return replace(layer, model=np.asarray(positions[rows]), max_points=None, **changes)


def choose_rows(n_points: int, n_chosen: int) -> IndexArray:
    """Return some of `n_points` > 0 rows, (n_chosen,) ascending: of as many runs of equal length, one row at random.

    It is the same choice each time. A regular one could fall in step with the lines of a scanner.
    """
    bounds = np.arange(n_chosen + 1, dtype=np.int64) * n_points // n_chosen
    inside = np.random.default_rng(0).random(n_chosen)
    rows: IndexArray = bounds[:-1] + (inside * np.diff(bounds)).astype(np.int64)
    return rows


def _take(values: Any, rows: IndexArray) -> Any:
    """Return what rows of points have; None for None."""
    if values is None or isinstance(values, str):
        return values
    if isinstance(values, np.ndarray):
        chosen: npt.NDArray[Any] = values[rows]
        return chosen
    return [values[row] for row in rows.tolist()]
