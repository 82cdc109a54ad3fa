"""Points on the device, as whatever draws or moves them takes them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .buffers import Buffer


@dataclass(frozen=True)
class DevicePoints:
    """The first `n_points` > 0 packed points of R^3 in `buffer`, which is padded to whole quads.

    bounding_points : (h, 3), between which all of them lie; None where the host does not know
    """

    buffer: Buffer
    n_points: int
    dtype: np.dtype[Any]
    bounding_points: npt.NDArray[np.float64] | None = None
