"""Leapfrog steps in NumPy, for machines without numba.

Each function does to all points what its twin in `loops.py` does to one after another, with the same products and sums
in the same order: the bytes are the same.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

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


def step_shifted(
    state: Array,
    other: Array,
    first_step: int,
    n_steps: int,
    _starts: Array,
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
    """Take steps of springs in slots that are alike for all points; see `loops.step_shifted`."""
    n = len(w)
    for step in range(first_step, first_step + n_steps):
        forces = np.zeros((3, n), np.float32)
        for shift, k, length, used in zip(shifts.tolist(), stiffness, rest, is_used, strict=True):
            here, there = slice(pad - shift, pad + n), slice(pad, pad + n + shift)
            d = state[:3, there] - state[:3, here]
            rate = _dot(d, state[3:6, there] - state[3:6, here])
            pulls = np.where(used[here], _tension(d, rate, k, length, c[DAMPING_S]), ZERO) * d
            forces += pulls[:, shift:]
            forces -= pulls[:, :n]
        _finish(state, other, pad, step, w, given, fans, obstacles, c, forces)
        state, other = other, state


def step_listed(
    state: Array,
    other: Array,
    first_step: int,
    n_steps: int,
    _starts: Array,
    _n_slots: Array,
    ends: Array,
    stiffness: Array,
    rest: Array,
    w: Array,
    given: Array,
    fans: Array,
    obstacles: Array,
    c: Array,
) -> None:
    """Take steps of springs in lists; see `loops.step_listed`."""
    for step in range(first_step, first_step + n_steps):
        forces = np.zeros((3, len(w)), np.float32)
        for end, k, length in zip(ends, stiffness, rest, strict=True):
            d = state[:3, end] - state[:3]
            rate = _dot(d, state[3:6, end] - state[3:6])
            forces += _tension(d, rate, k, length, c[DAMPING_S]) * d
        _finish(state, other, 0, step, w, given, fans, obstacles, c, forces)
        state, other = other, state


def _dot(a: Array, b: Array) -> Array:
    result: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return result


def _cross(a: Array, b: Array) -> Array:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _tension(d: Array, rate: Array, k: Any, rest: Any, damping: Any) -> Array:
    """Return the force of each spring over its length."""
    square = _dot(d, d)
    inverse_length = ONE / np.sqrt(np.where(square > TINY, square, TINY))
    tension: Array = k * (ONE - rest * inverse_length) + damping * k * inverse_length * inverse_length * rate
    return tension


def _finish(
    state: Array,
    out: Array,
    pad: int,
    step: int,
    w: Array,
    given: Array,
    fans: Array,
    obstacles: Array,
    c: Array,
    forces: Array,
) -> None:
    """Write all points after a step into `out`; `forces` (3, n) holds those of their springs."""
    points = slice(pad, pad + len(w))
    x, v = state[:3, points], state[3:6, points]
    wind = c[WIND : WIND + 3, None]
    for fan in fans:
        a, b = fan.T
        normal = _cross(x[:, a] - x, x[:, b] - x)
        square = _dot(normal, normal)
        has_area = square > ZERO
        past = wind - (v + v[:, a] + v[:, b]) / THREE
        speed = _dot(past, normal) * (ONE / np.sqrt(np.where(has_area, square, ONE)))
        forces += np.where(has_area, c[FACE_DRAG] * speed * np.abs(speed) * normal, ZERO)
    if len(given):
        forces += given.T
    is_free = w > ZERO
    gravity = c[GRAVITY : GRAVITY + 3, None]
    kicked = v + c[KICK_S] * (w * forces + gravity + c[DRAG_RATE] * (wind - v))
    velocity = np.where(is_free, kicked, v)
    position = x + c[DRIFT_S] * velocity
    time = np.float32(step + 1) * c[FRAME_PART]
    for obstacle in obstacles:
        pushed, slowed = _collide(obstacle, time, c[DRIFT_S], position, velocity)
        position, velocity = np.where(is_free, pushed, position), np.where(is_free, slowed, velocity)
    out[:3, points], out[3:6, points] = position, velocity


def _rotate_by(q: Array, v: Array) -> Array:
    t = TWO * _cross(q, v)
    turned: Array = v + q[3] * t + _cross(q, t)
    return turned


def _surface_distance(o: Array, p: Array) -> tuple[Array, Array]:
    """Return the outer normals (3, n) and the distances (n,) of points of the obstacle's frame."""
    if o[IS_HALF_SPACE] != ZERO:
        normal = np.zeros_like(p)
        normal[1] = ONE
        return normal, p[1]
    d = np.abs(p) - o[HALF_SIZE : HALF_SIZE + 3, None]
    signs = np.where(p >= ZERO, ONE, -ONE)
    beyond = np.where(d > ZERO, d, ZERO)
    square = _dot(beyond, beyond)
    is_outside = square > ZERO
    length = np.sqrt(np.where(is_outside, square, ONE))
    is_x = (d[0] >= d[1]) & (d[0] >= d[2])
    is_y = ~is_x & (d[1] >= d[2])
    nearest = np.stack([is_x, is_y, ~is_x & ~is_y])
    normal = np.where(is_outside, signs * beyond / length, np.where(nearest, signs, ZERO))
    depth = np.where(is_x, d[0], np.where(is_y, d[1], d[2]))
    return normal, np.where(is_outside, length, depth) - o[RADIUS]


def _collide(o: Array, time: Any, drift: Any, x: Array, v: Array) -> tuple[Array, Array]:
    """Return particles (3, n) pushed out of an obstacle, as `collide` in wgsl/shared/obstacle.wgsl."""
    left = ONE - time
    q = o[ROTATION_BEFORE : ROTATION_BEFORE + 4] * left + o[ROTATION_AFTER : ROTATION_AFTER + 4] * time
    q = (q / np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]))[:, None]
    center = o[CENTER_BEFORE : CENTER_BEFORE + 3] * left + o[CENTER_AFTER : CENTER_AFTER + 3] * time
    arm = x - center[:, None]
    normal, distance = _surface_distance(o, _rotate_by(np.concatenate([-q[:3], q[3:]]), arm))
    is_inside = ~(distance >= o[GAP])
    normal = _rotate_by(q, normal)
    turn = o[ANGULAR_VELOCITY : ANGULAR_VELOCITY + 3, None]
    relative = v - (o[VELOCITY : VELOCITY + 3, None] + _cross(turn, arm))
    approach = _dot(relative, normal)
    sliding = relative - approach * normal
    speed = np.sqrt(_dot(sliding, sliding))
    is_slowed = (approach < ZERO) & (speed > ZERO)
    part = -o[FRICTION] * approach / np.where(is_slowed, speed, ONE)
    part = np.where(is_slowed, np.where(part < ONE, part, ONE), ZERO)
    inwards = np.where(approach < ZERO, approach, ZERO)
    pushed = x + (o[GAP] - distance) * normal - drift * (part * sliding)
    slowed = v - inwards * normal - part * sliding
    return np.where(is_inside, pushed, x), np.where(is_inside, slowed, v)
