"""Leapfrog on the host: the state of a system in the host's memory, and what moves it."""

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._core.interrupts import defer_interrupts
from ...compute.host.choose import run_compiled
from ...compute.host.store import HostStore
from ...gpu.layouts import OBSTACLE
from ...host import HostDevice
from ..conditions import FrameConditions
from ..incidence import pack_fans, pack_slots
from ..spring_system import SpringSystem
from . import constants, vectorized
from .springs_by_slot import ShiftedSprings, arrange_springs

MAX_STEPS_PER_CALL = 256  # after which it is counted what is done of a long frame


class HostLeapfrog:
    """The twin of `Leapfrog` on the host device: the same contract, and the same state but for rounding."""

    def __init__(self, device: HostDevice, system: SpringSystem) -> None:
        self.device = device
        self._fans = pack_fans(system.triangles, system.n_points)
        self._springs = arrange_springs(pack_slots(system), system.n_points)
        self._states = [self._springs.allocate(system.n_points) for _ in range(2)]
        self._points = slice(self._springs.pad, self._springs.pad + system.n_points)
        self._inverse_masses = system.inverse_masses.astype(np.float32)

    def write(self, positions: npt.NDArray[np.float32], velocities: npt.NDArray[np.float32]) -> None:
        """Set the state: (n, 4) each, as `read_state` returns them."""
        self._states[0][:3, self._points] = positions[:, :3].T
        self._states[0][3:6, self._points] = velocities[:, :3].T
        self._inverse_masses = np.ascontiguousarray(positions[:, 3], np.float32)

    def read_state(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Return positions with one over the masses, and velocities with zeros: (n, 4) each."""
        positions = np.column_stack([self._read(0), self._inverse_masses])
        velocities = np.column_stack([self._read(3), np.zeros_like(self._inverse_masses)])
        return positions, velocities

    def read_positions(self) -> npt.NDArray[np.float32]:
        """Return the positions (n, 3)."""
        return self._read(0)

    def read_kicked_velocities(self, seconds: float, conditions: FrameConditions) -> npt.NDArray[np.float32]:
        """Return what the velocities (n, 3) would be after a kick of so many seconds; the state stays."""
        self._run(1, 0, seconds, seconds, 1.0, conditions)  # touching the obstacles where they are then
        velocities = self._read(3)
        self._states.reverse()
        return velocities

    def store_positions(self) -> HostStore:
        """Return a copy of the positions (n, 3)."""
        return HostStore(self.device, self._read(0), np.dtype(np.float32))

    def write_inverse_masses(self, inverse_masses: npt.NDArray[np.float64]) -> None:
        """Set one over the mass of each point (n,), in 1/kg; 0 for points that no force moves."""
        self._inverse_masses = inverse_masses.astype(np.float32)
        self._states[0][3:6, self._points][:, inverse_masses == 0.0] = 0.0

    def kick(self, seconds: float, conditions: FrameConditions) -> None:
        """Move the velocities on by `seconds`, or back if it is negative."""
        self._run(1, 0, seconds, 0.0, 0.0, conditions)

    def step(self, n_steps: int, step_s: float, conditions: FrameConditions, count: Callable[[int], object]) -> None:
        """Take the steps of a frame, from its first to its last.

        count : called with the number of steps that are taken, after each part of the frame
        """
        pins = conditions.pins
        at = self._points.start + pins["point"].astype(np.int64)
        self._states[0][:3, at], self._states[0][3:6, at] = pins["position"].T, pins["velocity"].T
        for first in range(0, n_steps, MAX_STEPS_PER_CALL):
            n = min(MAX_STEPS_PER_CALL, n_steps - first)
            self._run(n, first, step_s, step_s, 1.0 / n_steps, conditions)
            count(n)

    def _read(self, first: int) -> npt.NDArray[np.float32]:
        """Return three numbers of each point (n, 3)."""
        return self._states[0][first : first + 3, self._points].T.copy()

    def _run(
        self, n_steps: int, first: int, kick_s: float, drift_s: float, frame_part: float, conditions: FrameConditions
    ) -> None:
        """Take steps; `first` is the number of the first in its frame."""
        self.device.require_usable()
        name = "step_shifted" if isinstance(self._springs, ShiftedSprings) else "step_listed"
        forces = conditions.forces
        arguments = (
            *self._states,
            first,
            n_steps,
            *self._springs.arguments,
            self._inverse_masses,
            np.zeros((0, 3), np.float32) if forces is None else np.ascontiguousarray(forces, np.float32),
            self._fans if conditions.has_drag else self._fans[:0],
            _list_obstacles(conditions.obstacles),
            _list_constants(conditions, kick_s, drift_s, frame_part),
        )
        if not run_compiled(_import_loops, name, *arguments):
            with np.errstate(over="ignore", invalid="ignore"):
                getattr(vectorized, name)(*arguments)
        if n_steps % 2:
            self._states.reverse()


def _list_constants(
    conditions: FrameConditions, kick_s: float, drift_s: float, frame_part: float
) -> npt.NDArray[np.float32]:
    step = conditions.step
    c = np.zeros(constants.N_CONSTANTS, np.float32)
    c[constants.KICK_S], c[constants.DRIFT_S], c[constants.FRAME_PART] = kick_s, drift_s, frame_part
    c[constants.GRAVITY : constants.GRAVITY + 3] = step["gravity"]
    c[constants.WIND : constants.WIND + 3] = step["wind"]
    c[constants.DRAG_RATE], c[constants.FACE_DRAG] = step["drag_rate"], step["face_drag"]
    c[constants.DAMPING_S] = step["damping_s"]
    return c


def _list_obstacles(obstacles: npt.NDArray[np.void]) -> npt.NDArray[Any]:
    """Return `layouts.OBSTACLE` as rows of float32."""
    rows = obstacles.view(np.float32).reshape(len(obstacles), OBSTACLE.itemsize // 4).copy()
    rows[:, constants.IS_HALF_SPACE] = obstacles["is_half_space"]
    return rows


@cache
def _import_loops() -> ModuleType | None:
    try:
        with defer_interrupts():
            from . import loops
    except ModuleNotFoundError as error:
        if error.name != "numba":
            raise
        return None
    return loops
