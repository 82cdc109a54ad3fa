"""Which lines share a path.

A path paints what it covers once, however often its lines cross; the lines of a picture are each painted over those
before them. So a line that lets something shine through has a path of its own: where two cross, it is darker. Opaque
lines of one colour that come one after another share a path, which nobody can tell from many.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, IndexArray
from ..imaging.colors import packed
from .decimal_text import Hundredths, Octets, hundredths
from .join_segments import LONGEST, chained
from .layer import FloatArray, Polygons, Strokes, dash_pattern

SEAM = 0.5  # pixels by which polygons of several paths overlap, or what lies behind would glimmer between them


@dataclass(frozen=True)
class Paths:
    """Paths in the order in which they are painted.

    points : (n, 2)
    begins : (n,) whether a line of a path begins at the point
    offsets : (p + 1,) path i has the points from offsets[i] to offsets[i + 1]
    colors : (p, 4) red, green, blue, alpha from 0 to 255
    phases : (p,) how far into the pattern of dashes each line starts, or None where lines are not dashed
    closed : whether lines end where they begin, as polygons do
    """

    points: Hundredths
    begins: BoolArray
    offsets: IndexArray
    colors: Octets
    phases: Hundredths | None = None
    closed: bool = False

    @property
    def ends(self) -> BoolArray:
        """Whether a line ends at the point: (n,)."""
        return np.append(self.begins[1:], True)


def octets(colors: FloatArray, n: int) -> Octets:
    """Return `n` colours with 8 bits a component, as pictures of pixels have them: (n, 4)."""
    return np.broadcast_to(packed(np.asarray(colors, np.float64))[:, None].view(np.uint8), (n, 4))


def distinct(colors: Octets) -> tuple[Octets, IndexArray]:
    """Return the colours that there are, and which of them each one is."""
    as_numbers = np.ascontiguousarray(colors).view(np.uint32)[:, 0]
    _, first, which = np.unique(as_numbers, return_index=True, return_inverse=True)
    return colors[first], which


def line_paths(strokes: Strokes, *, hidden: bool) -> Paths:
    """Return the paths of the hidden or of the visible segments; those without any alpha are left out."""
    colors = octets(strokes.colors, len(strokes.segments))
    chosen = np.flatnonzero((strokes.hidden == hidden) & (colors[:, 3] > 0))
    ends, colors = hundredths(strokes.segments[chosen]).reshape(-1, 2, 2), colors[chosen]
    if hidden and strokes.hidden_style == "dash":
        period = hundredths(np.array([sum(dash_pattern(strokes.line_width))]))
        return _dashed(ends, colors, hundredths(strokes.dash_start[chosen]) % period)
    return _solid(ends, colors)


def _solid(ends: Hundredths, colors: Octets) -> Paths:
    runs = _runs(colors)
    points, begins = chained(ends, runs)
    offsets = _offsets(begins, runs[points >> 1])
    return Paths(ends.reshape(-1, 2)[points], begins, offsets, colors[points[offsets[:-1]] >> 1])


def _dashed(ends: Hundredths, colors: Octets, phases: Hundredths) -> Paths:
    """Return paths whose lines all start at one place of the pattern: each line begins it anew, so none are strung."""
    order = np.lexsort((phases, _runs(colors)))
    ends, colors, phases = ends[order], colors[order], phases[order]
    begins = np.tile([True, False], len(ends))
    offsets = _offsets(begins, np.repeat(np.cumsum(_changes(np.column_stack([_runs(colors), phases]))), 2))
    first = offsets[:-1] // 2
    return Paths(ends.reshape(-1, 2), begins, offsets, colors[first], phases[first])


def face_paths(polygons: Polygons) -> Iterator[tuple[int, Paths]]:
    """Yield an alpha, from 0 to 255, and the opaque paths to blend with it as one: neighbours that have that alpha.

    All polygons go round the same way, or where two of a path overlap there would be a hole.
    """
    n = len(polygons.offsets) - 1
    colors = octets(polygons.colors, n)
    for start, end in pairwise([*np.flatnonzero(_changes(colors[:, 3:])), n]):
        alpha = int(colors[start, 3])
        if alpha > 0:
            yield alpha, _face_paths(hundredths(polygons.points), polygons.offsets[start : end + 1], colors[start:end])


def _face_paths(points: Hundredths, offsets: npt.NDArray[np.integer[Any]], colors: Octets) -> Paths:
    points, offsets = points[offsets[0] : offsets[-1]], offsets - offsets[0]
    sizes = np.diff(offsets)
    which = np.repeat(np.arange(len(sizes)), sizes)
    index = np.arange(len(points))
    begins = index == offsets[which]
    following = np.where(index + 1 == offsets[which + 1], offsets[which], index + 1)
    p, q = points.astype(np.float64), points[following].astype(np.float64)
    areas = np.bincount(which, p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0], len(sizes))
    points = points[np.where(areas[which] < 0.0, offsets[which] + offsets[which + 1] - 1 - index, index)]
    opaque = colors.copy()
    opaque[:, 3] = 255
    paths = _offsets(begins, _runs(opaque)[which])
    return Paths(points, begins, paths, opaque[which[paths[:-1]]], closed=True)


def _changes(rows: npt.NDArray[np.integer[Any]]) -> BoolArray:
    """Tell of each row (n, k) whether it is another than the one before."""
    changed = np.ones(len(rows), np.bool_)
    changed[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    return changed


def _runs(colors: Octets) -> IndexArray:
    """Return the number of each colour's run: opaque neighbours that are equal, or one that is not opaque."""
    return np.cumsum(_changes(colors) | (colors[:, 3] < 255))


def _offsets(begins: BoolArray, runs: IndexArray) -> IndexArray:
    """Return where each path begins, and the end: a line begins there, another run or too long a path."""
    first = np.maximum.accumulate(np.where(_changes(runs[:, None]), np.arange(len(runs)), 0))
    part = (np.arange(len(runs)) - first) // LONGEST
    lines = np.flatnonzero(begins)
    changed = _changes(np.stack([runs[lines], part[lines]], axis=1))
    return np.append(lines[changed], len(runs))
