"""The loops of leapfrog steps. Each point is computed as wgsl/simulation/step_springs.wgsl computes it.

A state holds x, y, z and the velocity's x, y, z along its first axis, and points, after `pad` empty ones, along its
second. Steps go from one state to the other and back. Blocks of points are computed by any thread: what a point gets
does not depend on its block.
"""

from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from ...compute.host.compile import compile_function, compile_loop
from .constants import (
    ANGULAR_VELOCITY,
    CENTER_AFTER,
    CENTER_BEFORE,
    DAMPING_S,
    DRAG_RATE,
    DRIFT_S,
    FACE_DRAG,
    FRAME_PART,
    FRICTION,
    GAP,
    GRAVITY,
    HALF_SIZE,
    IS_HALF_SPACE,
    KICK_S,
    ONE,
    RADIUS,
    ROTATION_AFTER,
    ROTATION_BEFORE,
    THREE,
    TINY,
    TWO,
    VELOCITY,
    WIND,
    ZERO,
)

Array = npt.NDArray[Any]


@compile_function
def pull_ahead(
    state: Array, first: int, n: int, shift: int, k: Any, rest: Any, damping: Any, is_used: Array, out: Array
) -> None:
    """Write the forces (3, n) of springs from `n` points, the first of which is given, to those `shift` ahead."""
    end, first1, end1 = first + n, first + shift, first + n + shift
    x, y, z = state[0, first:end], state[1, first:end], state[2, first:end]
    u, v, w = state[3, first:end], state[4, first:end], state[5, first:end]
    x1, y1, z1 = state[0, first1:end1], state[1, first1:end1], state[2, first1:end1]
    u1, v1, w1 = state[3, first1:end1], state[4, first1:end1], state[5, first1:end1]
    used = is_used[first:end]
    for i in range(n):
        dx, dy, dz = x1[i] - x[i], y1[i] - y[i], z1[i] - z[i]
        square = dx * dx + dy * dy + dz * dz
        inverse_length = ONE / np.sqrt(square if square > TINY else TINY)
        rate = dx * (u1[i] - u[i]) + dy * (v1[i] - v[i]) + dz * (w1[i] - w[i])
        tension = k * (ONE - rest * inverse_length) + damping * k * inverse_length * inverse_length * rate
        tension = tension if used[i] else ZERO
        out[0, i], out[1, i], out[2, i] = tension * dx, tension * dy, tension * dz


@compile_function
def drag_faces(state: Array, first: int, n: int, pad: int, fans: Array, c: Array, forces: Array) -> None:
    """Add the drag of the air on the triangles around each point to `forces` (3, n)."""
    for i in range(n):
        at = first + i
        x, y, z = state[0, at], state[1, at], state[2, at]
        for fan in range(len(fans)):
            a, b = fans[fan, at - pad, 0] + pad, fans[fan, at - pad, 1] + pad
            ax, ay, az = state[0, a] - x, state[1, a] - y, state[2, a] - z
            bx, by, bz = state[0, b] - x, state[1, b] - y, state[2, b] - z
            nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            square = nx * nx + ny * ny + nz * nz
            if square > ZERO:
                u = c[WIND] - (state[3, at] + state[3, a] + state[3, b]) / THREE
                v = c[WIND + 1] - (state[4, at] + state[4, a] + state[4, b]) / THREE
                w = c[WIND + 2] - (state[5, at] + state[5, a] + state[5, b]) / THREE
                speed = (u * nx + v * ny + w * nz) * (ONE / np.sqrt(square))
                pressure = c[FACE_DRAG] * speed * abs(speed)
                forces[0, i] += pressure * nx
                forces[1, i] += pressure * ny
                forces[2, i] += pressure * nz


@compile_function
def kick_and_drift(state: Array, out: Array, first: int, n: int, pad: int, w: Array, c: Array, forces: Array) -> None:
    """Write what forces (3, n) make of points into `out`; the `w` (n,) of all are one over their masses."""
    kick, drift, drag = c[KICK_S], c[DRIFT_S], c[DRAG_RATE]
    masses = w[first - pad : first - pad + n]
    for axis in range(3):
        gravity, wind = c[GRAVITY + axis], c[WIND + axis]
        for i in range(n):
            v = state[3 + axis, first + i]
            moved = v + kick * (masses[i] * forces[axis, i] + gravity + drag * (wind - v))
            v = moved if masses[i] > ZERO else v
            out[3 + axis, first + i] = v
            out[axis, first + i] = state[axis, first + i] + drift * v


@compile_function
def rotate_by(qx: Any, qy: Any, qz: Any, qw: Any, x: Any, y: Any, z: Any) -> Any:
    """Return a vector turned by a unit quaternion."""
    tx, ty, tz = TWO * (qy * z - qz * y), TWO * (qz * x - qx * z), TWO * (qx * y - qy * x)
    return (
        x + qw * tx + (qy * tz - qz * ty),
        y + qw * ty + (qz * tx - qx * tz),
        z + qw * tz + (qx * ty - qy * tx),
    )


@compile_function
def surface_distance(o: Array, x: Any, y: Any, z: Any) -> Any:
    """Return the outer normal at the surface point closest to a point of the obstacle's frame, and the distance."""
    if o[IS_HALF_SPACE] != ZERO:
        return ZERO, ONE, ZERO, y
    dx, dy, dz = abs(x) - o[HALF_SIZE], abs(y) - o[HALF_SIZE + 1], abs(z) - o[HALF_SIZE + 2]
    sx, sy, sz = ONE if x >= ZERO else -ONE, ONE if y >= ZERO else -ONE, ONE if z >= ZERO else -ONE
    ex, ey, ez = dx if dx > ZERO else ZERO, dy if dy > ZERO else ZERO, dz if dz > ZERO else ZERO
    square = ex * ex + ey * ey + ez * ez
    if square > ZERO:
        length = np.sqrt(square)
        return sx * ex / length, sy * ey / length, sz * ez / length, length - o[RADIUS]
    if dx >= dy and dx >= dz:
        return sx, ZERO, ZERO, dx - o[RADIUS]
    if dy >= dz:
        return ZERO, sy, ZERO, dy - o[RADIUS]
    return ZERO, ZERO, sz, dz - o[RADIUS]


@compile_function
def collide(o: Array, time: Any, drift: Any, x: Any, y: Any, z: Any, u: Any, v: Any, w: Any) -> Any:
    """Return a particle pushed out of an obstacle, as `collide` in wgsl/shared/obstacle.wgsl."""
    left = ONE - time
    qx = o[ROTATION_BEFORE] * left + o[ROTATION_AFTER] * time
    qy = o[ROTATION_BEFORE + 1] * left + o[ROTATION_AFTER + 1] * time
    qz = o[ROTATION_BEFORE + 2] * left + o[ROTATION_AFTER + 2] * time
    qw = o[ROTATION_BEFORE + 3] * left + o[ROTATION_AFTER + 3] * time
    norm = np.sqrt(qx * qx + qy * qy + qz * qz + qw * qw)
    qx, qy, qz, qw = qx / norm, qy / norm, qz / norm, qw / norm
    ax = x - (o[CENTER_BEFORE] * left + o[CENTER_AFTER] * time)
    ay = y - (o[CENTER_BEFORE + 1] * left + o[CENTER_AFTER + 1] * time)
    az = z - (o[CENTER_BEFORE + 2] * left + o[CENTER_AFTER + 2] * time)
    lx, ly, lz = rotate_by(-qx, -qy, -qz, qw, ax, ay, az)
    nx, ny, nz, distance = surface_distance(o, lx, ly, lz)
    if distance >= o[GAP]:
        return x, y, z, u, v, w
    nx, ny, nz = rotate_by(qx, qy, qz, qw, nx, ny, nz)
    wx, wy, wz = o[ANGULAR_VELOCITY], o[ANGULAR_VELOCITY + 1], o[ANGULAR_VELOCITY + 2]
    ru = u - (o[VELOCITY] + (wy * az - wz * ay))
    rv = v - (o[VELOCITY + 1] + (wz * ax - wx * az))
    rw = w - (o[VELOCITY + 2] + (wx * ay - wy * ax))
    approach = ru * nx + rv * ny + rw * nz
    su, sv, sw = ru - approach * nx, rv - approach * ny, rw - approach * nz
    speed = np.sqrt(su * su + sv * sv + sw * sw)
    part = ZERO
    if approach < ZERO and speed > ZERO:
        part = -o[FRICTION] * approach / speed
        part = part if part < ONE else ONE
    inwards = approach if approach < ZERO else ZERO
    depth = o[GAP] - distance
    return (
        x + depth * nx - drift * (part * su),
        y + depth * ny - drift * (part * sv),
        z + depth * nz - drift * (part * sw),
        u - inwards * nx - part * su,
        v - inwards * ny - part * sv,
        w - inwards * nz - part * sw,
    )


@compile_function
def finish(
    state: Array,
    out: Array,
    first: int,
    n: int,
    pad: int,
    step: int,
    w: Array,
    given: Array,
    fans: Array,
    obstacles: Array,
    c: Array,
    forces: Array,
) -> None:
    """Write a block of points after a step into `out`; `forces` (3, n) holds those of its springs."""
    if len(fans):
        drag_faces(state, first, n, pad, fans, c, forces)
    if len(given):
        for axis in range(3):
            for i in range(n):
                forces[axis, i] += given[first - pad + i, axis]
    kick_and_drift(state, out, first, n, pad, w, c, forces)
    if len(obstacles):
        time = np.float32(step + 1) * c[FRAME_PART]
        for i in range(first, first + n):
            if w[i - pad] > ZERO:
                x, y, z, u, v, q = out[0, i], out[1, i], out[2, i], out[3, i], out[4, i], out[5, i]
                for k in range(len(obstacles)):
                    x, y, z, u, v, q = collide(obstacles[k], time, c[DRIFT_S], x, y, z, u, v, q)
                out[0, i], out[1, i], out[2, i], out[3, i], out[4, i], out[5, i] = x, y, z, u, v, q


@compile_function
def shift_block(
    state: Array,
    out: Array,
    step: int,
    first: int,
    n: int,
    pad: int,
    shifts: Array,
    stiffness: Array,
    rest: Array,
    is_used: Array,
    w: Array,
    given: Array,
    fans: Array,
    obstacles: Array,
    c: Array,
) -> None:
    """Write a block of points after a step into `out`, as `step_shifted` says."""
    forces = np.zeros((3, n), np.float32)
    pulls = np.empty((3, n + pad), np.float32)
    for s in range(len(shifts)):
        shift, k, length = shifts[s], stiffness[s], rest[s]
        pull_ahead(state, first - shift, n + shift, shift, k, length, c[DAMPING_S], is_used[s], pulls)
        for axis in range(3):
            for i in range(n):
                forces[axis, i] += pulls[axis, i + shift]
            for i in range(n):
                forces[axis, i] -= pulls[axis, i]
    finish(state, out, first, n, pad, step, w, given, fans, obstacles, c, forces)


@compile_loop
def step_shifted(
    state: Array,
    other: Array,
    first_step: int,
    n_steps: int,
    starts: Array,
    pad: int,
    shifts: Array,
    stiffness: Array,
    rest: Array,
    is_used: Array,
    w: Array,
    given: Array,
    fans: Array,
    obstacles: Array,
    c: Array,
) -> None:
    """Take steps of springs in slots that are alike for all points: (s,) shifts ahead, stiffnesses and rest lengths.

    starts : where each block of points begins, and where the last ends
    is_used : (s, points) whether the spring is there
    """
    springs = shifts, stiffness, rest, is_used
    for step in range(first_step, first_step + n_steps):
        if len(starts) == 2:  # one block: waking threads would take longer than it does
            shift_block(state, other, step, pad, starts[1], pad, *springs, w, given, fans, obstacles, c)
        else:
            for block in numba.prange(len(starts) - 1):
                first, n = starts[block] + pad, starts[block + 1] - starts[block]
                shift_block(state, other, step, first, n, pad, *springs, w, given, fans, obstacles, c)
        state, other = other, state


@compile_function
def list_block(
    state: Array,
    out: Array,
    step: int,
    first: int,
    n: int,
    n_slots: int,
    ends: Array,
    stiffness: Array,
    rest: Array,
    w: Array,
    given: Array,
    fans: Array,
    obstacles: Array,
    c: Array,
) -> None:
    """Write a block of points after a step into `out`, as `step_listed` says."""
    forces = np.zeros((3, n), np.float32)
    d = np.empty((4, n), np.float32)  # what each spring leads along, and how fast it grows times its length
    for s in range(n_slots):
        end = ends[s, first : first + n]
        for i in range(n):
            a, b = first + i, end[i]
            dx, dy, dz = state[0, b] - state[0, a], state[1, b] - state[1, a], state[2, b] - state[2, a]
            d[0, i], d[1, i], d[2, i] = dx, dy, dz
            d[3, i] = (
                dx * (state[3, b] - state[3, a]) + dy * (state[4, b] - state[4, a]) + dz * (state[5, b] - state[5, a])
            )
        ks, rests = stiffness[s, first : first + n], rest[s, first : first + n]
        for i in range(n):
            dx, dy, dz, k = d[0, i], d[1, i], d[2, i], ks[i]
            square = dx * dx + dy * dy + dz * dz
            inverse_length = ONE / np.sqrt(square if square > TINY else TINY)
            tension = (
                k * (ONE - rests[i] * inverse_length) + c[DAMPING_S] * k * inverse_length * inverse_length * d[3, i]
            )
            forces[0, i] += tension * dx
            forces[1, i] += tension * dy
            forces[2, i] += tension * dz
    finish(state, out, first, n, 0, step, w, given, fans, obstacles, c, forces)


@compile_loop
def step_listed(
    state: Array,
    other: Array,
    first_step: int,
    n_steps: int,
    starts: Array,
    n_slots: Array,
    ends: Array,
    stiffness: Array,
    rest: Array,
    w: Array,
    given: Array,
    fans: Array,
    obstacles: Array,
    c: Array,
) -> None:
    """Take steps of springs in lists: other ends, stiffnesses and rest lengths (s, points) by slot.

    starts : where each block of points begins, and where the last ends
    n_slots : how many slots the points of each block use
    """
    springs = ends, stiffness, rest
    for step in range(first_step, first_step + n_steps):
        if len(starts) == 2:  # one block: waking threads would take longer than it does
            list_block(state, other, step, 0, starts[1], n_slots[0], *springs, w, given, fans, obstacles, c)
        else:
            for block in numba.prange(len(starts) - 1):
                first, n = starts[block], starts[block + 1] - starts[block]
                list_block(state, other, step, first, n, n_slots[block], *springs, w, given, fans, obstacles, c)
        state, other = other, state
