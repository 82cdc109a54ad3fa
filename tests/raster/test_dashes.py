"""Dashes run along chains of edges: against a twin in double precision that walks them, on circles, and in tiles."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.geometry.edges import resolve_edges
from tests.support.projection import world_to_pixels
from tests.support.types import Array, Pixels

SIZE = (400, 320)
CAMERA = Camera.look_at((2.7, 1.9, 4.4), (0, 0, 0), fov_y=40.0)
FLAT = Camera.window((-1, 1), (-1, 1))
ON, OFF = 4.0, 3.0  # line widths
MAX_TURN_DEGREES = 50.0
MESHES = {
    "torus": samples.torus(20, 9),
    "icosphere": samples.icosphere(2),
    "snub dodecahedron": samples.snub_dodecahedron(),
}
WALL = Mesh([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [(0, 1, 2, 3)])


def before_everything(camera: Camera) -> Layer:
    """Return a wall that hides all and draws nothing."""
    if camera is FLAT:
        return Layer(WALL, transform=matrices.translate(0, 0, 3), hidden="remove", color="none")
    to_eye = np.array((2.7, 1.9, 4.4)) / np.linalg.norm((2.7, 1.9, 4.4))
    axis = np.cross((0.0, 0.0, 1.0), to_eye)
    turn = matrices.rotate(axis, np.arctan2(np.linalg.norm(axis), to_eye[2]))
    moved = matrices.chain(turn, matrices.translate(*(3.5 * to_eye)))
    return Layer(WALL, transform=moved, hidden="remove", color="none")


def walk(edges: Array, positions: Array) -> list[list[tuple[int, int]]]:
    """Return chains as lists of directed edges, by going straight on from edge to edge: a slow twin."""
    at: dict[int, list[int]] = {}
    for row, (a, b) in enumerate(edges.tolist()):
        at.setdefault(a, []).append(row)
        at.setdefault(b, []).append(row)

    def away(row: int, point: int) -> Array:
        a, b = edges[row]
        vector: Array = positions[b if a == point else a] - positions[point]
        vector /= np.linalg.norm(vector)
        return vector.astype(np.float32)

    def most_opposite(row: int, point: int) -> int | None:
        others = [other for other in at[point] if other != row]
        if not others:
            return None
        cosines = [float(away(row, point) @ away(other, point)) for other in others]
        best = int(np.argmin(cosines))
        return others[best] if cosines[best] <= -np.cos(np.radians(MAX_TURN_DEGREES)) else None

    def following(row: int, point: int) -> int | None:
        other = most_opposite(row, point)
        return other if other is not None and most_opposite(other, point) == row else None

    chains, done = [], set()
    for row, (a, _) in enumerate(edges.tolist()):
        if row in done:
            continue
        start, point = row, a
        while (before := following(start, point)) is not None and before != row:
            start, point = before, int(edges[before].sum() - point)
        if before == row:
            start, point = row, a
        chain: list[tuple[int, int]] = []
        following_row: int | None = start
        while following_row is not None and following_row not in done:
            done.add(following_row)
            far = int(edges[following_row].sum() - point)
            chain.append((point, far))
            following_row, point = following(following_row, far), far
        chains.append(chain)
    return chains


def distances_to(points: Array, ends: Array) -> Array:
    """Return how far points (p, 2) are from segments (k, 2, 2): (p, k)."""
    along = ends[:, 1] - ends[:, 0]
    to_points = points[:, None] - ends[:, 0]
    t = np.clip(np.einsum("pki,ki->pk", to_points, along) / np.einsum("ki,ki->k", along, along), 0, 1)
    distances: Array = np.linalg.norm(to_points - t[..., None] * along, axis=2)
    return distances


def judge(
    picture: Pixels, mesh: Mesh, camera: Camera, line_width: float, edges: Array | None = None
) -> tuple[int, int, int]:
    """Return how many places on dashes were found dark, on gaps white, and how many were found otherwise."""
    drawn = mesh.edges if edges is None else edges
    flat = world_to_pixels(mesh.positions, camera, SIZE)
    ends = flat[drawn]
    period = (ON + OFF) * line_width
    counts = [0, 0, 0]
    for chain in walk(drawn, mesh.positions):
        along = 0.0
        for a, b in chain:
            length = float(np.linalg.norm(flat[b] - flat[a]))
            major = int(np.abs(flat[b] - flat[a]).argmax())
            low, high = sorted((flat[a, major], flat[b, major]))
            centers = np.arange(np.ceil(low - 0.5), high - 0.5) + 0.5  # of the columns that a line steps through
            t = (centers - flat[a, major]) / (flat[b, major] - flat[a, major])
            places = flat[a] + t[:, None] * (flat[b] - flat[a])
            others = ends[(np.sort(drawn, axis=1) != sorted((a, b))).any(axis=1)]
            is_alone = (distances_to(places, others) > line_width + 1.5).all(axis=1)
            phase = (along + t * length) % period
            x, y = np.floor(places).astype(int).T
            dark = picture[y, x, 0] < 128
            on = is_alone & (phase > 1.0) & (phase < ON * line_width - 1.0)
            off = is_alone & (phase > ON * line_width + 1.0) & (phase < period - 1.0)
            counts[0] += int((on & dark).sum())
            counts[1] += int((off & ~dark).sum())
            counts[2] += int((on & ~dark).sum() + (off & dark).sum())
            along += length
    return counts[0], counts[1], counts[2]


@pytest.mark.parametrize("antialias", [True, False])
@pytest.mark.parametrize("name", MESHES)
def test_dashes_lie_where_a_twin_that_walks_the_chains_has_them(name: str, antialias: bool) -> None:
    mesh = MESHES[name].transformed(matrices.scale(1.3 / np.abs(MESHES[name].positions).max()))
    noise = 0.003 * np.random.default_rng(3).normal(size=mesh.positions.shape)  # no two edges are as opposite as others
    mesh = Mesh(mesh.positions + noise, mesh.faces)
    width = 2.0 if antialias else 1.5
    layers = [before_everything(CAMERA), Layer(mesh, hidden="dash", line_width=2.0, antialias=antialias)]
    picture = gx.render_array(layers, camera=CAMERA, size=SIZE)
    n_on, n_off, n_wrong = judge(picture, mesh, CAMERA, width)
    assert min(n_on, n_off) > 200
    assert n_wrong == 0


def plate_with_holes(outline: Array, holes: list[tuple[float, float, float, float]], height: float) -> Mesh:
    """Return a plate (z from 0 to `height`) with holes (x, y, radius, depth): a ring of quads around each, no lids."""
    points: list[Array] = []
    faces: list[list[int]] = []

    def add(ring: Array, z: float) -> Array:
        first = sum(map(len, points))
        points.append(np.column_stack([ring, np.full(len(ring), z)]))
        return np.arange(first, first + len(ring))

    def join(one: Array, other: Array) -> None:
        n = len(one)
        faces.extend([int(one[i]), int(one[(i + 1) % n]), int(other[(i + 1) % n]), int(other[i])] for i in range(n))

    join(add(outline, 0.0), add(outline, height))
    for x, y, radius, depth in holes:
        angles = 2.0 * np.pi * np.arange(60) / 60
        ring = np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])
        join(add(ring, height), add(ring, height - depth))
    return Mesh(np.concatenate(points), faces)


HEXAGON = np.column_stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)])
PARTS = {
    "nut": plate_with_holes(1.2 * HEXAGON, [(0.0, 0.0, 0.7, 0.8)], 0.8),
    "bracket with counterbores": plate_with_holes(
        np.array([(-1.4, -0.8), (1.4, -0.8), (1.4, 0.8), (-1.4, 0.8)]),
        [(x, 0.1, radius, depth) for x in (-0.8, 0.7) for radius, depth in ((0.5, 0.3), (0.25, 0.6))],
        0.6,
    ),
}


@pytest.mark.parametrize("name", PARTS)
def test_the_circles_of_parts_are_dashed_as_their_corners_are(name: str) -> None:
    part = PARTS[name]
    edges = resolve_edges(part, "feature")
    layers = [before_everything(CAMERA), Layer(part, edges="feature", hidden="dash", line_width=2.0)]
    picture = gx.render_array(layers, camera=CAMERA, size=SIZE)
    n_on, n_off, n_wrong = judge(picture, part, CAMERA, 2.0, edges)
    assert min(n_on, n_off) > 200
    assert n_wrong == 0


def circle(n: int, turn: Array) -> Mesh:
    angles = 2.0 * np.pi * np.arange(n) / n
    ring = np.column_stack([0.9 * np.cos(angles), 0.9 * np.sin(angles), 0.0 * angles])
    mesh = Mesh(ring, [(i, (i + 1) % n) for i in range(n)])
    return mesh.transformed(turn)


def count_dashes(picture: Pixels, mesh: Mesh) -> int:
    """Return how many dashes lie around a closed line."""
    ends = world_to_pixels(mesh.positions, FLAT, SIZE)
    corners = np.arange(len(ends) + 1)
    along = np.linspace(0.0, len(ends), 20_000, endpoint=False)
    closed = np.concatenate([ends, ends[:1]])
    x, y = (np.floor(np.interp(along, corners, closed[:, axis])).astype(int) for axis in (0, 1))
    dark = picture[y, x, 0] < 128
    return int((dark & ~np.roll(dark, 1)).sum())


@pytest.mark.parametrize("n", [48, 200, 3000])
@pytest.mark.parametrize("tilt", [0.0, 1.1])
def test_a_hidden_circle_has_as_many_dashes_as_its_length_however_many_edges_it_has(tilt: float, n: int) -> None:
    turn = matrices.rotate_x(tilt)
    layers = [before_everything(FLAT), Layer(circle(n, turn), hidden="dash", line_width=2.0)]
    picture = gx.render_array(layers, camera=FLAT, size=SIZE)
    ends = world_to_pixels(circle(20_000, turn).positions, FLAT, SIZE)
    length = np.linalg.norm(np.diff(ends, axis=0, append=ends[:1]), axis=1).sum()
    assert abs(count_dashes(picture, circle(n, turn)) - length / (2.0 * (ON + OFF))) <= 1.0


def test_in_svg_a_hidden_circle_is_one_path_whose_dashes_run_on() -> None:
    text = gx.render_svg(
        [before_everything(FLAT), Layer(circle(200, np.eye(4)), hidden="dash")], camera=FLAT, size=SIZE
    )
    hidden = text.split('class="hidden"')[1].split("</g>")[0]
    assert hidden.count("<path") == 1
    assert hidden.count("M") == 1
    assert "stroke-dashoffset" not in hidden


def test_where_faces_hide_parts_of_a_chain_its_dashes_go_on_in_svg_as_in_pixels() -> None:
    walls = Mesh(
        [(x, y, 1.0) for left in (-0.8, 0.1) for x, y in ((left, -1), (left + 0.4, -1), (left + 0.4, 1), (left, 1))],
        [(0, 1, 2, 3), (4, 5, 6, 7)],
    )
    models = [Layer(walls, hidden="remove", color="none"), Layer(circle(90, np.eye(4)), hidden="dash", line_width=2.0)]
    text = gx.render_svg(models, camera=FLAT, size=SIZE)
    hidden = text.split('class="hidden"')[1].split("</g>")[0]
    assert hidden.count("M") == 4
    assert hidden.count("stroke-dashoffset") == 4


def test_instances_have_dashes_of_their_own() -> None:
    near, far = matrices.identity(), matrices.scale(0.5)
    style: dict[str, Any] = {"hidden": "dash", "line_width": 2.0}
    ring = circle(100, np.eye(4))
    together = [before_everything(FLAT), Layer(ring, transform=np.stack([near, far]), **style)]
    apart = [before_everything(FLAT), Layer(ring, transform=near, **style), Layer(ring, transform=far, **style)]
    pictures = [gx.render_array(each, camera=FLAT, size=SIZE) for each in (together, apart)]
    np.testing.assert_array_equal(pictures[0], pictures[1])


def test_the_dashes_of_a_silhouette_run_along_it() -> None:
    ball = samples.icosphere(5)
    layers = [before_everything(FLAT), Layer(ball, edges="silhouette", hidden="dash", line_width=2.0)]
    picture = gx.render_array(layers, camera=FLAT, size=SIZE)
    dark = (picture[..., 0] < 128).sum()
    whole = (gx.render_array(layers[1:], camera=FLAT, size=SIZE)[..., 0] < 128).sum()
    assert dark / whole == pytest.approx(ON / (ON + OFF), abs=0.06)


PATTERN = (7.0, 3.0, 1.5, 3.0)  # line widths


def dark_shares(picture: Pixels, y: int) -> Array:
    """Return how dark each pixel of a row of a black line on white is, from 0 to 1, where the line is darkest."""
    shares: Array = 1.0 - picture[y, :, 0] / 255.0
    return shares


def exact_shares(pattern: tuple[float, ...], start: float, n: int) -> Array:
    """Return what dashes cover of the pixels of a row whose line begins at `start`."""
    bounds = np.cumsum((0.0, *pattern))
    shares = np.zeros(n)
    pixels = np.arange(n)
    for k in range(int(n / bounds[-1]) + 1):
        for begin, end in zip(bounds[:-1:2], bounds[1::2], strict=True):
            low, high = start + k * bounds[-1] + begin, start + k * bounds[-1] + end
            shares += np.clip(np.minimum(pixels + 1.0, high) - np.maximum(pixels, low), 0.0, 1.0)
    return shares


@pytest.mark.parametrize("rasterizer", ["compute", "render"])
@pytest.mark.parametrize("pattern", [PATTERN, (0.5, 3.0), (4.0, 2.0), (12.0, 3.0, 12.0, 3.0, 0.5, 3.0, 0.5, 3.0)])
def test_a_pattern_covers_the_pixels_of_a_visible_line_that_it_covers(
    pattern: tuple[float, ...], rasterizer: Any
) -> None:
    size, y, start, width = (200, 41), 20, 20.3, 2.0
    x = 2.0 * np.array([start, 190.0]) / size[0] - 1.0
    halfway = np.array([x[0], 0.3 * x[0] + 0.7 * x[1], x[1]])
    line = Mesh(np.column_stack([halfway, np.zeros(3), np.zeros(3)]), [(0, 1), (1, 2)])  # two edges of one chain
    camera = Camera.window((-1, 1), (-size[1] / size[0], size[1] / size[0]))
    picture = gx.render_array(line, camera=camera, size=size, dash=pattern, line_width=width, rasterizer=rasterizer)
    exact = exact_shares(tuple(width * length for length in pattern), start, size[0])
    inside = slice(24, 186)  # beside the caps of the ends
    np.testing.assert_allclose(dark_shares(picture, y)[inside], exact[inside], atol=0.02)


@pytest.mark.parametrize("name", PARTS)
def test_visible_lines_are_dashed_along_chains_as_hidden_ones_are(name: str) -> None:
    part, edges = PARTS[name], resolve_edges(PARTS[name], "feature")
    dashed = Layer(part, edges="feature", dash=(ON, OFF), line_width=2.0)
    n_on, n_off, n_wrong = judge(gx.render_array(dashed, camera=CAMERA, size=SIZE), part, CAMERA, 2.0, edges)
    assert min(n_on, n_off) > 200
    assert n_wrong == 0


@pytest.mark.parametrize("rasterizer", ["compute", "render"])
@pytest.mark.parametrize("antialias", [True, False])
def test_hidden_parts_have_a_style_of_their_own(rasterizer: Any, antialias: bool) -> None:
    ring = Layer(
        circle(90, np.eye(4)), hidden_style={"color": "red", "dash": None}, line_width=3.0, antialias=antialias
    )
    half = Mesh([(-9, -9, 1), (0, -9, 1), (0, 9, 1), (-9, 9, 1)], [(0, 1, 2, 3)])
    wall = Layer(half, hidden="remove", color="none")
    picture = gx.render_array([wall, ring], camera=FLAT, size=SIZE, rasterizer=rasterizer).astype(int)
    is_red = (picture[..., 0] - picture[..., 1]) > 100
    is_black = picture[..., 0] < 100
    assert is_red[:, : SIZE[0] // 2 - 2].any()
    assert not is_red[:, SIZE[0] // 2 + 2 :].any()
    assert is_black[:, SIZE[0] // 2 + 2 :].any()
    assert not is_black[:, : SIZE[0] // 2 - 2].any()
    whole = gx.render_array([Layer(ring.model, line_width=3.0, antialias=antialias)], camera=FLAT, size=SIZE)
    np.testing.assert_allclose((is_red | is_black).sum(), (whole[..., 0] < 100).sum(), rtol=0.1)
    alone = gx.render_array(ring, camera=FLAT, size=SIZE, rasterizer=rasterizer)  # nothing hides
    np.testing.assert_allclose(alone, whole, atol=2)


def test_svg_has_the_widths_colours_and_dashes_of_both() -> None:
    half = Mesh([(-9, -9, 1), (0, -9, 1), (0, 9, 1), (-9, 9, 1)], [(0, 1, 2, 3)])
    style: dict[str, Any] = {"dash": "long-dashed dotted", "line_width": "1mm"}
    style["hidden_style"] = {"color": "#808080", "line_width": "0.5mm", "dash": (3, 1)}
    models = [Layer(half, hidden="remove", color="none"), Layer(circle(90, np.eye(4)), **style)]
    text = gx.render_svg(models, camera=FLAT, size=SIZE)
    hidden = text.split('class="hidden"')[1].split(">")[0]
    visible = text.split('class="visible"')[1].split(">")[0]
    mm = 96 / 25.4
    assert f'stroke-width="{0.5 * mm:.6g}"' in hidden
    assert 'stroke="#808080"' in hidden
    assert f'stroke-dasharray="{1.5 * mm:.6g} {0.5 * mm:.6g}"' in hidden
    assert f'stroke-width="{mm:.6g}"' in visible
    assert 'stroke="#000000"' in visible
    assert f'stroke-dasharray="{" ".join(f"{length * mm:.6g}" for length in (24, 3, 0.5, 3))}"' in visible


def test_a_width_in_millimetres_has_as_many_pixels_as_the_picture_has_per_inch() -> None:
    ring = circle(90, np.eye(4))
    in_mm = gx.render_array(ring, camera=FLAT, size=SIZE, line_width="0.5mm", dpi=254.0)
    np.testing.assert_array_equal(in_mm, gx.render_array(ring, camera=FLAT, size=SIZE, line_width=5.0))
    with pytest.raises(gx.ArgumentError, match=r"^dpi must lie in \[1, 100000\], got 0$"):
        gx.render_array(ring, size=SIZE, dpi=0)
