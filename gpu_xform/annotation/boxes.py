"""Boxes that must not overlap: which are taken, and whether another has room."""

from collections.abc import Iterable

import numpy as np

from .._core.types import Float64Array
from .items import Box


class TakenBoxes:
    """Boxes of a picture that nothing else may cover."""

    def __init__(self, boxes: Iterable[Box] = ()) -> None:
        taken = list(boxes)
        self._boxes: Float64Array = np.empty((max(16, 2 * len(taken)), 4))
        self._count = len(taken)
        if taken:
            self._boxes[: self._count] = taken

    def add(self, box: Box) -> None:
        """Take a box."""
        if self._count == len(self._boxes):
            self._boxes = np.concatenate([self._boxes, np.empty_like(self._boxes)])
        self._boxes[self._count] = box
        self._count += 1

    def first_free(self, candidates: Float64Array) -> int | None:
        """Return the index of the first of boxes (c, 4) that overlaps none that is taken; None if each does."""
        taken = self._boxes[: self._count]
        begins_before = candidates[:, np.newaxis, :2] < taken[:, 2:]
        ends_after = candidates[:, np.newaxis, 2:] > taken[:, :2]
        is_free = np.all(np.any(~(begins_before & ends_after), axis=2), axis=1)
        return int(is_free.argmax()) if is_free.any() else None

    def is_free(self, box: Box) -> bool:
        """Say whether a box overlaps none that is taken."""
        return self.first_free(np.array([box])) is not None
