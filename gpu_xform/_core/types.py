"""Types that many folders name."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

Float64Array = npt.NDArray[np.float64]


@runtime_checkable
class SupportsAsMatrix(Protocol):
    """An object such as SciPy's `Rotation` or `RigidTransform`, which knows its own matrix."""

    def as_matrix(self) -> Any:
        """Return the 3x3 rotation or the 4x4 transform."""
        ...


MatrixLike = npt.ArrayLike | SupportsAsMatrix
