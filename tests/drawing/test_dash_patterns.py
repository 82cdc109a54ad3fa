"""Dash patterns and lengths with units: what is taken, in what words, and what is refused."""

from typing import Any

import numpy as np
import pytest

from gpu_xform import Layer, samples
from gpu_xform.cli.argument_types import styles
from gpu_xform.drawing.dash_patterns import LINE_TYPES, MAX_DASHES, as_dash_pattern, hidden_dashes
from gpu_xform.drawing.layer import with_lengths_in_pixels
from gpu_xform.drawing.lengths import to_millimetres, to_pixels
from gpu_xform.errors import ArgumentError, ArgumentTypeError


def test_the_line_types_of_the_standard_have_its_numbers_and_elements() -> None:
    assert list(LINE_TYPES) == [f"{number:02}" for number in range(1, 16)]
    long, dash, short, dot, gap = 24.0, 12.0, 6.0, 0.5, 3.0
    for number, (name, pattern) in LINE_TYPES.items():
        assert as_dash_pattern(number, "dash") == as_dash_pattern(name.replace("-", " ").upper(), "dash") == pattern
        assert styles.parse_dash(name) == name
        assert set(pattern[1::2]) <= {gap, 18.0}
        assert pattern.count(dot) == name.count("dotted") * (3 if "triplicate" in name else 1) or "double" in name
        assert (long in pattern) == ("long" in name)
        assert (short in pattern) == ("short" in name)
        assert (dash in pattern) == (name.startswith(("dashed", "double-dashed")))
    assert as_dash_pattern("04", "dash") == (long, gap, dot, gap)
    assert as_dash_pattern("15", "dash") == (dash, gap, dash, gap, dot, gap, dot, gap, dot, gap)


def test_an_odd_number_of_lengths_is_taken_twice_as_in_svg() -> None:
    assert as_dash_pattern([5, 1, 2], "dash") == (5.0, 1.0, 2.0, 5.0, 1.0, 2.0)
    assert as_dash_pattern(np.array([5, 1]), "dash") == (5.0, 1.0)
    assert as_dash_pattern(None, "dash") == as_dash_pattern("continuous", "dash") == as_dash_pattern((), "dash") == ()


@pytest.mark.parametrize(("line_width", "pattern"), [(3.0, (12.0, 9.0)), (1.5, (6.0, 4.5)), (0.4, (6.0, 4.5))])
def test_hidden_dashes_are_four_line_widths_long_and_three_apart(
    line_width: float, pattern: tuple[float, float]
) -> None:
    assert hidden_dashes(line_width) == pattern


@pytest.mark.parametrize(
    ("style", "error", "message"),
    [
        ({"dash": (4, 0)}, ArgumentError, r"^dash must hold positive lengths in line widths, below 1e6, got 0$"),
        ({"dash": (4, -2)}, ArgumentError, r"^dash must hold positive lengths .*, got -2$"),
        ({"dash": (4, float("nan"))}, ArgumentError, r"^dash must hold positive lengths .*, got nan$"),
        ({"dash": [1] * 18}, ArgumentError, f"^dash must have at most {MAX_DASHES} dashes, got 9$"),
        ({"dash": "dashd"}, ArgumentError, r"^dash must be a line type .*, got 'dashd'; did you mean 'dashed'\?$"),
        ({"dash": "16"}, ArgumentError, "^dash must be a line type of ISO 128, 01 to 15 or continuous, dashed, .*'16'"),
        ({"dash": 4}, ArgumentTypeError, r"^dash must be lengths in line widths, such as \(4, 2\), .*, got 4$"),
        ({"dash": ("a",)}, ArgumentTypeError, "^dash must be lengths in line widths"),
        (
            {"hidden_style": "gray"},
            ArgumentTypeError,
            "^hidden_style must be a dict, .* color, line_width, dash, got str",
        ),
        ({"hidden_style": {"colour": 1}}, ArgumentError, "^hidden_style must have keys among .*; did you mean 'color'"),
        ({"hidden_style": {"color": "blurple"}}, ArgumentError, r"^hidden_style\['color'\] must be a colour"),
        ({"hidden_style": {"line_width": 0}}, ArgumentError, r"^hidden_style\['line_width'\] must be positive"),
        ({"hidden_style": {"dash": (0, 1)}}, ArgumentError, r"^hidden_style\['dash'\] must hold positive"),
        ({"hidden_style": {}, "hidden": "remove"}, ArgumentError, "go with hidden='dash' or 'fade', got 'remove'$"),
        (
            {"line_width": "0.35 furlong"},
            ArgumentError,
            "^line_width must have one of the units px, mm, cm, in, pt, got",
        ),
        ({"line_width": "-1mm"}, ArgumentError, r"^line_width must be positive and at most 1e\+06, got -1mm$"),
        (
            {"line_width": "thick"},
            ArgumentTypeError,
            "^line_width must be 'auto', a number of pixels, or one with a unit",
        ),
        ({"point_size": "0mm"}, ArgumentError, "^point_size must be positive"),
    ],
    ids=str,
)
def test_what_is_no_style_is_refused_by_name(style: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        Layer(samples.cube(), **style)


@pytest.mark.parametrize(
    ("text", "pixels"), [("1in", 300.0), ("25.4mm", 300.0), ("2.54 cm", 300.0), ("72pt", 300.0), ("7px", 7.0), (7, 7.0)]
)
def test_lengths_have_units(text: float | str, pixels: float) -> None:
    assert to_pixels(text, "width", 300.0) == pytest.approx(pixels, rel=1e-12)


def test_a_layer_has_its_lengths_in_pixels_of_the_picture() -> None:
    layer = Layer(
        samples.cube(), line_width="0.35mm", point_size="1mm", hidden="dash", hidden_style={"line_width": "0.5pt"}
    )
    shown = with_lengths_in_pixels(layer, 254.0)
    assert shown.line_width == pytest.approx(3.5)
    assert shown.point_size == pytest.approx(10.0)
    assert shown.hidden_style == {"line_width": pytest.approx(0.5 / 72 * 254)}
    assert to_millimetres("10px", "margin") == pytest.approx(10 / 96 * 25.4)
    assert to_millimetres("1cm", "margin") == to_millimetres("10", "margin") == to_millimetres(10, "margin") == 10.0


def test_the_command_reads_the_same_styles() -> None:
    assert styles.parse_dash("4,2,1,2") == (4.0, 2.0, 1.0, 2.0)
    assert styles.parse_line_width("0.35mm") == "0.35mm"
    style = styles.parse_hidden_style("color=0.5,0.5,0.5; line-width=0.18mm;dash=4,2")
    assert style == {"color": [0.5, 0.5, 0.5], "line_width": "0.18mm", "dash": (4.0, 2.0)}
    for parse, text, message in (
        (styles.parse_dash, "4,0", "must hold positive lengths"),
        (styles.parse_dash, "dottd", "did you mean 'dotted'"),
        (styles.parse_hidden_style, "colour=red", "did you mean 'color'"),
        (styles.parse_hidden_style, "dash=4,-1", "dash: .*positive"),
        (styles.parse_line_width, "0mm", "expected a positive number"),
    ):
        with pytest.raises(Exception, match=message):
            parse(text)
