"""Annotations in pixels cover the areas that their shapes and boxes have."""

import numpy as np
import pytest

from gpu_xform.annotation.items import Annotation, Box, Disc, Line, Rectangle, Shape
from gpu_xform.annotation.paint import draw_annotation
from gpu_xform.annotation.text_style import make_text_style, move_text
from tests.support.types import Pixels

RED = (1.0, 0.0, 0.0, 1.0)
WHITE = (1.0, 1.0, 1.0, 1.0)


def drawn(annotation: Annotation, background: tuple[int, ...] = (255, 255, 255, 255)) -> Pixels:
    pixels = np.full((50, 60, 4), background, np.uint8)
    draw_annotation(pixels, annotation)
    return pixels


@pytest.mark.parametrize(
    ("shape", "area"),
    [
        (Rectangle(Box(10.25, 20.5, 15.5, 22.75), RED), 5.25 * 2.25),
        (Line(10.0, 10.0, 40.0, 33.0, 2.0, RED), 2.0 * np.hypot(30, 23)),
        (Line(5.0, 10.5, 45.0, 10.5, 1.0, RED, (6.0, 4.0)), 24.0),
        (Disc(30.3, 20.7, 9.0, RED), np.pi * 4.5**2),
    ],
)
def test_a_shape_covers_its_area(shape: Rectangle | Line | Disc, area: float) -> None:
    coverage = 1.0 - drawn(Annotation([shape]))[..., 1] / 255.0
    assert coverage.sum() == pytest.approx(area, rel=0.02)


def test_a_shape_beyond_the_picture_is_cut_off() -> None:
    line = Line(-9, 48, 99, 48, 1, RED)
    shapes: list[Shape] = [Rectangle(Box(-5.0, -5.0, 3.0, 2.0), RED), Disc(200.0, 10.0, 5.0, RED), line]
    covered = (drawn(Annotation(shapes))[..., 1] < 255).sum()
    assert covered == 6 + 120  # the line covers half of two rows


def test_a_text_keeps_to_its_box_and_its_halo_to_a_margin() -> None:
    style = make_text_style(None, 14.0, (60, 50), (0.0, 0.0, 1.0, 1.0))
    text = move_text(style.text("Agj1", "labels", color=RED), 12.25, 20.5)
    pixels = drawn(Annotation((), [text]), (0, 0, 255, 255)).astype(int)
    rows, columns = np.nonzero(pixels[..., 0] > 40)
    left, top, right, bottom = text.box
    assert (columns.min(), columns.max() + 1) == (pytest.approx(left, abs=1.6), pytest.approx(right, abs=2.6))
    assert (rows.min(), rows.max() + 1) == (pytest.approx(top, abs=1.6), pytest.approx(bottom, abs=1.6))


def test_over_a_transparent_picture_text_has_its_own_colour() -> None:
    style = make_text_style(None, 20.0, (60, 50), (0.0, 0.0, 0.0, 0.0))
    shown = drawn(Annotation((), [move_text(style.text("HI", "labels", color=RED), 9.0, 9.0)]), (0, 0, 0, 0))
    solid = shown[shown[..., 3] == 255]
    assert len(solid) > 20
    assert (solid == (255, 0, 0, 255)).all(axis=1).any()
    halo = shown[(shown[..., 3] > 0) & (shown[..., 1] > 200)]
    assert len(halo) > 20  # white, as on paper
    assert (shown[..., 3] == 0).any()


def test_texts_stand_out_from_the_background() -> None:
    assert make_text_style(None, None, (256, 256), WHITE).is_dark
    assert not make_text_style(None, None, (256, 256), (0.1, 0.1, 0.2, 1.0)).is_dark
    assert [make_text_style(None, None, (side, side), WHITE).size for side in (256, 1024)] == [10.0, 20.0]
