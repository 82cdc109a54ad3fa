"""Child strands lie between their guides, and go where these go."""

from typing import Any

import numpy as np
import pytest

from gpu_xform import ChildStrands, Strands, matrices, samples
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from gpu_xform.gpu.device import GpuDevice

GUIDES = samples.hair(40, 7, curls=1.5)


def interpolate(children: ChildStrands, positions: Any, clump: float) -> Any:
    """The twin of interpolate_strands.wgsl, in float64."""
    guides = np.asarray(positions, np.float64).reshape(GUIDES.points.shape)
    p = GUIDES.n_points
    k = np.arange(p)
    at = children.lengths.astype(np.float64)[:, np.newaxis] * k
    low = np.minimum(at.astype(int), p - 2)
    part = (at - low)[..., np.newaxis]
    pull = (clump * (k / (p - 1)) ** 2)[:, np.newaxis]
    result = np.zeros((children.n_strands, p, 3))
    for j in range(3):
        guide = guides[children.guides[:, j]]
        row = np.arange(children.n_strands)[:, np.newaxis]
        between = (1 - part) * guide[row, low] + part * guide[row, low + 1]
        weights = children.weights[:, j].astype(np.float64)[:, np.newaxis, np.newaxis]
        result += ((1 - pull) * weights + pull * (j == 0)) * between
    return result.reshape(-1, 3)


@pytest.mark.parametrize(("n", "clump"), [(1, 0.5), (64, 0.0), (1000, 1.0)])
def test_children_are_those_of_the_twin(n: int, clump: float, device: GpuDevice) -> None:
    children = ChildStrands(GUIDES, n, clump=clump, min_length=0.6, seed=3, device=device)
    moved = matrices.chain(matrices.rotate((1, 2, 3), 0.7), matrices.translate(0.3, -2, 1))
    positions = GUIDES.mesh.transformed(moved).positions + np.random.default_rng(1).normal(size=(280, 3)) * 0.01
    # At most ten roundings of numbers below 3, times the sum of the weights.
    tolerance = 10 * 2.0**-24 * 3
    found = children.interpolate(positions)
    assert found.dtype == np.float32
    assert found == pytest.approx(interpolate(children, positions, clump), abs=tolerance)
    assert children.mesh.positions == pytest.approx(interpolate(children, GUIDES.points, clump), abs=tolerance)


def test_what_moves_the_guides_moves_the_children(device: GpuDevice) -> None:
    children = ChildStrands(GUIDES, 90, device=device)
    matrix = matrices.chain(matrices.rotate((3, -1, 2), 2.0), matrices.translate(0.1, 0.2, 0.3))
    moved = children.interpolate(GUIDES.mesh.transformed(matrix).positions)
    assert moved == pytest.approx(children.mesh.transformed(matrix).positions, abs=1e-6)


def test_each_child_has_three_neighbours_as_guides(device: GpuDevice) -> None:
    children = ChildStrands(GUIDES, 400, min_length=0.7, device=device)
    guides, weights = children.guides, children.weights
    assert np.bincount(guides[:, 0]).tolist() == [10] * 40
    assert all(len(set(row)) == 3 for row in guides.tolist())
    assert weights.sum(axis=1) == pytest.approx(np.ones(400), abs=1e-6)
    assert (np.diff(weights, axis=1) <= 0).all()
    assert weights.min() >= -1e-6
    roots = GUIDES.points[guides, 0]
    sides = np.linalg.norm(roots - np.roll(roots, 1, axis=1), axis=2)
    gaps = np.linalg.norm(GUIDES.points[:, np.newaxis, 0] - GUIDES.points[np.newaxis, :, 0], axis=2)
    assert sides.max() < 3 * np.sort(gaps, axis=1)[:, 1].max()
    assert 0.7 <= children.lengths.min() < 0.72
    assert 0.98 < children.lengths.max() <= 1.0
    assert len(children.mesh.edges) == 400 * 6


def test_the_same_seed_gives_the_same_children_and_frames_their_meshes(device: GpuDevice) -> None:
    one, same = (ChildStrands(GUIDES, 50, seed=5, device=device) for _ in range(2))
    assert one.mesh == same.mesh
    assert one.mesh != ChildStrands(GUIDES, 50, seed=6, device=device).mesh
    frames = [GUIDES.mesh.positions + shift for shift in (0.0, 0.5, 1.0)]
    meshes = one.meshes(frames)  # type: ignore[arg-type]
    assert len(meshes) == 3
    assert len(meshes[1:]) == 2
    assert np.array_equal(meshes[1:][0].positions, one.interpolate(frames[1]))
    assert repr(one) == "<ChildStrands: 50 of 7 points>"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"guides": Strands(GUIDES.points[:2])}, "guides must be at least 3, got 2"),
        ({"n": 0}, r"n must lie in 1\.\.\d+, got 0"),
        ({"n": 10**9}, r"n must lie in 1\.\.\d+, got 1000000000"),
        ({"seed": -1}, "seed must not be negative, got -1"),
        ({"clump": 1.5}, r"clump must lie in 0\.\.1, got 1.5"),
        ({"min_length": -0.1}, r"min_length must lie in 0\.\.1, got -0.1"),
    ],
)
def test_impossible_children_are_refused(arguments: dict[str, Any], message: str, device: GpuDevice) -> None:
    plain: dict[str, Any] = {"guides": GUIDES, "n": 5, "device": device}
    with pytest.raises(ArgumentError, match=message):
        ChildStrands(**plain | arguments)
    with pytest.raises(ArgumentError, match=r"positions must have shape \(280, 3\), got \(7, 3\)"):
        ChildStrands(GUIDES, 5, device=device).interpolate(np.zeros((7, 3)))


def test_guides_are_strands(device: GpuDevice) -> None:
    with pytest.raises(ArgumentTypeError, match=r"^guides must be Strands, got Mesh$"):
        ChildStrands(samples.cube(), 10, device=device)  # type: ignore[arg-type]
