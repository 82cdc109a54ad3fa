from typing import Any

import matplotlib.colors
import numpy as np
import numpy.typing as npt
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from PIL import ImageColor

from gpu_xform.errors import ArgumentError, ArgumentTypeError
from gpu_xform.imaging.colors import COLOR_CYCLE, pack_rgba8, to_rgba, to_rgba_array

NAMES = sorted(name for name in matplotlib.colors.get_named_colors_mapping() if not name.startswith("xkcd:"))


@pytest.mark.parametrize(
    ("color", "expected"),
    [
        ("black", (0, 0, 0, 255)),
        ("Orange", (255, 165, 0, 255)),
        (" white ", (255, 255, 255, 255)),
        ("#abc", (0xAA, 0xBB, 0xCC, 255)),
        ("#010203", (1, 2, 3, 255)),
        ("#01020304", (1, 2, 3, 4)),
        ("#1234", (0x11, 0x22, 0x33, 0x44)),
        ("rgb(10, 20, 30)", (10, 20, 30, 255)),
        ("hsl(120, 100%, 50%)", (0, 255, 0, 255)),
        ((0.2, 0.4, 0.6), (51, 102, 153, 255)),
        ([0.2, 0.4, 0.6, 0.8], (51, 102, 153, 204)),
        (np.array([1, 0, 1]), (255, 0, 255, 255)),
    ],
    ids=str,
)
def test_a_colour_is_red_green_blue_and_alpha_in_that_order(color: Any, expected: tuple[int, ...]) -> None:
    assert to_rgba(color, "color") == pytest.approx(tuple(value / 255 for value in expected))


def test_every_name_that_matplotlib_or_pillow_has_is_the_same_here() -> None:
    assert len(NAMES) > 160
    for name in NAMES:
        assert to_rgba(name, "color") == matplotlib.colors.to_rgba(name), name
    for name in ImageColor.colormap:
        channels = np.array(ImageColor.getcolor(name.title(), "RGBA"))
        assert to_rgba(name.title(), "color") == tuple((channels / 255).tolist()), name


@pytest.mark.parametrize(
    "color",
    [
        *("#abc", "#ABCD", "#12fe9a", "#12fe9A7b", "none", "None", "TAB:Blue", "C0", "C9", "C10", "C123"),
        *(
            "0",
            "1",
            "0.5",
            ".25",
            "1.0",
            "1e-05",
            ("red", 0.5),
            ("#11223344", 1),
            ("0.3", 0.0),
            ("C1", 0.2),
            ("g", 1.0),
        ),
        *(((0.1, 0.2, 0.3), 0.4), ((0.1, 0.2, 0.3, 0.9), 0.4), ("none", 0.5), (np.array([0.1, 0.2, 0.3]), 0.4)),
    ],
    ids=str,
)
def test_what_else_matplotlib_takes_is_the_same_here(color: Any) -> None:
    assert to_rgba(color, "color") == matplotlib.colors.to_rgba(color)


def test_matplotlibs_letters_are_its_own_and_not_the_names_they_stand_for() -> None:
    assert to_rgba("g", "color") == (0.0, 0.5, 0.0, 1.0)
    assert to_rgba("green", "color") == (0.0, 128 / 255, 0.0, 1.0)
    assert to_rgba("c", "color") != to_rgba("cyan", "color")


@pytest.mark.parametrize(
    "color",
    [
        *(
            "",
            "#12345",
            "#gggggg",
            "face",
            "K",
            "c0",
            "C",
            "C-1",
            "1.1",
            "-0.5",
            "1.2.3",
            "nan",
        ),
        *("rgb(300, 0, 0)", "rgb(200%, 0%, 0%)", "hsl(10, 150%, 50%)", "rgba(255, 0, 0, 1)", "xkcd:mud", "\u0661"),
    ],
)
def test_an_unknown_name_is_refused(color: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        to_rgba(color, "paint")
    assert str(caught.value) == f"paint must be a colour's name or #rrggbb, got {color!r}"


@pytest.mark.parametrize(("color", "meant"), [("blurple", "purple"), ("tab:magenta", "magenta"), ("Gren", "green")])
def test_a_misspelt_name_is_refused_with_a_suggestion(color: str, meant: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        to_rgba(color, "paint")
    assert str(caught.value) == f"paint must be a colour's name or #rrggbb, got {color!r}; did you mean {meant!r}?"


@pytest.mark.parametrize("color", [(1, 2, 3), (0.1, 0.2), (0.1, 0.2, 0.3, -0.1), (0.1,) * 5, [[0.1, 0.2, 0.3]], 0.5])
def test_numbers_that_are_no_colour_are_refused(color: Any) -> None:
    with pytest.raises(ArgumentError, match=r"^paint must be a colour's name, or three or four numbers from 0 to 1"):
        to_rgba(color, "paint")


def test_what_holds_no_numbers_is_refused_by_type() -> None:
    with pytest.raises(ArgumentTypeError, match="paint"):
        to_rgba(None, "paint")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="paint must be finite"):
        to_rgba((0.1, float("nan"), 0.2), "paint")


@pytest.mark.parametrize("alpha", [-0.1, 1.01])
def test_an_alpha_outside_of_0_to_1_is_refused(alpha: float) -> None:
    with pytest.raises(ArgumentError, match=rf"^the alpha of paint must be from 0 to 1, got {alpha}$"):
        to_rgba(("red", alpha), "paint")
    with pytest.raises(
        ArgumentError, match=r"^paint must be a colour's name or #rrggbb, got 'blurple'; did you mean 'purple'\?$"
    ):
        to_rgba(("blurple", 0.5), "paint")


ROWS = np.array([(0.1, 0.2, 0.3, 0.4), (0.5, 0.6, 0.7, 0.8), (0.9, 1.0, 0.0, 1.0)])


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.float16])
def test_rows_of_numbers_are_taken_as_they_are(dtype: type) -> None:
    given_rows: npt.NDArray[Any] = ROWS.astype(dtype)
    for values in (given_rows, given_rows.tolist(), given_rows[::-1][::-1]):
        colors = to_rgba_array(values, "face_colors", 3, "faces")
        assert colors.dtype == np.float64
        assert (colors == given_rows).all()
    colors[0] = 0.0
    assert given_rows[0].any()


def test_rows_without_alpha_are_opaque() -> None:
    assert (to_rgba_array(ROWS[:, :3], "face_colors", 3, "faces") == np.column_stack([ROWS[:, :3], np.ones(3)])).all()
    assert to_rgba_array([(1, 0, 1)], "face_colors", 1, "faces").tolist() == [[1.0, 0.0, 1.0, 1.0]]


def test_colors_in_uint8_go_to_255_as_in_trimesh() -> None:
    channels = np.array([(1, 2, 3, 4), (255, 0, 128, 255)], np.uint8)
    assert (to_rgba_array(channels, "face_colors", 2, "faces") == channels / 255).all()
    assert to_rgba_array(channels[:, :3], "face_colors", 2, "faces")[:, 3].tolist() == [1.0, 1.0]
    box = trimesh.creation.box()
    box.visual.face_colors = np.arange(48, dtype=np.uint8).reshape(12, 4)
    assert (
        to_rgba_array(box.visual.face_colors, "face_colors", 12, "faces") * 255 == np.arange(48).reshape(12, 4)
    ).all()


@pytest.mark.parametrize(
    "values",
    [
        ["red", "C1", "0.5"],
        np.array(["red", "C1", "0.5"]),
        np.array(["red", "C1", "0.5"], dtype=object),
        ("red", (1.0, 0.4980392156862745, 0.054901960784313725), "0.5"),
        ["#ff0000ff", "#ff7f0e", (0.5, 0.5, 0.5, 1.0)],
        [("red", 1.0), ("C1", 1), ("0.5", 1.0)],
        [("red", 1.0), "tab:orange", ((0.5, 0.5, 0.5), 1.0)],
        (name for name in ("red", "C1", "0.5")),
    ],
    ids=lambda values: type(values).__name__,
)
def test_rows_may_be_colours_of_any_spelling(values: Any) -> None:
    colors = to_rgba_array(values, "face_colors", 3, "faces")
    assert colors.tolist() == [[1.0, 0.0, 0.0, 1.0], [1.0, 127 / 255, 14 / 255, 1.0], [0.5, 0.5, 0.5, 1.0]]


@pytest.mark.parametrize("columns", [3, 4])
def test_no_rows_are_the_colours_of_no_things(columns: int) -> None:
    assert to_rgba_array(np.zeros((0, columns)), "face_colors", 0, "faces").shape == (0, 4)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.zeros((11, 3)), "face_colors must have one row for each of the 12 faces, got 11"),
        (np.zeros((13, 4), np.uint8), "face_colors must have one row for each of the 12 faces, got 13"),
        (["red"] * 11, "face_colors must have one row for each of the 12 faces, got 11"),
        (np.zeros(12), "face_colors must have shape (12, 3) or (12, 4), got (12,)"),
        (np.zeros((12, 2)), "face_colors must have shape (12, 3) or (12, 4), got (12, 2)"),
        (np.zeros((12, 1, 3)), "face_colors must have shape (12, 3) or (12, 4), got (12, 1, 3)"),
        (0.5, "face_colors must have shape (12, 3) or (12, 4), got ()"),
        (
            np.vstack([np.ones((11, 3)), [0.0, 0.0, 255.0]]),
            "face_colors must hold numbers from 0 to 1, or uint8, got 255 at index (11, 2)",
        ),
        (
            -0.5 * np.eye(12, 3),
            "face_colors must hold numbers from 0 to 1, or uint8, got -0.5 at index (0, 0)",
        ),
        (np.full((12, 3), np.nan), "face_colors must be finite, got nan at index (0, 0)"),
        ("red", "face_colors must be one colour for each of the 12 faces, got the one 'red'"),
        (
            ["red"] * 3 + ["blurple"],
            "face_colors[3] must be a colour's name or #rrggbb, got 'blurple'; did you mean 'purple'?",
        ),
        (
            [(0.1, 0.2, 0.3), (0.1, 0.2)],
            "face_colors[1] must be a colour's name, or three or four numbers from 0 to 1, got (0.1, 0.2)",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_rows_that_are_no_colours_of_the_things_are_refused(values: Any, message: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        to_rgba_array(values, "face_colors", 12, "faces")
    assert str(caught.value) == message


@pytest.mark.parametrize("values", [None, np.ones((12, 3), bool), [None] * 12, object()])
def test_rows_of_another_type_are_refused_by_type(values: Any) -> None:
    with pytest.raises(ArgumentTypeError, match=r"^face_colors(\[0\])? must hold real numbers, got dtype "):
        to_rgba_array(values, "face_colors", 12, "faces")


def test_red_is_in_the_lowest_byte() -> None:
    assert pack_rgba8([(1 / 255, 2 / 255, 3 / 255, 4 / 255), (1.0, 0.0, 0.0, 1.0)]).tolist() == [0x04030201, 0xFF0000FF]


@given(st.lists(st.tuples(*[st.integers(0, 255)] * 4), min_size=1, max_size=5))
def test_packing_keeps_every_byte(channels: list[tuple[int, int, int, int]]) -> None:
    colors = [(r / 255, g / 255, b / 255, a / 255) for r, g, b, a in channels]
    words = pack_rgba8(colors)
    assert (pack_rgba8(np.array(colors)) == words).all()
    assert words.dtype == np.uint32
    assert [tuple(int(word) >> shift & 255 for shift in (0, 8, 16, 24)) for word in words] == channels


def test_the_cycle_has_ten_opaque_colours_each_its_own() -> None:
    colors = np.array([to_rgba(name, "color") for name in COLOR_CYCLE])
    assert len(np.unique(colors, axis=0)) == 10
    assert (colors[:, 3] == 1.0).all()
    gaps = np.linalg.norm(colors[:, None] - colors[None], axis=-1)[~np.eye(10, dtype=bool)]
    assert gaps.min() > 0.2
