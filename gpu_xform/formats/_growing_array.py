"""Rows that come part by part, in one array."""

from typing import Any

import numpy as np
import numpy.typing as npt

_MIN_ROWS = 64


class GrowingArray:
    """Rows, in an array that grows in place: parts that are joined at the end take twice the memory."""

    def __init__(self, dtype: npt.DTypeLike, *width: int) -> None:
        self._rows = np.empty((0, *width), dtype)
        self._n = 0

    def __len__(self) -> int:
        return self._n

    def append(self, rows: npt.NDArray[Any]) -> None:
        """Add rows, cast to the type of the array."""
        start = self.reserve(len(rows))
        self._rows[start : self._n] = rows

    def reserve(self, n: int) -> int:
        """Add rows of any content, to be written after `take`; return the first."""
        start, self._n = self._n, self._n + n
        if self._n > len(self._rows):
            self._resize(max(self._n + self._n // 4, _MIN_ROWS))
        return start

    def take(self) -> npt.NDArray[Any]:
        """Return all rows; nothing may be added after."""
        self._resize(self._n)
        return self._rows

    def _resize(self, n: int) -> None:
        self._rows.resize((n, *self._rows.shape[1:]), refcheck=False)  # nobody else has seen the array
