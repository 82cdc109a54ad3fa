"""Segments that meet, strung into lines: half the text, and a pen that draws them is lifted less often."""

import numpy as np
import numpy.typing as npt

from .decimal_text import Hundredths

LONGEST = 10_000  # points of a line, and of a path: readers of XML refuse texts of ten million characters


def chained(ends: Hundredths, runs: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """Return the points of lines through all segments, as indices into the segments' ends, and where a line begins.

    ends : (s, 2, 2) both ends of each segment
    runs : (s,) ascending; only segments of one run are strung together

    Where lines cross, each goes straight on. Lines come in the order of their first segments.
    """
    n = len(ends)
    if (runs[1:] != runs[:-1]).all():
        return np.arange(2 * n), np.tile([True, False], n)
    partner = _partners(ends, runs).tolist()
    seen = bytearray(n)
    points: list[int] = []
    begins: list[int] = []
    for segment in range(n):
        if seen[segment]:
            continue
        end = 2 * segment  # an even and the next odd index are the ends of one segment
        while (before := partner[end]) >= 0 and before ^ 1 != 2 * segment:
            end = before ^ 1
        begin = len(points)
        begins.append(begin)
        points.append(end)
        while True:
            seen[end >> 1] = 1
            points.append(end ^ 1)
            end = partner[end ^ 1]
            if end < 0 or seen[end >> 1]:
                break
            if len(points) - begin >= LONGEST:
                begin = len(points)
                begins.append(begin)
                points.append(end)
    is_first = np.zeros(len(points), np.bool_)
    is_first[begins] = True
    return np.array(points, np.int64), is_first


def _partners(ends: Hundredths, runs: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return, for each end of a segment, the end of another with which a line goes on, or -1: (2s,).

    The segments that meet in a point are ordered by their angles, and paired with those half the way round.
    """
    points = ends.reshape(-1, 2)
    directions = (ends[:, ::-1] - ends).reshape(-1, 2)
    angles = np.arctan2(directions[:, 1], directions[:, 0], dtype=np.float32)
    places = (points[:, 0].astype(np.int64) << 32) + points[:, 1]
    runs = np.repeat(runs, 2)
    order = np.lexsort((angles, places, runs))
    places, runs = places[order], runs[order]
    first = np.flatnonzero(np.concatenate([[True], (places[1:] != places[:-1]) | (runs[1:] != runs[:-1])]))
    degrees = np.diff(np.append(first, len(order)))
    rank = np.arange(len(order)) - np.repeat(first, degrees)
    half = np.repeat(degrees // 2, degrees)
    near = np.flatnonzero(rank < half)
    a, b = order[near], order[near + half[near]]
    partner = np.full(len(order), -1)
    partner[a], partner[b] = b, a
    return partner
