"""Live springs: what a window simulates in real time, and the point that follows the pointer."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .._core.types import Float64Array
from ..drawing.camera import Camera
from ..drawing.layer import Layer
from ..errors import ArgumentError, ArgumentTypeError, SimulationError
from ..simulation.conditions import ConditionOptions, require_condition_names
from ..simulation.springs import Springs
from .controls import LEFT, Event, pointer_position, to_ndc

FPS = 60.0
CLOCK_ROUNDING = 1e-3  # of a frame
MAX_FRAMES_PER_PICTURE = 4  # if a picture takes longer, time goes on more slowly than it should
PICK_RADIUS_PX = 14.0  # in logical pixels: a point that is farther from the pointer is not meant
SAME_PLACE_PX = 1.0  # of points about as near to the pointer, the one in front is meant
MAX_DRAG_PER_FRAME = 0.05  # of the size of the models: no faster, whatever the pointer does


@dataclass
class _Held:
    """The point that follows the pointer.

    goal : (3,), where it is to go, in the coordinates of the springs
    offset : (2,), from the pointer to the point, in NDC
    """

    springs: Springs
    point: int
    world_from_springs: Float64Array
    goal: Float64Array
    offset: Float64Array


class LiveSprings:
    """The springs among some layers, moved in real time.

    conditions : keywords of `Springs.simulate` that say what acts on all of them

    Raises `ArgumentError` and `ArgumentTypeError` as `Springs.simulate` does.
    """

    def __init__(
        self, layers: Sequence[Layer], conditions: ConditionOptions, clock: Callable[[], float] = time.monotonic
    ) -> None:
        found: dict[int, tuple[Springs, list[Float64Array]]] = {}
        for layer in layers:
            if isinstance(layer.model, Springs):
                springs, places = found.setdefault(id(layer.model), (layer.model, []))
                places += list(layer.world_from_model)
        self._systems = list(found.values())
        self._conditions = conditions
        self._clock = clock
        self._start = [springs.state() for springs, _ in self._systems]
        self._held: _Held | None = None
        self._last_s = 0.0
        self._is_slow = False
        self._problem = ""
        self.is_running = False
        require_condition_names(conditions)
        for springs, _ in self._systems:
            springs.count_substeps(FPS, **conditions)

    @property
    def is_there(self) -> bool:
        """Whether there is anything to simulate."""
        return bool(self._systems)

    @property
    def note(self) -> str:
        """What a title says of the simulation."""
        if not self._systems:
            return ""
        state = "space stops" if self.is_running else "space starts"
        return self._problem or (f"{state}, slower than real time" if self._is_slow and self.is_running else state)

    def handle(self, event: Event, size: tuple[float, float], camera: Camera) -> bool:
        """Apply an event of rendercanvas if it is for the springs, and say whether it was."""
        if not self._systems or min(size) <= 0.0:
            return False
        modifiers = set(event.get("modifiers", ()))
        match event["event_type"]:
            case "key_down" if not modifiers & {"Control", "Alt", "Meta"} and event["key"] in (" ", "0"):
                self._toggle() if event["key"] == " " else self._restart()
                return True
            case "pointer_down" if event["button"] == LEFT and "Shift" not in modifiers and self._held is None:
                self._held = self._pick(event, size, camera)
                return self._held is not None
            case "pointer_move" if self._held is not None:
                if LEFT in event["buttons"]:
                    self._pull(self._held, event, size, camera)
                else:  # released outside the window, without an event
                    self.let_go()
                return True
            case "pointer_up" if self._held is not None and event["button"] == LEFT:
                self.let_go()
                return True
        return False

    def let_go(self) -> None:
        """Release the point that is held, with the velocity that it has."""
        if self._held is not None:
            self._held.springs.release(self._held.point)
            self._held = None

    def advance(self) -> None:
        """Simulate the time that has passed since the last call, as far as it can be made up for."""
        if not self.is_running:
            return
        now = self._clock()
        n_due = int((now - self._last_s) * FPS + CLOCK_ROUNDING)
        if n_due < 1:
            return
        n_frames = min(n_due, MAX_FRAMES_PER_PICTURE)
        self._is_slow = n_frames < n_due
        self._last_s = now if self._is_slow else self._last_s + n_frames / FPS
        try:
            for _ in range(n_frames):
                self._move_held()
                for springs, _ in self._systems:
                    springs.simulate(1.0 / FPS, FPS, keep="device", **self._conditions)
        except (SimulationError, ArgumentError, ArgumentTypeError) as error:  # such as of what `force` returns
            self._restart()
            self._problem = str(error)

    def _toggle(self) -> None:
        self.is_running = not self.is_running
        self._last_s = self._clock()
        self._problem = ""

    def _restart(self) -> None:
        """Go back to what was first shown, and stop."""
        self.let_go()
        for (springs, _), state in zip(self._systems, self._start, strict=True):
            springs.restore(state)
        self.is_running = False
        self._problem = ""

    def _pick(self, event: Event, size: tuple[float, float], camera: Camera) -> _Held | None:
        """Return the point whose picture is nearest to the pointer, unless all are far from it."""
        pointer = to_ndc(pointer_position(event), size)
        best: tuple[float, float, _Held] | None = None
        for springs, places in self._systems:
            positions = springs.positions.astype(np.float64)
            for world_from_springs in places:
                clip = _clip(camera, size) @ world_from_springs
                projected = positions @ clip[:, :3].T + clip[:, 3]
                w = projected[:, 3]
                with np.errstate(divide="ignore", invalid="ignore"):
                    ndc = projected[:, :2] / w[:, np.newaxis]
                    away = np.linalg.norm((ndc - pointer) * np.array(size) / 2.0, axis=1)
                    depth = projected[:, 2] / w
                away = np.where((w > 0.0) & np.isfinite(away), away, np.inf)
                nearest = float(away.min())
                if nearest > PICK_RADIUS_PX:
                    continue
                point = int(np.argmin(np.where(away <= nearest + SAME_PLACE_PX, depth, np.inf)))
                if best is None or (nearest, float(depth[point])) < best[:2]:
                    held = _Held(springs, point, world_from_springs, positions[point], ndc[point] - pointer)
                    best = nearest, float(depth[point]), held
        if best is None:
            return None
        held = best[2]
        held.springs.hold(held.point)
        return held

    def _pull(self, held: _Held, event: Event, size: tuple[float, float], camera: Camera) -> None:
        """Give the held point a goal under the pointer, as far from the eye as it is."""
        clip = _clip(camera, size) @ held.world_from_springs
        x, y, _, w = clip
        along = w[:3] if w[:3].any() else np.cross(x[:3], y[:3])
        here = held.goal
        ndc = (to_ndc(pointer_position(event), size) + held.offset) * (w[:3] @ here + w[3])
        rows = np.array([x[:3], y[:3], along])
        try:
            goal = np.linalg.solve(rows, np.array([ndc[0] - x[3], ndc[1] - y[3], along @ here]))
        except np.linalg.LinAlgError:  # the camera sees the springs edge-on
            return
        held.goal = goal
        if not self.is_running:
            positions = held.springs.positions
            positions[held.point] = goal
            held.springs.positions = positions

    def _move_held(self) -> None:
        """Move the held point towards its goal."""
        held = self._held
        if held is None:
            return
        positions = held.springs.positions.astype(np.float64)
        here = positions[held.point]
        way = held.goal - here
        longest = MAX_DRAG_PER_FRAME * float(np.linalg.norm(np.ptp(positions, axis=0)))
        length = float(np.linalg.norm(way))
        held.springs.hold(held.point, here + way * min(1.0, longest / length if length else 1.0))


def _clip(camera: Camera, size: tuple[float, float]) -> Float64Array:
    return camera.clip_from_world(size[0] / size[1])
