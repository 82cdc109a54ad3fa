"""Axes: ticks at round numbers, where these are in the picture, on the outermost edges of the box."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform._core.types import Float64Array
from gpu_xform.annotation.axes import AxesFigure, inset_matrix, lay_out_axes, overflow, pad_bounds
from gpu_xform.annotation.items import Box
from gpu_xform.annotation.text_style import make_text_style
from gpu_xform.annotation.ticks import format_values, multiples_of, steps_from
from gpu_xform.drawing.depth import eye, reverse_z

SIZE = (320, 240)
STYLE = make_text_style(None, 10.0, SIZE, (1.0, 1.0, 1.0, 1.0))
BOUNDS = np.array([(-1.3, 0.0, 2.0), (2.2, 1.1, 4.7)])
EVERYWHERE = Box(-np.inf, -np.inf, np.inf, np.inf)


def figure(
    camera: gx.Camera,
    bounds: Float64Array = BOUNDS,
    viewport: Box = EVERYWHERE,
    titles: tuple[str | None, ...] = ("x", "y", "z"),
) -> AxesFigure:
    matrix = camera.clip_from_world(SIZE[0] / SIZE[1])
    return lay_out_axes(bounds, matrix, eye(reverse_z(matrix, lambda: bounds)), SIZE, viewport, titles, STYLE)


def to_pixels(point: Float64Array, camera: gx.Camera) -> Float64Array:
    x, y, _, w = camera.clip_from_world(SIZE[0] / SIZE[1]) @ np.append(point, 1.0)
    return np.array(((x / w + 1.0) / 2.0 * SIZE[0], (1.0 - y / w) / 2.0 * SIZE[1]))


directions = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda d: np.hypot(d[0], d[2]) > 0.2)


@settings(max_examples=25)
@given(directions, st.booleans(), st.floats(0.02, 900.0))
def test_ticks_stand_where_their_numbers_are_and_no_two_texts_overlap(
    direction: tuple[float, float, float], orthographic: bool, scale: float
) -> None:
    bounds = BOUNDS * scale
    corners = np.array(list(itertools.product(*bounds.T)))
    camera = gx.Camera.fit(corners, direction=direction, orthographic=orthographic, margin=0.15)
    axes = figure(camera, bounds)
    outline = np.array([to_pixels(corner, camera) for corner in corners])
    for axis, ticks in enumerate(axes.ticks):
        if not ticks:
            continue
        spine = next(spine for spine in axes.spines if spine[0, axis] != spine[1, axis])
        values = [tick.value for tick in ticks]
        steps = np.diff(values)
        if len(values) > 1:
            first_digit = f"{steps.min():e}"[0]
            assert first_digit in {"1", "2", "5"} or f"{steps.min():.0e}"[0] in {"1", "2", "5"}
        for tick in ticks:
            assert bounds[0, axis] - 1e-9 * scale <= tick.value <= bounds[1, axis] + 1e-9 * scale
            assert float(tick.text.text) == pytest.approx(tick.value, abs=1e-6 * scale)
            point = spine[0].copy()
            point[axis] = tick.value
            np.testing.assert_allclose((tick.x, tick.y), to_pixels(point, camera), atol=1e-6)
            # The text lies outside: the box's middle and the text are on opposite sides of the tick.
            middle = np.array(tick.text.box).reshape(2, 2).mean(axis=0)
            away = middle - (tick.x, tick.y)
            assert away @ ((tick.x, tick.y) - to_pixels(bounds.mean(axis=0), camera)) > -1e-6
            across = np.array((-away[1], away[0]))
            assert np.ptp(outline @ across) > 0.0
    boxes = [text.box for text in axes.annotation.texts]
    for a, b in itertools.combinations(boxes, 2):
        assert not (a.left < b.right and b.left < a.right and a.top < b.bottom and b.top < a.bottom)


def test_a_plane_seen_from_the_front_has_numbers_below_and_at_the_left() -> None:
    camera = gx.Camera.window((-1.0, 3.0), (-1.0, 2.0))
    axes = figure(camera, np.array([(0.0, 0.0, 0.0), (2.0, 1.0, 0.0)]))
    x, y, z = axes.ticks
    assert not z
    assert [tick.text.text for tick in y] == ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
    assert {tick.y for tick in x} == {160.0}
    assert {tick.x for tick in y} == {80.0}
    assert [tick.x for tick in x] == pytest.approx([80.0 + 80.0 * tick.value for tick in x])
    assert all(tick.text.box.top > 160.0 for tick in x)
    assert all(tick.text.box.right < 80.0 for tick in y)
    assert [text.text for text in axes.annotation.texts][-2:] == ["x", "y"]


def test_an_eye_in_the_box_sees_no_axes() -> None:
    inside = gx.Camera.look_at(BOUNDS.mean(axis=0), (9.0, 1.0, 3.0))
    assert figure(inside).annotation.is_empty


def test_ticks_beyond_the_picture_and_titles_that_are_none_are_left_out() -> None:
    camera = gx.Camera.look_at((3, 5, 12), (0.4, 0.5, 3.3), fov_y=10.0)
    whole, part = figure(camera), figure(camera, viewport=Box(0.0, 0.0, *SIZE), titles=(None, "up", ""))
    assert sum(map(len, part.ticks)) < sum(map(len, whole.ticks))
    titles = [text.text for text in part.annotation.texts[sum(map(len, part.ticks)) :]]
    assert set(titles) <= {"up"}


def test_the_grid_is_behind() -> None:
    camera = gx.Camera.fit(np.array(list(itertools.product(*BOUNDS.T))))  # looks down, to the left and to the back
    axes = figure(camera)
    low, high = BOUNDS
    on_side = {
        (axis, side)
        for axis in range(3)
        for side, value in enumerate((low[axis], high[axis]))
        if (axes.grid[:, :, axis] == value).all(axis=1).sum() > 4
    }
    assert on_side == {(0, 0), (1, 0), (2, 0)}
    assert ((axes.grid >= low) & (axes.grid <= high)).all()


@pytest.mark.parametrize(
    ("least", "expected"),
    [
        (0.3, [0.5, 1.0, 2.0, 5.0]),
        (1.0, [1.0, 2.0, 5.0, 10.0]),
        (4200.0, [5e3, 1e4, 2e4, 5e4]),
        (0.0011, [0.002, 0.005]),
    ],
)
def test_steps_are_round(least: float, expected: list[float]) -> None:
    assert list(itertools.islice(steps_from(least), len(expected))) == expected


@pytest.mark.parametrize(
    ("step", "low", "high", "texts"),
    [
        (0.5, -1.0, 1.0, ["-1.0", "-0.5", "0.0", "0.5", "1.0"]),
        (0.1, 0.25, 0.61, ["0.3", "0.4", "0.5", "0.6"]),
        (2.0, -3.0, 3.0, ["-2", "0", "2"]),
        (5e8, -5e8, 1e9, ["-5.0e8", "0", "5.0e8", "1.0e9"]),
        (1e-6, 0.0, 2e-6, ["0", "1e-6", "2e-6"]),
        (0.2, 1234567.0, 1234567.5, ["1234567.0", "1234567.2", "1234567.4"]),
    ],
)
def test_numbers_have_the_digits_that_their_step_needs(step: float, low: float, high: float, texts: list[str]) -> None:
    values = multiples_of(step, low, high)
    assert format_values(values, step) == texts


def test_the_frame_moves_in_by_what_texts_reach_over_it() -> None:
    inset = np.array((20.0, 10.0, 60.0, 30.0))
    corners = np.array([(-1, 1, 0.3, 1), (1, -1, 0.3, 1)]) @ inset_matrix(inset, SIZE).T
    pixels = (corners[:, :2] * (0.5, -0.5) + 0.5) * SIZE
    np.testing.assert_allclose(pixels, [(20, 10), (260, 210)])
    assert (corners[:, 2] == 0.3).all()
    text = STYLE.text("abc", "labels")
    np.testing.assert_allclose(overflow([text], SIZE, 4.0), [4, 4, 0, 0])
    np.testing.assert_allclose(pad_bounds(BOUNDS)[1] - BOUNDS[1], 0.04 * (BOUNDS[1] - BOUNDS[0]))
