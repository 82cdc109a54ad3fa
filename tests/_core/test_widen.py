"""Numbers of all types become those of float64."""

import numpy as np
import pytest

from gpu_xform._core.widen import widen

SIGNALLING = np.array([0x7F800001], np.uint32).view(np.float32)


@pytest.mark.parametrize("dtype", [bool, np.uint8, np.int32, np.float16, np.float32, ">f4", np.float64, np.longdouble])
def test_numbers_are_those_they_were(dtype: str | type) -> None:
    numbers = np.array([[0, 1], [1, 0], [1, 1]], dtype).T
    wide = widen(numbers)
    assert (str(wide.dtype), wide.flags.c_contiguous, wide.flags.writeable) == ("float64", True, True)
    assert wide.tolist() == [[0, 1, 1], [1, 0, 1]]
    assert not np.shares_memory(wide, numbers)


def test_signalling_nans_and_what_is_beyond_are_not_warned_of() -> None:
    assert np.isnan(widen(SIGNALLING)).all()
    assert widen(np.array([np.longdouble("1e400")])).tolist() == [np.inf]
