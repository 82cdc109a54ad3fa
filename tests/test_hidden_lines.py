"""Hidden lines, held against the exact answer: nothing visible is eaten, and nothing hidden leaks."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pytest
from solids import centred, interlocked_boxes, l_prism, staircase, star_prism, thin_plates
from visibility import SLIVER, Array, in_pixels, in_view, visible_intervals

import gpu_xform as gx
from gpu_xform import Camera, Mesh, samples

SIZE = (900, 700)
LINE_WIDTH = 1.5
APART = 3.0  # pixels from a line to what it does not touch
MARGIN = 3  # pixels added around a picture
FULL = 0.7  # of a line's ink; the least where it is not eaten


class Wrong(NamedTuple):
    """What parts of the length of all edges in the picture are visible but missing, and hidden but drawn."""

    eaten: float
    leaked: float


def wrong_length(ends: Array, drawn: Sequence[Array], visible: Sequence[Array], *, near: float = 0.0) -> Wrong:
    """Compare the parts of every edge that are drawn with those that are visible, as `visible_intervals` has both.

    ends : (m, 2, 2) of what is in view of each edge, in pixels; NaN where nothing is
    near : pixels; what is missing does not count where another edge is drawn so close to it, nor what is drawn where
        any edge is visible so close: the edges of a face that is seen almost from its edge are one line to the eye
    """
    total = np.nansum(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
    missing = [difference(whole, part) for whole, part in zip(visible, drawn, strict=True)]
    surplus = [difference(part, whole) for whole, part in zip(visible, drawn, strict=True)]
    return Wrong(
        length_apart(ends, missing, drawn, near, own=False) / total,
        length_apart(ends, surplus, visible, near, own=True) / total,
    )


def difference(a: Array, b: Array) -> Array:
    """Return what of the intervals `a` (k, 2) is in none of `b`, ascending."""
    cuts = np.unique(np.concatenate([a.ravel(), b.ravel()]))
    middles = 0.5 * (cuts[1:] + cuts[:-1])
    left = within(middles, a) & ~within(middles, b)
    return np.stack([cuts[:-1][left], cuts[1:][left]], axis=1)


def within(t: Array, parts: Array) -> Array:
    """Return which of `t` (n,) lie in one of the intervals (k, 2)."""
    return np.asarray(((parts[:, :1] < t) & (t < parts[:, 1:])).any(axis=0))


def length_apart(ends: Array, parts: Sequence[Array], others: Sequence[Array], near: float, *, own: bool) -> float:
    """Return the length of those parts that are farther than `near` from all of `others`, in pixels.

    own : whether what is in `others` of an edge counts for the parts of that edge
    """
    lines = Lines(ends, others)
    apart = 0.0
    for edge, own_parts in enumerate(parts):
        for begin, end in own_parts:
            a, b = ends[edge, 0] + np.array([[begin], [end]]) * (ends[edge, 1] - ends[edge, 0])
            length = float(np.hypot(*(b - a)))
            if near > 0.0:
                n = int(length / 0.25) + 1
                points = a + ((np.arange(n) + 0.5) / n)[:, np.newaxis] * (b - a)
                distance, owners = lines.distances(points, near)
                length *= (distance[:, own | (owners != edge)] > near).all(axis=1).mean()
            apart += length
    return apart


class Lines:
    """Parts of edges as lines in a picture, `ends` (k, 2, 2), to find those that are near."""

    def __init__(self, ends: Array, parts: Sequence[Array]) -> None:
        self._owners = np.repeat(np.arange(len(ends)), [len(of_edge) for of_edge in parts])
        flat = np.concatenate([np.empty((0, 2)), *parts])[..., np.newaxis]
        self.ends = ends[self._owners, :1] + flat * np.diff(ends[self._owners], axis=1)
        self._low, self._high = self.ends.min(axis=1), self.ends.max(axis=1)

    def distances(self, points: Array, reach: float) -> tuple[Array, Array]:
        """Return how far points (n, 2) are from the k lines within `reach`, and some more: (n, k); and whose they are.

        The edge of each line is (k,).
        """
        close = (self._low - reach <= points.max(axis=0)) & (self._high + reach >= points.min(axis=0))
        found = np.flatnonzero(close.all(axis=1))
        start, end = self.ends[found].swapaxes(0, 1)
        along, from_start = end - start, points[:, np.newaxis] - start
        square = np.maximum(np.einsum("ki,ki->k", along, along), 1e-300)
        t = np.clip(np.einsum("nki,ki->nk", from_start, along) / square, 0.0, 1.0)
        return np.linalg.norm(from_start - t[..., np.newaxis] * along, axis=2), self._owners[found]


def drawn_intervals(ends: Array, edges: Array, strokes: Array) -> list[Array]:
    """Return the parts of every edge that strokes cover, as `visible_intervals` has them.

    ends : (m, 2, 2) of what is in view of each edge, in pixels
    edges : (s,) which edge each stroke belongs to
    strokes : (s, 2, 2) pixels

    Raises ValueError where a stroke lies beside its edge.
    """
    along = ends[edges, 1] - ends[edges, 0]
    square = np.einsum("ij,ij->i", along, along)[:, np.newaxis]
    from_start = strokes - ends[edges, :1]
    across = np.abs(from_start[..., 0] * along[:, 1:] - from_start[..., 1] * along[:, :1]) / np.sqrt(square)
    if across.max(initial=0.0) > 0.05:
        raise ValueError(f"a stroke lies {across.max():g} pixels beside its edge")
    parts = np.clip(np.einsum("ski,si->sk", from_start, along) / square, 0.0, 1.0)
    parts.sort(axis=1)
    result = []
    for edge in range(len(ends)):
        own = parts[edges == edge]
        own = own[np.argsort(own[:, 0])]
        fresh = np.append(True, own[1:, 0] > np.maximum.accumulate(own[:, 1])[:-1] + SLIVER)[: len(own)]
        starts = np.flatnonzero(fresh)
        result.append(np.stack([own[starts, 0], np.maximum.reduceat(own[:, 1], starts)], axis=1) if len(own) else own)
    return result


class Judged(NamedTuple):
    """What a picture shows of the edges where no other line is near: `wrong`, and the part of their length judged."""

    wrong: Wrong
    part: float


def judge_picture(picture: Array, ends: Array, visible: Sequence[Array]) -> Judged:
    """Look at black lines on white, pixel by pixel along every edge, where all other lines are farther than APART.

    picture : (height, width, 4) uint8, lines of LINE_WIDTH
    ends : (m, 2, 2) of what is in view of each edge, in pixels; NaN where nothing is

    Across a visible place lies FULL of a line's ink at least; a hidden place is blank.
    """
    ink = np.pad(1.0 - picture[..., 0] / 255.0, MARGIN)
    lines = Lines(ends, visible)
    n_eaten = n_leaked = n_judged = n_samples = 0
    for edge in np.flatnonzero(np.isfinite(ends).all(axis=(1, 2))).tolist():
        a, b = ends[edge]
        length = float(np.hypot(*(b - a)))
        n = int(length)
        if n == 0:
            continue
        t = (np.arange(n) + 0.5) / n
        points = a + t[:, np.newaxis] * (b - a)
        distance, owners = lines.distances(points, APART)
        alone = (distance[:, owners != edge] > APART).all(axis=1)
        from_ends = np.abs(t[:, np.newaxis] - visible[edge].ravel()).min(axis=1, initial=1.0) * length
        inside = within(t, visible[edge])
        is_seen = alone & inside & (from_ends > APART)
        is_hidden = alone & ~inside & (from_ends > APART)
        # In each column of pixels that a flat line crosses lies its width over the cosine of its slope.
        is_steep = abs(b[1] - a[1]) > abs(b[0] - a[0])
        full = LINE_WIDTH * length / np.abs(b - a).max()
        x, y = np.floor(points).astype(np.int64).T + MARGIN
        reach = np.arange(-2, 3)[:, np.newaxis]
        across = (ink[y, x + reach] if is_steep else ink[y + reach, x]).sum(axis=0)
        n_eaten += int((across < FULL * full)[is_seen].sum())
        n_leaked += int((ink[y, x] > 0.0)[is_hidden].sum())
        n_judged += int((is_seen | is_hidden).sum())
        n_samples += n
    return Judged(Wrong(n_eaten / n_samples, n_leaked / n_samples), n_judged / n_samples)


SAMPLES = {
    "cube": samples.cube(),
    "house": samples.house(),
    "snub dodecahedron": samples.snub_dodecahedron(),
    "icosphere": samples.icosphere(3),
    "torus": samples.torus(24, 13),
    "L": centred(l_prism()),
    "star": centred(star_prism()),
    "boxes": interlocked_boxes(),
    "plates": thin_plates(),
    "stairs": centred(staircase(), 0.5),
}
DEGREE = np.pi / 180


def views(mesh: Mesh) -> dict[str, Camera]:
    """Return cameras for a mesh around 0, whose faces are often at right angles to the axes."""
    radius = float(np.linalg.norm(mesh.positions, axis=1).max())

    def away(direction: Sequence[float], distance: float) -> Array:
        """Return the eye that looks along `direction`, `distance` times the radius from 0."""
        eye: Array = -distance * radius * np.array(direction) / np.linalg.norm(direction)
        return eye

    along_x, along_z = (-1.0, -0.5 * DEGREE, -1.0 * DEGREE), (1.0 * DEGREE, -2.0 * DEGREE, -1.0)
    return {
        "fit": Camera.fit(mesh),
        "from below": Camera.fit(mesh, direction=(0.3, 1.0, -0.4), fov_y=75.0),
        "parallel": Camera.fit(mesh, direction=(0.5, -0.3, -0.7), orthographic=True),
        "grazing x, y": Camera.fit(mesh, direction=along_z, fov_y=2.0),
        "grazing y, z": Camera.fit(mesh, direction=along_x, orthographic=True),
        "grazing, wide": Camera.look_at(away(along_x, 1.9), (0.1, 0.05, 0.02), fov_y=70.0),
        "off-centre": Camera.look_at(away((-0.4, 0.7, -1.0), 3.0), (0.7 * radius, 0.5 * radius, 0.0)),
        "near": Camera.look_at(away((0.9, -0.8, -0.7), 1.1), (0.0, 0.1, 0.0), fov_y=60.0),
        "far": Camera.look_at(away((-0.6, -0.5, -1.0), 30.0), (radius, 0.0, 0.0)),
    }


def seen(mesh: Mesh, camera: Camera) -> tuple[Array, list[Array]]:
    """Return what is in view of each edge, in pixels (m, 2, 2), and the parts of it that are visible."""
    clip_from_model = camera.clip_from_world(SIZE[0] / SIZE[1])
    ends = in_pixels(in_view(mesh, mesh.edges, clip_from_model).clip, SIZE)
    return ends, visible_intervals(mesh, mesh.edges, clip_from_model)


def picture_of(ends: Array, parts: Sequence[Array]) -> Array:
    """Draw parts of edges as they are, black on white."""
    lines = Lines(ends, parts).ends
    points = np.column_stack([lines.reshape(-1, 2), np.zeros(2 * len(lines))])
    points[:, 1] = SIZE[1] - points[:, 1]
    return gx.render_array(
        Mesh(points, np.arange(len(points)).reshape(-1, 2)),
        camera=Camera.window((0, SIZE[0]), (0, SIZE[1])),
        size=SIZE,
        line_width=LINE_WIDTH,
    )


WHOLE = np.array([(0.0, 1.0)])
NOTHING = np.empty((0, 2))
THREE = np.array([[(0, 0), (40, 0)], [(0, 0), (0, 60)], [(0, 0.8), (80, 60.8)], [(np.nan, np.nan)] * 2])


def test_wrong_lengths_are_parts_of_all_that_is_in_view() -> None:
    visible = [np.array([(0.0, 0.5)]), WHOLE, NOTHING, NOTHING]
    assert wrong_length(THREE, visible, visible) == (0.0, 0.0)
    drawn = [np.array([(0.25, 0.5), (0.75, 1.0)]), np.array([(0.0, 0.2), (0.3, 0.9)]), np.array([(0.6, 0.65)]), NOTHING]
    eaten, leaked = wrong_length(THREE, drawn, visible)
    assert eaten == pytest.approx((0.25 * 40 + 0.2 * 60) / 200)
    assert leaked == pytest.approx((0.25 * 40 + 0.05 * 100) / 200)
    assert wrong_length(THREE, visible, drawn) == pytest.approx((leaked, eaten))


def test_what_looks_the_same_is_forgiven_and_gaps_in_a_line_are_not() -> None:
    close = np.array([[(0, 0), (100, 0)], [(0, 0.6), (100, 0.6)], [(0, 9), (100, 9)]])
    one_for_another = wrong_length(close, [NOTHING, WHOLE, WHOLE], [WHOLE, NOTHING, WHOLE], near=1.0)
    assert one_for_another == (0.0, 0.0)
    assert wrong_length(close, [NOTHING, WHOLE, WHOLE], [WHOLE, NOTHING, WHOLE], near=0.5) == pytest.approx(
        (1 / 3, 1 / 3)
    )
    dashes = np.arange(0, 100, 2)[:, np.newaxis] / 100 + [0.0, 0.01]
    assert wrong_length(close, [WHOLE, NOTHING, dashes], [WHOLE, NOTHING, WHOLE], near=1.0) == pytest.approx((1 / 6, 0))
    cut = [np.array([(0.0, 0.5)]), NOTHING, WHOLE]
    longer = [np.array([(0.0, 0.6)]), NOTHING, WHOLE]
    assert wrong_length(close, longer, cut, near=1.0).leaked == pytest.approx(0.09 / 3, abs=0.002)
    assert wrong_length(close, cut, longer, near=1.0).eaten == pytest.approx(0.1 / 3)


def test_strokes_become_parts_of_their_edges() -> None:
    edges = np.array([2, 0, 0, 0, 1])
    strokes = np.array(
        [[(40, 30.8), (8, 6.8)], [(10, 0), (20, 0)], [(30, 0), (50, 0)], [(20, 0), (25, 0)], [(0, 0), (0, 0)]],
        dtype=np.float64,
    )
    parts = drawn_intervals(THREE, edges, strokes)
    assert parts[0] == pytest.approx(np.array([(0.25, 0.625), (0.75, 1.0)]))
    assert parts[1] == pytest.approx(np.array([(0.0, 0.0)]))
    assert parts[2] == pytest.approx(np.array([(0.1, 0.5)]))
    assert len(parts[3]) == 0
    with pytest.raises(ValueError, match=r"0\.4 pixels beside"):
        drawn_intervals(THREE, edges[1:2], strokes[1:2] + np.array([0.0, 0.4]))


@pytest.mark.parametrize("name", ["house", "star", "icosphere", "boxes"])
def test_a_picture_of_what_is_visible_is_judged_right(name: str) -> None:
    ends, visible = seen(SAMPLES[name], views(SAMPLES[name])["fit"])
    judged = judge_picture(picture_of(ends, visible), ends, visible)
    assert judged.wrong == (0.0, 0.0)
    assert judged.part > 0.5


def test_a_wrong_picture_is_judged_by_how_much_of_it_is_wrong() -> None:
    ends, visible = seen(SAMPLES["stairs"], views(SAMPLES["stairs"])["fit"])
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    shown = np.array([np.diff(parts).sum() for parts in visible]) * lengths
    eaten, leaked = judge_picture(picture_of(ends, [WHOLE] * len(ends)), ends, visible).wrong
    assert eaten == 0.0
    assert 0.85 < leaked / (1.0 - shown.sum() / lengths.sum()) < 1.0
    eaten, leaked = judge_picture(np.full((SIZE[1], SIZE[0], 4), 255, np.uint8), ends, visible).wrong
    assert 0.85 < eaten / (shown.sum() / lengths.sum()) < 1.0
    assert leaked == 0.0
    longest = int(np.argmax(shown))
    dashes = np.arange(0.0, 1.0, 0.02)[:, np.newaxis] + [0.0, 0.01]
    dashed = [dashes if edge == longest else parts for edge, parts in enumerate(visible)]
    eaten, leaked = judge_picture(picture_of(ends, dashed), ends, visible).wrong
    assert leaked == 0.0
    assert 0.1 < eaten / (lengths[longest] / lengths.sum()) < 0.9


def test_half_a_line_is_not_a_line() -> None:
    ends = np.array([[(20.0, 349.9), (680.0, 349.9)]])
    for turned in (ends, ends[..., ::-1]):
        picture = picture_of(turned, [WHOLE])
        assert judge_picture(picture, turned, [WHOLE]).wrong == (0.0, 0.0)
        picture[350:] = 255
        picture[:, 350:] = 255
        assert judge_picture(picture, turned, [WHOLE]).wrong.eaten > 0.98
