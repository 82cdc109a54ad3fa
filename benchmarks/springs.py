"""Springs beside their peers: the state of each is compared before its time counts, ratios come from one run.

All take the same leapfrog steps of the same cloth, or of the same hair. The peers come with
`pip install 'gpu_xform[bench]'`, but for those that install on few machines (newton, taichi): these take part if they
are there.
"""

import argparse
import importlib.util
import math
import os
import platform
from collections.abc import Callable
from functools import partial
from typing import Any
from unittest.mock import patch

import numpy as np
from harness import Row, calm_threads, medians, table
from spring_peers import (
    Peer,
    Problem,
    newton_semi_implicit,
    numba_gather,
    numba_lists,
    problem_of,
    scipy_sparse,
    taichi_scatter,
    warp_kernels,
)

import gpu_xform as gx
from gpu_xform.simulation.leapfrog import Leapfrog
from gpu_xform.simulation.point_state import TEXEL_BYTES

MAX_APART_M = 1e-6  # after the steps of one round, in which a point falls by more
STRANDS, POINTS = 10_000, 32


def make_cloth(n: int, *, shuffled: bool = False, device: gx.Device | None = None) -> gx.Springs:
    """Return a cloth of n x n points and 1 m x 1 m, held at two corners; its points may be in no order."""
    mesh = gx.samples.grid(n - 1)
    size = np.ptp(mesh.positions, axis=0).max()
    mesh = mesh.transformed(gx.rotate_x(-90, degrees=True) @ gx.scale(1.0 / size))
    corners = np.array([0, n - 1])
    if shuffled:
        order = np.random.default_rng(3).permutation(mesh.n_points)
        places = np.argsort(order)
        mesh, corners = gx.Mesh(mesh.positions[order], places[np.asarray(mesh.faces)]), places[corners]
    return gx.Springs(
        mesh, mass=0.2, stretch=1000.0, shear=100.0, bend=50.0, damping=2e-5, pinned=corners, device=device
    )


def make_hair(device: gx.Device | None = None) -> gx.Springs:
    """Return strands on a sphere, with springs to the next and the next-but-one point."""
    directions = np.random.default_rng(2).standard_normal((STRANDS, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
    radii = 0.1 + 0.3 * np.arange(POINTS) / (POINTS - 1)
    points = (radii[:, np.newaxis] * directions[:, np.newaxis]).reshape(-1, 3)
    index = np.arange(STRANDS * POINTS).reshape(STRANDS, POINTS)
    stretch, bend = (np.stack([index[:, :-k], index[:, k:]], axis=-1).reshape(-1, 2) for k in (1, 2))
    return gx.Springs(
        points,
        springs=np.concatenate([stretch, bend]),
        stiffness=np.repeat([0.2, 0.02], [len(stretch), len(bend)]),
        mass=np.full(len(points), 1e-6),
        damping=1e-5,
        pinned=index[:, 0],
        device=device,
    )


def ours(springs: gx.Springs, dt: float) -> Peer:
    """Return our own steps."""

    def run(n_steps: int) -> Any:
        springs.step(n_steps, dt)
        return springs.positions

    return Peer(run, lambda: springs.positions)


def general(make: Callable[[], gx.Springs], dt: float) -> Peer:
    """Return our own steps by the kernel for any springs."""
    with patch("gpu_xform.simulation.leapfrog.find_grid", lambda *_: None):
        return ours(make(), dt)


def listed(make: Callable[[], gx.Springs], dt: float) -> Peer:
    """Return our own steps by the kernel for any springs, with lists as a mesh without order needs them."""
    with patch("gpu_xform.simulation.incidence.LISTED_COST", 0.0):
        return ours(make(), dt)


def compare(peers: dict[str, Peer], n_steps: int, max_apart_m: float = MAX_APART_M) -> None:
    """Stop if a peer is elsewhere after one round."""
    for peer in peers.values():
        peer.run(n_steps)
    expected = peers["ours"].positions()
    for name, peer in peers.items():
        apart = float(np.abs(np.asarray(peer.positions(), np.float64) - expected).max())
        print(f"- {name}: {apart:.1e} m from ours after {n_steps} steps")
        if not apart < max_apart_m:
            raise SystemExit(f"{name} is {apart:.2g} m off: not compared")


def cloth(n: int, n_steps: int, rounds: int, without: set[str]) -> list[Row]:
    """Time steps of a cloth."""
    springs = make_cloth(n)
    dt = 1.0 / 60.0 / np.ceil(1.0 / 60.0 / (0.98 * springs.largest_step))
    problem: Problem = problem_of(springs, dt)
    host = gx.Device("host")
    peers = {
        "ours": ours(springs, dt),
        "general": general(partial(make_cloth, n), dt),
        "listed": listed(partial(make_cloth, n), dt),
        "host": ours(make_cloth(n, device=host), dt),
        "host, listed": listed(partial(make_cloth, n, device=host), dt),
        "Warp": warp_kernels(problem),
        "Numba": numba_lists(problem),
        "SciPy": scipy_sparse(problem),
    }
    if "newton" not in without and importlib.util.find_spec("newton"):
        peers["newton SemiImplicit"] = newton_semi_implicit(problem)
    if "taichi" not in without and importlib.util.find_spec("taichi"):
        peers["Taichi"] = taichi_scatter(problem)
    print(f"cloth of {n} x {n}:")
    compare(peers, n_steps)
    seconds = medians({name: partial(peer.run, n_steps) for name, peer in peers.items()}, rounds=rounds)
    seconds = {name: value / n_steps for name, value in seconds.items()}
    what = f"a step of a cloth, {n} x {n}"
    asked = {"SciPy": 0.35, "newton SemiImplicit": 0.2, "Taichi": 0.4}
    return [
        Row(f"{what}, as a grid", "Warp", seconds["ours"], seconds["Warp"], 0.75),
        Row(f"{what}, as any springs", "Warp", seconds["general"], seconds["Warp"], 1.0),
        Row(f"{what}, as springs without order", "Warp", seconds["listed"], seconds["Warp"], 1.0),
        Row(f"{what}, on the host", "Numba", seconds["host"], seconds["Numba"], 1.0),
        Row(f"{what}, on the host, as springs without order", "Numba", seconds["host, listed"], seconds["Numba"], 1.0),
        *(Row(what, name, seconds["ours"], seconds[name], limit) for name, limit in asked.items() if name in seconds),
    ]


def net(n: int, n_steps: int, rounds: int) -> list[Row]:
    """Time steps of a cloth whose points are in no order."""
    springs = make_cloth(n, shuffled=True)
    dt = 1.0 / 60.0 / np.ceil(1.0 / 60.0 / (0.98 * springs.largest_step))
    problem = problem_of(springs, dt)
    peers = {
        "ours": ours(springs, dt),
        "host": ours(make_cloth(n, shuffled=True, device=gx.Device("host")), dt),
        "Warp": warp_kernels(problem),
        "Numba": numba_lists(problem),
    }
    print(f"cloth of {n} x {n}, shuffled:")
    compare(peers, n_steps)
    seconds = medians({name: partial(peer.run, n_steps) for name, peer in peers.items()}, rounds=rounds)
    seconds = {name: value / n_steps for name, value in seconds.items()}
    what = f"a step of a cloth, {n} x {n}, its points shuffled"
    return [
        Row(what, "Warp", seconds["ours"], seconds["Warp"], 1.0),
        Row(f"{what}, on the host", "Numba", seconds["host"], seconds["Numba"], 1.0),
    ]


def hair(n_steps: int, rounds: int) -> list[Row]:
    """Time steps of hair."""
    springs = make_hair()
    dt = 0.98 * springs.largest_step
    peers = {
        "ours": ours(springs, dt),
        "host": ours(make_hair(gx.Device("host")), dt),
        "Numba": numba_gather(problem_of(springs, dt), STRANDS, POINTS),
    }
    print(f"hair, {STRANDS:,} strands of {POINTS} points:")
    compare(peers, n_steps, 1e-5)
    seconds = medians({name: partial(peer.run, n_steps) for name, peer in peers.items()}, rounds=rounds)
    seconds = {name: value / n_steps for name, value in seconds.items()}
    return [
        Row("a step of hair", "Numba", seconds["ours"], seconds["Numba"], 1.0),
        Row("a step of hair, on the host", "Numba", seconds["host"], seconds["Numba"], 1.0),
    ]


def make_ball(n: int, **stiffness: Any) -> gx.Springs:
    """Return a ball of triangles whose points have no order: springs in lists."""
    ball = gx.samples.icosphere(n)
    order = np.random.default_rng(0).permutation(ball.n_points)
    numbers = np.argsort(order)
    mesh = gx.Mesh(ball.positions[order], [numbers[face].tolist() for face in ball.faces])
    return gx.Springs(mesh, mass=1.0, **stiffness)


def memory(name: str, springs: gx.Springs) -> str:
    """Return the device's bytes for springs beside those of their state and of themselves."""
    springs.step(1)
    stepper = springs._stepper
    held = 0
    if isinstance(stepper, Leapfrog):
        held = sum(buffer.n_bytes for buffer in stepper._buffers)
        held += sum(TEXEL_BYTES * math.prod(texture.extent) for texture in stepper._textures)
    state = 7 * 4 * springs.n_points + 5 * 4 * len(springs.springs)  # x, v, m; ends, rest, stiffness, damping
    return f"memory, {name}: {held / state:.2f} of the bytes of points and springs (asked: at most 1.5)"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="(5)")
    parser.add_argument("--without", nargs="*", default=[], metavar="PEER", help="newton or taichi")
    options = parser.parse_args()
    calm_threads()
    print(f"{os.cpu_count()} processors; Python {platform.python_version()}\n")
    print(memory("cloth of 300 x 300 as a grid", make_cloth(300)))
    with patch("gpu_xform.simulation.incidence.LISTED_COST", 0.0):
        print(memory("the same in lists", make_cloth(300)))
    print(memory("ball of triangles with stretch and bend, in lists", make_ball(6, stretch=100.0, bend=10.0)))
    print(memory("ball of triangles with stretch alone, in lists", make_ball(6, stretch=100.0)))
    without = set(options.without)
    rows = [*cloth(100, 60, options.rounds, without), *cloth(300, 20, options.rounds, without)]
    rows += [*net(100, 60, options.rounds), *net(300, 20, options.rounds), *hair(16, options.rounds)]
    print(f"\n{table(rows)}")


if __name__ == "__main__":
    main()
