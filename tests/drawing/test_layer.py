"""What a layer may be given, and what a picture of several layers is."""

import copy
import dataclasses
from typing import Any, get_type_hints

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, PointBuffer, matrices, samples
from gpu_xform.drawing.draw_list import Drawable, Faces, Lines
from gpu_xform.drawing.enums import HiddenStyle
from gpu_xform.drawing.layer import Style
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError
from gpu_xform.raster.binding_limits import split_to_binding_limits
from tests.support.types import DeviceFactory

CUBE = samples.cube()
SIZE = (90, 70)
CAMERA = Camera.look_at((3.0, 2.0, 5.0), (0.1, 0.0, 0.0))

BAD_STYLES: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"hidden": "dotted"}, ArgumentError, r"^hidden must be one of 'show', 'remove', 'dash', 'fade', got 'dotted'$"),
    ({"hidden": ["show"]}, ArgumentError, r"^hidden must be one of 'show', 'remove', 'dash', 'fade', got \['show'\]$"),
    ({"hidden": True}, ArgumentError, "^hidden must be one of"),
    ({"hidden": np.array(["show", "dash"])}, ArgumentError, "^hidden must be one of"),
    ({"name": 5}, ArgumentTypeError, "^name must be a string, got 5$"),
    ({"antialias": "no"}, ArgumentTypeError, "^antialias must be True or False, got 'no'$"),
    ({"antialias": None}, ArgumentTypeError, "^antialias must be True or False, got None$"),
    ({"antialias": np.array([1, 0])}, ArgumentTypeError, "^antialias must be True or False, got array"),
    ({"feature_angle": 500.0}, ArgumentError, r"^feature_angle must be in 0\.\.180 degrees, got 500$"),
    ({"feature_angle": [1.0]}, ArgumentError, "^feature_angle must be one number"),
    ({"feature_angle": 1j, "edges": "feature"}, ArgumentTypeError, "^feature_angle must hold real numbers"),
    ({"device": "llvmpipe"}, ArgumentTypeError, "^device must be a Device, got 'llvmpipe'$"),
    ({"device": ""}, ArgumentTypeError, "^device must be a Device, got ''$"),
    ({"device": np.zeros(2)}, ArgumentTypeError, "^device must be a Device, got array"),
    ({"alpha": 1.01}, ArgumentError, r"^alpha must lie in \[0, 1\], got 1.01$"),
    ({"alpha": -0.1}, ArgumentError, r"^alpha must lie in \[0, 1\], got -0.1$"),
    ({"alpha": float("nan")}, ArgumentError, "^alpha must"),
    ({"alpha": "half"}, ArgumentTypeError, "^alpha must"),
    ({"depth_cue": 2.0}, ArgumentError, r"^depth_cue must lie in \[0, 1\], got 2$"),
    ({"depth_cue": None}, ArgumentTypeError, "^depth_cue must"),
    ({"point_size": 0.0}, ArgumentError, "^point_size must be positive"),
    ({"point_size": 1e7}, ArgumentError, r"^point_size must be positive and at most 1e\+06, got 1e\+07$"),
    ({"point_size": "big"}, ArgumentTypeError, "^point_size must"),
    ({"max_points": 0}, ArgumentError, "^max_points must be at least 1, got 0"),
    ({"max_points": 1.5}, ArgumentTypeError, "^max_points must be a whole number"),
    ({"face_colors": np.zeros((5, 3))}, ArgumentError, "^face_colors must have one row for each of the 6 faces, got 5"),
    ({"face_colors": np.zeros(6)}, ArgumentError, r"^face_colors must have shape \(6, 3\) or \(6, 4\), got \(6,\)$"),
    ({"edge_colors": np.zeros((8, 3))}, ArgumentError, "^edge_colors must have one row for each of the 12 edges"),
    (
        {"edge_colors": np.zeros((12, 3)), "edges": [(0, 1), (1, 2)]},
        ArgumentError,
        "^edge_colors must have one row for each of the 2 edges, got 12$",
    ),
    ({"vertex_colors": np.zeros((12, 4))}, ArgumentError, "^vertex_colors must have one row for each of the 8 points"),
    ({"vertex_colors": np.full((8, 3), 1.5)}, ArgumentError, r"^vertex_colors must hold numbers from 0 to 1, or uint8"),
    ({"scalars": np.zeros(7)}, ArgumentError, "^scalars must have one number for each of the 8 points, got 7$"),
    ({"scalars": np.zeros(8), "cmap": "rainbowish"}, ArgumentError, "^cmap must be a colormap's name"),
    ({"scalars": np.zeros(8), "clim": (2, 1)}, ArgumentError, "^clim must be"),
    (
        {"scalars": np.zeros(8), "edge_colors": np.zeros((12, 3))},
        ArgumentError,
        "^at most one of face_colors, edge_colors, vertex_colors, scalars may be given, got edge_colors and scalars$",
    ),
    (
        {"vertex_colors": np.zeros((8, 3)), "face_colors": np.zeros((6, 3))},
        ArgumentError,
        "^at most one of face_colors, edge_colors, vertex_colors, scalars may be given, got face_colors and vertex_",
    ),
    (
        {"face_colors": np.zeros((6, 3)), "edges": "feature"},
        ArgumentError,
        r"^edges must be 'all' if each face has its own colour, got 'feature'$",
    ),
    ({"fill": "blurple"}, ArgumentError, "^fill must be a colour's name"),
    ({"fill": 5}, ArgumentError, "^fill must have shape"),
    ({"fill": np.array(1.0)}, ArgumentError, "^fill must have shape"),
    ({"fill": np.zeros((5, 3))}, ArgumentError, "^fill must have one row for each of the 6 faces, got 5$"),
    ({"fill": np.zeros((6, 2))}, ArgumentError, r"^fill must have shape \(6, 3\) or \(6, 4\), got \(6, 2\)$"),
    ({"fill": [(1, 0, 0), (1, 0)]}, ArgumentError, r"^fill\[1\] must be a colour's name"),
    ({"fill": (0.5, 2.0, 0.0)}, ArgumentError, "^fill must be a colour's name"),
    ({"transform": np.zeros((0, 4, 4))}, ArgumentError, "^transform must hold at least one matrix, got none$"),
    ({"transform": np.zeros((2, 3, 4))}, ArgumentError, r"^transform must have shape \(4, 4\), got \(2, 3, 4\)$"),
    (
        {"edges": "silhouettes"},
        ArgumentError,
        "^edges must be 'all', 'feature', 'boundary', 'silhouette', 'inter.* or an array",
    ),
    ({"edges": []}, MeshError, r"^edges must choose at least one edge"),
    ({"edges": "feature", "feature_angle": 200.0}, ArgumentError, "^feature_angle must be in"),
    ({"colour": "red"}, ArgumentTypeError, r"^unexpected keyword argument 'colour'; did you mean 'color'\?$"),
    ({"model": CUBE}, ArgumentTypeError, "^unexpected keyword argument 'model'$"),
]


@pytest.mark.parametrize(("style", "error", "message"), BAD_STYLES, ids=lambda value: str(value)[:40])
def test_a_style_that_cannot_be_taken_is_named(style: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        gx.render_array(CUBE, size=SIZE, **style)


def test_a_layer_takes_no_style_beside_its_own_and_a_list_gives_it_to_the_others() -> None:
    with pytest.raises(ArgumentError, match=r"^alpha must be given to the Layer itself$"):
        gx.render_array(Layer(CUBE), size=SIZE, alpha=0.5)
    with pytest.raises(ArgumentError, match=r"^models must hold at least one model, got none$"):
        gx.render_array([], size=SIZE)
    house = samples.house()
    mixed = gx.render_array([Layer(CUBE, color="red"), house], camera=CAMERA, size=SIZE, color="blue", line_width=3.0)
    named = [Layer(CUBE, color="red"), Layer(house, color="blue", line_width=3.0)]
    assert mixed.tobytes() == gx.render_array(named, camera=CAMERA, size=SIZE).tobytes()


def test_values_of_numpy_are_values() -> None:
    plain = gx.render_array(CUBE, size=SIZE, edges="feature", feature_angle=20.0, antialias=False, fill=["red"] * 6)
    numpy: dict[str, Any] = {"feature_angle": np.array(20), "antialias": np.bool_(False), "hidden": np.str_("remove")}
    assert (
        gx.render_array(CUBE, size=SIZE, edges="feature", fill=iter(["red"] * 6), **numpy).tobytes() == plain.tobytes()
    )


@pytest.mark.parametrize("style", [{"fill": "gold"}, {"point_size": 5.0}, {"fill": "gold", "point_size": 5.0}])
def test_a_model_with_faces_or_dots_to_draw_needs_no_edges(style: dict[str, Any]) -> None:
    ball = samples.icosphere(2)
    bare = gx.render_array(ball, size=SIZE, edges=[], **style)
    assert (bare != 255).any()
    for edges in ("feature", "boundary"):
        assert gx.render_array(ball, size=SIZE, edges=edges, **style).tobytes() == bare.tobytes()
    turn = "no two faces turn by more than 30 degrees; 'silhouette' draws the outline"
    with pytest.raises(MeshError, match=rf"^models\[0\]: edges must choose .*, 'feature' chooses none of 480: {turn}$"):
        gx.render_array([ball, CUBE], size=SIZE, edges="feature")


CLOSED = ": no edge is on one face alone; 'silhouette' draws the outline"
SMOOTH = ": no two faces turn by more than {} degrees; 'silhouette' draws the outline"


@pytest.mark.parametrize(
    ("edges", "message"),
    [
        ("feature", "'feature' chooses none of 480" + SMOOTH.format("62.5")),
        ([np.str_("feature")], "'feature' chooses none of 480" + SMOOTH.format("62.5")),
        ("boundary", "'boundary' chooses none of 480" + CLOSED),
        (["boundary", "feature"], "'boundary' and 'feature' choose none of 480" + SMOOTH.format("62.5")),
        (["feature", np.empty((0, 2), int)], "'feature' and an array choose none of 480" + SMOOTH.format("62.5")),
        (np.empty((0, 2), int), "an array chooses none of 480"),
        ([], "an array chooses none of 480"),
    ],
    ids=str,
)
def test_an_error_about_no_edges_says_what_was_chosen_and_what_draws_the_outline(edges: Any, message: str) -> None:
    ball = samples.icosphere(2)
    with pytest.raises(MeshError, match=f"^edges must choose at least one edge, {message}$"):
        gx.render_array(ball, size=SIZE, edges=edges, feature_angle=62.5)
    with_outline = [edges, "silhouette"] if isinstance(edges, str | np.ndarray) else [*edges, "silhouette"]
    assert (gx.render_array(ball, size=SIZE, edges=with_outline, feature_angle=62.5) != 255).any()


def test_colours_by_face_go_with_all_edges_and_give_way_to_other_colours() -> None:
    by_face = gx.render_array(CUBE, size=SIZE, color="face")
    assert gx.render_array(CUBE, size=SIZE, color="face", edges="all").tobytes() == by_face.tobytes()
    assert gx.render_array(CUBE, size=SIZE, color="face", edges=["all"]).tobytes() == by_face.tobytes()
    for other in ({"edge_colors": ["red"] * 12}, {"vertex_colors": ["red"] * 8}, {"scalars": range(8)}):
        expected = gx.render_array(CUBE, size=SIZE, **other)
        assert gx.render_array(CUBE, size=SIZE, color="face", **other).tobytes() == expected.tobytes()
        chosen = gx.render_array(CUBE, size=SIZE, color="face", edges="feature", **other)
        assert chosen.tobytes() == expected.tobytes()


@pytest.mark.parametrize("name", ["face_colors", "fill"])
def test_a_point_buffer_has_no_faces_to_colour(name: str) -> None:
    with (
        PointBuffer(CUBE.positions.astype(np.float32)) as points,
        pytest.raises(ArgumentError, match=r"(?i)colours by face|^fill must"),
    ):
        gx.render_array(points, size=SIZE, **{name: np.zeros((6, 3))})  # type: ignore[arg-type]


def test_a_layer_takes_its_style_by_name_alone_and_all_that_pictures_take() -> None:
    with pytest.raises(TypeError, match="positional argument"):
        Layer(CUBE, matrices.scale(2))  # type: ignore[call-arg]
    style = get_type_hints(Style)
    fields = get_type_hints(Layer)
    assert list(style) == [field.name for field in dataclasses.fields(Layer)][1:]
    assert style == {name: fields[name] for name in style}


def test_later_layers_lie_over_earlier_ones() -> None:
    bar = Mesh([(-1, 0, 0), (1, 0, 0)], [(0, 1)])
    across = Layer(bar, transform=matrices.rotate_z(90, degrees=True), color="#00ff00", line_width=9.0)
    along = Layer(bar, color="#ff0000", line_width=5.0)
    for layers, middle in (([across, along], [255, 0, 0, 255]), ([along, across], [0, 255, 0, 255])):
        shown = gx.render_array(layers, camera=Camera.window((-1, 1), (-1, 1)), size=(60, 60))
        assert shown[30, 30].tolist() == middle
        assert shown[30, 5].tolist() == [255, 0, 0, 255]
        assert shown[5, 30].tolist() == [0, 255, 0, 255]


OPAQUE: dict[str, dict[str, Any]] = {
    "plain": {},
    "wide": {"line_width": 11.0},
    "on or off": {"antialias": False},
    "removed": {"hidden": "remove"},
    "dots": {"point_size": 6.0},
    "filled": {"fill": "#ffcc00", "line_width": 2.0},
    "silhouette": {"edges": "silhouette"},
}
PLACES = np.stack(
    [
        matrices.chain(matrices.rotate((1, 2, 3), 0.7 * i), matrices.translate(1.3 * i - 3, 0.3 * i, -0.8 * i))
        for i in range(6)
    ]
)
WIDE_VIEW = Camera.look_at((1.0, 2.0, 11.0), (0.0, 0.5, 0.0))


@pytest.mark.slow
@pytest.mark.parametrize("style", OPAQUE)
@pytest.mark.parametrize("binding_bytes", [None, 512])
def test_instances_are_layers_of_their_own(
    style: str, binding_bytes: int | None, device_with_limits: DeviceFactory, device: Any
) -> None:
    used = device if binding_bytes is None else device_with_limits(max_binding_bytes=binding_bytes)
    options: dict[str, Any] = {"camera": WIDE_VIEW, "size": (160, 110), "device": used}
    house = samples.house()
    together = gx.render_array(house, transform=PLACES, color="#204080", **OPAQUE[style], **options)
    apart = gx.render_array(
        [Layer(house, transform=place, color="#204080", **OPAQUE[style]) for place in PLACES], **options
    )
    assert np.abs(together.astype(int) - apart).max() <= (2 if OPAQUE[style].get("line_width", 1.5) > 8 else 1)
    one = gx.render_array(house, transform=PLACES[0], color="#204080", **OPAQUE[style], **options)
    assert (one != together).any(axis=-1).sum() > 1000


@pytest.mark.parametrize(("n_points", "n_triangles", "n_edges"), [(400, 7, 9), (20, 1140, 190), (40, 0, 3000)])
def test_instances_are_split_so_that_points_and_a_number_per_face_or_edge_fit_bindings(
    n_points: int, n_triangles: int, n_edges: int, device_with_limits: DeviceFactory
) -> None:
    small = device_with_limits(max_binding_bytes=1 << 15)
    with PointBuffer(np.ones((n_points, 3), np.float32), device=small) as points:
        stored = points.device_points()
        faces = Faces(stored.buffer, n_triangles) if n_triangles else None
        lines = (Lines(stored.buffer, 1, 1.0), Lines(stored.buffer, n_edges, 1.0))
        matrices_of_many = np.random.default_rng(1).normal(size=(100, 4, 4))
        parts = list(split_to_binding_limits(small, Drawable(stored, matrices_of_many, faces, lines)))
    assert np.array_equal(np.concatenate([part.clip_from_points for part in parts]), matrices_of_many)
    largest = max(len(part.clip_from_points) for part in parts)
    per_instance = max(16 * n_points, 4 * n_triangles, 4 * n_edges)
    assert largest * per_instance + 16 <= 1 << 15 < (largest + 1) * per_instance + 16


def test_instances_of_one_matrix_are_that_one() -> None:
    once = gx.render_array(CUBE, transform=PLACES[2], camera=WIDE_VIEW, size=SIZE)
    assert gx.render_array(CUBE, transform=PLACES[2:3], camera=WIDE_VIEW, size=SIZE).tobytes() == once.tobytes()


def test_the_default_camera_holds_all_instances_and_all_models() -> None:
    layers = [
        Layer(CUBE, transform=PLACES, point_size=3.0),
        Layer(samples.house(), transform=matrices.translate(0, 7, 0)),
    ]
    drawn = gx.render_array(layers, size=(200, 200), background=None)[..., 3] > 0
    assert not drawn[[0, -1]].any()
    assert not drawn[:, [0, -1]].any()
    rows, columns = np.nonzero(drawn)
    assert max(np.ptp(rows), np.ptp(columns)) > 160


def area(picture: Any) -> float:
    """Return how many pixels' worth of black there is."""
    return float((255.0 - picture[..., 0]).sum() / 255.0)


@pytest.mark.parametrize("diameter", [1.0, 2.0, 5.5, 8.0, 13.0, 31.0])
def test_a_dot_has_the_area_of_its_disc(diameter: float) -> None:
    point = Mesh([(0.013, -0.021, 0.0)])
    shown = gx.render_array(point, camera=Camera.window((-1, 1), (-1, 1)), size=(50, 50), point_size=diameter)
    assert area(shown) == pytest.approx(np.pi / 4 * diameter**2, rel=0.03)


def test_points_alone_are_drawn_two_pixels_wide_however_they_are_given() -> None:
    cloud = Mesh(np.random.default_rng(3).uniform(-1, 1, (20, 3)))
    view = {"camera": Camera.fit(cloud), "size": (300, 200)}
    shown = gx.render_array(cloud, **view)  # type: ignore[arg-type]
    assert area(shown) == pytest.approx(20 * np.pi, rel=0.05)
    assert shown.tobytes() == gx.render_array(cloud, point_size=2.0, **view).tobytes()  # type: ignore[arg-type]
    with PointBuffer(cloud.positions.astype(np.float32)) as points:
        assert area(gx.render_array(points, **view)) == pytest.approx(20 * np.pi, rel=0.05)  # type: ignore[arg-type]
        assert area(gx.render_array(points, fill="red", **view)) == pytest.approx(20 * np.pi, rel=0.05)  # type: ignore[arg-type]
    for style in ({"fill": "red"}, {"edges": "silhouette"}, {"hidden": "remove"}, {"color": "face"}):
        assert area(gx.render_array(cloud, **style, **view)) == pytest.approx(20 * np.pi, rel=0.05)  # type: ignore[arg-type]


def test_dots_behind_faces_are_hidden() -> None:
    # Seen from beside a corner, a cube shows seven of its eight.
    seen: dict[HiddenStyle, float] = {"show": 8, "fade": 7.25, "remove": 7}
    camera = Camera.look_at((4.0, 1.7, 5.0), (0.0, 0.0, 0.0))
    for hidden, n_seen in seen.items():
        shown = gx.render_array(CUBE, camera=camera, size=(300, 250), edges=[(0, 0)], point_size=6.0, hidden=hidden)
        assert area(shown) == pytest.approx(n_seen * np.pi * 9, rel=0.02)


def test_an_unknown_keyword_of_a_layer_comes_with_a_suggestion() -> None:
    settings: dict[str, Any] = {"colour": "red"}
    with pytest.raises(ArgumentTypeError, match=r"^unexpected keyword argument 'colour'; did you mean 'color'\?$"):
        Layer(CUBE, **settings)
    assert dataclasses.replace(Layer(model=CUBE, color="red"), line_width=3).color == "red"
    assert copy.copy(Layer(CUBE, alpha=0.5)).alpha == 0.5


def test_the_text_of_a_layer_names_what_differs_from_the_defaults() -> None:
    assert repr(Layer(CUBE)) == f"Layer({CUBE!r})"
    layer = Layer(CUBE, color="red", transform=np.eye(4), line_width=2, antialias=False)
    assert repr(layer) == f"Layer({CUBE!r}, transform=<array (4, 4)>, line_width=2, antialias=False, color='red')"
