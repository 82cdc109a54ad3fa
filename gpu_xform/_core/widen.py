"""Numbers of any type as float64."""

import numpy as np
import numpy.typing as npt

from .types import Float64Array


def widen(numbers: npt.ArrayLike) -> Float64Array:
    """Return numbers as float64, in a new C-ordered array.

    What the bytes of a file are taken for may be signalling NaNs, of which NumPy would warn.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return np.array(numbers, np.float64, order="C")
