"""Line merging: segments that share ends become polylines: half the text, and fewer lifts of a plotter's pen."""

import numpy as np

from .._core.types import BoolArray, IndexArray
from .decimal_text import FixedPoint

MAX_DASH_GAP = 5  # hundredths of a pixel, which rounding makes of none
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
    return _trace_lines(_pair_ends(ends, runs))


def join_dashes(ends: FixedPoint, distances: FixedPoint, runs: IndexArray) -> tuple[IndexArray, BoolArray]:
    """Do the same where a segment begins at the place, and as far along the dash pattern, as another ends.

    distances : (s, 2) of both ends along the pattern; segments that differ by `MAX_DASH_GAP` go on as if they did not
    """
    n = len(ends)
    if (runs[1:] != runs[:-1]).all():
        return np.arange(2 * n), np.tile([True, False], n)
    points, along = ends.reshape(-1, 2), distances.ravel()
    places = (points[:, 0].astype(np.int64) << 32) + points[:, 1]
    both_runs = np.repeat(runs, 2)
    order = np.lexsort((along, places, both_runs))
    places, both_runs, along = places[order], both_runs[order], along[order]
    is_pair = (places[1:] == places[:-1]) & (both_runs[1:] == both_runs[:-1]) & ((order[1:] ^ order[:-1]) & 1 == 1)
    is_pair &= np.abs(along[1:] - along[:-1]) <= MAX_DASH_GAP
    first = np.flatnonzero(is_pair)
    first = first[np.diff(first, prepend=-2) > 1]  # of ends in a row that could be paired, the first two are
    partner = np.full(2 * n, -1)
    a, b = order[first], order[first + 1]
    partner[a], partner[b] = b, a
    return _trace_lines(partner)


def _trace_lines(partners: IndexArray) -> tuple[IndexArray, BoolArray]:
    """Follow the ends that are paired (2s,) through all segments."""
    n = len(partners) // 2
    partner = partners.tolist()
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
