"""Lines in many colours: whose colour each line has, and how two blend along an edge."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Mesh, samples
from gpu_xform.errors import ArgumentError
from gpu_xform.geometry.edges import resolve_edges
from gpu_xform.imaging.colormaps import apply_colormap
from tests.support.projection import world_to_clip, world_to_pixels

CUBE = samples.cube()
SIZE = (260, 200)
CAMERA = Camera.look_at((4.1, 2.8, 6.2), (0.1, 0, 0))
RNG = np.random.default_rng(5)
EDGE_ROWS = RNG.uniform(0, 1, (12, 3))


def at(picture: Any, place: Any) -> Any:
    x, y = np.floor(place).astype(int)
    return picture[y, x]


def assert_rows(picture: Any, edges: Any, rows: Any) -> None:
    """Hold what is drawn along each edge, somewhere that no other crosses it, against its own colour."""
    ends = world_to_pixels(CUBE.positions, CAMERA, SIZE)
    for (a, b), row in zip(edges, rows, strict=True):
        seen = np.array([at(picture, ends[a] + part * (ends[b] - ends[a])) for part in (0.23, 0.37, 0.59, 0.8)])
        off = np.abs(seen[:, :3] / 255 - row[:3]).max(axis=1)
        assert (off <= 1.01 / 255).sum() >= 2


def test_each_edge_has_the_colour_in_its_row() -> None:
    style: dict[str, Any] = {"camera": CAMERA, "size": SIZE, "line_width": 5.0}
    assert_rows(gx.render_array(CUBE, edge_colors=EDGE_ROWS, **style), CUBE.edges, EDGE_ROWS)
    own = CUBE.edges[[7, 2, 10]][:, ::-1]
    assert_rows(gx.render_array(CUBE, edges=own, edge_colors=EDGE_ROWS[:3], **style), own, EDGE_ROWS[:3])


def test_edges_by_name_keep_the_colours_of_their_own_rows() -> None:
    # Two faces in one plane: the edge between them is no crease, and the rows after it must not move up.
    roof = Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)], [(0, 1, 2, 3), (1, 4, 5, 2)])
    rows = RNG.uniform(0, 1, (7, 4))
    rows[:, 3] = 1.0
    camera = Camera.window((-0.3, 2.3), (-0.3, 1.3))
    chosen = resolve_edges(roof, "feature")
    assert len(chosen) == 6
    style: dict[str, Any] = {"camera": camera, "size": SIZE, "line_width": 4.0, "edge_colors": rows}
    ends = world_to_pixels(roof.positions, camera, SIZE)
    row_of = {tuple(edge): row for edge, row in zip(roof.edges.tolist(), rows, strict=True)}
    for edges in ("feature", "boundary", "silhouette", ["silhouette", "feature"], None, "all"):
        shown = gx.render_array(roof, edges=edges, **style)
        for (a, b), row in row_of.items():
            seen = at(shown, ends[a] + 0.37 * (ends[b] - ends[a])) / 255
            is_drawn = edges in (None, "all") or [a, b] in chosen.tolist()
            assert np.abs(seen - (row if is_drawn else 1.0)).max() <= 1.01 / 255


@pytest.mark.parametrize("edges", ["silhouette", ["silhouette", "boundary"]], ids=["alone", "beside others"])
def test_the_silhouette_keeps_the_colours_of_its_own_rows(edges: Any) -> None:
    box = Mesh(CUBE.positions, CUBE.faces[1:])  # without a lid, whose boundary is drawn in any view
    assert (box.edges == CUBE.edges).all()
    shown = gx.render_array(box, edges=edges, edge_colors=EDGE_ROWS, camera=CAMERA, size=SIZE, line_width=5.0)
    ends = world_to_pixels(CUBE.positions, CAMERA, SIZE)
    n_drawn = 0
    for (a, b), row in zip(box.edges, EDGE_ROWS, strict=True):
        seen = at(shown, ends[a] + 0.37 * (ends[b] - ends[a])) / 255
        if (seen < 1.0).any():
            n_drawn += 1
            assert np.abs(seen[:3] - row).max() <= 1.01 / 255
    assert 6 < n_drawn < 12


@pytest.mark.parametrize("antialias", [True, False])
@pytest.mark.parametrize("orthographic", [True, False])
def test_colours_of_points_blend_along_the_edge_in_space(antialias: bool, orthographic: bool) -> None:
    near_and_far = Mesh([(-0.4, -0.3, 3.0), (0.9, 0.5, -9.0), (-0.4, 0.35, 3.0)], [(0, 1), (2, 1)])
    camera = Camera.look_at((0.1, 0.0, 5.0), (0.1, 0.1, 0.0), fov_y=40.0, orthographic=orthographic)
    colors = np.array([(1.0, 0.0, 0.2), (0.0, 1.0, 0.4), (0.3, 0.1, 0.9)])
    shown = gx.render_array(
        near_and_far, vertex_colors=colors, camera=camera, size=SIZE, line_width=3.0, antialias=antialias
    )
    ends = world_to_pixels(near_and_far.positions, camera, SIZE)
    w = world_to_clip(near_and_far.positions, camera, SIZE)[:, 3]
    n_seen = 0
    for a, b in near_and_far.edges:
        length = np.linalg.norm(ends[b] - ends[a])
        for t in np.linspace(0.05, 0.9, 25):
            along = (t / w[b]) / ((1 - t) / w[a] + t / w[b])
            expected = (1 - along) * colors[a] + along * colors[b]
            nearby = t + np.array([-1.0, 1.0]) / length  # the pixel's centre lies up to a pixel off
            slack = np.ptp((nearby / w[b]) / ((1 - nearby) / w[a] + nearby / w[b]))
            seen = at(shown, ends[a] + t * (ends[b] - ends[a]))[:3] / 255
            is_beside = not antialias and (seen == 1.0).all()
            assert is_beside or np.abs(seen - expected).max() <= slack + 1.5 / 255
            n_seen += not is_beside
    assert n_seen >= 35


def test_scalars_are_the_colours_of_their_map() -> None:
    heights = CUBE.positions @ [0.3, 1.0, -0.2]
    style: dict[str, Any] = {"camera": CAMERA, "size": SIZE, "line_width": 4.0}
    for clim in (None, (-0.5, 2.0)):
        colors = apply_colormap(heights, "magma", clim, 8)
        expected = gx.render_array(CUBE, vertex_colors=colors, **style)
        assert gx.render_array(CUBE, scalars=heights, cmap="magma", clim=clim, **style).tobytes() == expected.tobytes()
    ends = world_to_pixels(CUBE.positions, CAMERA, SIZE)
    for place, color in zip(ends, colors, strict=True):
        # Three edges meet there, in nearly the colour of the corner.
        assert np.abs(at(expected, place) / 255 - color).max() < 0.1


def test_face_colors_take_the_place_of_the_cycle() -> None:
    rows = RNG.uniform(0, 1, (6, 3))
    style: dict[str, Any] = {"camera": CAMERA, "size": SIZE, "line_width": 5.0}
    shown = gx.render_array(CUBE, face_colors=rows, **style)
    last = dict(zip(map(frozenset, CUBE.face_edges.tolist()), CUBE.face_edge_faces.tolist(), strict=True))
    assert_rows(shown, [tuple(edge) for edge in last], rows[list(last.values())])


@pytest.mark.parametrize("line_width", [2.0, 12.0])
def test_opacities_multiply(line_width: float) -> None:
    line = Mesh([(-1, 0, 0), (1, 0, 0)], [(0, 1)])
    style: dict[str, Any] = {"camera": Camera.window((-1, 1), (-1, 1)), "size": (40, 40), "line_width": line_width}
    for colors in (
        {"color": "#ff000080"},
        {"edge_colors": [(1, 0, 0, 0.502)]},
        {"vertex_colors": [(1, 0, 0, 0.502)] * 2},
    ):
        shown = gx.render_array(line, alpha=0.5, **colors, **style)
        assert np.abs(shown[20, 20] / 255 - [1, 0.749, 0.749, 1]).max() <= 1.5 / 255
        transparent = gx.render_array(line, alpha=0.5, background=None, **colors, **style)
        assert np.abs(transparent[20, 20] / 255 - [1, 0, 0, 0.251]).max() <= 2 / 255


@pytest.mark.parametrize(
    "style",
    [{"color": "none"}, {"alpha": 0.0}, {"color": "none", "line_width": 12.0}, {"color": "none", "antialias": False}],
)
def test_what_is_transparent_leaves_no_trace(style: dict[str, Any]) -> None:
    shown = gx.render_array(CUBE, background=None, size=(60, 50), **style)
    assert not shown.any()


@pytest.mark.parametrize("alpha", [0.5, 0.1, 0.02])
@pytest.mark.parametrize("n", [2, 7, 40])
def test_transmittances_of_lines_over_one_another_multiply(n: int, alpha: float) -> None:
    edges = np.tile([(0, 1)], (n, 1))
    line = Mesh([(-1, 0, 0), (1, 0, 0)])
    shown = gx.render_array(
        line, edges=edges, alpha=alpha, camera=Camera.window((-1, 1), (-1, 1)), size=(40, 40), line_width=4.0
    )
    assert abs(shown[20, 20, 0] / 255 - (1 - alpha) ** n) <= 1 / 255


@pytest.mark.slow
def test_any_number_of_lines_stays_opaque() -> None:
    # Absorbance is counted in 32 bits, and with the finest steps an opaque line adds 16,024: left alone, so many would
    # come round to less than one line's.
    n = 268_034
    assert n * 16_024 % 2**32 < 16_024
    shown = gx.render_array(
        Mesh([(0, 0, 0), (0.05, 0, 0)]),
        edges=np.tile([(0, 1)], (n, 1)),
        camera=Camera.window((-1, 1), (-1, 1)),
        size=(8, 8),
        line_width=3.0,
    )
    assert (shown[3:5, 3:5, 0] == 0).all()


def darkness_of_parts(mesh: Mesh, n: int, size: tuple[int, int], style: dict[str, Any]) -> npt.NDArray[Any]:
    """Return by how much a picture of all edges differs from one of as many layers, each rounded to eight bits."""
    camera = Camera.fit(mesh)
    together, apart = (
        gx.render_array([gx.Layer(mesh, edges=part, **style) for part in parts], camera=camera, size=size)[..., 0]
        for parts in ([mesh.edges], np.array_split(mesh.edges, n))
    )
    assert 0.1 < (together < 255).mean() < 0.95
    return np.asarray(np.abs(together.astype(int) - apart))


@pytest.mark.slow
@pytest.mark.parametrize(
    "style",
    [
        {"alpha": 0.0019},
        {"color": (0.0, 0.0, 0.0, 0.01)},
        {"alpha": 0.1},
        {"alpha": 0.02, "depth_cue": 0.9},
        {"line_width": 0.003},
        {"alpha": 0.5, "line_width": 0.05},
    ],
)
def test_faint_lines_of_a_dense_model_add_up_as_those_of_a_few_models_do(style: dict[str, Any]) -> None:
    """Sums of few edges are finer; no edge may be lost where there are many."""
    assert (darkness_of_parts(samples.icosphere(6), 4, (50, 50), style) <= 3).all()


@pytest.mark.slow
def test_opaque_lines_of_a_dense_model_add_up_as_those_of_a_few_models_do() -> None:
    difference = darkness_of_parts(samples.icosphere(7), 8, (500, 500), {"line_width": 1.5})
    assert difference.max() <= 8
    assert difference.mean() <= 1


@pytest.mark.parametrize("style", [{}, {"hidden": "fade"}, {"antialias": False}, {"line_width": 8.0}])
def test_the_order_of_edges_of_one_colour_does_not_matter(style: dict[str, Any]) -> None:
    mesh = samples.snub_dodecahedron()
    options: dict[str, Any] = {"camera": Camera.fit(mesh), "size": (120, 100), "color": "#2040a080", **style}
    shown = gx.render_array(mesh, edges=mesh.edges, **options)
    for seed in range(2):
        shuffled = np.random.default_rng(seed).permutation(mesh.edges)
        assert gx.render_array(mesh, edges=shuffled, **options).tobytes() == shown.tobytes()


# A black square in front, a black line on it, and behind both a red line across; the red one is the last edge of all.
CROSSING = Mesh(
    [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (-0.9, 0, 0), (0.9, 0, 0), (0, -0.9, -1), (0, 0.9, -1)],
    [(0, 1, 2, 3), (4, 5), (6, 7)],
)
RED_BEHIND = [(1.0, 0.0, 0.0) if tuple(edge) == (6, 7) else (0.0, 0.0, 0.0) for edge in CROSSING.edges.tolist()]


@pytest.mark.parametrize("hidden", ["dash", "fade"])
@pytest.mark.parametrize("style", [{"line_width": 16.0}, {"line_width": 3.0}, {"antialias": False}])
def test_hidden_lines_lie_under_visible_ones_whatever_their_order(style: dict[str, Any], hidden: Any) -> None:
    options: dict[str, Any] = {"camera": Camera.look_at((0, 0, 6), (0, 0, 0)), "size": (201, 201), **style}
    shown = gx.render_array(CROSSING, edge_colors=RED_BEHIND, hidden=hidden, **options)
    alone = gx.render_array(CROSSING, edge_colors=RED_BEHIND, hidden="remove", **options)
    black = (alone[..., :3] == 0).all(axis=2)
    assert black.sum() > 100
    assert (shown[black] == alone[black]).all()
    red = (shown[..., 0] == 255) & (shown[..., 1] < 255)
    assert red.sum() > 10


def test_a_hidden_point_is_no_dash() -> None:
    options: dict[str, Any] = {"camera": CAMERA, "size": SIZE, "edges": [], "point_size": 10.0}
    dashed = gx.render_array(CUBE, hidden="dash", **options)
    assert dashed.tobytes() == gx.render_array(CUBE, hidden="remove", **options).tobytes()
    assert dashed.tobytes() != gx.render_array(CUBE, **options).tobytes()


def test_points_lie_over_lines_of_every_kind() -> None:
    ball = samples.snub_dodecahedron()
    red = np.tile((1.0, 0.0, 0.0), (len(ball.edges), 1))
    options: dict[str, Any] = {"camera": Camera.fit(ball), "size": (300, 300), "edge_colors": red, "line_width": 6.0}
    points = gx.render_array(ball, point_size=14.0, edges=[], camera=options["camera"], size=(300, 300))
    black = (points[..., :3] == 0).all(axis=2)
    for edges in ("all", "silhouette", ["feature", "silhouette"]):
        shown = gx.render_array(ball, edges=edges, point_size=14.0, **options)
        assert ((shown[..., 0] == 255) & (shown[..., 1] == 0)).any()
        assert (shown[black] == (0, 0, 0, 255)).all()


def test_rows_of_colours_are_those_of_the_edges_of_the_model_where_an_array_is_one_of_several() -> None:
    options: dict[str, Any] = {"camera": CAMERA, "size": SIZE, "edge_colors": EDGE_ROWS, "line_width": 3.0}
    chosen = CUBE.edges[[2, 7, 4]]
    shown = gx.render_array(CUBE, edges=[chosen, "silhouette"], **options)
    names_only = gx.render_array(CUBE, edges="silhouette", **options)
    assert_rows(shown, chosen, EDGE_ROWS[[2, 7, 4]])
    assert (shown != names_only).any()
    with pytest.raises(
        ArgumentError, match=r"^edge_colors can go with one array of edges, or .*, which \(1, 7\) is not$"
    ):
        gx.render_array(CUBE, edges=[np.array([(0, 1), (1, 7)]), "boundary"], **options)


def test_nothing_transparent_has_a_hue_that_others_fade_to() -> None:
    line = Mesh([(-1, 0, 0), (1, 0, 0)], [(0, 1)])
    colors = [(1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.0)]
    options: dict[str, Any] = {"camera": Camera.window((-1, 1), (-1, 1)), "size": (100, 100), "line_width": 8.0}
    shown = gx.render_array(line, vertex_colors=colors, **options)[50]
    assert (shown[:, 0] == 255).all()
    assert (shown[:, 1] == shown[:, 2]).all()
    assert np.abs(shown[20:80, 1] - (np.arange(20, 80) + 0.5) / 100 * 255).max() <= 1.5


@pytest.mark.parametrize("style", [{"alpha": 0.9}, {"depth_cue": 0.5}, {"hidden": "fade"}, {}])
def test_in_vector_pictures_transparent_lines_are_not_beads(style: dict[str, Any]) -> None:
    """Spans of one colour each overlap at their ends, where a transparent line would be darker."""
    ball = samples.snub_dodecahedron()
    numbers = ball.positions[:, 1].copy()
    if not style:
        numbers[ball.positions[:, 0] > 0] = np.nan
    svg = gx.render_svg(ball, scalars=numbers, line_width=5.0, **style)
    assert svg.count("<path") < 2.5 * len(ball.edges)  # some are cut where they become hidden
    assert gx.render_svg(ball, scalars=ball.positions[:, 1], line_width=5.0).count("<path") > 3 * len(ball.edges)
