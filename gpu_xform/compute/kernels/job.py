"""The job of a kernel: one record of the points, the matrices that transform them, and the use of the results."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.types import Float64Array
from ...device import Device
from .._skinning import Influences


class Epilogue(IntEnum):
    """What a kernel does with a homogeneous result; the numbers are the WGSL constants."""

    NONE = 0
    PERSPECTIVE_DIVIDE = 1
    NORMALIZE = 2


@dataclass(frozen=True)
class Job:
    """Each of the matrices applied to all points, computed in `dtype` on `device`.

    points : (n, 2) or (n, 3), n > 0
    matrices : (k, 4, 4), k > 0; for points of the plane with an idle z
    out : where the results go, (k, n, 2 or 3)
    is_sorted_in_space : whether "rebased" precision brings points together that lie together
    """

    device: Device
    points: npt.NDArray[Any]
    matrices: Float64Array
    out: npt.NDArray[Any]
    dtype: np.dtype[Any]
    epilogue: Epilogue = Epilogue.NONE
    is_sorted_in_space: bool = False


@dataclass(frozen=True, kw_only=True)
class SkinningJob(Job):
    """Each point moved by the matrices that it names.

    out : where the results go, (n, 2 or 3)
    inverse_transpose : apply the inverse transpose of the linear part, after the matrices of a point are blended
    """

    influences: Influences
    inverse_transpose: bool = False
