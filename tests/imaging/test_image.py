import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.imaging.image import to_pillow, unpremultiply
from tests.support.types import Pixels


def pixels(*rows: list[tuple[int, int, int, int]]) -> Pixels:
    return np.array(rows, np.uint8)


def test_colours_are_divided_by_alpha() -> None:
    given_pixels = pixels([(10, 20, 30, 255), (0, 0, 0, 0), (64, 32, 0, 128), (1, 2, 3, 4)])
    before = given_pixels.copy()
    assert unpremultiply(given_pixels).tolist() == [
        [[10, 20, 30, 255], [0, 0, 0, 0], [128, 64, 0, 128], [64, 128, 191, 4]]
    ]
    assert (given_pixels == before).all()


def test_a_colour_brighter_than_its_alpha_is_cut_at_255() -> None:
    assert unpremultiply(pixels([(12, 10, 200, 10)])).tolist() == [[[255, 255, 255, 10]]]


@given(st.integers(1, 255), st.integers(0, 255), st.integers(0, 255), st.integers(0, 255))
def test_multiplying_again_gives_back_what_was_stored(alpha: int, red: int, green: int, blue: int) -> None:
    stored = np.rint(np.array([red, green, blue]) * alpha / 255).astype(np.uint8)
    straight = unpremultiply(pixels([(*stored.tolist(), alpha)]))[0, 0]
    assert straight[3] == alpha
    assert (np.rint(straight[:3] * (alpha / 255)) == stored).all()
    assert (np.abs(straight[:3].astype(int) - [red, green, blue]) <= 0.5 * 255 / alpha + 0.5).all()


def test_an_image_is_rgba_with_row_0_at_the_top() -> None:
    made = to_pillow(pixels([(1, 2, 3, 4), (5, 6, 7, 8), (9, 10, 11, 12)], [(13, 14, 15, 16)] * 3))
    assert (made.mode, made.size) == ("RGBA", (3, 2))
    assert made.getpixel((1, 0)) == (5, 6, 7, 8)
    assert made.getpixel((2, 1)) == (13, 14, 15, 16)
