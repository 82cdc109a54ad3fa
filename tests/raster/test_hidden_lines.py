"""Hidden lines, held against the exact answer: nothing visible is eaten, and nothing hidden leaks."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Mesh, rotate, rotate_x, rotate_y, samples, scale
from gpu_xform.drawing.prepare import Frame, prepare_frame
from gpu_xform.vector.edge_visibility import split_edges_by_visibility
from tests.support.projection import clip_to_pixels
from tests.support.reference_visibility import MIN_PART, clip_to_view, visible_intervals
from tests.support.solids import (
    center,
    concatenate,
    interlocking,
    l_prism,
    staircase,
    star_prism,
    subdivide_edges,
    thin_plates,
)
from tests.support.types import Array

SIZE = (900, 700)
LINE_WIDTH = 1.5
APART = 3.0  # pixels from a line to what it does not touch
MARGIN = 3  # pixels added around a picture
MAX_WRONG = 0.005  # of the length of all edges in the picture
FULL = 0.7  # of a line's darkness: the least that is not counted as missing


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
    centers = 0.5 * (cuts[1:] + cuts[:-1])
    left = within(centers, a) & ~within(centers, b)
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
    square = np.einsum("ij,ij->i", along, along)
    long = square > 1e-12  # an edge seen end on has no parts
    edges, strokes, along, square = edges[long], strokes[long], along[long], square[long, np.newaxis]
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
        fresh = np.append(True, own[1:, 0] > np.maximum.accumulate(own[:, 1])[:-1] + MIN_PART)[: len(own)]
        starts = np.flatnonzero(fresh)
        result.append(np.stack([own[starts, 0], np.maximum.reduceat(own[:, 1], starts)], axis=1) if len(own) else own)
    return result


class Judged(NamedTuple):
    """What a picture shows of the edges where no other line is near: `wrong`, and the part of their length judged."""

    wrong: Wrong
    part: float


def judge_picture(picture: Array, ends: Array, visible: Sequence[Array], line_width: float = LINE_WIDTH) -> Judged:
    """Look at black lines on white, pixel by pixel along every edge, away from other lines and the border by APART.

    picture : (height, width, 4) uint8
    ends : (m, 2, 2) of what is in view of each edge, in pixels; NaN where nothing is

    Across a visible place lies FULL of a line's darkness at least; a hidden place is blank.
    """
    darkness = np.pad(1.0 - picture[..., 0] / 255.0, MARGIN)
    height, width = picture.shape[:2]
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
        from_rim = np.minimum(points, (width, height) - points).min(axis=1)
        alone = (distance[:, owners != edge] > APART).all(axis=1) & (from_rim > APART)
        from_ends = np.abs(t[:, np.newaxis] - visible[edge].ravel()).min(axis=1, initial=1.0) * length
        inside = within(t, visible[edge])
        is_seen = alone & inside & (from_ends > APART)
        is_hidden = alone & ~inside & (from_ends > APART)
        # In each column of pixels that a flat line crosses lies its width over the cosine of its slope.
        is_steep = abs(b[1] - a[1]) > abs(b[0] - a[0])
        full = line_width * length / np.abs(b - a).max()
        x, y = np.floor(points).astype(np.int64).T + MARGIN
        reach = np.arange(-2, 3)[:, np.newaxis]
        across = (darkness[y, x + reach] if is_steep else darkness[y + reach, x]).sum(axis=0)
        n_eaten += int((across < FULL * full)[is_seen].sum())
        n_leaked += int((darkness[y, x] > 0.0)[is_hidden].sum())
        n_judged += int((is_seen | is_hidden).sum())
        n_samples += n
    return Judged(Wrong(n_eaten / n_samples, n_leaked / n_samples), n_judged / n_samples)


SAMPLES = {
    "cube": samples.cube(),
    "house": samples.house(),
    "snub dodecahedron": samples.snub_dodecahedron(),
    "icosphere": samples.icosphere(3),
    "torus": samples.torus(24, 13),
    "L": center(l_prism()),
    "star": center(star_prism()),
    "boxes": concatenate(*interlocking()),
    "plates": thin_plates(),
    "stairs": center(staircase(), 0.5),
}
DEGREE = np.pi / 180


ALONG_X, ALONG_Z = (-1.0, -0.5 * DEGREE, -1.0 * DEGREE), (1.0 * DEGREE, -2.0 * DEGREE, -1.0)


def radius(mesh: Mesh) -> float:
    """Return how far the farthest point of a mesh is from 0."""
    return float(np.linalg.norm(mesh.positions, axis=1).max())


def eye(mesh: Mesh, direction: Sequence[float], radii: float) -> Array:
    """Return where 0 lies in `direction`, as far away as `radii` times the farthest point of a mesh."""
    result: Array = -radii * radius(mesh) * np.array(direction) / np.linalg.norm(direction)
    return result


def slice_of(mesh: Mesh, *, orthographic: bool) -> Camera:
    """Return a camera that shows what lies between two planes through a mesh."""
    at = eye(mesh, (-0.5, -0.4, 0.9), 3.0)
    near, far = 2.7 * radius(mesh), 3.3 * radius(mesh)
    return Camera.look_at(at, (0.0, 0.0, 0.0), fov_y=35.0, near=near, far=far, orthographic=orthographic)


# The samples lie around 0, and their faces are often at right angles to the axes.
VIEWS: dict[str, Callable[[Mesh], Camera]] = {
    "fit": Camera.fit,
    "from below": lambda mesh: Camera.fit(mesh, direction=(0.3, 1.0, -0.4), fov_y=75.0),
    "parallel": lambda mesh: Camera.fit(mesh, direction=(0.5, -0.3, -0.7), orthographic=True),
    "straight on": lambda mesh: Camera.fit(mesh, direction=(0.0, 0.0, -1.0)),
    "straight on, parallel": lambda mesh: Camera.fit(mesh, direction=(-1.0, 0.0, 0.0), orthographic=True),
    "grazing x, y": lambda mesh: Camera.fit(mesh, direction=ALONG_Z, fov_y=2.0),
    "grazing y, z": lambda mesh: Camera.fit(mesh, direction=ALONG_X, orthographic=True),
    "grazing, wide": lambda mesh: Camera.look_at(eye(mesh, ALONG_X, 1.9), (0.1, 0.05, 0.02), fov_y=70.0),
    "off-centre": lambda mesh: Camera.look_at(eye(mesh, (-0.4, 0.7, -1.0), 3.0), mesh.bounds[1] * (0.7, 0.5, 0.0)),
    "near": lambda mesh: Camera.look_at(eye(mesh, (0.9, -0.8, -0.7), 1.1), (0.0, 0.1, 0.0), fov_y=60.0),
    "parallel, from afar": lambda mesh: Camera.look_at(
        eye(mesh, (-0.3, -0.26, -0.9), 10.0), (0.0, 0.0, 0.0), fov_y=13.0, orthographic=True
    ),
    "slice": lambda mesh: slice_of(mesh, orthographic=False),
    "slice, parallel": lambda mesh: slice_of(mesh, orthographic=True),
    "far": lambda mesh: Camera.look_at(eye(mesh, (-0.6, -0.5, -1.0), 30.0), mesh.bounds[1] * (1.0, 0.0, 0.0)),
}


def seen(mesh: Mesh, clip_from_model: Array, size: tuple[int, int] = SIZE) -> tuple[Array, list[Array]]:
    """Return what is in view of each edge, in pixels (m, 2, 2), and the parts of it that are visible."""
    ends = clip_to_pixels(clip_to_view(mesh, mesh.edges, clip_from_model).clip, size)
    return ends, visible_intervals(mesh, mesh.edges, clip_from_model)


def matrix(camera: Camera, size: tuple[int, int] = SIZE) -> Array:
    return camera.clip_from_world(size[0] / size[1])


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
FIVE = np.array([[(0, 0), (40, 0)], [(0, 0), (0, 60)], [(0, 0.8), (80, 60.8)], [(7, 9)] * 2, [(np.nan, np.nan)] * 2])


def test_wrong_lengths_are_parts_of_all_that_is_in_view() -> None:
    visible = [np.array([(0.0, 0.5)]), WHOLE, NOTHING, NOTHING, NOTHING]
    assert wrong_length(FIVE, visible, visible) == (0.0, 0.0)
    drawn = [np.array([(0.25, 0.5), (0.75, 1.0)]), np.array([(0.0, 0.2), (0.3, 0.9)]), np.array([(0.6, 0.65)])]
    drawn += [NOTHING, NOTHING]
    eaten, leaked = wrong_length(FIVE, drawn, visible)
    assert eaten == pytest.approx((0.25 * 40 + 0.2 * 60) / 200)
    assert leaked == pytest.approx((0.25 * 40 + 0.05 * 100) / 200)
    assert wrong_length(FIVE, visible, drawn) == pytest.approx((leaked, eaten))


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
    edges = np.array([2, 0, 0, 0, 1, 3])
    strokes = np.array(
        [
            [(40, 30.8), (8, 6.8)],
            [(10, 0), (20, 0)],
            [(30, 0), (50, 0)],
            [(20, 0), (25, 0)],
            [(0, 0), (0, 0)],
            [(7, 9), (7, 9)],
        ],
        dtype=np.float64,
    )
    parts = drawn_intervals(FIVE, edges, strokes)
    assert parts[0] == pytest.approx(np.array([(0.25, 0.625), (0.75, 1.0)]))
    assert parts[1] == pytest.approx(np.array([(0.0, 0.0)]))
    assert parts[2] == pytest.approx(np.array([(0.1, 0.5)]))
    assert len(parts[3]) == len(parts[4]) == 0
    with pytest.raises(ValueError, match=r"0\.4 pixels beside"):
        drawn_intervals(FIVE, edges[1:2], strokes[1:2] + np.array([0.0, 0.4]))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["house", "star", "icosphere", "boxes"])
def test_a_picture_of_what_is_visible_is_judged_right(name: str) -> None:
    ends, visible = seen(SAMPLES[name], matrix(Camera.fit(SAMPLES[name])))
    judged = judge_picture(picture_of(ends, visible), ends, visible)
    assert judged.wrong == (0.0, 0.0)
    assert judged.part > 0.5


def test_a_wrong_picture_is_judged_by_how_much_of_it_is_wrong() -> None:
    ends, visible = seen(SAMPLES["stairs"], matrix(Camera.fit(SAMPLES["stairs"])))
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


def visible_spans(mesh: Mesh, camera: Camera, ends: Array, size: tuple[int, int] = SIZE) -> list[Array]:
    """Return the parts of every edge that the device finds visible, as `visible_intervals` has them."""
    with prepare_frame(mesh, Frame(camera, size), {"hidden": "remove", "line_width": LINE_WIDTH}) as prepared:
        drawables, longest = prepared.draw_list.drawables, max(size)
        (split,), _ = split_edges_by_visibility(
            prepared.device, drawables, prepared.view, lambda _: longest, find_visible=False
        )
    shown = split.spans[split.spans["is_hidden"] == 0]
    return drawn_intervals(ends, shown["edge"].astype(np.int64), shown["ends"].reshape(-1, 2, 2).astype(np.float64))


# The larger meshes from where most of their faces are seen almost from their edges, or much of them is out of view.
FEWER = {"icosphere": ("grazing y, z", "near"), "torus": ("from below", "grazing, wide", "near")}
# From afar the plates lie a quarter of a pixel apart, and along x they are seen from their edges.
NOT_THESE = {("plates", "far"), ("plates", "straight on, parallel")}
# Every other one, so that all samples and all views take part.
CASES = [
    (name, view)
    for row, name in enumerate(SAMPLES)
    for column, view in enumerate(FEWER.get(name, VIEWS))
    if (name, view) not in NOT_THESE and ((row + column) % 2 == 0 or name in FEWER)
]


@cache
def judge_spans(name: str, view: str) -> tuple[Array, list[Array], float]:
    """Return what is seen of a sample, as `seen` does, and how much of it the device judges wrongly: once for both
    rasterisers, which do not take part in it.
    """
    mesh = SAMPLES[name]
    camera = VIEWS[view](mesh)
    ends, visible = seen(mesh, matrix(camera))
    return ends, visible, sum(wrong_length(ends, visible_spans(mesh, camera, ends), visible, near=1.0))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "view"), CASES)
def test_nothing_visible_is_eaten_and_nothing_hidden_leaks(name: str, view: str) -> None:
    mesh = SAMPLES[name]
    camera = VIEWS[view](mesh)
    ends, visible, wrong = judge_spans(name, view)
    assert wrong <= MAX_WRONG
    picture = gx.render_array(mesh, camera=camera, size=SIZE, hidden="remove", line_width=LINE_WIDTH)
    judged = judge_picture(picture, ends, visible)
    assert sum(judged.wrong) <= MAX_WRONG
    assert judged.part > 0.25


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLES)
def test_in_a_large_picture_nothing_need_be_forgiven(name: str) -> None:
    mesh, size = SAMPLES[name], (3000, 2400)
    camera = Camera.fit(mesh)
    ends, visible = seen(mesh, matrix(camera, size), size)
    assert sum(wrong_length(ends, visible_spans(mesh, camera, ends, size), visible)) <= MAX_WRONG


def test_a_picture_of_several_tiles_is_as_right_as_one() -> None:
    mesh, size = SAMPLES["L"], (2500, 2300)
    camera = Camera.fit(mesh)
    picture = gx.render_array(mesh, camera=camera, size=size, hidden="remove", line_width=LINE_WIDTH)
    judged = judge_picture(picture, *seen(mesh, matrix(camera, size), size))
    assert sum(judged.wrong) <= MAX_WRONG
    assert judged.part > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("n_points", [1, 3])
@pytest.mark.parametrize("name", ["cube", "house"])
def test_points_in_line_on_an_edge_do_not_break_it(name: str, n_points: int) -> None:
    # Three corners in line make a triangle that rounding gives some area, but no plane.
    size = (640, 640)
    for axis, angle in (((1, 2, 3), 0.5), ((3, -1, 2), 1.1), ((-2, 1, 1), 1.9)):
        plain = SAMPLES[name].transformed(rotate(axis, angle))
        camera = Camera.fit(plain)
        picture = gx.render_array(
            subdivide_edges(plain, n_points), camera=camera, size=size, hidden="remove", line_width=LINE_WIDTH
        )
        assert judge_picture(picture, *seen(plain, matrix(camera, size), size)).wrong == (0.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("style", ["thin", "as quads"])
@pytest.mark.parametrize("view", ["fit", "grazing y, z"])
@pytest.mark.parametrize("name", ["snub dodecahedron", "star", "boxes"])
def test_however_lines_are_drawn(name: str, view: str, style: str) -> None:
    mesh = SAMPLES[name]
    camera = VIEWS[view](mesh)
    if style == "thin":
        picture = gx.render_array(mesh, camera=camera, size=SIZE, hidden="remove", antialias=False)
    else:
        black = np.zeros((len(mesh.edges), 3))
        picture = gx.render_array(
            mesh, camera=camera, size=SIZE, hidden="remove", line_width=LINE_WIDTH, edge_colors=black
        )
    judged = judge_picture(picture, *seen(mesh, matrix(camera)), line_width=1.0 if style == "thin" else LINE_WIDTH)
    assert sum(judged.wrong) <= MAX_WRONG
    assert judged.part > 0.6


@pytest.mark.parametrize("name", ["house", "star", "stairs"])
@pytest.mark.parametrize(
    "camera", [Camera.window((-1.9, 1.8), (-1.7, 1.6)), Camera.eye_on_z(5.0, (-2.6, 2.4), (-2.2, 2.3))], ids=repr
)
def test_the_cameras_of_lectures_look_along_z_at_turned_models(name: str, camera: Camera) -> None:
    mesh, turn = SAMPLES[name], rotate_y(0.6) @ rotate_x(-0.4) @ scale(0.7)
    clip_from_world = matrix(camera)
    if not clip_from_world[2, :3].any():  # it drops depth: any that falls along z will do
        clip_from_world[2, 2] = -0.1
    picture = gx.render_array(mesh, transform=turn, camera=camera, size=SIZE, hidden="remove", line_width=LINE_WIDTH)
    judged = judge_picture(picture, *seen(mesh, clip_from_world @ turn))
    assert sum(judged.wrong) <= MAX_WRONG
    assert judged.part > 0.6


def test_models_hide_one_another() -> None:
    one, other = interlocking()
    camera = Camera.fit(concatenate(one, other))
    picture = gx.render_array([one, other], camera=camera, size=SIZE, hidden="remove", line_width=LINE_WIDTH)
    judged = judge_picture(picture, *seen(concatenate(one, other), matrix(camera)))
    assert sum(judged.wrong) <= MAX_WRONG
    assert judged.part > 0.6
