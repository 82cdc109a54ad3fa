"""Reversed-Z depth, its slope over a pixel, the eye of a view, and the depth cue: all read off a view's matrix."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array

REVERSE_Z: Float64Array = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, -1.0, 1.0], [0, 0, 0, 1.0]])


class DepthCue(NamedTuple):
    """What the opacity of a point loses to its distance: `amount` times its relative distance.

    The relative distance of depth d and clip-space w is clamp(depth_scale * d + distance_scale * w + offset, 0, 1): 0
    at the nearest point of the picture, 1 at its farthest. Parallel views go by d, perspective ones by w.
    """

    depth_scale: float
    distance_scale: float
    offset: float
    amount: float


NO_DEPTH_CUE = DepthCue(0.0, 0.0, 0.0, 0.0)


def reverse_z(clip_from_world: Float64Array, points: Callable[[], Float64Array]) -> Float64Array:
    """Return the matrix (4, 4) with reversed-Z depth: 1 at the near plane, 0 at the far plane.

    Parallel views spread floating-point precision evenly over their depth: there the near and far planes move in on
    `points` (n, 3), never out. A camera that shows x and y as they are has no planes, and gets both.
    """
    matrix: Float64Array = REVERSE_Z @ clip_from_world
    if matrix[3, :3].any():
        return matrix
    # Taken before the reversal: 1 - z would lose what is left of z if the far plane is very far.
    z = clip_from_world[2]
    has_planes = z[:3].any()
    if not has_planes:
        z = np.append(-_cross(matrix[0, :3], matrix[1, :3]), 0.0)
    depth = (points() @ z[:3] + z[3]) / matrix[3, 3]
    low, high = (float(depth.min()), float(depth.max())) if len(depth) else (0.0, 0.0)
    # The points take up a quarter to three quarters, so that nothing is cut off.
    margin = 0.5 * (high - low) or max(abs(high), 1.0)
    low, high = low - margin, high + margin
    if has_planes:
        low, high = max(low, 0.0), min(high, 1.0)
    if low < high:
        matrix[2] = (high * matrix[3] - z) / (high - low)
    return matrix


def eye(clip_from_points: Float64Array) -> Float64Array:
    """Return the eye of a reversed-Z view (4, 4): (4,), homogeneous, w >= 0 unless the frame is mirrored.

    It is what the rows x, y and w map to zero; its depth is positive.
    """
    x, y, depth, w = clip_from_points
    rows = np.array([x, y, w])
    kernel = np.array([(-1.0) ** i * np.linalg.det(np.delete(rows, i, axis=1)) for i in range(4)])
    result: Float64Array = kernel if depth @ kernel > 0.0 else -kernel
    return result


def depth_slope_per_pixel(clip_from_world: Float64Array, width: int) -> tuple[float, float]:
    """Return (a, b): over the width of a pixel, along the view, the reversed-Z depth d changes by a * d + b."""
    x, y, depth, w = clip_from_world[:, :3]
    pixels_per_unit = math.hypot(*x.tolist()) * width / 2.0  # at w = 1
    if pixels_per_unit == 0.0:
        return 0.0, 0.0
    forward = _cross(x, y)
    w_rate, depth_rate = float(forward @ w), float(forward @ depth)
    if w_rate == 0.0:
        return 0.0, abs(depth_rate) / pixels_per_unit
    # d = c / w + e, where e is its limit far away: d' = -w' (d - e) / w, over a width of w / pixels_per_unit.
    rate = abs(w_rate) / pixels_per_unit
    return rate, -rate * depth_rate / w_rate


def fit_depth_cue(clip_from_world: Float64Array, points: Callable[[], Float64Array], amount: float) -> DepthCue:
    """Return the cue by which the farthest of `points` (n, 3) loses `amount`, and the nearest nothing.

    clip_from_world : (4, 4), reversed-Z
    """
    positions = points()
    homogeneous = positions @ clip_from_world[:, :3].T + clip_from_world[:, 3]
    homogeneous = homogeneous[homogeneous[:, 3] > 0.0]
    if len(homogeneous) == 0:
        return NO_DEPTH_CUE
    is_parallel = not clip_from_world[3, :3].any()
    distance = -homogeneous[:, 2] / homogeneous[:, 3] if is_parallel else homogeneous[:, 3]
    nearest, farthest = float(distance.min()), float(distance.max())
    if farthest == nearest:
        return NO_DEPTH_CUE
    scale = 1.0 / (farthest - nearest)
    return DepthCue(-scale if is_parallel else 0.0, 0.0 if is_parallel else scale, -nearest * scale, amount)


def depth_cue_loss(depth_cue: DepthCue, corners: Float64Array) -> Float64Array:
    """Return what a cue takes of the opacity at corners (c, 4) in clip space, reversed-Z: (c,).

    It is not clamped: before the nearest point it is less than 0, behind the farthest one more than the cue's amount.
    """
    z, w = corners[:, 2], corners[:, 3]
    share: Float64Array = depth_cue.depth_scale * z / w + depth_cue.distance_scale * w + depth_cue.offset
    return depth_cue.amount * share


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the direction (3,) of the cross product, of length 1 however long `a` and `b` are; zero if that is."""
    (a0, a1, a2), (b0, b1, b2) = _scaled_to_one(a.tolist()), _scaled_to_one(b.tolist())
    product = (a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0)
    return np.array(product) / (math.hypot(*product) or 1.0)


def _scaled_to_one(vector: list[float]) -> list[float]:
    """Return a vector over its largest component; plain numbers, as NumPy takes longer to begin than to do this."""
    largest = max(map(abs, vector)) or 1.0
    return [component / largest for component in vector]
