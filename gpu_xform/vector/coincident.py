"""Coincident lines: what lies on another line in the picture is left out, as drawings for print have it.

A hidden line on a visible one is not drawn, and of two hidden ones the longer alone, or its dashes would fill the gaps
of the other. Of visible edges, the parts that rounding leaves on an outline go.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array, IndexArray
from .decimal_text import to_fixed_point
from .join_segments import join_dashes
from .layer import FloatArray, VectorLayer

TOLERANCE_PX = 0.3  # between lines that are one in print
MIN_PIECE_PX = 0.5  # of what is left of a line; less is rounding
CELL_PX = 8.0
MAX_SINE = 0.15  # of the angle between lines that are one: of facets of two circles
STEEP = 0.8  # of slopes: such a line may count as steep or as flat
MAX_SEGMENTS = 1 << 16
MAX_PAIRS = 1 << 20  # of lines close to each other; pictures of more, dense meshes, stay as they are


def leave_out_coincident(layer: VectorLayer, is_part: BoolArray) -> VectorLayer:
    """Return a layer without what lies on other lines of it, if no line shows what is under it.

    is_part : (s,) which segments are parts of edges that are hidden elsewhere
    """
    hidden, n = layer.hidden, len(layer.segments)
    may_go = hidden | is_part
    is_narrower = layer.hidden_stroke.line_width <= layer.visible_stroke.line_width
    looks = np.broadcast_to(layer.colors, (n, 4))
    if not (may_go.any() and n <= MAX_SEGMENTS and is_narrower and not layer.visible_stroke.dash):
        return layer
    if (looks[:, 3] < 1.0).any() or any((looks[own] != looks[own][:1]).any() for own in (hidden, ~hidden)):
        return layer
    ranks = np.zeros(n, np.int64)
    parts = to_fixed_point(layer.segments[is_part])
    lengths = np.rint(np.hypot(*(parts[:, 2:] - parts[:, :2]).T))
    ranks[is_part] = 1 + np.argsort(np.lexsort((*parts.T, -lengths)))
    ranks[hidden] = n + 1 + _rank_by_length(layer.segments[hidden], layer.dash_start[hidden])
    rows, ranges = find_uncovered(layer.segments, ranks, may_go)
    start, along = layer.segments[rows, :2], layer.segments[rows, 2:] - layer.segments[rows, :2]
    ends = [
        np.where(ranges[:, [i]] == i, layer.segments[rows, 2 * i : 2 * i + 2], start + ranges[:, [i]] * along)
        for i in (0, 1)
    ]
    return replace(
        layer,
        segments=np.hstack(ends),
        hidden=hidden[rows],
        dash_start=layer.dash_start[rows] + ranges[:, 0] * np.hypot(*along.T),
        colors=layer.colors if len(layer.colors) == 1 else layer.colors[rows],
    )


def _rank_by_length(segments: FloatArray, starts: FloatArray) -> IndexArray:
    """Return the rank of each segment (s,): those of long lines before those of short ones, along each line."""
    ends = to_fixed_point(segments).reshape(-1, 2, 2)
    lengths = np.hypot(*(segments[:, 2:] - segments[:, :2]).T)
    distances = to_fixed_point(np.stack([starts, starts + lengths], axis=1))
    points, begins = join_dashes(ends, distances, np.zeros(len(ends), np.int64))
    line = np.empty(len(ends), np.int64)
    line[points >> 1] = np.cumsum(begins)
    ranks = np.empty(len(ends), np.int64)
    ranks[np.lexsort((starts, -np.bincount(line, lengths)[line]))] = np.arange(len(ends))
    return ranks


class Pieces(NamedTuple):
    """What is left of segments: the row of each piece (p,), and where on it each begins and ends (p, 2), 0 to 1."""

    rows: IndexArray
    ranges: Float64Array


def find_uncovered(segments: npt.NDArray[np.float32], ranks: IndexArray, may_go: BoolArray) -> Pieces:
    """Return what of segments (s, 4) does not lie on a segment of a lower rank.

    ranks : (s,) 0 for those that stay whole, as all do where `may_go` (s,) is false
    """
    ends = segments.astype(np.float64).reshape(-1, 2, 2)
    whole = np.arange(len(ends)), np.tile([0.0, 1.0], (len(ends), 1))
    upper = np.flatnonzero(may_go)
    pairs = _find_neighbours(ends, upper) if len(upper) else None
    if pairs is None:
        return Pieces(*whole)
    row, other = pairs
    lower = ranks[other] < ranks[row]
    row, low, high = _find_overlaps(ends, row[lower], other[lower])
    if len(row) == 0:
        return Pieces(*whole)
    rows, ranges = _subtract(row, low, high)
    lengths = np.linalg.norm(ends[rows, 1] - ends[rows, 0], axis=1)
    stays = (ranges[:, 1] - ranges[:, 0]) * lengths >= MIN_PIECE_PX
    untouched = np.setdiff1d(whole[0], row)
    rows, ranges = np.append(rows[stays], untouched), np.vstack([ranges[stays], whole[1][untouched]])
    order = np.argsort(rows, kind="stable")
    return Pieces(rows[order], ranges[order])


def _find_neighbours(ends: Float64Array, upper: IndexArray) -> tuple[IndexArray, IndexArray] | None:
    """Return pairs of a segment of `upper` and any other that is close to it and about as steep; None for too many."""
    size = np.abs(ends[:, 1] - ends[:, 0])
    is_steep = size[:, 1] > size[:, 0]
    is_both = size.min(axis=1) > STEEP * size.max(axis=1)
    rows, cells = [], []
    for steep in (False, True):
        own = np.flatnonzero((is_steep == steep) | is_both)
        row, cell = _columns(ends[own][:, :, ::-1] if steep else ends[own])
        rows.append(own[row])
        cells.append(np.column_stack([cell, np.full(len(cell), steep)]))
    row, cell = np.concatenate(rows), np.vstack(cells)
    asks = np.flatnonzero(np.isin(row, upper) & (is_steep[row] == cell[:, 2]))
    cell[:, :2] -= cell[:, :2].min(axis=0) - 1
    n_rows = int(cell[:, 1].max()) + 2
    keys = (2 * cell[:, 0] + cell[:, 2]) * n_rows + cell[:, 1]
    order = np.argsort(keys, kind="stable")
    found = []
    for step in (-1, 0, 1):
        begin = np.searchsorted(keys[order], keys[asks] + step, "left")
        n = np.searchsorted(keys[order], keys[asks] + step, "right") - begin
        found.append((begin, n))
    if sum(int(n.sum()) for _, n in found) > MAX_PAIRS:
        return None
    one, other = [], []
    for begin, n in found:
        one.append(np.repeat(row[asks], n))
        other.append(row[order[np.repeat(begin - np.cumsum(n) + n, n) + np.arange(n.sum())]])
    pairs = np.unique(np.concatenate(one) * len(ends) + np.concatenate(other))
    return pairs // len(ends), pairs % len(ends)


def _columns(ends: Float64Array) -> tuple[IndexArray, IndexArray]:
    """Return the cells (c, 2) of flat segments, one in each column, and the segment of each (c,)."""
    along = np.sort(ends[:, :, 0], axis=1)
    first, last = np.floor(along / CELL_PX).astype(np.int64).T
    n = last - first + 1
    row = np.repeat(np.arange(len(ends)), n)
    column = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n) + first[row]
    x = np.clip((column + 0.5) * CELL_PX, along[row, 0], along[row, 1])
    start, end = ends[row, 0], ends[row, 1]
    length = end[:, 0] - start[:, 0]
    t = np.divide(x - start[:, 0], length, out=np.zeros(len(row)), where=length != 0.0)
    y = start[:, 1] + t * (end[:, 1] - start[:, 1])
    return row, np.column_stack([column, np.floor(y / CELL_PX).astype(np.int64)])


def _find_overlaps(
    ends: Float64Array, row: IndexArray, other: IndexArray
) -> tuple[IndexArray, Float64Array, Float64Array]:
    """Return the pairs' segments that lie on the other one, and from where to where, 0 to 1."""
    start, along = ends[row, 0], ends[row, 1] - ends[row, 0]
    square = np.einsum("ij,ij->i", along, along)
    proper = square > 0.0
    row, start, along, square = row[proper], start[proper], along[proper], square[proper]
    towards = ends[other[proper]] - start[:, np.newaxis]
    t = np.einsum("ikj,ij->ik", towards, along) / square[:, np.newaxis]
    aside = (towards[:, :, 1] * along[:, :1] - towards[:, :, 0] * along[:, 1:]) / np.sqrt(square)[:, np.newaxis]
    low, high = np.clip(t.min(axis=1), 0.0, 1.0), np.clip(t.max(axis=1), 0.0, 1.0)
    length = t[:, 1] - t[:, 0]
    is_over = (high > low) & (length != 0.0)
    is_over &= np.abs(aside[:, 1] - aside[:, 0]) <= MAX_SINE * np.abs(length) * np.sqrt(square)
    slope = np.divide(aside[:, 1] - aside[:, 0], length, out=np.zeros(len(row)), where=length != 0.0)
    for at in (low, high):
        is_over &= np.abs(aside[:, 0] + (at - t[:, 0]) * slope) <= TOLERANCE_PX
    return row[is_over], low[is_over], high[is_over]


def _subtract(row: IndexArray, low: Float64Array, high: Float64Array) -> tuple[IndexArray, Float64Array]:
    """Return what of the range from 0 to 1 of each row is in none of its intervals."""
    order = np.lexsort((low, row))
    row, low, high = row[order], low[order], high[order]
    is_first = np.diff(row, prepend=-1) != 0
    base = 2.0 * np.cumsum(is_first)  # so that the ranges of rows lie apart
    reach = np.maximum.accumulate(base + high)
    before = np.maximum(np.append(0.0, reach[:-1]), base) - base
    is_last = np.append(is_first[1:], True)
    rows = np.append(row, row[is_last])
    begins = np.append(before, (reach - base)[is_last])
    finishes = np.append(low, np.ones(int(is_last.sum())))
    is_left = finishes > begins
    order = np.lexsort((begins[is_left], rows[is_left]))
    return rows[is_left][order], np.column_stack([begins, finishes])[is_left][order]
