"""Springs: the public face of a simulation."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Literal, Self, Unpack

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_int, as_vector, require_callable
from .._core.interrupts import defer_interrupts
from .._core.public import public
from .._core.types import BoolArray, Float64Array, IndexArray, Progress
from ..compute.mesh_buffer import MeshBuffer
from ..device import Device, resolve_device
from ..errors import ArgumentError, ArgumentTypeError, SimulationError
from ..geometry.mesh import Mesh, move
from ..gpu.layouts import PIN
from ..host import HostDevice
from ._validation import as_points, as_positive_float, as_small_vector
from .conditions import (
    GRAVITY,
    ConditionOptions,
    Conditions,
    Force,
    FrameConditions,
    PinMotion,
    Wind,
    require_condition_names,
)
from .energy import Energy, Momentum, measure_energy, measure_momentum
from .obstacles import Obstacle, warn_of_points_inside
from .spring_system import SpringSystem, join_systems, make_system
from .state_file import SavedState, pack_state, unpack_state
from .step_choice import MAX_SUBSTEPS, StepChoice, as_fps, as_step_count
from .stepper import make_stepper
from .trajectory import Frames, Trajectory, allocate_frames, strip_directions


@dataclass
class _Hold:
    """Where a held point is, and where it will be at the end of the next frame: (3,) each."""

    position: Float64Array
    target: Float64Array


@public
class Springs:
    """Points with masses, joined by springs: cloth, nets, hair. The device moves them by Newton's and Hooke's laws.

    A spring of stiffness k and rest length r pulls its ends together with the force k (length - r). Time goes on by
    leapfrog steps that are as short as the stiffest point needs them; positions and velocities are float32 on the
    device. Points do not collide with one another, only with obstacles. All quantities are in SI units.

    Parameters
    ----------
    model : Mesh, or (n, 3) numbers
        The points at the start, in metres. A mesh gives springs as well: see `stretch`.
    springs : (s, 2) integers, optional
        The ends of each spring, as indices of points; for a mesh, in addition to its own.
    stiffness : float or (s,) numbers
        Of `springs`, in newtons per metre.
    rest : float or (s,) numbers, optional
        The rest lengths of `springs`, in metres; by default their lengths in `model`.
    stretch : float
        The stiffness of a spring along every edge of a mesh, in N/m; required unless `springs` are given.
    shear : float
        The stiffness of a spring along both diagonals of every quad, in N/m.
    bend : float
        The stiffness of springs that resist folding, in N/m: across every edge between two faces, from the neighbours
        of its ends in one face to those in the other. So for triangles they join the two opposite corners; on a grid of
        quads, points that are two edges apart along a row. Of segments, they join the ends of two that meet.
    mass : float or (n,) numbers
        In kilograms: the total, which all points share equally, or the mass of each point.
    area_density : float
        In kg/m^2, in place of `mass`: each face gives its corners equal parts of its mass.
    damping : float
        In seconds: each spring has a damper of `damping` times its stiffness, in N s/m.
    pinned : (k,) integers or (n,) bool
        The points that no force moves.
    velocities : (n, 3) numbers, optional
        At the start, in m/s; zero by default.
    device : Device, optional
        By default the process's own.

    Raises
    ------
    ArgumentError
        For an index out of range, a spring from a point to itself or between points in one place, a rest length or a
        mass that is not positive, a negative stiffness, numbers that are not finite, or if no point is free.
    ArgumentTypeError
        For values that are no numbers, and indices that are no integers.
    """

    def __init__(
        self,
        model: Mesh | npt.ArrayLike,
        *,
        springs: npt.ArrayLike | None = None,
        stiffness: npt.ArrayLike | None = None,
        rest: npt.ArrayLike | None = None,
        stretch: float | None = None,
        shear: float = 0.0,
        bend: float = 0.0,
        mass: npt.ArrayLike | None = None,
        area_density: float | None = None,
        damping: float = 0.0,
        pinned: npt.ArrayLike = (),
        velocities: npt.ArrayLike | None = None,
        device: Device | None = None,
    ) -> None:
        system = make_system(
            model,
            springs=springs,
            stiffness=stiffness,
            rest=rest,
            stretch=stretch,
            shear=shear,
            bend=bend,
            mass=mass,
            area_density=area_density,
            damping=damping,
            pinned=pinned,
        )
        self._compose(system, velocities, device)

    @classmethod
    def join(cls, parts: Sequence[Springs], *, device: Device | None = None) -> Self:
        """Return one system of several bodies, at their present positions and velocities.

        The bodies do not touch one another. Their points follow one another in the order of the parts.

        Parameters
        ----------
        parts : sequence of Springs
            With equal damping. They stay as they are.
        device : Device, optional
            By default that of the first part.

        Returns
        -------
        Springs

        Raises
        ------
        ArgumentError
            If there are none, or if their damping differs.
        ArgumentTypeError
            If one is no Springs.
        """
        if isinstance(parts, Springs):
            raise ArgumentTypeError.expecting("parts", "be a sequence of Springs", "Springs")
        parts = list(parts)
        for part in parts:
            if not isinstance(part, Springs):
                raise ArgumentTypeError.expecting("parts", "hold Springs", type(part).__name__)
        if not parts:
            raise ArgumentError.expecting("parts", "hold at least one", "none")
        joint = cls.__new__(cls)
        system = join_systems([part._system for part in parts])
        joint._compose(system, np.concatenate([part.velocities for part in parts]), device or parts[0].device)
        joint.positions = np.concatenate([part.positions for part in parts])
        return joint

    def _compose(self, system: SpringSystem, velocities: npt.ArrayLike | None, device: Device | None) -> None:
        self._system = system
        self._steps = StepChoice(system)
        self._start = (
            np.zeros((system.n_points, 3))
            if velocities is None
            else as_points(velocities, "velocities", system.n_points)
        )
        self._stepper = make_stepper(resolve_device(device), system)
        self._last_trajectory: Trajectory | None = None
        self._held: dict[int, _Hold] = {}
        self._inspected: tuple[Obstacle, ...] = ()
        self._topology = strip_directions(system.mesh)
        self._lock = threading.Lock()  # held during a run
        self._state_lock = threading.RLock()  # held during a frame, and while the state is read or written
        self._runner: int | None = None  # the thread that takes steps
        self.reset()

    def reset(self) -> None:
        """Go back to the positions and velocities of the start, and to time 0; held points are released."""
        with self._alone(), self._state_lock:
            self.release()
            self._write(self._system.points, self._start)
            self._epoch, self._n_frames, self._frame_s = 0.0, 0, 0.0
            self._substeps = 0
            self._last = Conditions(self._system).during(0.0, 1.0, self._state)

    @property
    def device(self) -> Device:
        """The device that computes."""
        return self._stepper.device

    @property
    def n_points(self) -> int:
        """The number of points."""
        return self._system.n_points

    @property
    def springs(self) -> IndexArray:
        """The ends of every spring, given or of the mesh: (s, 2) int64."""
        return self._system.pairs.copy()

    @property
    def stiffness(self) -> Float64Array:
        """The stiffness of every spring in N/m: (s,) float64."""
        return self._system.stiffness.copy()

    @property
    def rest(self) -> Float64Array:
        """The rest length of every spring in metres: (s,) float64."""
        return self._system.rest.copy()

    @property
    def damping(self) -> float:
        """The damping of each spring over its stiffness, in seconds."""
        return self._system.damping_s

    @property
    def masses(self) -> Float64Array:
        """The mass of every point in kilograms: (n,) float64."""
        return self._system.masses.copy()

    @property
    def pinned(self) -> BoolArray:
        """Which points are pinned: (n,) bool."""
        return self._system.pinned.copy()

    @property
    def mesh(self) -> Mesh:
        """The mesh at the present positions; of points without a mesh, segments along the springs."""
        return move(self._system.mesh, self.positions, np.eye(4))

    def buffer(self) -> MeshBuffer:
        """Return the mesh at the present positions as a copy on the device, which stays when time goes on.

        Returns
        -------
        MeshBuffer
            `render` and its kin draw it without a way through the host's memory; they take a Springs itself as well.
        """
        with self._state_lock:
            return MeshBuffer.at_points(self._topology, self._stepper.store_positions())

    def as_model(self) -> Mesh | MeshBuffer:
        """Return what `render` and its kin draw of a Springs.

        Returns
        -------
        MeshBuffer or Mesh
            `buffer()`; of springs on the host device, which draws nothing, `mesh`.
        """
        return self.mesh if isinstance(self.device, HostDevice) else self.buffer()

    @property
    def time(self) -> float:
        """The seconds since the start."""
        return self._epoch + self._n_frames * self._frame_s

    @property
    def positions(self) -> npt.NDArray[np.float32]:
        """The positions in metres: (n, 3) float32, a copy. They can be assigned; velocities stay."""
        with self._state_lock:
            return self._stepper.read_positions()

    @positions.setter
    def positions(self, positions: npt.ArrayLike) -> None:
        """Move the points, (n, 3) finite numbers."""
        points = as_points(positions, "positions", self.n_points)
        with self._state_lock:
            self._write(points, self.velocities)

    @property
    def velocities(self) -> npt.NDArray[np.float32]:
        """The velocities in m/s: (n, 3) float32, a copy. They can be assigned; positions stay."""
        with self._state_lock:
            return self._stepper.read_kicked_velocities(self._lag_s, self._last)

    @velocities.setter
    def velocities(self, velocities: npt.ArrayLike) -> None:
        """Give the points other velocities, (n, 3) finite numbers; those of pinned points are zero."""
        given = as_points(velocities, "velocities", self.n_points)
        with self._state_lock:
            self._write(self.positions, given)

    @property
    def largest_step(self) -> float:
        """The longest stable step in seconds, without drag; infinite if there are no springs.

        (2/w) (sqrt(1 + z^2) - z), where w^2 is the largest bound by Gershgorin's theorem on the square of a frequency,
        over all points i: the sum over the springs of i of k / m_i, twice for those whose other end is free; and
        z = damping w / 2. It holds while no spring is compressed to less than half its rest length.
        """
        return self._steps.largest_step

    @property
    def substeps(self) -> int:
        """How many steps the last frame took; 0 before the first."""
        return self._substeps

    @property
    def trajectory(self) -> Trajectory | None:
        """The frames of the last `simulate`, as far as it came: after an error or Ctrl+C, those that are done.

        After Ctrl+C, the system is left in the state of the last of them.
        """
        return self._last_trajectory

    def energy(self, gravity: npt.ArrayLike = GRAVITY) -> Energy:
        """Return the energies of the present state, computed in float64.

        Parameters
        ----------
        gravity : (3,) numbers
            In m/s^2, for the potential energy, which is zero at the origin.

        Returns
        -------
        Energy
            `kinetic`, `elastic` and `potential`, in joules, and their `total`.

        Raises
        ------
        ArgumentError
            If `gravity` is no vector of three finite numbers.
        """
        return measure_energy(self._system, *self._state(), as_vector(gravity, "gravity", 3))

    def momentum(self) -> Momentum:
        """Return the momenta of the present state, computed in float64.

        Returns
        -------
        Momentum
            `linear`, (3,) in kg m/s, and `angular` about the origin, (3,) in kg m^2/s.
        """
        return measure_momentum(self._system, *self._state())

    def simulate(
        self,
        duration: float,
        fps: float = 30.0,
        *,
        gravity: npt.ArrayLike = GRAVITY,
        drag: float | None = None,
        drag_rate: float | None = None,
        wind: Wind | None = None,
        force: Force | None = None,
        move_pins: PinMotion | None = None,
        obstacles: Obstacle | Sequence[Obstacle] = (),
        substeps: int | None = None,
        max_substeps: int = MAX_SUBSTEPS,
        keep: Literal["host", "device"] = "host",
        progress: Progress | None = None,
    ) -> Trajectory:
        """Let time go on, and return the positions at the start of it and after every frame.

        Simulating in two parts gives the same positions as in one. Ctrl+C is put off until the frame is whole, so that
        what is simulated after it goes on as if there had been none.

        Parameters
        ----------
        duration : float
            In seconds; rounded to whole frames, at least one.
        fps : float
            Frames per second.
        gravity : (3,) numbers
            In m/s^2.
        drag : float
            The drag coefficient of the faces, about 1 to 2 for cloth; 0 by default. A triangle of area A and unit
            normal n, past which air flows with velocity u, feels the force drag 1.2 kg/m^3 A/2 (u.n)|u.n| n.
        drag_rate : float
            In 1/s: each point feels the acceleration drag_rate (wind - velocity). For hair, which has no faces.
            0 by default.
        wind : (3,) numbers, or a function of the time in seconds that returns them, optional
            The velocity of the air in m/s, constant during a frame. It acts through `drag` or `drag_rate`, of which one
            must be given; it does nothing if that is 0.
        force : function, optional
            Called at the start of each frame with the time in seconds, the positions and the velocities (n, 3); returns
            the forces (n, 3) in newtons that act on the points during the frame.
        move_pins : function, optional
            Called with the time in seconds; returns a (4, 4) matrix that moves the pinned points from where they were
            at the start, or their positions (p, 3). During a frame they move in straight lines. `Scene.follow` returns
            such a function, with which they follow a node.
        obstacles : Sphere, HalfSpace, Capsule, Box, or a sequence of them
            What points cannot enter.
        substeps : int, optional
            Steps per frame; by default as few as are stable for points that meet the air no faster than a constant
            `wind` blows. If faster motion or a changing wind in `drag` makes the positions not finite, more may help;
            so may less wind or drag.
        max_substeps : int
            How many steps per frame are too many.
        keep : "host" or "device"
            Where the frames stay: as one array in the host's memory, or on the device, from which `animate` draws them.
            Those of the host device are in the host's memory.
        progress : function, optional
            Called with the number of frames done and of all frames, after each.

        Returns
        -------
        Trajectory
            round(duration fps) + 1 frames; the last is the state in which the system is left.

        Raises
        ------
        ArgumentError
            An argument has an impossible value; `substeps` makes the steps longer than the largest stable one, which is
            named; or the system needs more than `max_substeps`: the stiffest point is named.
        SimulationError
            A position is not finite: the frame is named, and `trajectory` holds the frames before it.

        Warns
        -----
        SimulationWarning
            Free points start deeper inside an obstacle than its gap.
        """
        fps = as_fps(fps)
        duration = as_positive_float(duration, "duration", math.inf)
        conditions = Conditions(
            self._system,
            gravity=gravity,
            drag=drag,
            drag_rate=drag_rate,
            wind=wind,
            force=force,
            move_pins=move_pins,
            obstacles=obstacles,
        )
        require_callable(progress, "progress")
        place: object = keep
        if not (isinstance(place, str) and place in ("host", "device")):
            raise ArgumentError.expecting("keep", "be 'host' or 'device'", repr(keep))
        n_steps = self._steps.choose_substeps(1.0 / fps, conditions, substeps, max_substeps)
        is_buffered = keep == "device" and not isinstance(self.device, HostDevice)
        frames, times = allocate_frames(duration, fps, self.n_points, is_buffered=is_buffered)
        with self._alone():
            n_frames = len(times) - 1
            self._begin_frames(1.0 / fps)
            times[:] = self._epoch + (self._n_frames + times) * self._frame_s
            self._keep_frame(frames, 0, times[0])
            if conditions.obstacles != self._inspected:
                warn_of_points_inside(
                    conditions.obstacles, np.asarray(frames[0]), self._inverse_masses() > 0.0, times[0]
                )
                self._inspected = conditions.obstacles
            n_done = 1
            try:
                for k in range(1, n_frames + 1):
                    with defer_interrupts(), self._state_lock:  # so that the state is always that of the last frame
                        self._advance(times[k - 1], times[k], n_steps, conditions)
                        self._keep_frame(frames, k, times[k])
                        n_done = k + 1
                    if progress is not None:
                        progress(k, n_frames)
            finally:
                self._last_trajectory = Trajectory(frames[:n_done], times[:n_done], self._system.mesh)
        return self._last_trajectory

    def hold(self, point: int, position: npt.ArrayLike | None = None) -> None:
        """Hold a point from now on, as if it were pinned, until it is released.

        Parameters
        ----------
        point : int
            Its index. It may be pinned: then it stays where it is released.
        position : (3,) numbers, optional
            Where it is at the end of the next frame, to which it moves in a straight line; by default where it is now.

        Raises
        ------
        ArgumentError
            If there is no such point, or if `position` is no vector of three finite numbers.
        """
        point = self._as_index(point)
        target = None if position is None else as_small_vector(position, "position")
        with self._state_lock:
            self._hold(point, target)

    def _hold(self, point: int, target: Float64Array | None) -> None:
        if point not in self._held:
            here = self.positions[point].astype(np.float64)
            self._held[point] = _Hold(here, here)
            self._stepper.write_inverse_masses(self._inverse_masses())
        hold = self._held[point]
        hold.target = hold.position if target is None else target

    def release(self, point: int | None = None) -> None:
        """Let a point go that is held, with the velocity at which it was moved.

        Parameters
        ----------
        point : int, optional
            Its index; by default all that are held. One that is not held stays as it is.

        Raises
        ------
        ArgumentError
            If there is no such point.
        """
        index = None if point is None else self._as_index(point)
        with self._state_lock:
            released = list(self._held) if index is None else [index]
            if any(self._held.pop(each, None) is not None for each in released):
                self._held = {} if index is None else self._held
                self._stepper.write_inverse_masses(self._inverse_masses())

    def count_substeps(self, fps: float = 30.0, **conditions: Unpack[ConditionOptions]) -> int:
        """Return how many steps a frame takes, without taking them.

        Parameters
        ----------
        fps : float
            Frames per second.
        **conditions
            gravity, drag, drag_rate, wind, force, move_pins and obstacles, as `simulate` takes them.

        Returns
        -------
        int

        Raises
        ------
        ArgumentError, ArgumentTypeError
            As `simulate` raises them.
        """
        frame_s = 1.0 / as_fps(fps)
        require_condition_names(conditions)
        return self._steps.choose_substeps(frame_s, Conditions(self._system, **conditions), None, MAX_SUBSTEPS)

    def step(self, n: int = 1, dt: float | None = None, **conditions: Unpack[ConditionOptions]) -> None:
        """Take `n` steps, and leave the system after the last.

        Parameters
        ----------
        n : int
            The number of steps.
        dt : float, optional
            The length of each in seconds; by default 0.98 of the largest, or less in a constant wind, as in `simulate`.
        **conditions
            gravity, drag, drag_rate, wind, force, move_pins and obstacles, as `simulate` takes them; the steps together
            count as one frame.

        Raises
        ------
        ArgumentError
            If an argument has an impossible value, or `dt` is above the largest stable step.
        """
        n = as_step_count(n, "n")
        require_condition_names(conditions)
        frame = Conditions(self._system, **conditions)
        dt = self._steps.choose_step(frame, dt)
        with self._alone(), defer_interrupts(), self._state_lock:
            self._begin_frames(n * dt)
            self._advance(self.time, self.time + n * dt, n, frame, dt)

    def state(self) -> bytes:
        """Return the present state, to be written to a file.

        Returns
        -------
        bytes
            `restore` continues from it as if there had been no pause, to the byte on the same device. It holds no
            conditions: what acts on the points is to be given again.

        Raises
        ------
        SimulationError
            If a position or a velocity is not finite.
        """
        with self._state_lock:
            saved = SavedState(
                *self._stepper.read_state(), self._epoch, self._n_frames, self._frame_s, self._lag_s, self._last.step
            )
        return pack_state(saved, self._system)

    def restore(self, state: bytes | bytearray | memoryview) -> None:
        """Go back to a state that `state` has returned.

        Parameters
        ----------
        state : bytes
            Of a system with the same points, masses, springs and pins.

        Raises
        ------
        ArgumentError
            If it is the state of another system, of which the error says what differs, or no state at all.
        ArgumentTypeError
            If it is no bytes.
        """
        saved = unpack_state(state, self._system)
        with self._alone(), self._state_lock:
            self.release()
            self._stepper.write(saved.positions, saved.velocities)
            self._inspected = ()
            self._epoch, self._n_frames, self._frame_s = saved.epoch_s, saved.n_frames, saved.frame_s
            self._lag_s = saved.lag_s
            self._last = FrameConditions(saved.step)

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Let no other thread, and no function that is called for this one, take steps meanwhile."""
        if self._runner == threading.get_ident():
            raise SimulationError(
                "simulate, step, restore and reset cannot be called while the same Springs is simulated, "
                "such as by its force, wind or progress"
            )
        self.device.require_usable()  # in a fork, where nobody may let the lock go
        with self._lock:
            try:
                self._runner = threading.get_ident()
                yield
            finally:
                self._runner = None

    def _as_index(self, point: int) -> int:
        """Return the index of a point, checked."""
        point = as_int(point, "point")
        if not 0 <= point < self.n_points:
            raise ArgumentError.expecting("point", f"lie in 0..{self.n_points - 1}", point)
        return point

    def _write(self, positions: npt.ArrayLike, velocities: npt.ArrayLike) -> None:
        """Set positions and velocities (n, 3) of one time."""
        state = np.zeros((2, self.n_points, 4), np.float32)
        state[0, :, :3], state[0, :, 3] = positions, self._inverse_masses()
        for point, hold in self._held.items():
            hold.position = hold.target = state[0, point, :3].astype(np.float64)
        state[1, :, :3] = np.where(self._system.pinned[:, np.newaxis], 0.0, velocities)
        self._stepper.write(*state)
        self._inspected = ()  # the obstacles in which no point lies, or of which a warning was given
        self._lag_s = 0.0  # how far the device's velocities are behind its positions
        self._pins_move = False

    def _inverse_masses(self) -> Float64Array:
        """Return one over each mass, 0 for points that are pinned or held: (n,)."""
        inverse_masses = self._system.inverse_masses
        inverse_masses[list(self._held)] = 0.0
        return inverse_masses

    def _move_held(self, frame: FrameConditions, duration_s: float) -> FrameConditions:
        """Return the conditions of a frame with the points that are held among the pins that move."""
        if not self._held:
            return frame
        pins = np.zeros(len(self._held), PIN)
        for pin, (point, hold) in zip(pins, self._held.items(), strict=True):
            pin["position"], pin["point"] = hold.position, point
            pin["velocity"] = (hold.target - hold.position) / duration_s
            hold.position = hold.target
        others = frame.pins[~np.isin(frame.pins["point"], pins["point"])]
        return replace(frame, pins=np.concatenate([others, pins]))

    def _keep_frame(self, frames: Frames, k: int, time: float) -> None:
        """Keep the present positions as frame k; raise SimulationError if one is not finite."""
        where = f"in frame {k}" if k else "at the start"
        if isinstance(frames, np.ndarray):
            frames[k] = self.positions
            self._require_finite(frames[k], time, k, where)
            return
        buffer = self.buffer()
        if not np.isfinite(buffer.bounds()).all():
            self._require_finite(buffer.numpy(), time, k, where)
        frames.append(buffer)

    def _state(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        with self._state_lock:
            return self.positions, self.velocities

    def _begin_frames(self, frame_s: float) -> None:
        """Count frames of another length from now on."""
        if frame_s != self._frame_s:
            self._epoch, self._n_frames, self._frame_s = self.time, 0, frame_s

    def _advance(
        self, start_s: float, end_s: float, n_steps: int, conditions: Conditions, step_s: float | None = None
    ) -> None:
        """Take the steps of one frame."""
        step_s = self._frame_s / n_steps if step_s is None else step_s
        frame = conditions.during(start_s, end_s, self._state)
        pins_move = len(frame.pins) > 0
        if self._pins_move and not pins_move:
            self._write(*self._state())
        frame = self._move_held(frame, end_s - start_s)
        if self._lag_s != step_s / 2.0:
            self._stepper.kick(self._lag_s - step_s / 2.0, frame)
            self._lag_s = step_s / 2.0
        self._last = frame
        self._pins_move = pins_move
        self._substeps = n_steps
        n_submitted = 0

        def count(n: int) -> None:
            nonlocal n_submitted
            n_submitted += n
            if n_submitted == n_steps:
                self._n_frames += 1

        try:
            self._stepper.step(n_steps, step_s, frame, count)
        except BaseException:
            if 0 < n_submitted < n_steps:
                self._epoch, self._n_frames = self.time + n_submitted * step_s, 0
                self._frame_s = 0.0
            raise

    def _require_finite(self, positions: npt.NDArray[np.float32], time: float, frame: int, where: str) -> None:
        wrong = ~np.isfinite(positions).all(axis=1)
        if wrong.any():
            point = int(np.argmax(wrong))
            has_drag = self._last.has_drag or self._last.drag_rate > 0.0
            weaker = "less wind or drag" if has_drag else "weaker forces"
            remedy = f"more substeps than {self._substeps:,}, or {weaker}, may help; " if frame else ""
            raise SimulationError(
                f"point {point} is not at a finite position {where}, at {time:g} s: {remedy}restore a state, or "
                "reset()",
                frame=frame,
            )

    def __copy__(self) -> Springs:
        return self._copy_to(self.device)

    def __deepcopy__(self, _: dict[int, object]) -> Springs:
        return self._copy_to(self.device)

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle the state; what is unpickled computes on the process's own device, or on the host if this does."""
        return _unpickle, (self._system, self._start, self.state(), isinstance(self.device, HostDevice))

    def _copy_to(self, device: Device | None) -> Springs:
        return _make_from_state(self._system, self._start, self.state(), device)

    def __repr__(self) -> str:
        return f"<Springs: {self.n_points} points, {len(self._system.pairs)} springs at {self.time:g} s>"


def _make_from_state(system: SpringSystem, start: Float64Array, state: bytes, device: Device | None) -> Springs:
    springs = Springs.__new__(Springs)
    springs._compose(system, start, device)
    springs.restore(state)
    return springs


def _unpickle(system: SpringSystem, start: Float64Array, state: bytes, is_on_host: bool) -> Springs:
    return _make_from_state(system, start, state, Device("host") if is_on_host else None)
