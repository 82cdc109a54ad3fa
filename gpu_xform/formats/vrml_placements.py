"""Where a shape of VRML stands: a matrix, and what is computed of it once for all shapes there."""

from functools import cached_property

import numpy as np

from .._core.types import Float64Array
from ..geometry.attributes import sign_of_determinant

_IDENTITY_KEY = np.eye(4).tobytes()


class Placement:
    """An affine matrix (4, 4); None moves nothing. Nobody may write to it."""

    def __init__(self, matrix: Float64Array | None = None) -> None:
        self.matrix = matrix

    def then(self, matrix: Float64Array) -> "Placement":
        """Return the place of what has a matrix of its own within this one."""
        return Placement(matrix if self.matrix is None else self.matrix @ matrix)

    def move(self, points: Float64Array) -> Float64Array:
        """Return points (n, 3), moved."""
        if self.matrix is None:
            return points
        moved: Float64Array = points @ self.linear.T + self.matrix[:3, 3]
        return moved

    @cached_property
    def key(self) -> bytes:
        """Bytes that are equal for equal matrices."""
        return _IDENTITY_KEY if self.matrix is None else self.matrix.tobytes()

    @cached_property
    def linear(self) -> Float64Array:
        """The matrix without its translation: (3, 3)."""
        return np.eye(3) if self.matrix is None else self.matrix[:3, :3]

    @cached_property
    def linear_key(self) -> bytes:
        """Bytes that are equal for equal matrices but for their translations."""
        return self.linear.tobytes()

    @cached_property
    def is_mirrored(self) -> bool:
        """Whether it turns right hands to left ones."""
        return self.matrix is not None and sign_of_determinant(self.linear) < 0


UNMOVED = Placement()
