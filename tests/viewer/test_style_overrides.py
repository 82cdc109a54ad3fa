from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gpu_xform import Layer, Mesh, render_array, samples
from gpu_xform.viewer import style_overrides
from gpu_xform.viewer.style_overrides import DARK, StyleOverrides, apply_overrides

HOUSE = samples.house()
N_EDGES, N_FACES = len(HOUSE.edges), HOUSE.n_faces
POINTS = Mesh(HOUSE.positions, [])

Change = Callable[[StyleOverrides, Layer], tuple[StyleOverrides, str]]


def notes_of(change: Change, layer: Layer, times: int) -> list[str]:
    overrides, notes = StyleOverrides(), []
    for _ in range(times):
        overrides, note = change(overrides, layer)
        notes.append(note)
    return notes


def shown(layer: Layer, overrides: StyleOverrides, pixel_ratio: float = 1.0) -> Layer:
    [layer] = apply_overrides([layer], overrides, pixel_ratio)
    return layer


def pixels(layer: Layer) -> bytes:
    # No colour of the overrides vanishes on this background.
    return render_array(layer, size=(60, 50), background="#3060a0").tobytes()


@pytest.mark.parametrize(
    ("change", "style", "expected"),
    [
        (style_overrides.next_edges, {}, ["feature", "boundary", "silhouette", "all", "feature"]),
        (style_overrides.next_edges, {"edges": "boundary"}, ["silhouette", "all"]),
        (style_overrides.next_edges, {"edges": ["silhouette"]}, ["all", "feature"]),
        (style_overrides.next_edges, {"edges": ["feature", "boundary"]}, ["all", "feature"]),
        (style_overrides.next_edges, {"edges": np.array([[0, 1]])}, ["all", "feature"]),
        (style_overrides.next_hidden, {}, ["remove", "dash", "fade", "show", "remove"]),
        (style_overrides.next_hidden, {"fill": "gold"}, ["dash", "fade"]),
        (style_overrides.next_hidden, {"hidden": "fade"}, ["show", "remove"]),
        (style_overrides.toggle_fill, {}, ["on", "off", "on"]),
        (style_overrides.toggle_fill, {"fill": "gold"}, ["off", "on"]),
        (style_overrides.toggle_face_colors, {}, ["on", "off", "on"]),
        (style_overrides.toggle_face_colors, {"color": "face"}, ["off", "on"]),
        (style_overrides.toggle_face_colors, {"fill": "face"}, ["off", "on"]),
        (style_overrides.toggle_face_colors, {"face_colors": np.ones((N_FACES, 3))}, ["off", "on"]),
        (style_overrides.toggle_antialias, {}, ["off", "on"]),
        (style_overrides.toggle_antialias, {"antialias": False}, ["on", "off"]),
    ],
)
def test_a_key_cycles_from_what_is_shown(change: Change, style: dict[str, Any], expected: list[str]) -> None:
    assert [note.split(": ")[1] for note in notes_of(change, Layer(HOUSE, **style), len(expected))] == expected


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
def test_backgrounds_cycle_back_to_the_first(given: Any, expected: list[str | None]) -> None:
    overrides, found = StyleOverrides(), []
    for _ in expected:
        overrides, _note = style_overrides.next_background(overrides, given)
        found.append(overrides.background)
    assert found == expected


def test_without_keys_a_layer_is_drawn_as_it_is() -> None:
    for layer in (Layer(HOUSE, color="face", fill="gold"), Layer(HOUSE, edges="feature"), Layer(POINTS)):
        assert pixels(shown(layer, StyleOverrides())) == pixels(layer)


@pytest.mark.parametrize(
    ("style", "overrides", "expected"),
    [
        ({}, StyleOverrides(edges="feature"), {"edges": "feature"}),
        ({"edges": "feature"}, StyleOverrides(edges="all"), {}),
        ({"edges": [[0, 1]], "edge_colors": [(1, 0, 0)]}, StyleOverrides(edges="all"), {}),
        ({"edge_colors": np.eye(3)[np.arange(N_EDGES) % 3]}, StyleOverrides(edges="feature"), None),
        ({}, StyleOverrides(hidden="dash"), {"hidden": "dash"}),
        ({}, StyleOverrides(filled=True), {"fill": "lightgray"}),
        ({"fill": "gold"}, StyleOverrides(filled=True), {"fill": "gold"}),
        ({"fill": "gold"}, StyleOverrides(filled=False), {}),
        ({}, StyleOverrides(face_colors=True), {"color": "face"}),
        ({}, StyleOverrides(face_colors=True, filled=True), {"fill": "face"}),
        ({"fill": "face"}, StyleOverrides(face_colors=False), {"fill": "lightgray"}),
        ({"color": "face"}, StyleOverrides(face_colors=False), {}),
        ({"color": "red"}, StyleOverrides(face_colors=False), {"color": "red"}),
        ({"color": "face"}, StyleOverrides(edges="feature"), {"edges": "feature"}),
        ({"color": "face"}, StyleOverrides(edges="all"), {"color": "face"}),
        ({}, StyleOverrides(face_colors=True, edges="feature"), {"edges": "feature"}),
        ({}, StyleOverrides(face_colors=True, edges="feature", filled=True), {"edges": "feature", "fill": "face"}),
        ({"face_colors": [(1, 0, 0)] * N_FACES}, StyleOverrides(face_colors=False), {}),
        ({"face_colors": [(1, 0, 0)] * N_FACES}, StyleOverrides(edges="feature"), {"edges": "feature"}),
        ({"scalars": HOUSE.positions[:, 1]}, StyleOverrides(face_colors=True), {"color": "face"}),
        ({"vertex_colors": HOUSE.positions * 0}, StyleOverrides(face_colors=True), {"color": "face"}),
        ({}, StyleOverrides(antialias=False), {"antialias": False}),
        ({}, StyleOverrides(background=DARK), {"color": "white"}),
        ({"color": "#000"}, StyleOverrides(background=DARK), {"color": "white"}),
        ({"color": "none"}, StyleOverrides(background=DARK), {"color": "none"}),
        ({"color": "#00000080"}, StyleOverrides(background=DARK), {"color": "#ffffff80"}),
        ({"color": "red"}, StyleOverrides(background=DARK), {"color": "red"}),
        ({"color": np.zeros(3)}, StyleOverrides(background=DARK), {"color": "white"}),
        ({"color": np.array([0.2, 0.3, 0.4])}, StyleOverrides(background=DARK), {"color": (0.2, 0.3, 0.4)}),
        ({}, StyleOverrides(background=DARK, filled=True), {"fill": "lightgray"}),
        ({}, StyleOverrides(background="white"), {}),
        ({"color": "face"}, StyleOverrides(background=DARK, face_colors=False), {"color": "white"}),
    ],
)
def test_overrides_are_drawn_as_the_style_that_they_give(
    style: dict[str, Any], overrides: StyleOverrides, expected: dict[str, Any] | None
) -> None:
    drawn = pixels(shown(Layer(HOUSE, **style), overrides))
    if expected is None:  # the layer's own colours stay
        expected = style | {"edges": overrides.edges}
    assert drawn == pixels(Layer(HOUSE, **expected))


def test_on_a_screen_of_finer_pixels_lines_and_points_are_as_wide_as_on_others() -> None:
    fine = shown(Layer(HOUSE, line_width=2.0, point_size=3.0), StyleOverrides(), 1.5)
    assert (fine.line_width, fine.point_size) == (3.0, 4.5)
    assert shown(Layer(HOUSE), StyleOverrides(), 2.0).point_size is None
    assert pixels(shown(Layer(POINTS), StyleOverrides(), 2.0)) == pixels(Layer(POINTS, point_size=4.0))


def test_points_alone_are_shown_whatever_is_requested_of_faces() -> None:
    overrides = StyleOverrides(edges="feature", hidden="dash", filled=True, face_colors=True)
    assert pixels(shown(Layer(POINTS), overrides)) == pixels(Layer(POINTS))
