"""Line merging: each segment is drawn once, in as few and as straight lines as can be."""

from collections import Counter
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.vector.join_segments import join_segments

Line = list[tuple[int, int]]
COORDINATES = st.integers(-2, 2)
SEGMENTS = st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES, COORDINATES), max_size=30)


def join(segments: npt.ArrayLike, runs: npt.ArrayLike | None = None) -> tuple[list[Line], list[int]]:
    """Return the lines, as points, and the run of each."""
    ends = np.array(segments, np.int32).reshape(-1, 2, 2)
    which = np.zeros(len(ends), np.int64) if runs is None else np.array(runs, np.int64)
    points, begins = join_segments(ends, which)
    starts = np.flatnonzero(begins)
    lines = np.split(points, starts[1:])
    for line in lines:
        assert len(set(which[line >> 1].tolist())) <= 1
    places = [[(int(x), int(y)) for x, y in ends.reshape(-1, 2)[line]] for line in lines]
    return (places if len(ends) else []), which[points[starts] >> 1].tolist()


def pairs(lines: list[Line]) -> Counter[frozenset[tuple[int, int]]]:
    return Counter(frozenset(pair) for line in lines for pair in pairwise(line))


@given(SEGMENTS, st.data())
def test_each_segment_is_drawn_once_within_its_run(segments: list[tuple[int, ...]], data: st.DataObject) -> None:
    runs = sorted(data.draw(st.lists(st.integers(0, 3), min_size=len(segments), max_size=len(segments))))
    lines, of_runs = join(segments, runs)
    assert of_runs == sorted(of_runs)
    for run in set(runs):
        mine = [[(a, b), (c, d)] for (a, b, c, d), r in zip(segments, runs, strict=True) if r == run]
        assert pairs([line for line, r in zip(lines, of_runs, strict=True) if r == run]) == pairs(mine)


@given(SEGMENTS)
def test_lines_end_only_where_an_odd_number_of_segments_meet(segments: list[tuple[int, ...]]) -> None:
    lines, _ = join(segments)
    meeting = Counter(end for a, b, c, d in segments for end in ((a, b), (c, d)))
    ending = Counter(end for line in lines if line[0] != line[-1] for end in (line[0], line[-1]))
    if len(segments) > 1:
        assert all(meeting[place] % 2 == 1 and n == 1 for place, n in ending.items())


def test_where_lines_cross_each_goes_straight_on() -> None:
    across = [(x, y, x + 1, y) for y in range(5) for x in range(7)]
    down = [(x, y, x, y + 1) for x in range(8) for y in range(4)]
    segments = np.random.default_rng(0).permutation(across + down)
    turned = np.where(np.arange(len(segments))[:, np.newaxis] % 3 == 0, segments[:, [2, 3, 0, 1]], segments)
    lines, _ = join(turned)
    crossings = [
        np.subtract(line[i + 1], line[i]) == np.subtract(line[i], line[i - 1])
        for line in lines
        for i in range(1, len(line) - 1)
        if 0 < line[i][0] < 7 and 0 < line[i][1] < 4
    ]
    assert len(crossings) >= 2 * 6 * 3 - 1  # but where a line that is closed was begun
    assert np.all(crossings)


def test_a_ring_is_one_line_that_closes() -> None:
    segments = [(0, 0, 5, 1), (3, 7, 5, 1), (3, 7, 0, 0)]
    [line], _ = join(segments)
    assert line[0] == line[-1]
    assert pairs([line]) == pairs([[(a, b), (c, d)] for a, b, c, d in segments])


def test_lines_come_in_the_order_of_their_first_segments() -> None:
    lines, _ = join([(9, 9, 8, 8), (0, 0, 1, 0), (5, 5, 6, 5), (2, 0, 1, 0), (3, 0, 2, 0)])
    assert [set(line) for line in lines] == [{(9, 9), (8, 8)}, {(0, 0), (1, 0), (2, 0), (3, 0)}, {(5, 5), (6, 5)}]


def test_runs_of_one_segment_stay_as_they_are() -> None:
    lines, of_runs = join([(0, 0, 1, 0), (2, 0, 1, 0), (3, 0, 2, 0)], [4, 5, 7])
    assert lines == [[(0, 0), (1, 0)], [(2, 0), (1, 0)], [(3, 0), (2, 0)]]
    assert of_runs == [4, 5, 7]
    assert join([])[0] == []


@pytest.mark.parametrize("n", [9, 10, 11, 30, 57])
def test_a_line_too_long_goes_on_as_another(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gpu_xform.vector.join_segments.MAX_POINTS_PER_LINE", 10)
    segments = [(x, x * x, x + 1, (x + 1) ** 2) for x in range(n)]
    lines, _ = join(segments)
    assert pairs(lines) == pairs([[(a, b), (c, d)] for a, b, c, d in segments])
    assert max(map(len, lines)) <= 10
    assert len(lines) == -(-n // 9)
    for before, after in pairwise(lines):
        assert before[-1] == after[0]
