"""Bounding boxes of models, and where their corners and points stand in the world."""

import itertools
from collections.abc import Sequence

import numpy as np

from .._core.types import Float64Array

_CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))  # of which bound each corner takes its coordinates
_IDENTITY = np.eye(4)


def box_corners(bounds: Float64Array) -> Float64Array:
    """Return the corners (8, 3) of the box between `bounds` (2, 3)."""
    corners: Float64Array = bounds[_CORNERS, (0, 1, 2)]
    return corners


def box_in_world(points: Float64Array, world_from_model: Float64Array) -> Float64Array:
    """Return the corners (c, 3) of the box around `points` (n, 3) of each of the instances (k, 4, 4)."""
    if len(points) == 0:
        return np.empty((0, 3))
    return corners_in_world(np.stack([points.min(axis=0), points.max(axis=0)]), world_from_model)


def corners_in_world(bounds: Float64Array, world_from_model: Float64Array) -> Float64Array:
    """Return the corners (8 * k, 3) of the box between `bounds` (2, 3) of each of the instances (k, 4, 4)."""
    corners = box_corners(bounds)
    return join_points([world_positions(corners, matrix) for matrix in world_from_model])


def join_points(parts: Sequence[Float64Array]) -> Float64Array:
    """Return the points (n, 3) of all parts; those of a single one as they are, for they may be many."""
    filled = [part for part in parts if len(part)]
    return filled[0] if len(filled) == 1 else np.concatenate([np.empty((0, 3)), *filled])


def world_positions(positions: Float64Array, world_from_model: Float64Array) -> Float64Array:
    """Return `positions` (n, 3) in the world, divided by w; those with w <= 0 are left out."""
    if np.array_equal(world_from_model, _IDENTITY):
        return positions
    with np.errstate(over="ignore", invalid="ignore"):
        homogeneous = positions @ world_from_model[:, :3].T + world_from_model[:, 3]
    in_front = homogeneous[homogeneous[:, 3] > 0.0]
    return np.asarray(in_front[:, :3] / in_front[:, 3:])
