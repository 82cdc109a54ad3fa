"""Leapfrog on the device: kicks and drifts, each one dispatch, between two copies of the points' state."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..compute.kernels.store import GpuStore
from ..errors import ArgumentError
from ..gpu import uniforms
from ..gpu.buffers import Buffer
from ..gpu.chunking import choose_workgroup_size
from ..gpu.context import CommandEncoder, Submittable
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Bindable, Binding, dispatch
from ..gpu.layouts import OBSTACLE, SLOT_PACKET, as_bytes
from ..gpu.shaders import ComputePipeline
from .conditions import FrameConditions
from .grid import Grid, find_grid
from .incidence import MAX_PACKETS, Slots, pack_fans, pack_slots
from .obstacles import MAX_OBSTACLES
from .point_state import POOL_OWNER, TEXEL_BYTES, TEXELS_PER_POINT, TEXELS_PER_ROW, PointState, create_table
from .spring_system import SpringSystem

MAX_STEPS_PER_SUBMISSION = 256  # so that no driver takes a long frame for a hang
GRID_WORKGROUP_SIZE = 8  # an invocation has much to do, and there are few
MAX_STRIP_ROWS = {"CPU": 50}  # a few long strips, of which little is computed twice
MAX_STRIP_ROWS_OF_GPU = 4  # many short ones, for thousands of threads
STRANDS_PER_WORKGROUP = 32
MAX_STEPS_PER_DISPATCH = 4  # of strands: each that is read once a step instead takes twice as long
MAX_LOOPS = 32_768  # of an invocation: some drivers stop silently after twice as many
UNUSED_BYTES = 32  # of what stands for an array that a stage does not read


class Leapfrog:
    """The state of a system on a device: positions at a time, velocities half a step earlier, and what moves them.

    A kick adds acceleration times time to the velocities, a drift adds velocities times time to the positions. Both are
    one dispatch, which reads one copy of the state and writes the other.
    """

    def __init__(self, device: GpuDevice, system: SpringSystem) -> None:
        self.device = device
        self._system = system
        self._inverse_masses = system.inverse_masses
        n_points = system.n_points
        self._slots = pack_slots(system)
        self._fans = pack_fans(system.triangles, n_points)
        self._require_room()
        self._buffers: list[Buffer] = []
        springs = self._slots.springs.reshape(-1, 4)
        self._springs = create_table(device, len(springs), "rgba32uint", "springs")
        self._springs.upload(springs)
        self._masks = self._upload("masks", self._slots.masks)
        self._unused = self._allocate("unused", UNUSED_BYTES)
        self._fan_buffer: Buffer | None = None
        self._force_buffer: Buffer | None = None
        self._pin_buffer: Buffer | None = None
        self._state = PointState(device, n_points)
        self._textures = [self._springs, *self._state.textures]
        self._grid = find_grid(self._slots, n_points, MAX_STRIP_ROWS.get(device.adapter.kind, MAX_STRIP_ROWS_OF_GPU))
        self._grid_state: _GridState | None = None

    def _require_room(self) -> None:
        limits = self.device.limits
        n_texels = (3 if self._slots.kind is Slots.LISTED else 1) * max(self._slots.n_packets, 1)
        most = min(
            limits.max_bound_bytes // max(TEXEL_BYTES, 8 * len(self._fans)),
            limits.max_workgroups * choose_workgroup_size(self.device),
            limits.max_texture_side * TEXELS_PER_ROW // max(n_texels, TEXELS_PER_POINT),
        )
        if self._system.n_points > most:
            expected = f"have at most {most:,} points with so many springs on {self.device.name!r}"
            raise ArgumentError.expecting("model", expected, f"{self._system.n_points:,}")

    def _allocate(self, name: str, n_bytes: int) -> Buffer:
        buffer = Buffer(self.device.context, max(n_bytes, UNUSED_BYTES), label=f"springs: {name}", persistent=True)
        self._buffers.append(buffer)
        return buffer

    def _upload(self, name: str, array: npt.NDArray[np.generic]) -> Buffer:
        buffer = self._allocate(name, array.nbytes)
        if array.nbytes:
            buffer.upload(array)
        return buffer

    def write(self, positions: npt.NDArray[np.float32], velocities: npt.NDArray[np.float32]) -> None:
        """Set the state: (n, 4) each, as `read_state` returns them."""
        self._state.write(positions, velocities)

    def read_state(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Return all that the device holds of positions and velocities: (n, 4) each."""
        return self._state.read()

    def read_positions(self) -> npt.NDArray[np.float32]:
        """Return the positions (n, 3)."""
        n_bytes = 12 * self._system.n_points
        with self.device.lock:
            points = self.device.pool.scratch(POOL_OWNER, "positions", n_bytes)
            self._pack_positions(points)
            with points.map_read(n_bytes) as view:
                return view.view(np.float32).reshape(-1, 3).copy()

    def read_kicked_velocities(self, seconds: float, conditions: FrameConditions) -> npt.NDArray[np.float32]:
        """Return what the velocities (n, 3) would be after a kick of so many seconds; the state stays."""
        with self.device.lock:
            self._run(1, seconds, seconds, 1.0, conditions, begin=None)  # touching the obstacles where they are then
            _, velocities = self._state.read()
            self._state.swap()
            return velocities[:, :3].copy()

    def store_positions(self) -> GpuStore:
        """Return a copy of the positions (n, 3), made on the device."""
        n_points = self._system.n_points
        store = GpuStore.allocate(self.device, (n_points, 3), np.dtype(np.float32))
        with self.device.lock:
            self._pack_positions(store.device_points().buffer)
        return store

    def _pack_positions(self, points: Buffer) -> None:
        """Copy the positions into a buffer (n, 3)."""
        n_points, size = self._system.n_points, choose_workgroup_size(self.device)
        pipeline = self.device.pipelines.compute("pack_positions", workgroup_size=size, n_points=n_points)
        state = self._state.present
        with self.device.encode_commands(state, points, label="springs: copy") as encoder:
            bindings = self.device.bind_groups.bind(pipeline, state=state, points=points)
            dispatch(encoder, pipeline, bindings, -(-n_points // size))

    def write_inverse_masses(self, inverse_masses: npt.NDArray[np.float64]) -> None:
        """Set one over the mass of each point (n,), in 1/kg; 0 for points that no force moves."""
        positions, velocities = self.read_state()
        positions[:, 3] = inverse_masses
        velocities[inverse_masses == 0.0] = 0.0
        self.write(positions, velocities)
        self._inverse_masses = inverse_masses
        if self._grid is not None and self._grid_state is not None:
            self._grid_state.inverse_masses.upload(self._grid.to_blocks(inverse_masses))

    def kick(self, seconds: float, conditions: FrameConditions) -> None:
        """Move the velocities on by `seconds`, or back if it is negative."""
        self._run(1, seconds, 0.0, 0.0, conditions, begin=None)

    def step(self, n_steps: int, step_s: float, conditions: FrameConditions, count: Callable[[int], object]) -> None:
        """Take the steps of a frame, from its first to its last.

        count : called with the number of steps that are submitted, after each submission
        """
        if len(conditions.pins):
            self._place_pins(conditions.pins)
        if self._grid and conditions.forces is None and not conditions.has_drag:
            if self._grid.has_rows:
                self._step_grid(self._grid, n_steps, step_s, conditions, count)
                return
            if _count_loops(self._grid, conditions) <= MAX_LOOPS:
                self._step_strands(self._grid, n_steps, step_s, conditions, count)
                return
        for first in range(0, n_steps, MAX_STEPS_PER_SUBMISSION):
            n = min(MAX_STEPS_PER_SUBMISSION, n_steps - first)
            self._run(n, step_s, step_s, 1.0 / n_steps, conditions, begin=first == 0, count=count)

    def _run(
        self,
        n_steps: int,
        kick_s: float,
        drift_s: float,
        frame_part: float,
        conditions: FrameConditions,
        *,
        begin: bool | None,
        count: Callable[[int], object] = lambda _: None,
    ) -> None:
        """Submit steps; `begin` says whether the first is the first of its frame, None that it is no step of one."""
        with self.device.lock:
            pipeline = self._pipeline(conditions)
            structs, obstacles = self._upload_conditions(
                conditions, kick_s, drift_s, frame_part, is_first=begin is not False
            )
            [packets] = uniforms.upload(
                self.device, POOL_OWNER, "packets", [_fill(MAX_PACKETS, SLOT_PACKET, self._slots.packets)]
            )
            fixed: dict[str, Bindable] = {
                "obstacles": obstacles,
                "packets": packets,
                "springs": self._springs,
                "masks": self._masks,
                "fans": self._fans_on_device() if conditions.has_drag else self._unused,
                "forces": self._forces_on_device(conditions.forces),
            }
            groups = [
                [
                    self.device.bind_groups.bind(
                        pipeline,
                        spring_step=struct,
                        **self._state.bindings(turn),
                        **fixed,
                    )
                    for turn in range(2)
                ]
                for struct in structs
            ]
            n_workgroups = -(-self._system.n_points // choose_workgroup_size(self.device))
            with self.device.encode_commands(*self._buffers, *self._textures, label="springs") as encoder:
                for k in range(n_steps):
                    dispatch(encoder, pipeline, groups[min(k, 1)][k % 2], n_workgroups)
                self._state.swap(n_steps)
                count(n_steps)

    def _upload_conditions(
        self, conditions: FrameConditions, kick_s: float, drift_s: float, frame_part: float, *, is_first: bool
    ) -> tuple[list[Binding], Binding]:
        """Upload what acts during steps: a struct for the first of them and one for the others, and the obstacles."""
        step = conditions.step.copy()
        step["kick_s"], step["drift_s"], step["frame_part"] = kick_s, drift_s, frame_part
        first_step = step.copy()
        first_step["is_first"] = is_first
        structs = uniforms.upload(self.device, POOL_OWNER, "steps", [first_step, step])
        [obstacles] = uniforms.upload(
            self.device, POOL_OWNER, "obstacles", [_fill(MAX_OBSTACLES, OBSTACLE, conditions.obstacles)]
        )
        return structs, obstacles

    def _step_grid(
        self, grid: Grid, n_steps: int, step_s: float, conditions: FrameConditions, count: Callable[[int], object]
    ) -> None:
        """Take the steps of a frame in blocks of columns, and put the result back."""
        pipelines = self.device.pipelines
        with self.device.lock:
            if self._grid_state is None:
                self._grid_state = _GridState(self, grid)
            state = self._grid_state
            structs, obstacles = self._upload_conditions(conditions, step_s, step_s, 1.0 / n_steps, is_first=True)
            [layout] = uniforms.upload(self.device, POOL_OWNER, "grid", [grid.struct()])
            pipeline = pipelines.compute(
                "step_grid",
                workgroup_size=GRID_WORKGROUP_SIZE,
                rows_per_strip=grid.rows_per_strip,
                n_obstacles=len(conditions.obstacles),
                has_damping=self._system.damping_s > 0.0,
            )
            groups = [
                [
                    self.device.bind_groups.bind(
                        pipeline,
                        spring_step=struct,
                        grid=layout,
                        obstacles=obstacles,
                        inverse_masses=state.inverse_masses,
                        positions=state.positions[source],
                        velocities=state.velocities[source],
                        next_positions=state.positions[source ^ 1],
                        next_velocities=state.velocities[source ^ 1],
                        step_counts=state.step_counts,
                    )
                    for source in range(2)
                ]
                for struct in structs
            ]
            n_workgroups = -(-grid.n_blocks * grid.n_strips // GRID_WORKGROUP_SIZE)
            source = 0
            for first in range(0, n_steps, MAX_STEPS_PER_SUBMISSION):
                n = min(MAX_STEPS_PER_SUBMISSION, n_steps - first)
                used: list[Submittable] = [*self._buffers, *self._textures]
                with self.device.encode_commands(*used, label="springs: grid") as encoder:
                    self._copy_grid(encoder, "pack_grid", layout, state, source)
                    for k in range(n):
                        dispatch(encoder, pipeline, groups[0 if first + k == 0 else 1][source], n_workgroups)
                        source ^= 1
                    self._copy_grid(encoder, "unpack_grid", layout, state, source, inverse_masses=state.inverse_masses)
                    count(n)

    def _step_strands(
        self, grid: Grid, n_steps: int, step_s: float, conditions: FrameConditions, count: Callable[[int], object]
    ) -> None:
        """Take the steps of a frame, several in each dispatch."""
        pipelines = self.device.pipelines
        with self.device.lock:
            structs, obstacles = self._upload_conditions(conditions, step_s, step_s, 1.0 / n_steps, is_first=True)
            [layout] = uniforms.upload(self.device, POOL_OWNER, "grid", [grid.struct()])
            n_workgroups = -(-grid.n_columns // STRANDS_PER_WORKGROUP)
            for first in range(0, n_steps, MAX_STEPS_PER_SUBMISSION):
                n = min(MAX_STEPS_PER_SUBMISSION, n_steps - first)
                with self.device.encode_commands(*self._buffers, *self._textures, label="springs: strands") as encoder:
                    for start in range(first, first + n, MAX_STEPS_PER_DISPATCH):
                        pipeline = pipelines.compute(
                            "step_strands",
                            workgroup_size=STRANDS_PER_WORKGROUP,
                            n_steps=min(MAX_STEPS_PER_DISPATCH, first + n - start),
                            n_obstacles=len(conditions.obstacles),
                            has_damping=self._system.damping_s > 0.0,
                        )
                        group = self.device.bind_groups.bind(
                            pipeline,
                            spring_step=structs[min(start, 1)],
                            grid=layout,
                            obstacles=obstacles,
                            **self._state.bindings(0),
                        )
                        dispatch(encoder, pipeline, group, n_workgroups)
                        self._state.swap()
                    count(n)

    def _copy_grid(
        self,
        encoder: CommandEncoder,
        stage: str,
        layout: Binding,
        grid_state: "_GridState",
        source: int,
        **more: Bindable,
    ) -> None:
        """Encode a copy of the state into blocks, or back."""
        size = choose_workgroup_size(self.device)
        pipeline = self.device.pipelines.compute(stage, workgroup_size=size)
        bindings = self.device.bind_groups.bind(
            pipeline,
            grid=layout,
            state=self._state.present,
            grid_positions=grid_state.positions[source],
            grid_velocities=grid_state.velocities[source],
            **more,
        )
        dispatch(encoder, pipeline, bindings, -(-self._system.n_points // size))

    def _pipeline(self, conditions: FrameConditions) -> ComputePipeline:
        return self.device.pipelines.compute(
            "step_springs",
            workgroup_size=choose_workgroup_size(self.device),
            n_packets=self._slots.n_packets,
            slots=self._slots.kind,
            n_fans=len(self._fans) if conditions.has_drag else 0,
            has_damping=self._system.damping_s > 0.0,
            has_forces=conditions.forces is not None,
            n_obstacles=len(conditions.obstacles),
        )

    def _fans_on_device(self) -> Buffer:
        if self._fan_buffer is None:
            self._fan_buffer = self._upload("fans", self._fans)
        return self._fan_buffer

    def _forces_on_device(self, forces: npt.NDArray[np.float64] | None) -> Buffer:
        if forces is None:
            return self._unused
        if self._force_buffer is None:
            self._force_buffer = self._allocate("forces", 16 * self._system.n_points)
        padded = np.zeros((self._system.n_points, 4), np.float32)
        padded[:, :3] = forces
        self._force_buffer.upload(padded)
        return self._force_buffer

    def _place_pins(self, pins: npt.NDArray[np.void]) -> None:
        with self.device.lock:
            if self._pin_buffer is None:
                self._pin_buffer = self._allocate("pins", pins.nbytes)
            self._pin_buffer.upload(as_bytes(pins))
            size = choose_workgroup_size(self.device)
            pipeline = self.device.pipelines.compute("place_pins", workgroup_size=size)
            state = self._state.present
            with self.device.encode_commands(self._pin_buffer, state, label="springs: pins") as encoder:
                bindings = self.device.bind_groups.bind(pipeline, pins=self._pin_buffer, state=state)
                dispatch(encoder, pipeline, bindings, -(-len(pins) // size))


class _GridState:
    """The buffers of a grid in blocks of columns."""

    def __init__(self, owner: Leapfrog, grid: Grid) -> None:
        blocks = grid.to_blocks(owner._inverse_masses)
        zeros = np.zeros((3, *blocks.shape), np.float32)
        self.inverse_masses = owner._upload("grid: inverse masses", blocks)
        self.positions = [owner._upload("grid: positions", zeros) for _ in range(2)]
        self.velocities = [owner._upload("grid: velocities", zeros) for _ in range(2)]
        self.step_counts = owner._allocate("grid: step counts", 4 * grid.n_blocks * grid.n_strips)


def _count_loops(strands: Grid, conditions: FrameConditions) -> int:
    """Return how often an invocation that goes down a strand runs through loops."""
    n_ticks = strands.n_rows + 2 * MAX_STEPS_PER_DISPATCH
    return n_ticks * (1 + MAX_STEPS_PER_DISPATCH * len(conditions.obstacles))


def _fill(n: int, dtype: np.dtype[np.void], structs: npt.NDArray[np.void]) -> npt.NDArray[np.uint8]:
    """Return the bytes of an array of n structs, of which the first are given."""
    filled = np.zeros(n, dtype)
    filled[: len(structs)] = structs
    return as_bytes(filled)
