"""Springs by other libraries: the same points, springs, dampers, gravity and leapfrog steps, as each is used."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import gpu_xform as gx

Array = npt.NDArray[np.float64]
GRAVITY = -9.81


@dataclass(frozen=True)
class Problem:
    """Points (n, 3), some of them pinned, and springs (s, 2) between them; velocities are those half a step ago."""

    points: Array
    velocities: Array
    inverse_masses: Array
    pairs: npt.NDArray[np.int64]
    stiffness: Array
    rest: Array
    damping: Array
    dt: float


@dataclass(frozen=True)
class Peer:
    """`run(n)` takes n steps; `positions` returns (n, 3)."""

    run: Callable[[int], object]
    positions: Callable[[], npt.NDArray[Any]]


def problem_of(springs: gx.Springs, dt: float) -> Problem:
    """Return what `springs` is at its start, flat and at rest, for peers that begin with a whole kick."""
    inverse_masses = np.where(springs.pinned, 0.0, 1.0 / springs.masses)
    velocities = np.zeros((springs.n_points, 3))
    velocities[:, 1] = np.where(springs.pinned, 0.0, -GRAVITY * dt / 2.0)
    return Problem(
        springs.positions.astype(np.float64),
        velocities,
        inverse_masses,
        springs.springs,
        springs.stiffness,
        springs.rest,
        springs.damping * springs.stiffness,
        dt,
    )


def scipy_sparse(problem: Problem) -> Peer:
    """Differences along springs, and sums at points, as products with a sparse incidence matrix, in float64."""
    import scipy.sparse

    n, s = len(problem.points), len(problem.pairs)
    rows = np.repeat(np.arange(s), 2)
    incidence = scipy.sparse.csr_array((np.tile([-1.0, 1.0], s), (rows, problem.pairs.ravel())), shape=(s, n))
    transposed = incidence.T.tocsr()
    x, v = problem.points.copy(), problem.velocities.copy()
    w, gravity = problem.inverse_masses[:, None], np.array([0.0, GRAVITY, 0.0]) * (problem.inverse_masses[:, None] > 0)

    def run(n_steps: int) -> None:
        for _ in range(n_steps):
            d, u = incidence @ x, incidence @ v
            length = np.sqrt(np.einsum("ij,ij->i", d, d))
            rate = np.einsum("ij,ij->i", d, u) / length
            force = ((problem.stiffness * (length - problem.rest) + problem.damping * rate) / length)[:, None] * d
            v[:] += problem.dt * (gravity - w * (transposed @ force))
            x[:] += problem.dt * v

    return Peer(run, lambda: x)


def warp_kernels(problem: Problem) -> Peer:
    """Use two Warp kernels, as its examples do: springs add to both ends by atomics, then points are integrated."""
    wp: Any = importlib.import_module("warp")

    wp.config.quiet = True
    wp.init()

    @wp.kernel  # type: ignore[untyped-decorator, unused-ignore]
    def pull(
        x: wp.array(dtype=wp.vec3),  # type: ignore[valid-type]
        v: wp.array(dtype=wp.vec3),  # type: ignore[valid-type]
        ends: wp.array(dtype=wp.int32),  # type: ignore[valid-type]
        rest: wp.array(dtype=float),  # type: ignore[valid-type]
        ke: wp.array(dtype=float),  # type: ignore[valid-type]
        kd: wp.array(dtype=float),  # type: ignore[valid-type]
        f: wp.array(dtype=wp.vec3),  # type: ignore[valid-type]
    ) -> None:
        tid = wp.tid()
        i = ends[tid * 2]
        j = ends[tid * 2 + 1]
        xij = x[i] - x[j]
        vij = v[i] - v[j]
        length = wp.length(xij)
        direction = xij * (1.0 / length)
        force = direction * (ke[tid] * (length - rest[tid]) + kd[tid] * wp.dot(direction, vij))
        wp.atomic_sub(f, i, force)
        wp.atomic_add(f, j, force)

    @wp.kernel  # type: ignore[untyped-decorator, unused-ignore]
    def integrate(
        x: wp.array(dtype=wp.vec3),  # type: ignore[valid-type]
        v: wp.array(dtype=wp.vec3),  # type: ignore[valid-type]
        f: wp.array(dtype=wp.vec3),  # type: ignore[valid-type]
        w: wp.array(dtype=float),  # type: ignore[valid-type]
        gravity: wp.vec3,
        dt: float,
    ) -> None:
        tid = wp.tid()
        inverse_mass = w[tid]
        v1 = v[tid] + (f[tid] * inverse_mass + gravity * wp.step(-inverse_mass)) * dt
        v[tid] = v1
        x[tid] = x[tid] + v1 * dt

    def array(values: npt.NDArray[Any], dtype: Any) -> Any:
        return wp.array(values, dtype=dtype, device="cpu")

    x = array(problem.points.astype(np.float32), wp.vec3)
    v = array(problem.velocities.astype(np.float32), wp.vec3)
    f = array(np.zeros_like(problem.points, np.float32), wp.vec3)
    ends = array(problem.pairs.astype(np.int32).ravel(), wp.int32)
    rest, ke, kd, w = (
        array(values.astype(np.float32), float)
        for values in (problem.rest, problem.stiffness, problem.damping, problem.inverse_masses)
    )
    gravity = wp.vec3(0.0, GRAVITY, 0.0)

    def run(n_steps: int) -> None:
        for _ in range(n_steps):
            f.zero_()
            wp.launch(pull, dim=len(problem.pairs), inputs=[x, v, ends, rest, ke, kd], outputs=[f], device="cpu")
            wp.launch(integrate, dim=len(problem.points), inputs=[x, v, f, w, gravity, problem.dt], device="cpu")

    return Peer(run, x.numpy)


def newton_semi_implicit(problem: Problem) -> Peer:
    """Newton's `SolverSemiImplicit`, on the CPU."""
    newton: Any = importlib.import_module("newton")

    builder = newton.ModelBuilder(up_axis=newton.Axis.Y, gravity=(0.0, GRAVITY, 0.0))
    masses = np.where(problem.inverse_masses > 0.0, 1.0 / np.maximum(problem.inverse_masses, 1e-30), 0.0)
    for point, velocity, mass in zip(problem.points, problem.velocities, masses, strict=True):
        builder.add_particle(pos=tuple(point), vel=tuple(velocity), mass=float(mass), radius=1e-4)
    for (i, j), ke, kd in zip(problem.pairs.tolist(), problem.stiffness, problem.damping, strict=True):
        builder.add_spring(i, j, float(ke), float(kd), 0.0)
    builder.spring_rest_length[:] = problem.rest.tolist()
    model = builder.finalize(device="cpu")
    solver = newton.solvers.SolverSemiImplicit(model)
    states = [model.state(), model.state()]
    control = model.control()

    def run(n_steps: int) -> None:
        for _ in range(n_steps):
            states[0].clear_forces()
            solver.step(states[0], states[1], control, None, problem.dt)
            states.reverse()

    return Peer(run, lambda: states[0].particle_q.numpy())


def taichi_scatter(problem: Problem) -> Peer:
    """Two Taichi kernels: springs add to both ends by atomics, then points are integrated."""
    ti: Any = importlib.import_module("taichi")

    ti.init(arch=ti.cpu, log_level=ti.ERROR, offline_cache=False)
    n, s = len(problem.points), len(problem.pairs)
    x, v, f = (ti.Vector.field(3, ti.f32, n) for _ in range(3))
    ends = ti.Vector.field(2, ti.i32, s)
    rest, ke, kd = (ti.field(ti.f32, s) for _ in range(3))
    w = ti.field(ti.f32, n)
    given = (x, problem.points), (v, problem.velocities), (rest, problem.rest), (ke, problem.stiffness)
    for field, values in (*given, (kd, problem.damping), (w, problem.inverse_masses)):
        field.from_numpy(values.astype(np.float32))
    ends.from_numpy(problem.pairs.astype(np.int32))
    dt, gravity = problem.dt, GRAVITY

    @ti.kernel  # type: ignore[untyped-decorator, unused-ignore]
    def step():  # type: ignore[no-untyped-def, unused-ignore]  # Taichi reads annotations
        for i in f:
            f[i] = ti.Vector([0.0, 0.0, 0.0])
        for k in ends:
            i, j = ends[k][0], ends[k][1]
            d = x[j] - x[i]
            length = d.norm()
            u = d / length
            force = (ke[k] * (length - rest[k]) + kd[k] * (v[j] - v[i]).dot(u)) * u
            f[i] += force
            f[j] -= force
        for i in x:
            if w[i] > 0.0:
                v[i] += dt * (w[i] * f[i] + ti.Vector([0.0, gravity, 0.0]))
            x[i] += dt * v[i]

    def run(n_steps: int) -> None:
        for _ in range(n_steps):
            step()

    return Peer(run, x.to_numpy)


def numba_lists(problem: Problem) -> Peer:
    """Use a Numba kernel for any springs, which gathers those of each point from lists, points in parallel."""
    numba: Any = importlib.import_module("numba")

    n = len(problem.points)
    points, others = problem.pairs.T.ravel(), problem.pairs[:, ::-1].T.ravel()
    order = np.argsort(points, kind="stable")
    spring = np.tile(np.arange(len(problem.pairs)), 2)[order]
    starts = np.append(0, np.cumsum(np.bincount(points, minlength=n))).astype(np.int32)
    ends = others[order].astype(np.int32)
    ke, kd, rest = (values[spring].astype(np.float32) for values in (problem.stiffness, problem.damping, problem.rest))
    dt, gravity, one, zero = (np.float32(value) for value in (problem.dt, GRAVITY, 1.0, 0.0))

    @numba.njit(parallel=True, fastmath=True)  # type: ignore[untyped-decorator, unused-ignore]
    def step(x: Any, v: Any, w: Any, next_x: Any, next_v: Any) -> None:
        for i in numba.prange(n):
            fx = fy = fz = zero
            for q in range(starts[i], starts[i + 1]):
                j = ends[q]
                dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
                il = one / np.sqrt(dx * dx + dy * dy + dz * dz)
                rate = dx * (v[j, 0] - v[i, 0]) + dy * (v[j, 1] - v[i, 1]) + dz * (v[j, 2] - v[i, 2])
                t = ke[q] * (one - rest[q] * il) + kd[q] * il * il * rate
                fx += t * dx
                fy += t * dy
                fz += t * dz
            free = one if w[i] > zero else zero
            vx, vy = v[i, 0] + dt * w[i] * fx, v[i, 1] + dt * (w[i] * fy + free * gravity)
            vz = v[i, 2] + dt * w[i] * fz
            next_v[i, 0], next_v[i, 1], next_v[i, 2] = vx, vy, vz
            next_x[i, 0], next_x[i, 1], next_x[i, 2] = x[i, 0] + dt * vx, x[i, 1] + dt * vy, x[i, 2] + dt * vz

    states = [[values.astype(np.float32) for values in (problem.points, problem.velocities)] for _ in range(2)]
    w = problem.inverse_masses.astype(np.float32)

    def run(n_steps: int) -> None:
        for _ in range(n_steps):
            step(*states[0], w, *states[1])
            states.reverse()

    return Peer(run, lambda: states[0][0])


def numba_gather(problem: Problem, n_strands: int, n_points: int) -> Peer:
    """Use a Numba kernel for strands of equal springs to the next points and those after, strands in parallel."""
    numba: Any = importlib.import_module("numba")

    stretch, bend = (float(problem.stiffness[k]) for k in (0, -1))
    first, second = (float(problem.rest[k]) for k in (0, -1))
    beta = float(problem.damping[0]) / stretch
    dt = np.float32(problem.dt)
    single = np.float32

    @numba.njit(parallel=True, fastmath=True)  # type: ignore[untyped-decorator, unused-ignore]
    def step(x: Any, v: Any, w: Any, next_x: Any, next_v: Any) -> None:
        for strand in numba.prange(n_strands):
            for place in range(n_points):
                i = strand * n_points + place
                fx = fy = fz = single(0.0)
                for shift in (-2, -1, 1, 2):
                    if 0 <= place + shift < n_points:
                        j = i + shift
                        k = single(stretch) if abs(shift) == 1 else single(bend)
                        r = single(first) if abs(shift) == 1 else single(second)
                        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
                        il = single(1.0) / np.sqrt(dx * dx + dy * dy + dz * dz)
                        t = k * (single(1.0) - r * il)
                        rate = dx * (v[j, 0] - v[i, 0]) + dy * (v[j, 1] - v[i, 1]) + dz * (v[j, 2] - v[i, 2])
                        t += single(beta) * k * il * il * rate
                        fx += t * dx
                        fy += t * dy
                        fz += t * dz
                free = single(1.0) if w[i] > 0.0 else single(0.0)
                vx, vy = v[i, 0] + dt * w[i] * fx, v[i, 1] + dt * (w[i] * fy + free * single(GRAVITY))
                vz = v[i, 2] + dt * w[i] * fz
                next_v[i, 0], next_v[i, 1], next_v[i, 2] = vx, vy, vz
                next_x[i, 0], next_x[i, 1], next_x[i, 2] = x[i, 0] + dt * vx, x[i, 1] + dt * vy, x[i, 2] + dt * vz

    states = [[values.astype(np.float32) for values in (problem.points, problem.velocities)] for _ in range(2)]
    w = problem.inverse_masses.astype(np.float32)

    def run(n_steps: int) -> None:
        for _ in range(n_steps):
            step(*states[0], w, *states[1])
            states.reverse()

    return Peer(run, lambda: states[0][0])
