import math
from typing import Any

import numpy as np
import pytest

from gpu_xform import Camera, Layer, samples
from gpu_xform.viewer.controls import Controls, InitialView, Request, ViewState
from gpu_xform.viewer.key_bindings import KEYS
from gpu_xform.viewer.orbit import BoundingSphere, Orbit
from gpu_xform.viewer.style_overrides import StyleOverrides
from tests.support.types import Array

HOUSE = samples.house()
CAMERA = Camera.fit(HOUSE)
BOUNDS = BoundingSphere.around(HOUSE.positions)
SIZE = (400.0, 200.0)
START = Orbit.from_camera(CAMERA, 2.0, BOUNDS)


def controls(up: Array | None = None) -> Controls:
    return Controls(InitialView(CAMERA, BOUNDS, lambda: HOUSE.positions, Layer(HOUSE), "white", up))


def pointer(kind: str, x: float, y: float, button: int = 1, *modifiers: str) -> dict[str, Any]:
    buttons = () if kind == "up" else (button,)
    return {
        "event_type": f"pointer_{kind}",
        "x": x,
        "y": y,
        "button": 0 if kind == "move" else button,
        "buttons": buttons,
        "modifiers": modifiers,
    }


def drag(on: Controls, *places: tuple[float, float], button: int = 1, modifiers: tuple[str, ...] = ()) -> None:
    on.handle(pointer("down", *places[0], button, *modifiers), SIZE)
    for place in places[1:]:
        on.handle(pointer("move", *place, button, *modifiers), SIZE)
    on.handle(pointer("up", *places[-1], button, *modifiers), SIZE)


def key(on: Controls, name: str, *modifiers: str) -> Request | None:
    return on.handle({"event_type": "key_down", "key": name, "modifiers": modifiers}, SIZE)


def orbit(on: Controls) -> Orbit:
    assert on.view.orbit is not None
    return on.view.orbit


def assert_same(a: Orbit, b: Orbit) -> None:
    np.testing.assert_allclose(a.camera.clip_from_world(2.0), b.camera.clip_from_world(2.0), rtol=1e-9, atol=1e-9)


def test_before_any_drag_the_view_is_the_initial_one() -> None:
    on = controls()
    on.handle(pointer("move", 10, 10), SIZE)
    on.handle(pointer("down", 10, 10), SIZE)
    on.handle(pointer("up", 10, 10), SIZE)
    assert on.view == ViewState()


def test_a_drag_of_the_height_of_the_window_rotates_by_half_a_turn() -> None:
    on = controls()
    drag(on, (100, 100), (130, 90))
    assert_same(orbit(on), START.rotated(math.pi * 30 / 200, math.pi * -10 / 200))


def test_a_drag_in_steps_goes_where_the_pointer_goes() -> None:
    on = controls()
    drag(on, (100, 100), (110, 100), (90, 100), (140, 100))
    assert_same(orbit(on), START.rotated(math.pi * 40 / 200, 0.0))


@pytest.mark.parametrize(("button", "modifiers"), [(1, ("Shift",)), (2, ()), (3, ()), (2, ("Shift",))])
def test_with_shift_or_another_button_a_drag_moves(button: int, modifiers: tuple[str, ...]) -> None:
    on = controls()
    drag(on, (100, 50), (300, 100), (200, 150), button=button, modifiers=modifiers)
    assert_same(orbit(on), START.panned(np.array([-0.5, 0.5]), np.array([0.0, -0.5]), 2.0))


def test_a_drag_keeps_to_the_button_that_began_it() -> None:
    on = controls()
    on.handle(pointer("down", 100, 100), SIZE)
    on.handle(pointer("down", 100, 100, 2) | {"buttons": (1, 2)}, SIZE)
    on.handle(pointer("up", 100, 100, 2) | {"buttons": (1,)}, SIZE)
    on.handle(pointer("move", 120, 100), SIZE)
    assert_same(orbit(on), START.rotated(math.pi * 0.1, 0.0))


def test_a_drag_ends_where_its_button_is_up_again_even_unseen() -> None:
    on = controls()
    drag(on, (100, 100), (120, 100))
    before = on.view
    on.handle(pointer("move", 200, 100) | {"buttons": ()}, SIZE)
    assert on.view is before
    on.handle(pointer("down", 100, 100), SIZE)
    on.handle(pointer("move", 200, 100) | {"buttons": ()}, SIZE)
    on.handle(pointer("move", 300, 100), SIZE)
    assert on.view is before


@pytest.mark.parametrize("notches", [1, -1, 3])
def test_a_wheel_zooms_at_the_pointer(notches: int) -> None:
    on = controls()
    on.handle({"event_type": "wheel", "dx": 0, "dy": 100.0 * notches, "x": 100, "y": 50, "modifiers": ()}, SIZE)
    assert_same(orbit(on), START.zoomed(1.2**notches, np.array([-0.5, 0.5]), 2.0))


@pytest.mark.parametrize("dy", [1e9, -1e9])
def test_a_wheel_that_turns_wildly_zooms_as_far_as_it_goes(dy: float) -> None:
    on = controls()
    on.handle({"event_type": "wheel", "dx": 0, "dy": dy, "x": 100, "y": 50, "modifiers": ()}, SIZE)
    assert_same(orbit(on), START.zoomed(1.2 ** math.copysign(100.0, dy), np.array([-0.5, 0.5]), 2.0))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("+", START.zoomed(1 / 1.2, np.zeros(2), 2.0)),
        ("=", START.zoomed(1 / 1.2, np.zeros(2), 2.0)),
        ("-", START.zoomed(1.2, np.zeros(2), 2.0)),
        ("ArrowRight", START.rotated(math.pi / 12, 0.0)),
        ("ArrowLeft", START.rotated(-math.pi / 12, 0.0)),
        ("ArrowUp", START.rotated(0.0, -math.pi / 12)),
        ("ArrowDown", START.rotated(0.0, math.pi / 12)),
        *(
            (name, START.seen_from(side, HOUSE.positions, 2.0))
            for name, side in [("1", "front"), ("2", "right"), ("3", "above")]
        ),
    ],
)
def test_keys_that_move(name: str, expected: Orbit) -> None:
    on = controls()
    assert key(on, name) is None
    assert_same(orbit(on), expected)


def test_with_shift_a_side_is_seen_from_the_other() -> None:
    for name, side in [("1", "back"), ("2", "left"), ("3", "below")]:
        on = controls()
        key(on, name, "Shift")
        assert_same(orbit(on), START.seen_from(side, HOUSE.positions, 2.0))


def test_p_goes_to_a_parallel_view_and_back() -> None:
    on = controls()
    key(on, "p")
    assert orbit(on).orthographic
    key(on, "p")
    assert_same(orbit(on), START)


@pytest.mark.parametrize("name", ["r", "R", "Home"])
def test_r_goes_back_to_the_first_view_and_keeps_the_style(name: str) -> None:
    on = controls()
    key(on, "e")
    drag(on, (100, 100), (130, 90))
    key(on, name)
    assert on.view.orbit is None
    assert on.view.overrides == StyleOverrides(edges="feature")


def test_backspace_goes_back_to_the_first_style_and_keeps_the_view() -> None:
    on = controls()
    for name in "edfcab":
        key(on, name)
    drag(on, (100, 100), (130, 90))
    key(on, "Backspace")
    assert on.view.overrides == StyleOverrides()
    assert on.view.orbit is not None


@pytest.mark.parametrize(
    ("names", "overrides", "note"),
    [
        ("e", StyleOverrides(edges="feature"), "edges: feature"),
        ("EE", StyleOverrides(edges="boundary"), "edges: boundary"),
        ("d", StyleOverrides(hidden="remove"), "hidden edges: remove"),
        ("f", StyleOverrides(filled=True), "faces filled: on"),
        ("fd", StyleOverrides(filled=True, hidden="dash"), "hidden edges: dash"),
        ("c", StyleOverrides(face_colors=True), "one colour per face: on"),
        ("ec", StyleOverrides(edges="feature", filled=True, face_colors=True), "one colour per face: on"),
        ("a", StyleOverrides(antialias=False), "smooth lines: off"),
        ("b", StyleOverrides(background="#1e1e1e"), "background: #1e1e1e"),
    ],
)
def test_keys_that_change_the_style(names: str, overrides: StyleOverrides, note: str) -> None:
    on = controls()
    for name in names:
        assert key(on, name) is None
    assert on.view == ViewState(overrides=overrides, note=note)


@pytest.mark.parametrize(
    ("name", "request_"),
    [("s", Request.SAVE), ("S", Request.SAVE), ("q", Request.CLOSE), ("Escape", Request.CLOSE), ("x", None)],
)
def test_keys_that_request_something_of_the_window_keep_the_view(name: str, request_: Request | None) -> None:
    on = controls()
    before = on.view
    assert key(on, name) is request_
    assert on.view is before


@pytest.mark.parametrize("name", ["h", "?", "/", "F1"])
def test_help_is_shown_and_hidden(name: str) -> None:
    on = controls()
    for expected in (True, False):
        key(on, name)
        assert on.view.has_help is expected


@pytest.mark.parametrize("modifier", ["Control", "Alt", "Meta"])
def test_what_is_typed_with_control_is_not_for_the_view(modifier: str) -> None:
    on = controls()
    for name in "qse1":
        assert key(on, name, modifier) is None
    assert on.view == ViewState()


def test_every_key_of_the_help_does_something() -> None:
    for names, _ in KEYS:
        for typed in names.split(", "):
            name = {"Esc": "Escape"}.get(typed, typed)
            on = controls()
            before = on.view
            assert key(on, name) is not None or on.view is not before, typed


def test_a_window_without_a_size_takes_no_events() -> None:
    on = controls()
    on.handle({"event_type": "wheel", "dx": 0, "dy": 100.0, "x": 0, "y": 0, "modifiers": ()}, (0.0, 100.0))
    assert on.view == ViewState()


def test_rotation_is_about_the_up_that_is_given() -> None:
    on = controls(up=np.array([0.0, 0.0, 1.0]))
    drag(on, (100, 100), (130, 100))
    assert_same(
        orbit(on), Orbit.from_camera(CAMERA, 2.0, BOUNDS, np.array([0.0, 0.0, 1.0])).rotated(math.pi * 0.15, 0.0)
    )
