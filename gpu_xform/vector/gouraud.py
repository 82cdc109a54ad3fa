"""Gouraud meshes: free-form triangle meshes of PDF, in which colours change linearly (ISO 32000-1, 8.7.4.5.5)."""

import numpy as np

from .._core.types import Float64Array
from .paths import Paths

_VERTEX = np.dtype([("flag", "u1"), ("place", ">u4", (2,)), ("color", "u1", (3,))])  # without gaps between
_LARGEST = 2**32 - 1


def pack_gouraud(paths: Paths, start: int, end: int) -> tuple[list[float], bytes]:
    """Return paths from `start` to `end`, each a convex polygon with a gradient, as triangles in their order.

    Returns the box that the numbers of places stand for, x and y from their least to their greatest, and the vertices.
    """
    if paths.axes is None or paths.end_colors is None:
        raise ValueError("no gradients")
    offsets = paths.offsets[start : end + 1]
    points = paths.points[offsets[0] : offsets[-1]] / 100.0
    sizes = np.diff(offsets)
    path = np.repeat(np.arange(start, end), sizes)
    axes, ends = paths.axes[path].astype(np.float64), paths.end_colors[path, :, :3].astype(np.float64)
    low, high = points.min(axis=0), points.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    vertices = np.zeros(len(points), _VERTEX)
    vertices["place"] = np.rint((points - low) / span * _LARGEST).astype(np.uint32)
    vertices["color"] = np.rint(_colors_at(points, axes, ends)).astype(np.uint8)
    n_triangles = sizes - 2
    polygon = np.repeat(np.arange(len(sizes)), n_triangles)
    first = (offsets[:-1] - offsets[0])[polygon]
    second = first + 1 + np.arange(len(polygon)) - (np.cumsum(n_triangles) - n_triangles)[polygon]
    box = np.column_stack([low, low + span]).ravel().tolist()
    return box, vertices[np.column_stack([first, second, second + 1]).ravel()].tobytes()


def _colors_at(points: Float64Array, axes: Float64Array, ends: Float64Array) -> Float64Array:
    """Return the colours (n, 3) at points (n, 2) of gradients with axes (n, 4) and colours (n, 2, 3) at their ends."""
    origin, along = axes[:, :2], axes[:, 2:] - axes[:, :2]
    length = np.einsum("ij,ij->i", along, along)
    share = np.einsum("ij,ij->i", points - origin, along) / np.where(length > 0.0, length, 1.0)
    share = np.clip(share, 0.0, 1.0)[:, np.newaxis]
    colors: Float64Array = (1.0 - share) * ends[:, 0] + share * ends[:, 1]
    return colors
