"""The column of legend and colour bars keeps to the right of the picture, and nothing in it overlaps."""

import itertools

import numpy as np
import pytest

from gpu_xform.annotation.column import ColorBar, LegendEntry, lay_out_column
from gpu_xform.annotation.items import Box, Disc, Line, Rectangle
from gpu_xform.annotation.text_style import make_text_style

SIZE = (300, 240)
STYLE = make_text_style(None, 10.0, SIZE, (1.0, 1.0, 1.0, 1.0))
RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
GREYS = np.repeat(np.linspace(0.0, 1.0, 200)[:, np.newaxis], 4, axis=1)
ENTRIES = [LegendEntry("faces", RED, BLUE, 2.0, None, 0.0), LegendEntry("dots", None, None, 1.5, BLUE, 6.0)]
BARS = [ColorBar("height", (-1.0, 3.0), GREYS), ColorBar("", (5.0, 5.0), GREYS)]


@pytest.mark.parametrize("entries", [[], ENTRIES])
@pytest.mark.parametrize("bars", [[], BARS[:1], BARS])
def test_texts_keep_to_the_column_and_apart(entries: list[LegendEntry], bars: list[ColorBar]) -> None:
    column = lay_out_column(entries, bars, SIZE, STYLE)
    assert (column.width == 0.0) == (not entries and not bars)
    texts = column.annotation.texts
    for text in texts:
        assert SIZE[0] - column.width <= text.box.left < text.box.right <= SIZE[0]
        assert 0.0 <= text.box.top < text.box.bottom <= SIZE[1]
    for a, b in itertools.combinations([text.box for text in texts], 2):
        assert not (a.left < b.right and b.left < a.right and a.top < b.bottom and b.top < a.bottom)


def test_a_legend_shows_what_is_drawn_beside_each_name() -> None:
    annotation = lay_out_column(ENTRIES, [], SIZE, STYLE).annotation
    fill, line, dot = annotation.shapes
    assert isinstance(fill, Rectangle)
    assert isinstance(line, Line)
    assert isinstance(dot, Disc)
    assert (fill.color, line.color, line.width, dot.color, dot.diameter) == (RED, BLUE, 2.0, BLUE, 6.0)
    faces, dots = annotation.texts
    assert faces.box.top < line.y0 < faces.box.bottom
    assert dots.box.top < dot.y < dots.box.bottom
    assert fill.box.right < faces.box.left


def test_the_ticks_of_a_colour_bar_stand_beside_their_colours() -> None:
    annotation = lay_out_column([], BARS[:1], SIZE, STYLE).annotation
    rows = [shape for shape in annotation.shapes if isinstance(shape, Rectangle)]
    ticks = [shape for shape in annotation.shapes if isinstance(shape, Line)]
    title, *numbers = annotation.texts
    assert title.text == "height"
    assert len(numbers) == len(ticks) >= 4
    top, bottom = rows[0].box.top, rows[0].box.bottom
    assert [row.box.bottom for row in rows] == [bottom] * len(rows)  # each covers those before it
    assert rows[0].color[0] == 1.0
    assert rows[-1].color[0] == 0.0
    for text, tick in zip(numbers, ticks, strict=True):
        share = (float(text.text) + 1.0) / 4.0
        assert tick.y0 == pytest.approx(bottom - share * (bottom - top))
        beside = next(row for row in reversed(rows) if row.box.top <= tick.y0 + 1e-6)
        assert beside.color[0] == pytest.approx(share, abs=2.0 / len(rows))


def test_colours_that_follow_one_another_are_one_row() -> None:
    steps = ColorBar("", (0.0, 1.0), np.repeat(np.array([RED, BLUE]), 50, axis=0))
    rows = [s for s in lay_out_column([], [steps], SIZE, STYLE).annotation.shapes if isinstance(s, Rectangle)]
    assert [row.color for row in rows] == [BLUE, RED]
    assert rows[1].box.top == pytest.approx(0.5 * (rows[0].box.top + rows[0].box.bottom), abs=1.0)


def test_long_names_end_in_dots_and_what_has_no_height_is_left_out() -> None:
    many = [LegendEntry(f"a very long name of a model, number {i}", RED, None, 1.0, None, 0.0) for i in range(40)]
    column = lay_out_column(many, BARS, SIZE, STYLE)
    assert 0.3 * SIZE[0] < column.width <= 0.46 * SIZE[0]
    assert 5 < len(column.annotation.texts) < 40
    assert all(text.text.endswith("...") for text in column.annotation.texts)
    assert all(text.box.bottom <= SIZE[1] for text in column.annotation.texts)
    assert Box(0, 0, 1, 1).moved(1, 2) == Box(1, 2, 2, 3)
