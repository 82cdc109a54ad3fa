"""Line merging: segments that share ends become polylines: half the text, and fewer lifts of a plotter's pen."""

import numpy as np

from .._core.types import BoolArray, IndexArray
from .decimal_text import FixedPoint

MAX_POINTS_PER_LINE = 10_000  # and per path: XML readers refuse texts of ten million characters


def join_segments(ends: FixedPoint, runs: IndexArray) -> tuple[IndexArray, BoolArray]:
    """Return the points of lines through all segments, as indices into the segments' ends, and where a line begins.

    ends : (s, 2, 2) both ends of each segment
    runs : (s,) ascending; only segments of one run are joined

    At a crossing, each line goes straight on. Lines come in the order of their first segments.
    """
    n = len(ends)
    if (runs[1:] != runs[:-1]).all():
        return np.arange(2 * n), np.tile([True, False], n)
    partner = _pair_ends(ends, runs).tolist()
    is_done = bytearray(n)
    points: list[int] = []
    begins: list[int] = []
    for segment in range(n):
        if is_done[segment]:
            continue
        end = 2 * segment  # an even and the next odd index are the ends of one segment
        while (before := partner[end]) >= 0 and before ^ 1 != 2 * segment:
            end = before ^ 1
        begin = len(points)
        begins.append(begin)
        points.append(end)
        while True:
            is_done[end >> 1] = 1
            points.append(end ^ 1)
            end = partner[end ^ 1]
            if end < 0 or is_done[end >> 1]:
                break
            if len(points) - begin >= MAX_POINTS_PER_LINE:
                begin = len(points)
                begins.append(begin)
                points.append(end)
    is_first = np.zeros(len(points), np.bool_)
    is_first[begins] = True
    return np.array(points, np.int64), is_first


def _pair_ends(ends: FixedPoint, runs: IndexArray) -> IndexArray:
    """Return, for each end of a segment, the end of another at which a line continues, or -1: (2s,).

    The segments that meet in a point are sorted by angle; each is paired with the one half of the way round.
    """
    points = ends.reshape(-1, 2)
    directions = (ends[:, ::-1] - ends).reshape(-1, 2)
    angles = np.arctan2(directions[:, 1], directions[:, 0], dtype=np.float32)
    keys = (points[:, 0].astype(np.int64) << 32) + points[:, 1]
    runs = np.repeat(runs, 2)
    order = np.lexsort((angles, keys, runs))
    keys, runs = keys[order], runs[order]
    first = np.flatnonzero(np.concatenate([[True], (keys[1:] != keys[:-1]) | (runs[1:] != runs[:-1])]))
    degrees = np.diff(np.append(first, len(order)))
    rank = np.arange(len(order)) - np.repeat(first, degrees)
    half = np.repeat(degrees // 2, degrees)
    in_first_half = np.flatnonzero(rank < half)
    a, b = order[in_first_half], order[in_first_half + half[in_first_half]]
    partner = np.full(len(order), -1)
    partner[a], partner[b] = b, a
    return partner
