"""The stepper: what keeps the state of a system and moves it, on one kind of device."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
import numpy.typing as npt

from ..compute.backend import PointStore
from ..device import Device
from ..host import HostDevice
from .conditions import FrameConditions
from .spring_system import SpringSystem

FloatArray = npt.NDArray[np.float32]


class Stepper(Protocol):
    """Positions of points at a time, velocities half a step earlier, and what moves them."""

    @property
    def device(self) -> Device:
        """Where they are."""

    def write(self, positions: FloatArray, velocities: FloatArray) -> None:
        """Set the state: (n, 4) each, as `read_state` returns them."""

    def read_state(self) -> tuple[FloatArray, FloatArray]:
        """Return positions with one over the masses, and velocities with a number that is not theirs: (n, 4) each."""

    def read_positions(self) -> FloatArray:
        """Return the positions (n, 3)."""

    def read_kicked_velocities(self, seconds: float, conditions: FrameConditions) -> FloatArray:
        """Return what the velocities (n, 3) would be after a kick of so many seconds; the state stays."""

    def store_positions(self) -> PointStore:
        """Return a copy of the positions (n, 3), made where they are."""

    def write_inverse_masses(self, inverse_masses: npt.NDArray[np.float64]) -> None:
        """Set one over the mass of each point (n,), in 1/kg; 0 for points that no force moves."""

    def kick(self, seconds: float, conditions: FrameConditions) -> None:
        """Move the velocities on by `seconds`, or back if it is negative."""

    def step(self, n_steps: int, step_s: float, conditions: FrameConditions, count: Callable[[int], object]) -> None:
        """Take the steps of a frame, from its first to its last; `count` is told how many are certain to be taken."""


def make_stepper(device: Device, system: SpringSystem) -> Stepper:
    """Return what moves a system on a device; the module for its kind is imported when the first is made."""
    if isinstance(device, HostDevice):
        from .host.leapfrog import HostLeapfrog

        return HostLeapfrog(device, system)
    from ..gpu.device import require_gpu_device
    from .leapfrog import Leapfrog

    return Leapfrog(require_gpu_device(device), system)
