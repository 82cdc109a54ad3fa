"""Type aliases that several folders use."""

import os
from collections.abc import Callable
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

BoolArray: TypeAlias = npt.NDArray[np.bool_]
Float64Array: TypeAlias = npt.NDArray[np.float64]
IndexArray: TypeAlias = npt.NDArray[np.int64]

Progress: TypeAlias = Callable[[int, int], object]
StrPath: TypeAlias = str | os.PathLike[str]


@runtime_checkable
class SupportsAsMatrix(Protocol):
    """An object that knows its own matrix, such as SciPy's `Rotation` or `RigidTransform`."""

    def as_matrix(self) -> Any:
        """Return the 3x3 rotation or the 4x4 transform."""
        ...


MatrixLike: TypeAlias = npt.ArrayLike | SupportsAsMatrix
