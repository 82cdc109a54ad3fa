"""Conditions: what acts on the points from outside, over a run and during one frame of it."""

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias, TypedDict

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array, as_square_matrix, require_affine
from .._core.types import Float64Array, IndexArray, MatrixLike
from ..errors import ArgumentError, ArgumentTypeError
from ..gpu.layouts import OBSTACLE, PIN, SPRING_STEP
from ._validation import (
    MAX_NUMBER,
    MAX_SQUARED,
    as_nonnegative_float,
    as_points,
    as_small_vector,
    call_at,
    require_at_most,
)
from .obstacles import Obstacle, as_obstacles, pack_obstacles
from .spring_system import SpringSystem

GRAVITY = (0.0, -9.81, 0.0)  # m/s^2
AIR_DENSITY = 1.2  # kg/m^3, at 20 degrees Celsius and 1 bar

Wind: TypeAlias = npt.ArrayLike | Callable[[float], npt.ArrayLike]
Force: TypeAlias = Callable[[float, npt.NDArray[np.float32], npt.NDArray[np.float32]], npt.ArrayLike]
PinMotion: TypeAlias = Callable[[float], MatrixLike]


class ConditionOptions(TypedDict, total=False):
    """The keywords of `Springs.simulate` that say what acts on the points."""

    gravity: npt.ArrayLike
    drag: float | None
    drag_rate: float | None
    wind: Wind | None
    force: Force | None
    move_pins: PinMotion | None
    obstacles: Obstacle | Sequence[Obstacle]


def require_condition_names(given: Mapping[str, object]) -> None:
    """Raise ArgumentTypeError for a keyword that is none of `ConditionOptions`."""
    for name in given:
        if name not in ConditionOptions.__annotations__:
            close = difflib.get_close_matches(name, ConditionOptions.__annotations__, 1)
            hint = f"; did you mean {close[0]!r}?" if close else ""
            raise ArgumentTypeError(f"unexpected keyword argument {name!r}{hint}")


@dataclass(frozen=True, eq=False)
class FrameConditions:
    """What acts during one frame.

    step : `layouts.SPRING_STEP`, without its times
    obstacles : `layouts.OBSTACLE` (k,)
    pins : `layouts.PIN` (p,), of pins that move
    forces : (n, 3), in newtons; None for none
    """

    step: npt.NDArray[np.void]
    obstacles: npt.NDArray[np.void] = field(default_factory=lambda: np.zeros(0, OBSTACLE))
    pins: npt.NDArray[np.void] = field(default_factory=lambda: np.zeros(0, PIN))
    forces: npt.NDArray[np.float64] | None = None

    @property
    def has_drag(self) -> bool:
        """Whether air drags on faces."""
        return bool(self.step["face_drag"] != 0.0)

    @property
    def drag_rate(self) -> float:
        """The rate at which points lose speed to the air, in 1/s."""
        return float(self.step["drag_rate"])


class Conditions:
    """What acts on the points of a system during a run, validated. The arguments are keywords of `Springs.simulate`."""

    def __init__(
        self,
        system: SpringSystem,
        *,
        gravity: npt.ArrayLike = GRAVITY,
        drag: float | None = None,
        drag_rate: float | None = None,
        wind: Wind | None = None,
        force: Force | None = None,
        move_pins: PinMotion | None = None,
        obstacles: Obstacle | Sequence[Obstacle] = (),
    ) -> None:
        self._system = system
        self._pins: IndexArray = np.flatnonzero(system.pinned)
        self.gravity = as_small_vector(gravity, "gravity")
        self.drag = as_nonnegative_float(0.0 if drag is None else drag, "drag")
        self.drag_rate = as_nonnegative_float(0.0 if drag_rate is None else drag_rate, "drag_rate")
        self._wind = wind
        self.force = _as_function(force, "force")
        self.move_pins = _as_function(move_pins, "move_pins")
        self.obstacles = as_obstacles(obstacles)
        if self.drag and len(system.triangles) == 0:
            raise ArgumentError.expecting("drag", "be 0 without faces; drag_rate acts on points", f"{self.drag:g}")
        if wind is not None and drag is None and drag_rate is None:
            raise ArgumentError.expecting("wind", "come with a drag or a drag_rate, through which it acts", "neither")
        if self.move_pins is not None and len(self._pins) == 0:
            raise ArgumentError("move_pins needs pinned points", argument="move_pins")
        if not callable(wind):
            self._wind_at(0.0)

    @property
    def face_drag_rate(self) -> float:
        """A bound on the rate in 1/s at which faces lose speed that meet the air no faster than a constant wind blows.

        A triangle of area A, across which air flows with speed u, gives each corner the third of drag 1.2 A u^2 / 2. It
        moves with the mean velocity of its corners. By Gershgorin's theorem no motion decays faster than the largest of
        drag 1.2 u (sum of A / 3 over the triangles of i) / m_i over all free points i.
        """
        if not self.drag or callable(self._wind):
            return 0.0
        return self.drag * AIR_DENSITY * float(np.linalg.norm(self._wind_at(0.0))) * self._system.max_area_per_mass

    def during(
        self,
        start_s: float,
        end_s: float,
        state: Callable[[], tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]],
    ) -> FrameConditions:
        """Return what acts while the time goes from `start_s` to `end_s`.

        state : returns the positions and velocities (n, 3) at the start, if a force asks for them
        """
        step = np.zeros((), SPRING_STEP)
        step["gravity"], step["wind"] = self.gravity, self._wind_at(start_s)
        step["n_points"] = self._system.n_points
        step["damping_s"] = self._system.damping_s
        step["face_drag"] = self.drag * AIR_DENSITY / 12.0
        step["drag_rate"] = self.drag_rate
        return FrameConditions(
            step,
            pack_obstacles(self.obstacles, start_s, end_s),
            self._pins_during(start_s, end_s),
            self._forces_at(start_s, state),
        )

    def _wind_at(self, time: float) -> Float64Array:
        if self._wind is None:
            return np.zeros(3)
        if not callable(self._wind):
            return as_small_vector(self._wind, "wind")
        return call_at(self._wind, "wind", time, check=lambda wind: as_small_vector(wind, "wind"))

    def _forces_at(self, time: float, state: Callable[[], tuple[Any, Any]]) -> Float64Array | None:
        if self.force is None:
            return None
        n_points = self._system.n_points

        def check(forces: Any) -> Float64Array:
            return as_points(forces, "force", n_points, MAX_NUMBER)

        return call_at(self.force, "force", time, *state(), check=check)

    def _pins_during(self, start_s: float, end_s: float) -> npt.NDArray[np.void]:
        pins = np.zeros(0 if self.move_pins is None else len(self._pins), PIN)
        if self.move_pins is not None:
            first, last = (self._pin_positions(self.move_pins, time) for time in (start_s, end_s))
            pins["position"], pins["velocity"], pins["point"] = first, (last - first) / (end_s - start_s), self._pins
        return pins

    def _pin_positions(self, move_pins: PinMotion, time: float) -> Float64Array:
        """Return where the pinned points are (p, 3)."""
        return call_at(move_pins, "move_pins", time, check=self._as_pin_positions)

    def _as_pin_positions(self, given: Any) -> Float64Array:
        """Return positions (p, 3), or what a matrix moves the pins' first positions to."""
        start = self._system.points[self._pins]
        if not hasattr(given, "as_matrix"):
            array = as_real_array(given, "move_pins")
            if array.shape == start.shape:
                return as_points(array, "move_pins")
            if array.shape != (4, 4):
                raise ArgumentError.expecting(
                    "move_pins", f"return a (4, 4) matrix or {start.shape} points", array.shape
                )
        matrix = as_square_matrix(given, "move_pins", 4)
        require_affine(matrix, "move_pins")
        require_at_most(matrix, "move_pins", MAX_SQUARED)
        return as_points(start @ matrix[:3, :3].T + matrix[:3, 3], "move_pins")


def _as_function(value: Any, name: str) -> Any:
    if value is not None and not callable(value):
        raise ArgumentTypeError.expecting(name, "be a function of the time", type(value).__name__)
    return value
