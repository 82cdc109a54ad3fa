"""What a picture's matrix says of depth: where the eye is, what lies before what, and how far off it is."""

import math
from collections.abc import Callable

import numpy as np

from .._core.types import Float64Array

# Depth is 1 at the near plane and 0 at the far one: floating point then keeps apart what is far away.
REVERSED_DEPTH: Float64Array = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, -1.0, 1.0], [0, 0, 0, 1.0]])


def with_depth(clip_from_world: Float64Array, outline: Callable[[], Float64Array]) -> Float64Array:
    """Return the matrix (4, 4), its depth turned round.

    In parallel views all depths are as exact as the nearest, of which floating point has few: near and far plane move
    in on `outline` (n, 3), and never out. A camera that shows x and y as they are has neither, and gets both.
    """
    matrix: Float64Array = REVERSED_DEPTH @ clip_from_world
    if matrix[3, :3].any():
        return matrix
    # Not yet turned round: 1 - z would lose what is left of z where the far plane is very far.
    z = clip_from_world[2]
    has_planes = z[:3].any()
    if not has_planes:
        z = np.append(-_cross(matrix[0, :3], matrix[1, :3]), 0.0)
    depth = (outline() @ z[:3] + z[3]) / matrix[3, 3]
    low, high = (float(depth.min()), float(depth.max())) if len(depth) else (0.0, 0.0)
    # From a quarter to three quarters, so that nothing is cut off.
    room = 0.5 * (high - low) or max(abs(high), 1.0)
    low, high = low - room, high + room
    if has_planes:
        low, high = max(low, 0.0), min(high, 1.0)
    if low < high:
        matrix[2] = (high * matrix[3] - z) / (high - low)
    return matrix


def eye(clip_from_points: Float64Array) -> Float64Array:
    """Return where a view (4, 4), depth turned round, looks from: (4,), homogeneous, w >= 0 but for mirrored frames.

    It is what the rows x, y and w map to zero; its depth is positive.
    """
    x, y, depth, w = clip_from_points
    rows = np.array([x, y, w])
    kernel = np.array([(-1.0) ** i * np.linalg.det(np.delete(rows, i, axis=1)) for i in range(4)])
    result: Float64Array = kernel if depth @ kernel > 0.0 else -kernel
    return result


def pixel_depth(clip_from_world: Float64Array, width: int) -> tuple[float, float]:
    """Return (a, b): over a pixel's width along the view, the depth d, turned round, changes by a * d + b."""
    x, y, depth, w = clip_from_world
    largest = float(np.abs(x[:3]).max())
    if largest == 0.0:
        return 0.0, 0.0
    across = largest * float(np.linalg.norm(x[:3] / largest)) * width / 2.0  # pixels a unit, at w = 1
    forward = _cross(x[:3], y[:3])
    w_rate, depth_rate = float(forward @ w[:3]), float(forward @ depth[:3])
    if w_rate == 0.0:
        return 0.0, abs(depth_rate) / across
    # d = c / w + e, with e what it tends to far away: d' = -w' (d - e) / w over a pixel's width w / across.
    rate = abs(w_rate) / across
    return rate, -rate * depth_rate / w_rate


def depth_cue(clip_from_world: Float64Array, outline: Callable[[], Float64Array], amount: float) -> Float64Array:
    """Return `Lines.cue` by which the farthest of `outline` (n, 3) loses `amount`, and the nearest nothing."""
    points = outline()
    homogeneous = points @ clip_from_world[:, :3].T + clip_from_world[:, 3]
    homogeneous = homogeneous[homogeneous[:, 3] > 0.0]
    if len(homogeneous) == 0:
        return np.zeros(4)
    is_parallel = not clip_from_world[3, :3].any()
    way = -homogeneous[:, 2] / homogeneous[:, 3] if is_parallel else homogeneous[:, 3]
    nearest, farthest = float(way.min()), float(way.max())
    if farthest == nearest:
        return np.zeros(4)
    scale = 1.0 / (farthest - nearest)
    return np.array([-scale if is_parallel else 0.0, 0.0 if is_parallel else scale, -nearest * scale, amount])


def lost_by_distance(cue: Float64Array, corners: Float64Array) -> Float64Array:
    """Return what a cue (4,) takes of the strength at corners (c, 4) in clip space, depth turned round: (c,).

    It is not limited: before the nearest point it is less than 0, behind the farthest one more than the cue's amount.
    """
    z, w = corners[:, 2], corners[:, 3]
    lost: Float64Array = cue[3] * (cue[0] * z / w + cue[1] * w + cue[2])
    return lost


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the direction (3,) of the cross product, of length 1, however long `a` and `b` are; zero where it is."""
    (a0, a1, a2), (b0, b1, b2) = (a / (np.abs(a).max() or 1.0)).tolist(), (b / (np.abs(b).max() or 1.0)).tolist()
    product = (a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0)
    return np.array(product) / (math.hypot(*product) or 1.0)
