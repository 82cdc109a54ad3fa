"""Points on the device, in the form in which stages draw and move them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .buffers import Buffer
from .chunking import align_points


@dataclass(frozen=True)
class DevicePoints:
    """The first `n_points` > 0 packed points of R^3 in `buffer`, which is padded as `pad_points` does.

    bounding_points : (h, 3), whose convex hull holds all of them; None if the host does not know
    """

    buffer: Buffer
    n_points: int
    dtype: np.dtype[Any]
    bounding_points: npt.NDArray[np.float64] | None = None


def pad_points(points: npt.NDArray[Any], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """Return points (n, 3) as `dtype`, followed by zeros: a shader invocation reads several points at once."""
    padded = np.zeros((align_points(len(points)), 3), dtype)
    padded[: len(points)] = points
    return padded
