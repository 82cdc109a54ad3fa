"""Reference coverage: the area of every pixel that lies under a line, from scanlines with exact ends."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tests.support.types import Array

SCANLINES_PER_PIXEL = 64


def capsule_areas(a: Array, b: Array, line_width: float, size: tuple[int, int]) -> Array:
    """Return the coverage of a line with round ends, from `a` to `b` in pixels: (height, width) float64.

    The capsule is convex, so each scanline crosses it in one piece.
    """
    radius = 0.5 * line_width
    y, left, right = _empty_spans(size)
    for center in (a, b):
        square = radius**2 - (y - center[1]) ** 2
        half = np.sqrt(np.maximum(square, 0.0))
        left = np.where(square >= 0.0, np.minimum(left, center[0] - half), left)
        right = np.where(square >= 0.0, np.maximum(right, center[0] + half), right)
    if np.hypot(*(b - a)) > 0.0:
        left, right = _widen(left, right, y, _bar_corners(a, b, line_width))
    return _areas(left, right, size)


def bar_areas(a: Array, b: Array, line_width: float, size: tuple[int, int]) -> Array:
    """Return the coverage of a line with flat ends, from `a` to `b` in pixels: (height, width) float64."""
    y, left, right = _empty_spans(size)
    return _areas(*_widen(left, right, y, _bar_corners(a, b, line_width)), size)


def _empty_spans(size: tuple[int, int]) -> tuple[Array, Array, Array]:
    """Return the height of every scanline, and where its span starts and ends: nowhere yet."""
    y = (np.arange(SCANLINES_PER_PIXEL * size[1]) + 0.5) / SCANLINES_PER_PIXEL
    return y, np.full(len(y), np.inf), np.full(len(y), -np.inf)


def _bar_corners(a: Array, b: Array, line_width: float) -> list[Array]:
    across = 0.5 * line_width / float(np.hypot(*(b - a))) * np.array([a[1] - b[1], b[0] - a[0]])
    return [a + across, b + across, b - across, a - across]


def _widen(left: Array, right: Array, y: Array, corners: Sequence[Array]) -> tuple[Array, Array]:
    """Widen the spans to hold a convex polygon."""
    for p, q in pairwise([*corners, corners[0]]):
        if p[1] != q[1]:
            t = (y - p[1]) / (q[1] - p[1])
            x = p[0] + t * (q[0] - p[0])
            crosses = (t >= 0.0) & (t <= 1.0)
            left, right = np.where(crosses, np.minimum(left, x), left), np.where(crosses, np.maximum(right, x), right)
    return left, right


def _areas(left: Array, right: Array, size: tuple[int, int]) -> Array:
    width, height = size
    pixel = np.arange(width)
    covered = np.clip(np.minimum(right[:, None], pixel + 1) - np.maximum(left[:, None], pixel), 0.0, 1.0)
    return np.asarray(covered.reshape(height, SCANLINES_PER_PIXEL, width).mean(axis=1))
