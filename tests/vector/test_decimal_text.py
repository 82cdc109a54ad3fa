"""Decimal text: exact to the hundredth, and never longer than needed."""

import re
from decimal import Decimal
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.vector.decimal_text import format_rows, to_fixed_point

LIMIT = 10**9


def words(*values: int) -> list[str]:
    text, at = format_rows(np.array(values, np.int32), b";")
    assert at.tolist() == [0, *(i + 1 for i, character in enumerate(text) if character == ord(";"))]
    return text.decode("ascii").split(";")[:-1]


@given(st.lists(st.integers(-LIMIT, LIMIT), min_size=1, max_size=40))
def test_a_word_is_its_number_in_the_shortest_form(values: list[int]) -> None:
    for word, value in zip(words(*values), values, strict=True):
        assert Decimal(word) * 100 == value
        assert re.fullmatch(r"-?(0|[1-9]\d*)(\.\d?[1-9])?", word)
        assert word != "-0"


def test_some_words() -> None:
    values = (0, 1, -1, 10, -70, 100, 101, 110, -12345, 10**9, 9, 99, 1000, 100000)
    expected = "0 0.01 -0.01 0.1 -0.7 1 1.01 1.1 -123.45 10000000 0.09 0.99 10 1000"
    assert words(*values) == expected.split()
    assert words(5) == ["0.05"]


@pytest.mark.parametrize("n", [0, 1, 2**15 - 1, 2**15, 2**15 + 1, 2**16 + 1])
def test_rows_of_any_number_are_the_pieces_one_after_another(n: int) -> None:
    values = np.arange(n, dtype=np.int32) - 500
    marks = np.where(values % 3 == 0, b"ab", b"")
    text, at = format_rows(b"<", values, marks, b">\n", -values)
    expected = [
        b"<%s%s>\n%s" % (words(v)[0].encode(), m, words(-v)[0].encode())
        for v, m in zip(values[:700], marks, strict=False)
    ]
    assert len(at) == n + 1
    assert [text[a:b] for a, b in pairwise(at)][:700] == expected
    assert at[-1] == len(text)
    if n:
        assert text[at[-2] :] == b"<%s%s>\n%s" % (words(n - 501)[0].encode(), marks[-1], words(501 - n)[0].encode())


@given(st.floats(-1e7, 1e7, width=32))
def test_pixels_are_rounded_to_the_nearest_hundredth(value: float) -> None:
    [rounded] = to_fixed_point(np.array([value], np.float32)).tolist()
    assert abs(rounded - 100 * value) <= 0.5
