from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.colors import FACE_CYCLE, packed, rgba
from gpu_xform.errors import ArgumentError, ArgumentTypeError


@pytest.mark.parametrize(
    ("color", "expected"),
    [
        ("black", (0, 0, 0, 255)),
        ("Orange", (255, 165, 0, 255)),
        (" white ", (255, 255, 255, 255)),
        ("#abc", (0xAA, 0xBB, 0xCC, 255)),
        ("#010203", (1, 2, 3, 255)),
        ("#01020304", (1, 2, 3, 4)),
        ("rgb(10, 20, 30)", (10, 20, 30, 255)),
        ("hsl(120, 100%, 50%)", (0, 255, 0, 255)),
        ((0.2, 0.4, 0.6), (51, 102, 153, 255)),
        ([0.2, 0.4, 0.6, 0.8], (51, 102, 153, 204)),
        (np.array([1, 0, 1]), (255, 0, 255, 255)),
    ],
    ids=str,
)
def test_a_colour_is_red_green_blue_and_alpha_in_that_order(color: Any, expected: tuple[int, ...]) -> None:
    assert rgba(color, "color") == pytest.approx(tuple(value / 255 for value in expected))


@pytest.mark.parametrize("color", ["blurple", "", "#12345", "#gggggg", "face"])
def test_an_unknown_name_is_refused(color: str) -> None:
    with pytest.raises(ArgumentError, match=rf"^paint must be a colour's name or #rrggbb, got '{color}'$"):
        rgba(color, "paint")


@pytest.mark.parametrize("color", [(1, 2, 3), (0.1, 0.2), (0.1, 0.2, 0.3, -0.1), (0.1,) * 5, [[0.1, 0.2, 0.3]], 0.5])
def test_numbers_that_are_no_colour_are_refused(color: Any) -> None:
    with pytest.raises(ArgumentError, match=r"^paint must be a colour's name, or three or four numbers from 0 to 1"):
        rgba(color, "paint")


def test_what_holds_no_numbers_is_refused_by_type() -> None:
    with pytest.raises(ArgumentTypeError, match="paint"):
        rgba(None, "paint")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="paint must be finite"):
        rgba((0.1, float("nan"), 0.2), "paint")


def test_red_is_in_the_lowest_byte() -> None:
    assert packed([(1 / 255, 2 / 255, 3 / 255, 4 / 255), (1.0, 0.0, 0.0, 1.0)]).tolist() == [0x04030201, 0xFF0000FF]


@given(st.lists(st.tuples(*[st.integers(0, 255)] * 4), min_size=1, max_size=5))
def test_packing_keeps_every_byte(octets: list[tuple[int, int, int, int]]) -> None:
    colors = [(r / 255, g / 255, b / 255, a / 255) for r, g, b, a in octets]
    words = packed(colors)
    assert words.dtype == np.uint32
    assert [tuple(int(word) >> shift & 255 for shift in (0, 8, 16, 24)) for word in words] == octets


def test_the_cycle_has_ten_opaque_colours_each_its_own() -> None:
    colors = np.array([rgba(name, "color") for name in FACE_CYCLE])
    assert len(np.unique(colors, axis=0)) == 10
    assert (colors[:, 3] == 1.0).all()
    gaps = np.linalg.norm(colors[:, None] - colors[None], axis=-1)[~np.eye(10, dtype=bool)]
    assert gaps.min() > 0.2
