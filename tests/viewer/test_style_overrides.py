from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gpu_xform import Layer, Mesh, render_array, samples
from gpu_xform.viewer import style_overrides as looks
from gpu_xform.viewer.style_overrides import DARK, Look, restyled

HOUSE = samples.house()
N_EDGES, N_FACES = len(HOUSE.edges), HOUSE.n_faces
POINTS = Mesh(HOUSE.positions, [])

Change = Callable[[Look, Layer], tuple[Look, str]]


def said(change: Change, layer: Layer, times: int) -> list[str]:
    look, notes = Look(), []
    for _ in range(times):
        look, note = change(look, layer)
        notes.append(note)
    return notes


def shown(layer: Layer, look: Look, pixel_ratio: float = 1.0) -> Layer:
    [layer] = restyled([layer], look, pixel_ratio)
    return layer


def pixels(layer: Layer) -> bytes:
    return render_array(layer, size=(60, 50), background="#3060a0").tobytes()  # on which no colour of a look vanishes


@pytest.mark.parametrize(
    ("change", "style", "expected"),
    [
        (looks.next_edges, {}, ["feature", "boundary", "silhouette", "all", "feature"]),
        (looks.next_edges, {"edges": "boundary"}, ["silhouette", "all"]),
        (looks.next_edges, {"edges": ["silhouette"]}, ["all", "feature"]),
        (looks.next_edges, {"edges": ["feature", "boundary"]}, ["all", "feature"]),
        (looks.next_edges, {"edges": np.array([[0, 1]])}, ["all", "feature"]),
        (looks.next_hidden, {}, ["remove", "dash", "fade", "show", "remove"]),
        (looks.next_hidden, {"fill": "gold"}, ["dash", "fade"]),
        (looks.next_hidden, {"hidden": "fade"}, ["show", "remove"]),
        (looks.other_fill, {}, ["on", "off", "on"]),
        (looks.other_fill, {"fill": "gold"}, ["off", "on"]),
        (looks.other_face_colors, {}, ["on", "off", "on"]),
        (looks.other_face_colors, {"color": "face"}, ["off", "on"]),
        (looks.other_face_colors, {"fill": "face"}, ["off", "on"]),
        (looks.other_face_colors, {"face_colors": np.ones((N_FACES, 3))}, ["off", "on"]),
        (looks.other_antialias, {}, ["off", "on"]),
        (looks.other_antialias, {"antialias": False}, ["on", "off"]),
    ],
)
def test_a_key_goes_on_from_what_is_shown(change: Change, style: dict[str, Any], expected: list[str]) -> None:
    assert [note.split(": ")[1] for note in said(change, Layer(HOUSE, **style), len(expected))] == expected


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("white", [DARK, None, DARK]),
        ("#ffffff", [DARK, None]),
        ((1.0, 1.0, 1.0), [DARK, None]),
        ("navy", ["white", DARK, None, "white"]),
        (None, ["white", DARK, None]),
        (np.array([0.0, 0.0, 0.5]), ["white", DARK, None]),
    ],
)
def test_backgrounds_go_round_and_come_back_to_the_first(given: Any, expected: list[str | None]) -> None:
    look, found = Look(), []
    for _ in expected:
        look, _note = looks.next_ground(look, given)
        found.append(look.ground)
    assert found == expected


def test_without_keys_a_layer_is_drawn_as_it_is() -> None:
    for layer in (Layer(HOUSE, color="face", fill="gold"), Layer(HOUSE, edges="feature"), Layer(POINTS)):
        assert pixels(shown(layer, Look())) == pixels(layer)


@pytest.mark.parametrize(
    ("style", "look", "expected"),
    [
        ({}, Look(edges="feature"), {"edges": "feature"}),
        ({"edges": "feature"}, Look(edges="all"), {}),
        ({"edges": [[0, 1]], "edge_colors": [(1, 0, 0)]}, Look(edges="all"), {}),
        ({"edge_colors": np.eye(3)[np.arange(N_EDGES) % 3]}, Look(edges="feature"), None),
        ({}, Look(hidden="dash"), {"hidden": "dash"}),
        ({}, Look(filled=True), {"fill": "lightgray"}),
        ({"fill": "gold"}, Look(filled=True), {"fill": "gold"}),
        ({"fill": "gold"}, Look(filled=False), {}),
        ({}, Look(by_face=True), {"color": "face"}),
        ({}, Look(by_face=True, filled=True), {"fill": "face"}),
        ({"fill": "face"}, Look(by_face=False), {"fill": "lightgray"}),
        ({"color": "face"}, Look(by_face=False), {}),
        ({"color": "red"}, Look(by_face=False), {"color": "red"}),
        ({"color": "face"}, Look(edges="feature"), {"edges": "feature"}),
        ({"color": "face"}, Look(edges="all"), {"color": "face"}),
        ({}, Look(by_face=True, edges="feature"), {"edges": "feature"}),
        ({}, Look(by_face=True, edges="feature", filled=True), {"edges": "feature", "fill": "face"}),
        ({"face_colors": [(1, 0, 0)] * N_FACES}, Look(by_face=False), {}),
        ({"face_colors": [(1, 0, 0)] * N_FACES}, Look(edges="feature"), {"edges": "feature"}),
        ({"scalars": HOUSE.positions[:, 1]}, Look(by_face=True), {"color": "face"}),
        ({"vertex_colors": HOUSE.positions * 0}, Look(by_face=True), {"color": "face"}),
        ({}, Look(antialias=False), {"antialias": False}),
        ({}, Look(ground=DARK), {"color": "white"}),
        ({"color": "#000"}, Look(ground=DARK), {"color": "white"}),
        ({"color": "none"}, Look(ground=DARK), {"color": "none"}),
        ({"color": "#00000080"}, Look(ground=DARK), {"color": "#ffffff80"}),
        ({"color": "red"}, Look(ground=DARK), {"color": "red"}),
        ({"color": np.zeros(3)}, Look(ground=DARK), {"color": "white"}),
        ({"color": np.array([0.2, 0.3, 0.4])}, Look(ground=DARK), {"color": (0.2, 0.3, 0.4)}),
        ({}, Look(ground=DARK, filled=True), {"fill": "lightgray"}),
        ({}, Look(ground="white"), {}),
        ({"color": "face"}, Look(ground=DARK, by_face=False), {"color": "white"}),
    ],
)
def test_a_look_is_drawn_as_the_style_that_it_means(
    style: dict[str, Any], look: Look, expected: dict[str, Any] | None
) -> None:
    drawn = pixels(shown(Layer(HOUSE, **style), look))
    if expected is None:  # the layer's own colours stay
        expected = style | {"edges": look.edges}
    assert drawn == pixels(Layer(HOUSE, **expected))


def test_on_a_screen_of_finer_pixels_lines_and_dots_are_as_wide_as_on_others() -> None:
    fine = shown(Layer(HOUSE, line_width=2.0, point_size=3.0), Look(), 1.5)
    assert (fine.line_width, fine.point_size) == (3.0, 4.5)
    assert shown(Layer(HOUSE), Look(), 2.0).point_size is None
    assert pixels(shown(Layer(POINTS), Look(), 2.0)) == pixels(Layer(POINTS, point_size=4.0))


def test_points_alone_are_shown_whatever_is_asked_of_faces() -> None:
    look = Look(edges="feature", hidden="dash", filled=True, by_face=True)
    assert pixels(shown(Layer(POINTS), look)) == pixels(Layer(POINTS))
