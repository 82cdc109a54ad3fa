"""Reference picture of vector layers: exact coverage, composited one line after another."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from gpu_xform.vector import Polygons, VectorLayer
from tests.support.reference_coverage import bar_areas, capsule_areas
from tests.support.types import Array

SAMPLES = 8  # per side of a pixel


def composite_layers(size: tuple[int, int], background: Sequence[float], layers: Iterable[VectorLayer]) -> Array:
    """Return the picture (height, width, 4), premultiplied, from 0 to 1."""
    width, height = size
    picture = np.empty((height, width, 4))
    picture[:] = _premultiplied(background)
    for layer in layers:
        for covered, color in _covers(layer, size):
            source = covered[..., np.newaxis] * _premultiplied(color)
            picture = source + (1.0 - source[..., 3:]) * picture
    return picture


def _premultiplied(color: Sequence[float] | Array) -> Array:
    return np.array([*np.multiply(color[:3], color[3]), color[3]])


def _covers(layer: VectorLayer, size: tuple[int, int]) -> Iterator[tuple[Array, Array]]:
    """Yield the coverage of every pixel (height, width) and the colour, for one primitive after another."""
    if layer.polygons is not None:
        yield from _polygon_covers(layer.polygons, size)
    n = len(layer.segments)
    colors = np.broadcast_to(layer.colors, (n, 4))
    for i in sorted(range(n), key=lambda i: not layer.hidden[i]):
        a, b = layer.segments[i].astype(np.float64).reshape(2, 2)
        stroke = layer.stroke(hidden=bool(layer.hidden[i]))
        if stroke.dash:
            dashes = _dashes(a, b, float(layer.dash_start[i]), stroke.dash)
            covered = sum((bar_areas(p, q, stroke.line_width, size) for p, q in dashes), np.zeros(size[::-1]))
        else:
            covered = capsule_areas(a, b, stroke.line_width, size)
        yield covered, colors[i]
    if layer.points is not None:
        shown = np.broadcast_to(layer.points.colors, (len(layer.points.circles), 4))
        for (x, y, diameter), color in zip(layer.points.circles, shown, strict=True):
            middle = np.array([x, y], np.float64)
            yield capsule_areas(middle, middle, float(diameter), size), color


def _dashes(a: Array, b: Array, start: float, pattern: tuple[float, ...]) -> Iterator[tuple[Array, Array]]:
    length = float(np.hypot(*(b - a)))
    period = sum(pattern)
    bounds = np.cumsum([0.0, *pattern])
    for k in range(int(start // period), int((start + length) // period) + 1):
        for begin, end in zip(bounds[:-1:2] + k * period - start, bounds[1::2] + k * period - start, strict=True):
            low, high = max(begin, 0.0), min(end, length)
            if low < high:
                yield a + (b - a) * low / length, a + (b - a) * high / length


def _polygon_covers(polygons: Polygons, size: tuple[int, int]) -> Iterator[tuple[Array, Array]]:
    """Adjacent polygons of one alpha hide one another and are composited as one; each may have another colour."""
    colors = np.broadcast_to(polygons.colors, (len(polygons.offsets) - 1, 4))
    cuts = [0, *(np.flatnonzero(np.diff(colors[:, 3])) + 1).tolist(), len(colors)]
    for first, end in pairwise(cuts):
        nearest = np.full((SAMPLES * size[1], SAMPLES * size[0]), -1)
        for i in range(first, end):
            nearest[_inside(polygons.points[polygons.offsets[i] : polygons.offsets[i + 1]], size)] = i
        # Of all that is not covered by earlier ones of the same group, so that blending them in turn adds them up.
        left = np.ones(size[::-1])
        for i in range(first, end):
            covered = _by_pixel((nearest == i).astype(np.float64))
            yield np.divide(covered, left, out=np.zeros_like(left), where=left > 1e-9), colors[i]
            left = left - covered * colors[i, 3]


def _inside(corners: npt.NDArray[np.floating], size: tuple[int, int]) -> npt.NDArray[np.bool_]:
    x, y = _samples(size)
    inside = np.zeros(x.shape, np.bool_)
    for p, q in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if p[1] != q[1]:
            crosses = (y >= min(p[1], q[1])) & (y < max(p[1], q[1]))
            inside ^= crosses & (x < p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]))
    return inside


def _samples(size: tuple[int, int]) -> tuple[Array, Array]:
    y, x = (np.mgrid[: SAMPLES * size[1], : SAMPLES * size[0]] + 0.5) / SAMPLES
    return x, y


def _by_pixel(samples: Array) -> Array:
    height, width = samples.shape
    mean: Array = samples.reshape(height // SAMPLES, SAMPLES, width // SAMPLES, SAMPLES).mean(axis=(1, 3))
    return mean
