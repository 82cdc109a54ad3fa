"""Pairs of boxes, beside those that all pairs give."""

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.geometry.box_tree import find_overlapping_boxes

PLENTY = 1 << 20


def boxes(n: int, d: int, largest: float, seed: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return boxes whose corners are whole numbers, so that many touch."""
    random = np.random.default_rng(seed)
    low = random.integers(-9, 9, (n, d)).astype(np.float64)
    return low, low + np.floor(random.exponential(largest, (n, d)))


@given(st.integers(0, 70), st.integers(1, 4), st.sampled_from([0.3, 2.0, 20.0]), st.integers(1, 5), st.integers(0, 999))
def test_all_pairs_of_different_kinds_that_meet_are_found_once(
    n: int, d: int, largest: float, n_kinds: int, seed: int
) -> None:
    low, high = boxes(n, d, largest, seed)
    kinds = np.random.default_rng(seed).integers(-2, n_kinds - 2, n)
    i, j = np.triu_indices(n, 1)
    met = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1) & (kinds[i] != kinds[j])
    found = find_overlapping_boxes(low, high, kinds, PLENTY)
    assert sorted(zip(*(side.tolist() for side in found), strict=True)) == list(
        zip(i[met].tolist(), j[met].tolist(), strict=True)
    )


def test_one_box_around_many_small_ones_is_paired_with_each() -> None:
    n = 1000
    corners = np.random.default_rng(1).uniform(0.0, 100.0, (n, 2))
    low = np.concatenate([corners, [[-1.0, -1.0]]])
    high = np.concatenate([corners + 0.001, [[101.0, 101.0]]])
    i, j = find_overlapping_boxes(low, high, np.append(np.zeros(n, np.int64), 1), n)
    assert sorted(i.tolist()) == list(range(n))
    assert (j == n).all()


def test_more_pairs_than_there_is_room_for_are_an_overflow() -> None:
    low, high = np.zeros((40, 2)), np.ones((40, 2))
    assert len(find_overlapping_boxes(low, high, np.arange(40), 1000)[0]) == 780
    with pytest.raises(OverflowError, match=r"^more than 100 pairs of boxes overlap$"):
        find_overlapping_boxes(low, high, np.arange(40), 100)
