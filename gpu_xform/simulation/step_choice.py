"""The choice of steps: how many a frame takes and how long they are, validated against what is stable."""

import math
from typing import SupportsIndex

from .._core.arguments import as_int
from ..errors import ArgumentError
from ._validation import as_positive_float
from .conditions import Conditions
from .spring_system import SpringSystem
from .stability import SAFETY, count_steps, find_largest_step, find_stiffest_point

MAX_SUBSTEPS = 10_000  # per frame, unless more are allowed
MIN_FPS, MAX_FPS = 1e-6, 1e6
MAX_STEPS = 10_000_000  # of one call: nothing interrupts a frame
MAX_STEP_S = 1.0 / MIN_FPS


class StepChoice:
    """The steps of one system."""

    def __init__(self, system: SpringSystem) -> None:
        self._stiffest = find_stiffest_point(system)
        self._damping_s = system.damping_s

    @property
    def largest_step(self) -> float:
        """The longest stable step in seconds, without drag."""
        return find_largest_step(self._stiffest.frequency, self._damping_s)

    def choose_substeps(self, frame_s: float, conditions: Conditions, substeps: int | None, max_substeps: int) -> int:
        """Return the number of steps of a frame, as few as are stable unless it is given."""
        max_substeps = as_step_count(max_substeps, "max_substeps")
        if substeps is None:
            needed = count_steps(frame_s, self._find_step(conditions))
            if needed > max_substeps:
                raise self._describe_cost(frame_s, needed, conditions, max_substeps)
            return needed
        n_steps = as_step_count(substeps, "substeps")
        largest = self._find_limit(conditions)
        if frame_s / n_steps > largest:
            least = _format_count(math.ceil(frame_s / largest))
            expected = f"be at least {least}, for steps of at most {largest:.6g} s, the largest stable one"
            raise ArgumentError.expecting("substeps", expected, n_steps)
        return n_steps

    def choose_step(self, conditions: Conditions, dt: float | None) -> float:
        """Return the length of a step in seconds: a little less than the largest unless it is given."""
        largest = self._find_limit(conditions)
        if dt is None:
            if math.isinf(largest):
                raise ArgumentError.expecting("dt", "be given if there are no springs", "none")
            return SAFETY * self._find_step(conditions)
        dt = as_positive_float(dt, "dt", MAX_STEP_S)
        if dt > largest:
            raise ArgumentError.expecting("dt", f"be at most {largest:.6g} s, the largest stable step", f"{dt:.6g}")
        return dt

    def _find_limit(self, conditions: Conditions) -> float:
        """Return the longest step that is stable where the faces meet no air."""
        return find_largest_step(self._stiffest.frequency, self._damping_s, conditions.drag_rate)

    def _find_step(self, conditions: Conditions) -> float:
        """Return the longest step that is stable where points meet the air no faster than a constant wind blows."""
        drag_rate = conditions.drag_rate + conditions.face_drag_rate
        return find_largest_step(self._stiffest.frequency, self._damping_s, drag_rate)

    def _describe_cost(self, frame_s: float, needed: int, conditions: Conditions, max_substeps: int) -> ArgumentError:
        """Return the error about too many steps, which names what makes them so short."""
        start = f"a frame needs {_format_count(needed)} steps, more than max_substeps, {max_substeps:,}: "
        w, damping_s, drag_rate = self._stiffest.frequency, self._damping_s, conditions.drag_rate
        face_drag_rate = conditions.face_drag_rate
        causes = (
            ("damping", damping_s, find_largest_step(w, 0.0, drag_rate + face_drag_rate), "damping"),
            ("drag_rate", drag_rate, find_largest_step(w, damping_s, face_drag_rate), "drag_rate"),
            ("drag", conditions.drag, find_largest_step(w, damping_s, drag_rate), "drag, or less wind,"),
        )
        for name, value, step_s, less in causes:
            if value and count_steps(frame_s, step_s) <= max_substeps:
                return ArgumentError(f"{start}{name} is {value:g}. Less {less} would need fewer", argument=name)
        stiffest = self._stiffest
        return ArgumentError(
            f"{start}point {stiffest.point} has springs of {stiffest.stiffness:g} N/m in sum and a mass of "
            f"{stiffest.mass:g} kg. Softer springs, more mass, more frames per second, or a coarser model would need "
            "fewer",
            argument="max_substeps",
        )


def as_fps(fps: float) -> float:
    """Return a number of frames per second, checked."""
    fps = as_positive_float(fps, "fps")
    if not MIN_FPS <= fps <= MAX_FPS:
        bound = f"be at most {MAX_FPS:g}" if fps > MAX_FPS else f"be at least {MIN_FPS:g}"
        raise ArgumentError.expecting("fps", bound, f"{fps:g}")
    return fps


def as_step_count(value: SupportsIndex, name: str) -> int:
    """Return a number of steps, checked."""
    n = as_int(value, name)
    if n < 1:
        raise ArgumentError.expecting(name, "be at least 1", n)
    if n > MAX_STEPS:
        raise ArgumentError.expecting(name, f"be at most {MAX_STEPS:,}", n)
    return n


def _format_count(n: int) -> str:
    return f"{n:,}" if n < 1e12 else f"{float(n):.3g}"
