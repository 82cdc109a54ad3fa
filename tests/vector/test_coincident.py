"""Lines that lie on others, held against points sampled along them."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera
from gpu_xform.vector import Stroke, VectorLayer, format_svg
from gpu_xform.vector.coincident import MIN_PIECE_PX, TOLERANCE_PX, find_uncovered, leave_out_coincident
from tests.support.solids import TURN, turned_part
from tests.support.types import Array

DASHED = Stroke(1.0, (4.0, 3.0))


def layer_of(
    segments: Sequence[tuple[float, ...]], hidden: list[bool], starts: list[float] | None = None
) -> VectorLayer:
    start = np.array(starts or [0.0] * len(segments), np.float32)
    black = np.array([[0.0, 0.0, 0.0, 1.0]])
    return VectorLayer("", np.array(segments, np.float32), np.array(hidden), start, black, Stroke(1.0, ()), DASHED)


def left_of(layer: VectorLayer, is_part: list[bool] | None = None) -> VectorLayer:
    n = len(layer.segments)
    return leave_out_coincident(layer, np.zeros(n, np.bool_) if is_part is None else np.array(is_part))


def test_the_part_of_a_hidden_line_on_a_visible_one_goes_and_dashes_run_on_behind_it() -> None:
    layer = layer_of([(10, 5, 110, 5), (70, 5, 40, 5.1)], [True, False], [2.5, 0.0])
    left = left_of(layer)
    np.testing.assert_allclose(left.segments, [(10, 5, 40, 5), (70, 5, 110, 5), (70, 5, 40, 5.1)], atol=1e-5)
    np.testing.assert_allclose(left.dash_start, [2.5, 62.5, 0.0], atol=1e-5)
    assert left.hidden.tolist() == [True, True, False]


def test_a_chain_that_comes_back_on_itself_is_drawn_once() -> None:
    there = [(10.0 * i, 3.0 * i, 10.0 * i + 10, 3.0 * i + 3) for i in range(5)]
    back = [(c, d, a, b) for a, b, c, d in there[::-1]]
    length = float(np.hypot(10, 3))
    layer = layer_of(there + back, [True] * 10, [length * i for i in range(10)])
    assert left_of(layer).segments.tolist() == np.array(there, np.float32).tolist()
    mixed = np.array([7, 1, 9, 3, 0, 5, 2, 8, 6, 4])
    shuffled = replace(layer, segments=layer.segments[mixed], dash_start=layer.dash_start[mixed])
    assert sorted(left_of(shuffled).dash_start) == pytest.approx([length * i for i in range(5)], rel=1e-6)


def test_of_hidden_lines_on_each_other_the_longer_stays() -> None:
    left = left_of(layer_of([(40, 8, 60, 8), (10, 8, 90, 8)], [True, True]))
    assert left.segments.tolist() == [[10, 8, 90, 8]]


def test_lines_that_cross_or_run_side_by_side_stay() -> None:
    segments = [(0, 0, 100, 0), (0, 1, 100, -1), (0, 2, 100, 2), (50, -9, 50, 9), (100, 0, 140, 0)]
    layer = layer_of(segments, [True] * 4 + [False])
    assert left_of(layer).segments.tolist() == layer.segments.tolist()


def test_crumbs_on_a_visible_line_go_and_whole_edges_stay() -> None:
    segments = [(20, 0, 23, 4), (14, -8, 50, 40), (26, 8, 32, 16), (60, 60, 62, 60)]
    left = left_of(layer_of(segments, [False] * 4), [True, False, False, True])
    assert left.segments.tolist() == [list(map(float, row)) for row in segments[1:]]


@pytest.mark.parametrize("change", ["clear", "two colours", "dashed", "thin"])
def test_all_stays_where_what_lies_below_shows(change: str) -> None:
    layer = layer_of([(10, 5, 110, 5), (40, 5, 70, 5), (0, 0, 3, 9)], [True, False, False])
    colors = np.tile([0.0, 0.0, 0.0, 1.0], (3, 1))
    colors[2] = (0, 0, 0, 0.5) if change == "clear" else (1, 0, 0, 1)
    changed = {
        "clear": replace(layer, colors=colors),
        "two colours": replace(layer, colors=colors),
        "dashed": replace(layer, visible_stroke=DASHED),
        "thin": replace(layer, visible_stroke=Stroke(0.5, ())),
    }[change]
    assert left_of(changed) is changed


def distance_to(points: Array, segments: Array) -> Array:
    """Return how far points (p, 2) are from the nearest of segments (k, 4)."""
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    towards = points[:, np.newaxis] - start
    t = np.clip((towards * along).sum(axis=2) / (along**2).sum(axis=1), 0.0, 1.0)
    distances: Array = np.linalg.norm(towards - t[..., np.newaxis] * along, axis=2).min(axis=1)
    return distances


def test_nothing_goes_but_what_lies_on_another_line() -> None:
    generator = np.random.default_rng(7)
    bases = generator.uniform(0, 300, (12, 4))
    low = generator.uniform(0, 0.9, (240, 1))
    ranges = np.hstack([low, low + generator.uniform(0.02, 0.3, (240, 1))])
    lines = bases[generator.integers(12, size=240)]
    along = lines[:, 2:] - lines[:, :2]
    segments = np.hstack([lines[:, :2] + ranges[:, [i]] * along for i in (0, 1)]).astype(np.float32)
    ranks = np.arange(240)
    rows, left = find_uncovered(segments, ranks, ranks > 30)
    assert set(range(31)) <= set(rows.tolist())
    start, own = segments[rows, :2], segments[rows, 2:] - segments[rows, :2]
    pieces = np.hstack([start + left[:, [i]] * own for i in (0, 1)])
    t = np.linspace(0.0, 1.0, 30)[:, np.newaxis]
    samples = np.vstack([row[:2] + t * (row[2:] - row[:2]) for row in segments])
    assert distance_to(samples, pieces).max() < 2.0 * MIN_PIECE_PX + TOLERANCE_PX
    assert np.count_nonzero(np.isin(np.arange(240), rows)) < 120


def test_a_rim_that_is_seen_edge_on_is_dashed_once() -> None:
    part = turned_part()
    below = Camera.fit(part, direction=TURN[:3, :3] @ (0, -1, -1e-3), up=TURN[:3, :3] @ (0, 0, 1), orthographic=True)
    svg = gx.render_svg(part, edges="feature", hidden="dash", camera=below, size=(128, 128))
    assert "dasharray" not in svg
    outline = re.findall(
        r' d="([^"]+)"', gx.render_svg(part, edges=["feature", "silhouette"], hidden="dash", size=(99, 99))
    )
    assert sum(path.count("M") for path in outline) < 6


def test_edges_that_are_seen_end_on_leave_no_points_on_lines() -> None:
    segments = [(0, 0, 9, 0), (9, 0, 9.001, 0.001), (30, 5, 30, 5)]
    svg = format_svg((64, 64), (1.0, 1.0, 1.0, 1.0), [layer_of(segments, [False] * 3)])
    assert re.findall(r' d="([^"]+)"', svg) == ["M0 0 9 0M30 5 30 5"]
