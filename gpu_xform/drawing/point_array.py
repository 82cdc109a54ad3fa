"""Point arrays: large arrays of points that are drawn from where they are, without a copy of them all."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import describe_first_non_finite, require_room
from ..errors import MeshError
from ..geometry.mesh import Mesh

MIN_CLOUD_POINTS = 1 << 17  # of fewer, a copy costs nothing, and pixels can keep more of the nearest ones
_BLOCK_POINTS = 1 << 16


@dataclass(frozen=True, eq=False)
class PointArray:
    """An array of points (n, 3), which is not copied: it must not change before the picture is drawn."""

    array: npt.NDArray[Any]

    @property
    def n_points(self) -> int:
        """The number of points."""
        return len(self.array)

    @cached_property
    def mesh(self) -> Mesh:
        """The mesh of the points: a copy in double precision."""
        return Mesh(self.array)


def as_point_array(array: npt.NDArray[Any]) -> PointArray | None:
    """Return a plain array of many points to be drawn without a copy; None for any other array."""
    is_plain = type(array) in (np.ndarray, np.memmap)
    if not is_plain or array.ndim != 2 or array.shape[1] != 3 or len(array) < MIN_CLOUD_POINTS:
        return None
    require_room(array, "models")
    return PointArray(array) if array.dtype.kind in "fiu" and array.dtype.itemsize <= 8 else None


def require_finite(array: npt.NDArray[Any]) -> None:
    """Raise `MeshError` that names the first coordinate of points (n, 3) that is not finite, as `Mesh` does."""
    for first in range(0, len(array), _BLOCK_POINTS):
        block = array[first : first + _BLOCK_POINTS]
        if not np.isfinite(block).all():
            row, column = np.argwhere(~np.isfinite(block))[0].tolist()
            value = describe_first_non_finite(block[row, column])
            raise MeshError(f"positions must be finite, got {value} at index ({first + row}, {column})")
