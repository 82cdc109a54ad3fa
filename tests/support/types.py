"""Type aliases of the tests."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from gpu_xform.gpu.device import GpuDevice

Array = npt.NDArray[Any]
Pixels = npt.NDArray[np.uint8]
DeviceFactory = Callable[..., GpuDevice]
